//! The frames of a job on standard output (`-o -`), in their order.

use std::{
    fmt,
    io::{self, IsTerminal as _, Write as _},
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

use batch_render::{
    batch::{JobEvent, Observer, Plan},
    error::Error,
    output::{self, EncodeError, Format, FrameImage, OutputError},
    render::Cancel,
    value::UnknownName,
};

use super::{closed_pipe::is_closed_pipe, preview::RATE, y4m};

/// The name that stands for standard output.
pub const STANDARD_OUTPUT: &str = "-";

/// The name of the form of uncompressed films.
const Y4M: &str = "y4m";

/// The form of the frames on standard output.
#[derive(Clone, Copy, Debug)]
pub enum StreamForm {
    /// Whole files, one after the other.
    Files(&'static dyn Format),
    /// An uncompressed film.
    Y4m,
}

impl StreamForm {
    /// Reads the name of a form.
    pub fn parse(name: &str) -> Result<Self, String> {
        let names = output::FORMATS.iter().map(|format| format.name()).chain([Y4M]);
        match output::format(name) {
            Some(format) => Ok(Self::Files(format)),
            None if name == Y4M => Ok(Self::Y4m),
            None => Err(UnknownName::new("format", name, names).to_string()),
        }
    }

    /// The format of its files, if it has any.
    pub fn format(self) -> Option<&'static dyn Format> {
        match self {
            Self::Files(format) => Some(format),
            Self::Y4m => None,
        }
    }
}

/// The reader of standard output has gone before the last frame.
#[derive(Debug)]
pub struct PipeClosed;

impl fmt::Display for PipeClosed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the reader of standard output has gone")
    }
}

impl std::error::Error for PipeClosed {}

/// Refuses to write pictures to a terminal.
pub fn refuse_terminal() -> Result<(), Error> {
    let message = "-o -: standard output is a terminal: write to a pipe or a file (`| program`, `> file`)";
    match io::stdout().is_terminal() {
        true => Err(Error::Usage(message.to_owned())),
        false => Ok(()),
    }
}

/// Writes the frames of a job to standard output as they are finished. An error cancels the job.
pub struct Stream<'a> {
    form: StreamForm,
    plan: &'a Plan,
    cancel: &'a Cancel,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Whether a frame was written.
    is_begun: bool,
    error: Option<EncodeError>,
}

impl<'a> Stream<'a> {
    /// The stream of a job that `cancel` stops.
    ///
    /// # Errors
    /// The form holds no sequence.
    pub fn new(form: StreamForm, plan: &'a Plan, cancel: &'a Cancel) -> Result<Self, Error> {
        let holds_one = form.format().is_some_and(|format| !format.makes_streams());
        if holds_one && plan.frames.len() > 1 {
            let count = plan.frames.len();
            return Err(Error::Usage(format!(
                "-o -: {count} frames make a stream of y4m, png, jpg or npz; readers of EXR take one"
            )));
        }
        Ok(Self {
            form,
            plan,
            cancel,
            state: Mutex::default(),
        })
    }

    fn write(&self, image: &FrameImage<'_>, is_begun: bool) -> Result<(), EncodeError> {
        let bytes = match self.form {
            StreamForm::Files(format) => output::encode(format, image, self.plan.files.encoding)?.0,
            StreamForm::Y4m => y4m::frame(image),
        };
        let mut out = io::stdout().lock();
        if matches!(self.form, StreamForm::Y4m) && !is_begun {
            let window = image.film.window;
            let rate = self.plan.picture.fps.unwrap_or(RATE);
            out.write_all(y4m::header([window.width(), window.height()], rate).as_bytes())?;
        }
        out.write_all(&bytes)?;
        Ok(out.flush()?)
    }

    /// Ends the stream.
    ///
    /// # Errors
    /// A frame was not written: [`PipeClosed`] if nobody reads it.
    pub fn finish(self) -> anyhow::Result<()> {
        let state = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        match state.error {
            None => Ok(()),
            Some(EncodeError::Io(error)) if is_closed_pipe(&error) => Err(PipeClosed.into()),
            Some(EncodeError::Io(error)) => Err(Error::Stdout(error).into()),
            Some(EncodeError::Unfit(reason)) => {
                let path = PathBuf::from(STANDARD_OUTPUT);
                Err(Error::Output(OutputError::Encode { reason, path }).into())
            }
        }
    }
}

impl Observer for Stream<'_> {
    fn event(&self, event: &JobEvent<'_>) {
        let JobEvent::FrameImage { image, .. } = event else {
            return;
        };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.error.is_none() {
            state.error = self.write(image, state.is_begun).err();
            state.is_begun = true;
        }
        if state.error.is_some() {
            self.cancel.cancel();
        }
    }
}
