//! The preview of a job (`--preview`): its frames as a small moving picture. A film (`-o film.gif`,
//! `-o film.apng`) is the same at full size.
//!
//! Pictures wait in a temporary file until the job ends, so that memory does not grow with the sequence. Frames that were
//! there already, also those of other parts of the job, are read from their PNG files, or from
//! their EXR files where there are none.

use std::{
    collections::BTreeMap,
    ffi::OsString,
    fs::File,
    io::{self, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::{Mutex, PoisonError},
};

use batch_render::{
    batch::{Existing, Job, JobEvent, Observer, Plan, PlannedFrame, shows_finished, with_finished},
    error::Error,
    math::srgb,
    output::{
        self, Contents, EncodeError, Format as _, FrameImage, OutputError, atomic, job_file::FolderGate, png::Png,
    },
    render::Cancel,
};
use image::{DynamicImage, RgbImage, imageops};
use tempfile::NamedTempFile;

use super::{
    create::cannot_create,
    gif::{self, Histogram},
    small_picture::small_picture,
};

/// The largest width of a preview, in pixels.
const MAX_COLUMNS: u32 = 640;

/// The program that makes films.
const FFMPEG: &str = "ffmpeg";

/// Frames a second where the job does not say.
pub const RATE: (i32, u32) = (24, 1);

/// The path of a preview, whose ending tells what it is.
pub fn preview_path(text: OsString) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|e| e.to_str()) {
        Some("png" | "apng" | "mp4") => Ok(path),
        _ => Err("expected a file that ends in .png, .apng or .mp4".to_owned()),
    }
}

/// Whether a file of this name holds a whole sequence.
pub fn is_animated(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.is_some_and(|e| ["apng", GIF].iter().any(|animated| e.eq_ignore_ascii_case(animated)))
}

const GIF: &str = "gif";

/// The kinds of moving pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FilmKind {
    Png,
    Gif,
    Mp4,
}

impl FilmKind {
    /// The kind that the ending of a name asks for.
    fn of(path: &Path) -> Self {
        match path.extension() {
            Some(e) if e.eq_ignore_ascii_case(GIF) => Self::Gif,
            Some(e) if e == "mp4" => Self::Mp4,
            _ => Self::Png,
        }
    }

    /// Refuses what cannot be written in pictures of this size.
    fn check(self, path: &Path, [width, height]: [u32; 2]) -> Result<(), Error> {
        let is_installed = || {
            let quiet = Command::new(FFMPEG)
                .arg("-version")
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .status();
            quiet.is_ok_and(|status| status.success())
        };
        match self {
            Self::Gif if width.max(height) > gif::MAX_SIDE => Err(Error::Usage(format!(
                "a GIF has at most {} columns and rows, not {width}x{height}: {}",
                gif::MAX_SIDE,
                path.display()
            ))),
            Self::Mp4 if !is_installed() => {
                let picture = path.with_extension("png");
                Err(Error::Usage(format!(
                    "--preview {}: this needs {FFMPEG}, which is not installed; --preview {} needs no other program",
                    path.display(),
                    picture.display()
                )))
            }
            _ => Ok(()),
        }
    }
}

/// The size of the pictures of a preview.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PreviewSize {
    /// At most 640 columns.
    Small,
    /// That of the frames.
    Full,
}

impl PreviewSize {
    fn picture(self, image: &FrameImage<'_>) -> RgbImage {
        match self {
            Self::Small => small_picture(image, MAX_COLUMNS),
            Self::Full => {
                let window = image.film.window;
                let pixels = image.pixels_over_black().into_flattened();
                RgbImage::from_raw(window.width(), window.height(), pixels).unwrap_or_default()
            }
        }
    }
}

/// Collects the frames of a job.
pub struct Preview<'a> {
    path: &'a Path,
    kind: FilmKind,
    size: PreviewSize,
    job: &'a Job,
    spool: Mutex<Spool>,
}

/// Pictures of one size, one after the other.
struct Spool {
    file: File,
    /// The width and height, once there is a picture.
    size: Option<[u32; 2]>,
    /// The place of each frame's picture among them.
    places: BTreeMap<i32, u64>,
    error: Option<io::Error>,
}

