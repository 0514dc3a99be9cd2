//! Checkpoints: the state of an unfinished frame, saved beside its first file; and kept sums, that of a finished one, to
//! which a later job can add samples.
//!
//! Both are whole or absent, have a checksum, and contain a fingerprint of their frame, so that they are not used with other inputs
//! or settings. That of kept sums leaves out the number of samples.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{
    assets::ContentHash,
    batch::PlannedFrame,
    output::{OutputError, atomic},
    render::SampleRanges,
    warnings::{WarningKind, Warnings},
};

/// Increased with every change of the state's format.
const VERSION: u32 = 3;

/// The checkpoint's path; `None` for a frame without files.
pub(in crate::batch) fn path(frame: &PlannedFrame) -> Option<PathBuf> {
    beside(frame, ".checkpoint")
}

/// The path of kept sums; `None` for a frame without files.
pub(in crate::batch) fn sums_path(frame: &PlannedFrame) -> Option<PathBuf> {
    beside(frame, ".sums")
}

/// The path of the kept sums of a range of the samples, which a job with this range alone has written.
pub(in crate::batch) fn range_path(frame: &PlannedFrame, ranges: SampleRanges) -> Option<PathBuf> {
    let whole = sums_path(frame)?;
    let folder = whole.with_file_name(ranges.folder()?);
    Some(folder.join(whole.file_name()?))
}

fn beside(frame: &PlannedFrame, ending: &str) -> Option<PathBuf> {
    let mut name = frame.files.first()?.path.clone().into_os_string();
    name.push(ending);
    Some(name.into())
}

/// The path of the picture of an unfinished frame, which a signal asks for.
pub(in crate::batch) fn picture_path(frame: &PlannedFrame) -> Option<PathBuf> {
    Some(frame.files.first()?.path.with_extension("partial.exr"))
}

/// The lines before the state.
fn head(fingerprint: &str, state: &[u8]) -> String {
    let order = if cfg!(target_endian = "big") { "big" } else { "little" };
    let hash = ContentHash::of(state);
    format!("batch-render checkpoint {VERSION} {order}\n{fingerprint}\n{hash}\n")
}

/// Saves the state of the frame with this fingerprint.
pub(in crate::batch) fn write(path: &Path, fingerprint: &str, state: &[u8]) -> Result<(), OutputError> {
    atomic::write(path, |out| {
        out.write_all(head(fingerprint, state).as_bytes())?;
        Ok(out.write_all(state)?)
    })
}

/// Reads the state of the frame with this fingerprint; `None` if it is missing, damaged or of another frame.
pub(in crate::batch) fn read(path: &Path, fingerprint: &str, warnings: &Warnings) -> Option<Vec<u8>> {
    // Opening anything but a file may wait for ever.
    let mut bytes = path.is_file().then(|| fs::read(path).ok()).flatten()?;
    let length = head(fingerprint, &[]).len();
    let is_own = bytes.len() >= length && bytes.starts_with(head(fingerprint, &bytes[length..]).as_bytes());
    if !is_own {
        let path = path.display();
        let text = format!("not used, for it is damaged or of other settings: {path}");
        warnings.add_live(WarningKind::CHECKPOINT, path, text);
        return None;
    }
    Some(bytes.split_off(length))
}

/// Removes the checkpoint of a frame that is on disk.
pub(in crate::batch) fn remove(frame: &PlannedFrame) {
    if let Some(path) = path(frame) {
        // Most frames have none.
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_whole_state_of_the_same_frame_is_read() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("f.exr.checkpoint");
        let kept = |fingerprint| read(&path, fingerprint, &Warnings::default());
        assert_eq!(kept("a"), None);
        write(&path, "a", b"state").unwrap();
        assert_eq!(kept("a").as_deref(), Some(&b"state"[..]));
        assert_eq!(kept("b"), None);
        let whole = fs::read(&path).unwrap();
        for byte in 0..whole.len() {
            let mut flipped = whole.clone();
            flipped[byte] ^= 1;
            for bytes in [&flipped[..], &whole[..byte]] {
                fs::write(&path, bytes).unwrap();
                assert_eq!(kept("a"), None, "byte {byte}");
            }
        }
    }
}
