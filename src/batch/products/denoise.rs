//! Denoising sequences: files with the passes of `--aovs denoise` become files with less noise.
//!
//! A frame's file depends on its own file and those of the frames around it, and on nothing else: any part of a sequence, denoised
//! where the frames around it are there, has the bytes of the whole.

mod layers;

use std::{
    collections::{BTreeMap, BTreeSet, HashMap, VecDeque},
    path::{Path, PathBuf},
};

use super::targets;
use crate::{
    assets::ContentHash,
    batch::{
        FrameRange,
        plan::denoise_options::{DenoiseOptions, FilterKind},
        resume::fingerprint::{FINGERPRINT, PICTURE},
    },
    denoise::{self, DenoiseError, Frame, Method, Oidn},
    error::Error,
    math::sorting,
    output::{self, Attribute, Exr, ExrFile, FilePattern, Format as _, OutputError, Value, atomic},
    render::{Cancel, Cancelled},
    simd::Isa,
};

/// The attribute that says how a file was denoised.
pub(super) const DENOISED: &str = "batch-render/denoised";

/// Rises with every change of the denoiser that changes pixels.
const VERSION: u32 = 9;

/// A sequence to denoise.
#[derive(Clone, Debug)]
pub struct DenoiseRequest {
    pub input: FilePattern,
    pub output: FilePattern,
    /// The frames to denoise; all that are there where `None`.
    pub frames: Option<FrameRange>,
    pub helpers: Helpers,
    pub options: DenoiseOptions,
    /// Whether files that are there already and fit stay.
    pub skip_existing: bool,
    pub simd: Isa,
}

/// The frames that may help others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Helpers {
    /// All frames that are there; a gap between them is an error.
    Complete,
    /// The frames of this list that are there.
    Among(Vec<i32>),
}

/// An observer of a sequence that is denoised.
pub trait DenoiseObserver {
    fn done(&self, _frame: i32, _path: &Path) {}
    fn skipped(&self, _frame: i32) {}
    /// These frames were denoised without the missing ones beside them.
    fn lacking(&self, _frames: &[i32], _missing: &[i32]) {}
}

/// Denoises a sequence on the threads of the current rayon pool.
///
/// # Errors
/// A file is missing, has not what the denoiser needs, or cannot be written; or `cancel` says so.
pub fn denoise(request: &DenoiseRequest, observer: &dyn DenoiseObserver, cancel: Option<&Cancel>) -> Result<(), Error> {
    if request.output.format().name() != Exr.name() {
        let message = format!("denoised sequences are EXR files: {}", request.output.as_str());
        return Err(Error::Usage(message));
    }
    denoise_into(request, &OneFile { request, observer }, cancel)
}

/// Receives the denoised frames of a sequence.
pub(super) trait DenoisedFrames {
    /// The files that are made of a frame.
    fn files(&self, frame: i32) -> Vec<PathBuf>;
    /// Returns whether the files of a frame are there, whole and with this fingerprint, and stay.
    fn keep(&self, frame: i32, fingerprint: &str) -> bool;
    fn write(&self, frame: i32, file: &ExrFile) -> Result<(), Error>;
    /// See [`DenoiseObserver::lacking`].
    fn lacking(&self, _frames: &[i32], _missing: &[i32]) {}
}

/// Each frame is one EXR file.
struct OneFile<'a> {
    request: &'a DenoiseRequest,
    observer: &'a dyn DenoiseObserver,
}

impl DenoisedFrames for OneFile<'_> {
    fn files(&self, frame: i32) -> Vec<PathBuf> {
        vec![self.request.output.path(frame)]
    }

    fn keep(&self, frame: i32, fingerprint: &str) -> bool {
        let has = || {
            let facts = Exr.inspect(&self.request.output.path(frame));
            facts.is_some_and(|facts| facts.attribute(FINGERPRINT) == Some(&Value::from(fingerprint)))
        };
        let is_kept = self.request.skip_existing && has();
        if is_kept {
            self.observer.skipped(frame);
        }
        is_kept
    }

    fn write(&self, frame: i32, file: &ExrFile) -> Result<(), Error> {
        let path = self.request.output.path(frame);
        atomic::check(&path)?;
        write(&path, file)?;
        self.observer.done(frame, &path);
        Ok(())
    }

    fn lacking(&self, frames: &[i32], missing: &[i32]) {
        self.observer.lacking(frames, missing);
    }
}