impl Spool {
    fn bytes(&self) -> usize {
        self.size.map_or(0, |[w, h]| 3 * w as usize * h as usize)
    }

    fn has(&self, frame: &PlannedFrame) -> bool {
        self.places.contains_key(&frame.number)
    }

    /// Adds a picture, unless one before it could not be added.
    fn add(&mut self, number: i32, picture: RgbImage) {
        if self.error.is_none() {
            self.error = self.put(number, picture).err();
        }
    }

    fn put(&mut self, number: i32, picture: RgbImage) -> io::Result<()> {
        let size = *self.size.get_or_insert([picture.width(), picture.height()]);
        let picture = if size == [picture.width(), picture.height()] {
            picture
        } else {
            imageops::thumbnail(&picture, size[0], size[1])
        };
        let place = self.places.len() as u64;
        let place = *self.places.entry(number).or_insert(place);
        self.file.seek(SeekFrom::Start(place * self.bytes() as u64))?;
        self.file.write_all(&picture)
    }

    fn get(&mut self, number: i32) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; self.bytes()];
        self.file
            .seek(SeekFrom::Start(self.places[&number] * bytes.len() as u64))?;
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

impl<'a> Preview<'a> {
    /// Starts the preview of a job.
    ///
    /// # Errors
    /// Such a file cannot be made, some frames could not be shown in a film, or no temporary file can be made.
    pub fn new(path: &'a Path, size: PreviewSize, job: &'a Job) -> Result<Self, Error> {
        let (kind, plan) = (FilmKind::of(path), &job.plan);
        kind.check(path, plan.picture.size())?;
        let is_partial = plan.policy.existing == Existing::Skip || plan.all_frames().len() > plan.frames.len();
        if size == PreviewSize::Full && is_partial && !shows_finished(plan) {
            return Err(Error::Usage(format!(
                "-o {}: an animated picture is made of all frames, with --skip-existing and --part also of those on disk: name \
                 files for them that can be shown, PNG, JPEG or EXR (-o f.####.png), and with --show and --exposure auto not EXR \
                 alone",
                path.display()
            )));
        }
        let file = tempfile::tempfile().map_err(|source| cannot_create(source, &std::env::temp_dir()))?;
        Ok(Self {
            path,
            kind,
            size,
            job,
            spool: Mutex::new(Spool {
                file,
                size: None,
                places: BTreeMap::new(),
                error: None,
            }),
        })
    }

