//! The passes of a job: which of them its films hold, and which one its files show.

use super::Request;
use crate::{
    describe::{OneOrMany, SceneDesc},
    error::Error,
    film::{PassRequest, passes::PassSource},
    output::{Contents, FilePattern},
    render::Content,
    value::{Problem, Spanned, UnknownName},
};

/// The passes of a job's films.
#[derive(Clone, Debug, Default)]
pub(super) struct PassChoice {
    pub passes: Vec<PassRequest>,
    /// Whether files show the only pass in place of the beauty.
    pub is_shown: bool,
}

impl PassChoice {
    /// The passes that a request names; `None` if it names none, and the scene decides.
    ///
    /// # Errors
    /// A name is unknown, or no file of the job can hold the passes.
    pub fn of_request(request: &Request, patterns: &[FilePattern]) -> Result<Option<Self>, Error> {
        if let Some(name) = &request.show {
            let choice = shown(name).map_err(|unfit| Error::Usage(format!("--show: {unfit}")))?;
            return Ok(Some(choice));
        }
        if request.aovs.is_empty() {
            return Ok(None);
        }
        let passes = PassRequest::parse_list(request.aovs.iter().map(String::as_str))
            .map_err(|unknown| Error::Usage(format!("--aovs: {unknown}")))?;
        if !holds_passes(patterns) {
            let message = "--aovs: only EXR files hold passes, and the job writes none";
            return Err(Error::Usage(message.to_owned()));
        }
        Ok(Some(Self::beside_beauty(passes)))
    }

    /// The passes that a scene file names.
    ///
    /// # Errors
    /// Names that are unknown.
    pub fn of_scene(desc: &SceneDesc, patterns: &[FilePattern]) -> Result<Self, Vec<Problem>> {
        if let Some(name) = &desc.output.show {
            return shown(name.get_ref()).map_err(|unfit| vec![unfit.at(name)]);
        }
        let Some(OneOrMany(names)) = &desc.output.aovs else {
            return Ok(Self::default());
        };
        let (mut passes, mut problems) = (Vec::new(), Vec::new());
        for name in names {
            match PassRequest::parse_list([name.get_ref().as_str()]) {
                Ok(list) => passes.extend(list),
                Err(unknown) => problems.push(unknown.at(name.span())),
            }
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        if !holds_passes(patterns) {
            tracing::warn!("the job writes no EXR file, which alone holds passes: `aovs` are left out");
            passes.clear();
        }
        Ok(Self::beside_beauty(passes))
    }

    fn beside_beauty(passes: Vec<PassRequest>) -> Self {
        Self {
            passes,
            is_shown: false,
        }
    }

    /// The content to render: if files show data alone, no light is rendered.
    pub fn content(&self) -> Content {
        let is_data = |pass: &PassRequest| matches!(pass.spec().source, PassSource::FirstHit(_));
        if self.is_shown && self.passes.iter().all(is_data) {
            Content::FirstHits
        } else {
            Content::Light
        }
    }

    /// The first pass of light, for integrators that compute none.
    pub fn first_of_light(&self) -> Option<&PassRequest> {
        let is_light =
            |pass: &&PassRequest| matches!(pass.spec().source, PassSource::Light(_) | PassSource::LightGroup);
        self.passes.iter().find(is_light)
    }
}

/// Why a pass cannot be shown.
#[derive(Debug, thiserror::Error)]
enum UnfitToShow {
    #[error(transparent)]
    Unknown(UnknownName),
    #[error("`{0}` stands for several passes (show one, such as `lightgroup_default`)")]
    Several(String),
}

impl UnfitToShow {
    fn at(self, name: &Spanned<String>) -> Problem {
        match self {
            Self::Unknown(unknown) => unknown.at(name.span()),
            several @ Self::Several(_) => Problem::at(name.span(), several.to_string()),
        }
    }
}

fn shown(name: &str) -> Result<PassChoice, UnfitToShow> {
    if name == "all" {
        return Err(UnfitToShow::Several(name.to_owned()));
    }
    let pass = PassRequest::parse(name).map_err(UnfitToShow::Unknown)?;
    match (&pass, pass.spec().source) {
        (_, PassSource::Integrator) => Ok(PassChoice::default()),
        (PassRequest::Pass(_), PassSource::LightGroup) => Err(UnfitToShow::Several(name.to_owned())),
        _ => Ok(PassChoice {
            passes: vec![pass],
            is_shown: true,
        }),
    }
}

fn holds_passes(patterns: &[FilePattern]) -> bool {
    patterns.iter().any(|p| p.format().contents() == Contents::Data)
}