/// Writes a denoised file, with a seal.
pub(super) fn write(path: &Path, file: &ExrFile) -> Result<(), OutputError> {
    atomic::write(path, |out| Ok(out.write_all(&output::sealed(file.encode()?))?))
}

/// Denoises a sequence as [`denoise()`] does, into files that `frames` writes.
pub(super) fn denoise_into(
    request: &DenoiseRequest,
    frames: &dyn DenoisedFrames,
    cancel: Option<&Cancel>,
) -> Result<(), Error> {
    let sequence = Sequence::find(request)?;
    let outputs = sequence.wanted.iter().flat_map(|(frame, _)| frames.files(*frame));
    targets::check_distinct(outputs, sequence.files.values().cloned())?;
    let mut method = load(&request.options.filter)?;
    let how = how(&method);
    let (mut loaded, mut seals) = (Loaded::default(), Seals::default());
    for (frame, around) in &sequence.wanted {
        let fingerprint = seals.fingerprint(request, &how, &sequence.inputs(*frame, around))?;
        if frames.keep(*frame, &fingerprint) {
            continue;
        }
        if cancel.is_some_and(Cancel::is_cancelled) {
            return Err(Cancelled.into());
        }
        loaded.keep(around, &sequence.files)?;
        let mut file = loaded.denoise(*frame, &mut method, request.simd)?;
        for part in &mut file.parts {
            part.attributes.retain(|a| a.name != PICTURE && a.name != FINGERPRINT);
            part.attributes.extend([
                Attribute::new(DENOISED, format!("{how}, {} other frames", around.len() - 1)),
                Attribute::new(FINGERPRINT, fingerprint.as_str()),
            ]);
        }
        frames.write(*frame, &file)?;
    }
    let (lacking, missing) = sequence.lacking(request);
    if !missing.is_empty() {
        frames.lacking(&lacking, &missing);
    }
    Ok(())
}

/// The fingerprints of the denoised frames of a sequence; `None` where a file that the frame is made of is damaged or foreign.
pub(super) fn fingerprints(request: &DenoiseRequest) -> Result<BTreeMap<i32, Option<String>>, Error> {
    let sequence = Sequence::find(request)?;
    let (how, mut seals) = (how(&load(&request.options.filter)?), Seals::default());
    let mut of = |frame, around: &[i32]| seals.fingerprint(request, &how, &sequence.inputs(frame, around)).ok();
    let of_wanted = sequence
        .wanted
        .iter()
        .map(|(frame, around)| (*frame, of(*frame, around)));
    Ok(sorting::ordered(of_wanted))
}

/// The frames to denoise, each with those that it needs, itself among them, in rising order.
struct Sequence {
    wanted: Vec<(i32, Vec<i32>)>,
    files: BTreeMap<i32, PathBuf>,
}

impl Sequence {
    /// The files that a denoised frame is made of: its own first, since frames may need the same files.
    fn inputs(&self, frame: i32, around: &[i32]) -> Vec<&Path> {
        let all = std::iter::once(&frame).chain(around);
        all.map(|frame| &*self.files[frame]).collect()
    }

    /// The frames that are denoised without one beside them that lies between frames of a complete sequence, and those that are
    /// missing.
    fn lacking(&self, request: &DenoiseRequest) -> (Vec<i32>, Vec<i32>) {
        let (mut frames, mut missing) = (Vec::new(), BTreeSet::new());
        let reach = request.options.temporal as i32;
        if let (Some(first), Some(last)) = (self.files.keys().next(), self.files.keys().next_back())
            && request.helpers == Helpers::Complete
        {
            for (frame, _) in &self.wanted {
                let around = frame.saturating_sub(reach).max(*first)..=frame.saturating_add(reach).min(*last);
                let absent: Vec<i32> = around.filter(|other| !self.files.contains_key(other)).collect();
                frames.extend(absent.first().map(|_| *frame));
                missing.extend(absent);
            }
        }
        (frames, missing.into_iter().collect())
    }