    /// Writes the preview of the frames that there are, or the film once it has all frames. An older file stays otherwise.
    ///
    /// # Errors
    /// It cannot be written, no frame of a preview has a picture, or a frame of this job is missing in a film.
    pub fn finish(self, cancel: &Cancel) -> Result<(), Error> {
        let mut spool = self.spool.into_inner().unwrap_or_else(PoisonError::into_inner);
        let (path, plan) = (self.path, &self.job.plan);
        // The last part to end finds the frames of all others.
        let _gate = plan
            .is_chunk
            .then(|| FolderGate::close(&atomic::folder_of(path), Some(cancel)));
        let frames = plan.all_frames();
        let others = frames.iter().filter(|frame| !spool.has(frame));
        let others: Vec<PlannedFrame> = others.cloned().collect();
        let stale = self.job.stale(&others)?;
        for (frame, _) in others.iter().zip(stale).filter(|(_, stale)| stale.is_none()) {
            if let Some(picture) = finished_picture(plan, frame, self.size) {
                spool.add(frame.number, picture);
            }
        }
        if let Some(source) = spool.error {
            return Err(cannot_create(source, &std::env::temp_dir()));
        }
        let missing = frames.iter().filter(|frame| !spool.has(frame)).count();
        let own = plan.frames.iter().filter(|frame| !spool.has(frame)).count();
        let (name, count) = (path.display(), frames.len());
        if cancel.is_cancelled() && (spool.size.is_none() || self.size == PreviewSize::Full && own > 0) {
            // The signal is why there is nothing to write, and an older file stays.
            return Ok(());
        }
        match self.size {
            PreviewSize::Full if own > 0 => {
                let reason = format!("{own} of its {count} frames are missing, and an older file stays as it is");
                return Err(encode(path, reason));
            }
            PreviewSize::Full if missing > 0 => {
                tracing::warn!(
                    "-o {name}: the part that ends last writes it: {missing} of its {count} frames are not yet there"
                );
                return Ok(());
            }
            PreviewSize::Small if missing > 0 && spool.size.is_some() => tracing::warn!(
                "--preview: {missing} frames are not in {name}: they are not on disk, or have no PNG, JPEG or EXR file that can be shown"
            ),
            _ => {}
        }
        let Some(size) = spool.size else {
            return Err(encode(path, "no frame of the preview has a picture".to_owned()));
        };
        let rate = plan.picture.fps.unwrap_or(RATE);
        let numbers = frames.iter().filter(|frame| spool.has(frame));
        let numbers: Vec<i32> = numbers.map(|frame| frame.number).collect();
        match self.kind {
            FilmKind::Gif => {
                let mut colors = Histogram::new();
                for number in &numbers {
                    let frame = spool.get(*number);
                    colors.add(&frame.map_err(|source| cannot_create(source, &std::env::temp_dir()))?);
                }
                let palette = colors.palette();
                let frames = numbers.into_iter().map(|number| spool.get(number));
                let end = |frame: usize| hundredths(frame as u64 + 1, rate);
                atomic::write(path, |out| Ok(gif::write(out, size, &palette, end, frames)?))?;
            }
            FilmKind::Mp4 => {
                let frames = numbers.into_iter().map(|number| spool.get(number));
                let mut film = film(size, rate, frames).map_err(|reason| encode(path, reason))?;
                atomic::write(path, |out| Ok(io::copy(&mut film, out)?))?;
            }
            FilmKind::Png => {
                let frames = numbers.into_iter().map(|number| spool.get(number));
                atomic::write(path, |out| write_picture(out, size, rate, frames))?;
            }
        }
        Ok(())
    }
}

fn encode(path: &Path, reason: String) -> Error {
    let path = path.to_owned();
    Error::Output(OutputError::Encode { reason, path })
}

impl Observer for Preview<'_> {
    fn event(&self, event: &JobEvent<'_>) {
        if let JobEvent::FrameImage { frame, image } = event {
            let picture = self.size.picture(image);
            let mut spool = self.spool.lock().unwrap_or_else(PoisonError::into_inner);
            spool.add(*frame, picture);
        }
    }
}

/// The picture of a frame whose files are there: of a PNG file that covers everything, which holds the very pixels, else of an EXR
/// file, which holds the light of what is clear as well, else of any other.
fn finished_picture(plan: &Plan, frame: &PlannedFrame, size: PreviewSize) -> Option<RgbImage> {
    let files = plan.final_files(frame);
    let pictures = files.iter().filter(|file| file.format.contents() == Contents::Picture);
    let (pngs, others): (Vec<_>, Vec<_>) = pictures.partition(|file| file.format.name() == Png.name());
    let png = pngs.into_iter().find_map(|file| output::decoded(&file.path));
    let is_exact = png.as_ref().is_some_and(is_covered);
    let of_exr = || with_finished(plan, frame, |image| size.picture(image));
    if let Some(picture) = if is_exact { None } else { of_exr() } {
        return Some(picture);
    }
    let picture = png.or_else(|| others.into_iter().find_map(|file| output::decoded(&file.path)));
    let picture = over_black(picture?);
    if size == PreviewSize::Full {
        return Some(picture);
    }
    let columns = MAX_COLUMNS.min(picture.width());
    let rows = (columns * picture.height()).div_ceil(picture.width().max(1)).max(1);
    Some(imageops::thumbnail(&picture, columns, rows))
}

/// Whether nothing of a picture is clear.
fn is_covered(picture: &DynamicImage) -> bool {
    !picture.color().has_alpha() || picture.to_rgba8().pixels().all(|pixel| pixel.0[3] == u8::MAX)
}

