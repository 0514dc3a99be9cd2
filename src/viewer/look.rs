//! The look of the view: integrator, passes, samples, resolution and display.

use serde::{Deserialize, Serialize};

use crate::{
    batch::{Plan, Request},
    describe::{SceneDesc, number_or_text},
    film::{PassRequest, passes::BEAUTY},
    output::Shown,
};

/// The largest factor of the resolution scale.
const MAX_SCALE: u32 = 8;

/// The most samples that a page may request.
const MAX_SAMPLES: u32 = 1 << 16;

/// The look of the view. Names are those of the command line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Look {
    pub integrator: String,
    /// The display transform.
    pub view: String,
    /// In stops.
    pub exposure: f32,
    /// `beauty`, or another pass.
    pub pass: String,
    pub samples: u32,
    /// The divisor of the resolution.
    pub scale: u32,
}

impl Look {
    /// The look of a plan of this scene.
    pub fn of_plan(plan: &Plan, desc: &SceneDesc) -> Self {
        let picture = &plan.picture;
        let shown = match picture.shown {
            Shown::Plane(_) => picture.settings.passes.first().map(PassRequest::name),
            Shown::All => None,
        };
        Self {
            integrator: desc.render.integrator.name().to_owned(),
            view: picture.view.name().to_owned(),
            exposure: picture.exposure,
            pass: shown.unwrap_or_else(|| BEAUTY.name.to_owned()),
            samples: desc.render.samples.get_ref().max(),
            scale: 1,
        }
    }

    /// Whether its numbers are within bounds; names are checked by the plan.
    pub fn is_bounded(&self) -> bool {
        self.exposure.abs() <= 64.0
            && (1..=MAX_SCALE).contains(&self.scale)
            && (1..=MAX_SAMPLES).contains(&self.samples)
    }

    /// The same changes of another look: what differs from `before` stays, and all else is that of `after`.
    pub fn rebased(&self, before: &Self, after: &Self) -> Self {
        fn pick<T: PartialEq + Clone>([own, before, after]: [&T; 3]) -> T {
            if own == before { after.clone() } else { own.clone() }
        }
        Self {
            integrator: pick([self, before, after].map(|look| &look.integrator)),
            view: pick([self, before, after].map(|look| &look.view)),
            exposure: pick([self, before, after].map(|look| &look.exposure)),
            pass: pick([self, before, after].map(|look| &look.pass)),
            samples: pick([self, before, after].map(|look| &look.samples)),
            scale: self.scale,
        }
    }

    /// The request with all that the look says.
    pub fn apply_all(&self, request: &Request) -> Request {
        with(request, self.flags())
    }

    /// The request of a job of which the look replaces what differs from `before`, the look of the request itself.
    pub fn apply_changes(&self, before: &Self, request: &Request) -> Request {
        with(request, self.changes(before))
    }

    /// The flags of the command line, with values, that say the same as [`Look::apply_changes`].
    pub fn options(&self, before: &Self) -> Vec<(&'static str, String)> {
        let changes = self.changes(before);
        changes.map(|flag| (flag.name, flag.value)).collect()
    }

    fn flags(&self) -> impl Iterator<Item = Flag> {
        [
            ("integrator", "render.integrator", self.integrator.clone()),
            ("show", "output.show", self.pass.clone()),
            ("samples", "render.samples", self.samples.to_string()),
            ("view", "output.view", self.view.clone()),
            ("exposure", "output.exposure", self.exposure.to_string()),
        ]
        .into_iter()
        .map(|(name, key, value)| Flag { name, key, value })
    }

    fn changes(&self, before: &Self) -> impl Iterator<Item = Flag> {
        let pairs = self.flags().zip(before.flags());
        pairs.filter(|(new, old)| new.value != old.value).map(|(new, _)| new)
    }
}

/// A flag of the command line with its value, and the key of the scene file that it sets.
struct Flag {
    name: &'static str,
    key: &'static str,
    value: String,
}

fn with(request: &Request, flags: impl Iterator<Item = Flag>) -> Request {
    let mut request = request.clone();
    for Flag { name, key, value } in flags {
        request.overrides.set(&format!("--{name}"), key, number_or_text(&value));
    }
    request
}
