//! Merging: crops of one frame from several jobs become the file that one job would have written.

use std::path::{Path, PathBuf};

use super::{denoise::DENOISED, targets};
use crate::{
    batch::resume::fingerprint::{FINGERPRINT, Fingerprint, PICTURE},
    error::Error,
    film::Window,
    output::{self, Attribute, CropFile, FileFacts, Format, JoinError, Value, atomic},
};

/// Joins the crops `inputs`, at least one, into `out`: byte for byte the file of the frame rendered whole.
///
/// # Errors
/// A file is missing, damaged or of another picture, the crops leave a gap or overlap, or `out` cannot be written.
pub fn merge(out: &Path, inputs: &[PathBuf]) -> Result<(), Error> {
    let extension = out.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let format = output::format(extension).ok_or_else(|| {
        let message = format!(
            "the name of the merged file ends in {}: {}",
            output::joined_endings(),
            out.display()
        );
        Error::Usage(message)
    })?;
    let first = inputs
        .first()
        .ok_or_else(|| Error::Usage("nothing to merge".to_owned()))?;
    targets::check_distinct([out.to_owned()].into_iter(), inputs.iter().cloned())?;
    let mut crops = Vec::new();
    let mut common: Option<Crop> = None;
    for path in inputs {
        let crop = look(format, path)?;
        if common.as_ref().is_some_and(|first| first.picture != crop.picture) {
            return Err(JoinError::OtherPicture {
                first: first.clone(),
                second: path.clone(),
            }
            .into());
        }
        crops.push(CropFile {
            path: path.clone(),
            window: crop.facts.window,
        });
        common.get_or_insert(crop);
    }
    let Crop { picture, facts } = common.expect("there is an input");
    let whole = Fingerprint::of_window(&picture, Window::full(facts.resolution));
    let own = [Attribute::new(FINGERPRINT, whole)];
    let bytes = output::join(format, facts.resolution, &crops, &own)?;
    atomic::check(out)?;
    Ok(atomic::write(out, |file| Ok(file.write_all(&bytes)?))?)
}

/// A complete crop.
struct Crop {
    /// The fingerprint of its frame.
    picture: String,
    facts: FileFacts,
}

fn look(format: &dyn Format, path: &Path) -> Result<Crop, JoinError> {
    let path = path.to_owned();
    if !path.exists() {
        return Err(JoinError::Missing { path });
    }
    let Some(facts) = format.inspect(&path) else {
        let mut others = output::FORMATS.iter().filter(|other| other.name() != format.name());
        return Err(match others.find(|other| other.facts(&path).is_some()) {
            Some(other) => JoinError::OtherFormat {
                found: other.name(),
                expected: format.name(),
                path,
            },
            None => JoinError::Damaged { path },
        });
    };
    if facts.attribute(DENOISED).is_some() {
        return Err(JoinError::Denoised { path });
    }
    match facts.attribute(PICTURE) {
        Some(Value::String(picture)) if facts.version() == Some(env!("CARGO_PKG_VERSION")) => Ok(Crop {
            picture: picture.clone(),
            facts,
        }),
        _ => Err(JoinError::Foreign { path }),
    }
}