/// The picture over black, in linear light, as the frames that a job renders are shown.
fn over_black(picture: DynamicImage) -> RgbImage {
    if !picture.color().has_alpha() {
        return picture.into_rgb8();
    }
    let picture = picture.into_rgba8();
    RgbImage::from_fn(picture.width(), picture.height(), |x, y| {
        let image::Rgba([r, g, b, a]) = *picture.get_pixel(x, y);
        let alpha = f32::from(a) / 255.0;
        image::Rgb([r, g, b].map(|c| srgb::encode8(srgb::decode8(c) * alpha)))
    })
}

/// Writes an animated PNG, which plays for ever.
fn write_picture(
    out: &mut dyn Write,
    [width, height]: [u32; 2],
    rate: (i32, u32),
    frames: impl ExactSizeIterator<Item = io::Result<Vec<u8>>>,
) -> Result<(), EncodeError> {
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let (numerator, denominator) = delay(rate);
    if frames.len() > 1 {
        encoder.set_animated(frames.len() as u32, 0)?;
        encoder.set_frame_delay(numerator, denominator)?;
    }
    let mut writer = encoder.write_header()?;
    for frame in frames {
        writer.write_image_data(&frame?)?;
    }
    Ok(writer.finish()?)
}

/// The end of so many frames, in hundredths of a second.
fn hundredths(frames: u64, (numerator, denominator): (i32, u32)) -> u64 {
    let per_frame = 100.0 * f64::from(denominator) / f64::from(numerator);
    (frames as f64 * per_frame).round() as u64
}

/// The time that a frame is shown, in seconds, as a fraction of small numbers.
fn delay((numerator, denominator): (i32, u32)) -> (u16, u16) {
    match (u16::try_from(denominator), u16::try_from(numerator)) {
        (Ok(seconds), Ok(frames)) if frames > 0 => (seconds, frames),
        _ => {
            let milliseconds = 1000.0 * f64::from(denominator) / f64::from(numerator);
            (milliseconds.round().clamp(1.0, 65535.0) as u16, 1000)
        }
    }
}

/// Has ffmpeg write a film, which is whole once it ends.
fn film(
    [width, height]: [u32; 2],
    (numerator, denominator): (i32, u32),
    mut frames: impl ExactSizeIterator<Item = io::Result<Vec<u8>>>,
) -> Result<NamedTempFile, String> {
    let failed = |error: io::Error| format!("{FFMPEG}: {error}");
    let film = tempfile::Builder::new().suffix(".mp4").tempfile().map_err(failed)?;
    let mut ffmpeg = Command::new(FFMPEG)
        .args(["-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"])
        .args([
            "-s",
            &format!("{width}x{height}"),
            "-r",
            &format!("{numerator}/{denominator}"),
        ])
        // Players want an even number of columns and rows, and colours at half the resolution.
        .args(["-i", "-", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"])
        .arg(film.path())
        .stdin(Stdio::piped())
        .spawn()
        .map_err(failed)?;
    let mut input = ffmpeg.stdin.take().expect("it is piped");
    let written = frames.try_for_each(|frame| input.write_all(&frame?));
    drop(input);
    let status = ffmpeg.wait().map_err(failed)?;
    written.map_err(failed)?;
    if !status.success() {
        return Err(format!("{FFMPEG} ended with {status}"));
    }
    Ok(film)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_shown_for_one_over_the_rate() {
        assert_eq!(delay((24, 1)), (1, 24));
        assert_eq!(delay((24_000, 1001)), (1001, 24_000));
        assert_eq!(delay((120_000, 1001)), (8, 1000));
    }

    #[test]
    fn hundredths_of_a_second_keep_up_with_the_rate() {
        let rate = (24_000, 1001);
        assert_eq!([1, 2, 3].map(|frames| hundredths(frames, rate)), [4, 8, 13]);
        assert_eq!(hundredths(24_000, rate), 100_100);
    }

    #[test]
    fn the_ending_tells_what_a_preview_is() {
        for (name, is_right) in [
            ("film.png", true),
            ("a/film.mp4", true),
            ("film.gif", false),
            ("film", false),
        ] {
            assert_eq!(preview_path(name.into()).is_ok(), is_right, "{name}");
        }
    }
}
