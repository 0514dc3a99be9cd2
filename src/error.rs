//! The errors of all rooms, gathered, and who must act on each.

use std::path::PathBuf;

use crate::{
    assets::{
        AssetError, OverBudget,
        camera_path::{CameraPathError, ValueTableError},
    },
    camera::path::PathError,
    compare::CompareError,
    compile,
    denoise::DenoiseError,
    describe,
    describe::Diagnostics,
    output::{JoinError, OutputError, sequence::FilePatternError},
    render::{Cancelled, RenderError},
};

/// Why a job was not done.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A request that makes no sense.
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    Pattern(#[from] FilePatternError),
    #[error(transparent)]
    Scene(#[from] describe::Error),
    #[error("--camera chooses a camera of a model, and a scene file has only its own")]
    CameraOfSceneFile,
    #[error("--variant chooses the materials of a model, and a scene file gives each mesh its own (`variant`)")]
    VariantOfSceneFile,
    #[error("--animation plays those of a model, and a scene file gives each mesh its own (`animation`)")]
    AnimationOfSceneFile,
    #[error("--light-units is that of a model's lights, and a scene file gives each mesh its own (`light_units`)")]
    LightUnitsOfSceneFile,
    #[error("--point-radius is that of a model's points, and a scene file gives each mesh its own (`radius`)")]
    PointRadiusOfSceneFile,
    #[error("--ground is that of a model by itself, and a scene file has its own objects")]
    GroundOfSceneFile,
    #[error("--normalise: only a model by itself is moved; objects of scene files have a `transform`")]
    NormaliseOfSceneFile,
    #[error("--normalise: {name} moves the model, which would replace its place: move its nodes (node.NAME.transform)")]
    NormaliseMoved { name: String },
    #[error("{flag}: the scene has nothing with bounds: {}", path.display())]
    Boundless { flag: &'static str, path: PathBuf },
    #[error("{0}")]
    Invalid(Diagnostics),
    #[error("the scene has no [camera], and no camera path was given: {}", path.display())]
    NoCamera { path: PathBuf },
    #[error("the picture has {width}x{height} pixels: {cause}")]
    Memory { width: u32, height: u32, cause: OverBudget },
    #[error(transparent)]
    Compile(#[from] compile::Error),
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[error(transparent)]
    CameraPath(#[from] CameraPathError),
    #[error(transparent)]
    Values(#[from] ValueTableError),
    #[error("{origin}: cannot read the file: {cause}: {}", path.display())]
    CellFile {
        origin: String,
        cause: std::io::Error,
        path: PathBuf,
    },
    #[error("{}: {name} is set by {other}, too{}", path.display(), taken_out(*is_drawn, name))]
    SetTwice {
        path: PathBuf,
        name: String,
        /// The other source of the same value.
        other: String,
        is_drawn: bool,
    },
    #[error("frame {frame} of the camera path: {cause}")]
    Pose { frame: i64, cause: PathError },
    #[error("{}: the scene's {camera} camera has no use for {}", path.display(), columns.join(", "))]
    Columns {
        path: PathBuf,
        /// Its kind.
        camera: &'static str,
        columns: Vec<&'static str>,
    },
    #[error("the output {} is a file that the job reads: {}", output.display(), input.display())]
    OverwritesInput { output: PathBuf, input: PathBuf },
    #[error("two outputs are one file: {} and {}", first.display(), second.display())]
    WrittenTwice { first: PathBuf, second: PathBuf },
    #[error("an output is in a folder that is an output itself: {} and {}", output.display(), folder.display())]
    WithinOutput { output: PathBuf, folder: PathBuf },
    #[error("cannot start {what}: {cause}")]
    Threads { what: String, cause: String },
    #[error("cannot serve on {address}: {cause}")]
    Listen {
        address: std::net::SocketAddr,
        cause: std::io::Error,
    },
    #[error("the server has failed: {cause}")]
    Serve { cause: std::io::Error },
    #[error("cannot read standard input: {0}")]
    Stdin(std::io::Error),
    #[error("cannot write to standard output: {0}")]
    Stdout(std::io::Error),
    /// Another job is writing a file of this one.
    #[error("{0}")]
    Busy(String),
    #[error("the labels of other pictures cannot be kept: {cause}: remove the file, or render into another folder: {}", path.display())]
    OtherLabels { cause: String, path: PathBuf },
    #[error("the file exists already: {}", path.display())]
    Exists { path: PathBuf },
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Crops were not merged.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// A sequence was not denoised.
    #[error(transparent)]
    Denoise(#[from] DenoiseError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Who must act on an error, and whether trying again may help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// Whoever typed the command.
    Usage,
    /// Whoever made the scene or the camera path.
    Data,
    /// Whoever put the files in place.
    MissingInput,
    /// Whoever runs the machine: nothing can be created there.
    CannotCreate,
    /// Whoever runs the machine: the disk is full, is read-only or fails.
    Io,
    /// Whoever runs the machine: the system allows no more threads.
    System,
    /// Nobody: another job is at work.
    Busy,
    /// Nobody: it was stopped.
    Cancelled,
}

impl From<RenderError> for Error {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            RenderError::Pass(unknown) => Self::Usage(unknown.to_string()),
        }
    }
}

impl Error {
    /// The system would not start `what`.
    pub fn threads(what: &str, cause: &dyn std::fmt::Display) -> Self {
        Self::Threads {
            what: what.to_owned(),
            cause: cause.to_string(),
        }
    }

    /// The texts of the problems, one for each.
    pub fn messages(&self) -> Vec<String> {
        match self {
            Self::Invalid(d) | Self::Scene(describe::Error::Invalid(d)) | Self::Compile(compile::Error::Invalid(d)) => {
                d.messages()
            }
            Self::Compile(compile::Error::Assets(errors)) => errors.messages().to_vec(),
            Self::CameraPath(e) => e.to_string().lines().map(str::to_owned).collect(),
            Self::Values(e) => e.to_string().lines().map(str::to_owned).collect(),
            other => vec![other.to_string()],
        }
    }

    /// Whether the messages show lines of a file below them.
    pub fn has_excerpts(&self) -> bool {
        match self {
            Self::Invalid(_) | Self::Scene(describe::Error::Invalid(_)) | Self::Compile(compile::Error::Invalid(_)) => {
                true
            }
            Self::Compile(compile::Error::Assets(errors)) => errors.have_excerpts(),
            _ => false,
        }
    }

    /// A way to go on without correcting the error, where there is one.
    pub fn help(&self) -> Option<&'static str> {
        match self {
            Self::Compile(compile::Error::Assets(errors))
                if errors.iter().all(|e| matches!(e, AssetError::Image(_))) =>
            {
                Some("--missing-assets placeholder renders squares of magenta and black instead of such an image")
            }
            _ => None,
        }
    }

    pub fn blame(&self) -> Blame {
        match self {
            Self::Invalid(d) | Self::Scene(describe::Error::Invalid(d)) | Self::Compile(compile::Error::Invalid(d))
                if d.are_of_overrides() =>
            {
                Blame::Usage
            }
            Self::Usage(_)
            | Self::CameraOfSceneFile
            | Self::VariantOfSceneFile
            | Self::AnimationOfSceneFile
            | Self::LightUnitsOfSceneFile
            | Self::PointRadiusOfSceneFile
            | Self::GroundOfSceneFile
            | Self::NormaliseOfSceneFile
            | Self::NormaliseMoved { .. }
            | Self::Pattern(_)
            | Self::OverwritesInput { .. }
            | Self::WithinOutput { .. }
            | Self::WrittenTwice { .. } => Blame::Usage,
            Self::Scene(describe::Error::Read { cause, .. } | describe::Error::ReadRandom { cause, .. })
            | Self::Compare(CompareError::Read { source: cause, .. })
            | Self::CellFile { cause, .. } => input(cause),
            Self::Compile(compile::Error::Assets(errors)) => {
                if errors.iter().any(AssetError::is_missing) {
                    Blame::MissingInput
                } else {
                    Blame::Data
                }
            }
            Self::Compare(CompareError::Image(error)) if error.is_missing() => Blame::MissingInput,
            Self::CameraPath(CameraPathError::NotFound { .. })
            | Self::Values(ValueTableError::NotFound { .. })
            | Self::Join(JoinError::Missing { .. })
            | Self::Denoise(DenoiseError::NoFiles { .. } | DenoiseError::Missing { .. } | DenoiseError::Oidn(_)) => {
                Blame::MissingInput
            }
            Self::Compile(_)
            | Self::Compare(_)
            | Self::CameraPath(_)
            | Self::Values(_)
            | Self::SetTwice { .. }
            | Self::Scene(_)
            | Self::Invalid(_)
            | Self::NoCamera { .. }
            | Self::Boundless { .. }
            | Self::Join(_)
            | Self::Denoise(_)
            | Self::Pose { .. }
            | Self::Columns { .. }
            | Self::OtherLabels { .. }
            | Self::Memory { .. } => Blame::Data,
            Self::Output(error) if error.is_of_disk() => Blame::Io,
            Self::Exists { .. } | Self::Output(OutputError::Create { .. }) => Blame::CannotCreate,
            Self::Output(_) | Self::Stdin(_) | Self::Stdout(_) => Blame::Io,
            Self::Threads { .. } | Self::Listen { .. } | Self::Serve { .. } => Blame::System,
            Self::Busy(_) => Blame::Busy,
            Self::Cancelled(_) => Blame::Cancelled,
        }
    }
}

/// The advice for a value that is drawn and has another source.
fn taken_out(is_drawn: bool, name: &str) -> String {
    match is_drawn {
        true => format!(": --set random.{name}=none takes it out of those that are drawn"),
        false => String::new(),
    }
}

fn input(cause: &std::io::Error) -> Blame {
    match cause.kind() {
        std::io::ErrorKind::NotFound => Blame::MissingInput,
        _ => Blame::Data,
    }
}
