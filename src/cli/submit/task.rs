//! The facts of a job that a farm is told.

use batch_render::batch::FrameRange;

/// The facts of a job that both engines are told.
pub struct Task {
    pub name: String,
    /// The folder in which the program starts, where relative paths begin.
    pub folder: String,
    /// This program.
    pub program: String,
    /// Its arguments, without those that choose frames.
    pub arguments: Vec<String>,
    /// The steps of the job, each of which begins when the one before has succeeded.
    pub steps: Vec<Step>,
    /// The frames of the whole job.
    pub frames: FrameRange,
    pub chunk: u32,
}

/// The most characters of a job's name: the limit of OpenJD.
const LONGEST_NAME: usize = 128;

impl Task {
    /// The name of the job that renders this scene.
    pub fn name_of(scene: &str) -> String {
        format!("batch-render {scene}").chars().take(LONGEST_NAME).collect()
    }
}

/// A step of a job.
#[derive(Clone, Debug)]
pub struct Step {
    pub kind: StepKind,
    /// The arguments of its tasks beside those of all tasks.
    pub own: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepKind {
    Render,
    Denoise,
    Preview,
}

impl StepKind {
    /// The name in a template.
    pub fn name(self) -> &'static str {
        match self {
            Self::Render => "Render",
            Self::Denoise => "Denoise",
            Self::Preview => "Preview",
        }
    }

    /// The name of the batch script.
    pub fn script(self) -> &'static str {
        match self {
            Self::Render => "frames.sbatch",
            Self::Denoise => "denoise.sbatch",
            Self::Preview => "preview.sbatch",
        }
    }

    /// Whether one task has all frames, in place of one task for each chunk.
    pub fn is_whole(self) -> bool {
        self == Self::Preview
    }
}

impl Step {
    fn new(kind: StepKind, own: &[&str]) -> Self {
        Self {
            kind,
            own: own.iter().map(|&word| word.to_owned()).collect(),
        }
    }

    /// The steps of a job that denoises its frames or not, renders finished frames again or not, and makes this preview.
    pub fn list(denoises: bool, overwrites: bool, preview: Option<&str>) -> Vec<Self> {
        const SKIP: &str = "--skip-existing";
        let existing = if overwrites { "--overwrite" } else { SKIP };
        let mut steps = match denoises {
            false => vec![Self::new(StepKind::Render, &[existing])],
            true => vec![
                Self::new(StepKind::Render, &["--denoise-step=render", existing]),
                Self::new(StepKind::Denoise, &["--denoise-step=denoise", existing]),
            ],
        };
        steps.extend(preview.map(|path| Self::new(StepKind::Preview, &[&format!("--preview={path}"), SKIP])));
        steps
    }
}