    fn find(request: &DenoiseRequest) -> Result<Self, Error> {
        let files = files(request)?;
        let wanted: Vec<i32> = match &request.frames {
            Some(range) => range.iter().filter_map(|frame| i32::try_from(frame).ok()).collect(),
            None => files.keys().copied().collect(),
        };
        if wanted.is_empty() {
            return Err(DenoiseError::NoFiles {
                pattern: request.input.as_str().to_owned(),
            }
            .into());
        }
        let may_help = |frame: &i32| match &request.helpers {
            Helpers::Among(list) => list.contains(frame),
            Helpers::Complete => true,
        };
        let reach = request.options.temporal as i32;
        let mut list = Vec::new();
        for frame in wanted {
            if !files.contains_key(&frame) {
                let path = request.input.path(frame);
                return Err(DenoiseError::Missing { path }.into());
            }
            let around = frame.saturating_sub(reach)..=frame.saturating_add(reach);
            let around: Vec<i32> = files.range(around).map(|(frame, _)| *frame).filter(may_help).collect();
            let gap = around.windows(2).find(|pair| pair[1] - pair[0] > 1);
            if let Some(pair) = gap.filter(|_| request.helpers == Helpers::Complete) {
                return Err(DenoiseError::Gap {
                    path: request.input.path(pair[0] + 1),
                    before: pair[0],
                    after: pair[1],
                }
                .into());
            }
            list.push((frame, around));
        }
        let numbers: Vec<i32> = list.iter().map(|(frame, _)| *frame).collect();
        output::sequence::check_distinct(std::slice::from_ref(&request.output), &numbers)?;
        Ok(Self { wanted: list, files })
    }
}

/// The files that are there, by their frames. A name without a field is that of one picture, with the number at its end.
fn files(request: &DenoiseRequest) -> Result<BTreeMap<i32, PathBuf>, Error> {
    let input = &request.input;
    if input.has_frame() {
        return match input.existing() {
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::Usage(format!("{cause}: {}", input.as_str())))
            }
            found => Ok(found.unwrap_or_default()),
        };
    }
    if request
        .frames
        .as_ref()
        .is_some_and(|frames| frames.iter().nth(1).is_some())
    {
        let message = "--range: one file has one frame; a name with a field, such as f.####.exr, names several";
        return Err(Error::Usage(format!("{message}: {}", input.as_str())));
    }
    let asked = request.frames.as_ref().map(FrameRange::first);
    let asked = asked.and_then(|frame| i32::try_from(frame).ok());
    let frame = match asked.or_else(|| input.number()) {
        Some(frame) => frame,
        None if request.output.has_frame() => {
            let message = format!(
                "{} needs a number, and the name of the file has none (--range)",
                request.output.as_str()
            );
            return Err(Error::Usage(format!("{message}: {}", input.as_str())));
        }
        None => 0,
    };
    let file = Some((frame, input.path(frame))).filter(|(_, path)| path.exists());
    Ok(file.into_iter().collect())
}

/// The frames in memory, in rising order.
#[derive(Default)]
struct Loaded {
    frames: VecDeque<LoadedFrame>,
}

struct LoadedFrame {
    number: i32,
    path: PathBuf,
    /// The file that the denoised one is made of, until that is done.
    file: Option<ExrFile>,
    layers: Vec<String>,
    frame: Frame,
}

impl LoadedFrame {
    fn read(number: i32, path: &Path) -> Result<Self, DenoiseError> {
        let file = ExrFile::read(path).map_err(|cause| DenoiseError::Unreadable {
            path: path.to_owned(),
            cause: cause.to_string(),
        })?;
        if file.attribute(DENOISED).is_some() {
            return Err(DenoiseError::Denoised { path: path.to_owned() });
        }
        if file.attribute("batch-render/samples") == Some(&Value::Int(1)) {
            return Err(DenoiseError::OneSample { path: path.to_owned() });
        }
        let layers = layers::light_layers(&file);
        Ok(Self {
            frame: Frame {
                number,
                ..layers::frame(&file, &layers, path)?
            },
            layers,
            number,
            path: path.to_owned(),
            file: Some(file),
        })
    }

