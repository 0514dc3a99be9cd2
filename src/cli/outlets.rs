//! The outlets of frames beside their own files: standard output (`-o -`), and animated pictures (`-o film.gif`).

use std::path::PathBuf;

use batch_render::{batch::TakenFrames, error::Error, output::FilePattern};

use super::{args::RenderArgs, stream::StreamForm};

/// The outlets of a job.
pub struct Outlets {
    /// The form of the frames on standard output, if they go there.
    pub stream: Option<StreamForm>,
    /// Animated pictures of all frames.
    pub films: Vec<PathBuf>,
}

impl Outlets {
    /// The outlets that the arguments name.
    ///
    /// # Errors
    /// The form of standard output is missing or of no use, frames could be missing there, or a film has a name for each frame.
    pub fn new(args: &RenderArgs) -> Result<Self, Error> {
        let refuse = |message: &str| Err(Error::Usage(message.to_owned()));
        let stream = match (args.settings.has_stream, args.output_format) {
            (false, None) => None,
            (false, Some(_)) => {
                return refuse("--output-format is that of standard output (-o -); files have it in their names");
            }
            (true, None) => return refuse("-o -: --output-format tells the form of the frames, such as png or y4m"),
            (true, Some(_)) if args.existing.skips() => {
                return refuse("-o -: frames that --skip-existing skips would be missing on standard output");
            }
            (true, form) => form,
        };
        let films = args.settings.films.iter().map(|text| film(text));
        Ok(Self {
            stream,
            films: films.collect::<Result<_, _>>()?,
        })
    }

    /// The frames that these outlets take.
    pub fn taken(&self) -> TakenFrames {
        match self.stream.map(StreamForm::format) {
            Some(Some(format)) => TakenFrames::Files(format),
            Some(None) => TakenFrames::Pictures,
            None if self.films.is_empty() => TakenFrames::None,
            None => TakenFrames::Pictures,
        }
    }
}

/// The path of a film, in which the characters of fields are written as in the patterns of files.
fn film(text: &str) -> Result<PathBuf, Error> {
    let pattern = FilePattern::parse(&format!("{text}.png")).ok();
    let pattern = pattern.filter(|pattern| !pattern.has_frame());
    let path = pattern.map(|pattern| pattern.path(0).with_extension(""));
    path.ok_or_else(|| {
        Error::Usage(format!(
            "an animated picture is one file of all frames, whose name has no field for the frame's number: {text}"
        ))
    })
}
