//! The passes of a job: those of its films, and the one that its files show.

use super::patterns::is_chosen;
use crate::{
    batch::Request,
    describe::{OutputDesc, SceneDesc},
    error::Error,
    film::{
        PassRequest,
        passes::{PASSES, PassSource},
        request::{ALL, DENOISE},
    },
    integrator::BuiltIn,
    output::{Contents, Format},
    render::Content,
    value::{Problem, Spanned, UnknownName, is_override},
    warnings::WarningKind,
};

/// The passes of a job's films.
#[derive(Clone, Debug, Default)]
pub(in crate::batch) struct PassChoice {
    pub passes: Vec<PassRequest>,
    /// Whether files show the only pass instead of the beauty.
    pub is_shown: bool,
    /// Whether all available passes are requested.
    pub is_all: bool,
    /// Whether those that denoisers read are requested.
    pub serves_denoisers: bool,
}

impl PassChoice {
    /// The passes that a scene names.
    ///
    /// # Errors
    /// Names that are unknown, and passes that no file of the job can hold.
    pub fn new(desc: &SceneDesc, request: &Request, formats: &[&dyn Format]) -> Result<Self, Vec<Problem>> {
        let OutputDesc { show, aovs, .. } = &desc.output;
        let last = aovs.iter().flat_map(|aovs| &aovs.0).map(|name| name.span().start).max();
        // Passes that an override names replace the one that the file shows.
        let is_replaced =
            last.is_some_and(|at| is_override(&(at..at)) && show.as_ref().is_some_and(|s| s.span().start < at));
        if let Some(name) = show.as_ref().filter(|_| !is_replaced) {
            return shown(name.get_ref()).map_err(|unfit| vec![unfit.at(name)]);
        }
        let Some(names) = aovs else {
            return Ok(Self::default());
        };
        let (mut passes, mut problems) = (Vec::new(), Vec::new());
        for name in &names.0 {
            match PassRequest::parse_list([name.get_ref().as_str()]) {
                Ok(list) => passes.extend(list),
                Err(unknown) => problems.push(unknown.at(name.span())),
            }
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        if !holds_passes(formats) {
            // Outputs of the command line, such as previews, need not hold the scene's passes.
            let message = match (names.is_override(), is_chosen(desc) || request.taken.are_any()) {
                (true, _) => "only EXR and NPZ files hold passes, and the job writes none",
                (_, false) => "only EXR and NPZ files hold passes, and `files` names none",
                (false, true) => {
                    let text = "the job writes no EXR and no NPZ file, which alone hold passes: `aovs` are left out";
                    request
                        .warnings
                        .add_topic(WarningKind::UNUSED_SETTING, "aovs", "aovs", text);
                    return Ok(Self::default());
                }
            };
            let at = names.0.first().map(Spanned::span).unwrap_or_default();
            return Err(vec![Problem::at(at, message)]);
        }
        Ok(Self {
            passes,
            is_shown: false,
            is_all: names.0.iter().any(|name| name.get_ref() == ALL),
            serves_denoisers: names.0.iter().any(|name| name.get_ref() == DENOISE),
        })
    }

    /// Adds the pass of this name to the films, unless they have it.
    pub fn add(&mut self, name: &str) {
        let pass = PassRequest::parse(name).expect("the table has the row");
        if !self.passes.contains(&pass) {
            self.passes.push(pass);
        }
    }

    /// Adds the passes that denoisers read.
    pub fn add_denoise(&mut self) {
        let denoise = PASSES
            .iter()
            .filter(|spec| spec.serves_denoisers())
            .map(PassRequest::Pass);
        let missing: Vec<PassRequest> = denoise.filter(|pass| !self.passes.contains(pass)).collect();
        self.passes.extend(missing);
        self.serves_denoisers = true;
    }

    /// The content to render: no light if files show only data.
    pub fn content(&self) -> Content {
        let is_data = |pass: &PassRequest| matches!(pass.spec().source, PassSource::FirstHit(_));
        if self.is_shown && self.passes.iter().all(is_data) {
            Content::FirstHits
        } else {
            Content::Light
        }
    }

    /// If all passes are requested, removes those that `integrator` cannot compute.
    ///
    /// # Errors
    /// A pass that is requested by name cannot be computed.
    pub fn fit_to(&mut self, (name, integrator): (&str, &BuiltIn)) -> Result<(), Error> {
        let computes = integrator.as_dyn();
        let unfit = |pass: &PassRequest| match pass.spec().source {
            PassSource::Integrator => false,
            PassSource::Light(_) | PassSource::LightGroup => !computes.has_light(),
            _ => computes.wants_cost(),
        };
        if self.is_all {
            self.passes.retain(|pass| !unfit(pass));
        }
        match self.passes.iter().find(|pass| unfit(pass)) {
            None => Ok(()),
            Some(pass) => Err(Error::Usage(format!(
                "the integrator `{name}` cannot fill the pass `{}`",
                pass.name()
            ))),
        }
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
    if name == ALL || name == DENOISE {
        return Err(UnfitToShow::Several(name.to_owned()));
    }
    let pass = PassRequest::parse(name).map_err(UnfitToShow::Unknown)?;
    match (&pass, pass.spec().source) {
        (_, PassSource::Integrator) => Ok(PassChoice::default()),
        (PassRequest::Pass(_), PassSource::LightGroup) => Err(UnfitToShow::Several(name.to_owned())),
        _ => Ok(PassChoice {
            passes: vec![pass],
            is_shown: true,
            ..PassChoice::default()
        }),
    }
}

fn holds_passes(formats: &[&dyn Format]) -> bool {
    formats.iter().any(|format| format.contents() == Contents::Data)
}