    fn fits(&self, other: &Self) -> bool {
        let kind = |f: &Self| (f.frame.size, f.frame.origin, f.frame.resolution);
        kind(self) == kind(other) && self.layers == other.layers
    }
}

impl Loaded {
    /// Keeps those of these frames that are there, and reads the others.
    fn keep(&mut self, around: &[i32], files: &BTreeMap<i32, PathBuf>) -> Result<(), DenoiseError> {
        self.frames.retain(|frame| around.contains(&frame.number));
        for number in around {
            if self.frames.iter().all(|frame| frame.number != *number) {
                let frame = LoadedFrame::read(*number, &files[number])?;
                if let Some(first) = self.frames.front().filter(|first| !first.fits(&frame)) {
                    return Err(DenoiseError::Different {
                        first: first.path.clone(),
                        second: frame.path,
                    });
                }
                self.frames.push_back(frame);
            }
        }
        sorting::sort_by_key(self.frames.make_contiguous(), |frame| frame.number);
        Ok(())
    }

    /// The file of a frame that is there, denoised. Each frame can be denoised once.
    fn denoise(&mut self, number: i32, method: &mut Method, simd: Isa) -> Result<ExrFile, DenoiseError> {
        let is_own = |frame: &LoadedFrame| frame.number == number;
        let own = self.frames.iter_mut().find(|frame| is_own(frame));
        let file = own.and_then(|own| own.file.take());
        let mut file = file.expect("it was loaded, and each frame is denoised once");
        let (own, others): (Vec<_>, Vec<_>) = self.frames.iter().partition(|frame| is_own(frame));
        let others: Vec<&Frame> = others.into_iter().map(|other| &other.frame).collect();
        let own = own[0];
        let (pixels, part) = own.frame.cut_light();
        if pixels > 0 {
            let percent = 100.0 * part;
            tracing::info!(
                "frame {number}: outliers of {pixels} pixels were cut, which held {percent:.2} % of the light"
            );
        }
        let denoised = denoise::denoise(&own.frame, &others, method, simd)?;
        layers::put(&mut file, &own.layers, &denoised);
        Ok(file)
    }
}

/// The filter, ready to work.
pub(in crate::batch) fn load(filter: &FilterKind) -> Result<Method, DenoiseError> {
    Ok(match filter {
        FilterKind::NonLocalMeans => Method::NonLocalMeans,
        FilterKind::Oidn { library } => {
            let oidn = Oidn::load(library.as_deref(), rayon::current_num_threads())?;
            tracing::info!("Open Image Denoise {}", oidn.version());
            Method::Oidn(oidn)
        }
    })
}

/// The text about a filter in files.
fn how(method: &Method) -> String {
    match method {
        Method::NonLocalMeans => "non-local means, outliers cut, alpha divided out".to_owned(),
        Method::Oidn(oidn) => format!("Open Image Denoise {}", oidn.version()),
    }
}

/// The seals of the files that were looked at, by their paths.
#[derive(Default)]
struct Seals(HashMap<PathBuf, String>);

impl Seals {
    /// The hash of all that a denoised file depends on: the files, by their seals, and the settings.
    fn fingerprint(&mut self, request: &DenoiseRequest, how: &str, files: &[&Path]) -> Result<String, DenoiseError> {
        let version = env!("CARGO_PKG_VERSION");
        let mut text = format!("{VERSION} {version} {} {how}\n", request.options.temporal);
        for path in files {
            if !self.0.contains_key(*path) {
                self.0.insert((*path).to_owned(), seal(path)?);
            }
            text.push_str(&self.0[*path]);
            text.push('\n');
        }
        Ok(ContentHash::of(text.as_bytes()).to_string())
    }
}

/// The seal of the whole file at `path`, which is a hash of its bytes.
fn seal(path: &Path) -> Result<String, DenoiseError> {
    let facts = Exr.inspect(path);
    let facts = facts.ok_or_else(|| DenoiseError::Damaged { path: path.to_owned() })?;
    match (facts.version(), facts.attribute(output::SEAL)) {
        (Some(_), Some(Value::String(seal))) => Ok(seal.clone()),
        _ => Err(DenoiseError::Foreign { path: path.to_owned() }),
    }
}
