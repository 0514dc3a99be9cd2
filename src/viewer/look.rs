//! The look of the view: integrator, passes, samples, resolution and display.

use serde::{Deserialize, Serialize};

use crate::{
    batch::{Plan, Request},
    describe::SceneDesc,
    film::passes::BEAUTY,
    output::Shown,
    value::Exposure,
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
    /// The look of a plan.
    pub fn of_plan(plan: &Plan, desc: &SceneDesc, request: &Request) -> Self {
        let of_scene = desc.render.integrator.as_ref().map(|i| i.name().to_owned());
        let pass = match plan.picture.shown {
            Shown::Plane(_) => plan.picture.settings.passes.first(),
            Shown::All => None,
        };
        let pass = request.show.clone().or_else(|| {
            let name = desc.output.show.as_ref().map(|name| name.get_ref().clone());
            name.filter(|_| pass.is_some())
        });
        Self {
            integrator: request
                .integrator
                .clone()
                .or(of_scene)
                .unwrap_or_else(|| "path".to_owned()),
            view: plan.picture.view.name().to_owned(),
            exposure: plan.picture.exposure,
            pass: pass.unwrap_or_else(|| BEAUTY.name.to_owned()),
            samples: request.samples.unwrap_or(desc.render.samples.get_ref().max()),
            scale: 1,
        }
    }

    /// Whether its numbers are within bounds; names are checked by the plan.
    pub fn is_bounded(&self) -> bool {
        self.exposure.abs() <= 64.0
            && (1..=MAX_SCALE).contains(&self.scale)
            && (1..=MAX_SAMPLES).contains(&self.samples)
    }

    /// The request with everything that the look says, and without passes that it does not show.
    pub fn apply_all(&self, request: &Request) -> Request {
        Request {
            integrator: Some(self.integrator.clone()),
            view: Some(self.view.clone()),
            exposure: Some(Exposure::Stops(self.exposure)),
            show: Some(self.pass.clone()),
            aovs: Vec::new(),
            samples: Some(self.samples),
            ..request.clone()
        }
    }

    /// The request of a job of which the look replaces what differs from `before`, the look of the request itself.
    pub fn apply_changes(&self, before: &Self, request: &Request) -> Request {
        let mut request = request.clone();
        if self.integrator != before.integrator {
            request.integrator = Some(self.integrator.clone());
        }
        if self.view != before.view {
            request.view = Some(self.view.clone());
        }
        if self.exposure != before.exposure {
            request.exposure = Some(Exposure::Stops(self.exposure));
        }
        if self.pass != before.pass {
            request.show = Some(self.pass.clone());
            request.aovs.clear();
        }
        if self.samples != before.samples {
            request.samples = Some(self.samples);
        }
        request
    }

    /// The flags of the command line, with values, that say the same as [`Look::apply_changes`].
    pub fn options(&self, before: &Self) -> Vec<(&'static str, String)> {
        let all = |look: &Self| {
            [
                ("integrator", look.integrator.clone()),
                ("show", look.pass.clone()),
                ("samples", look.samples.to_string()),
                ("view", look.view.clone()),
                ("exposure", look.exposure.to_string()),
            ]
        };
        let pairs = all(self).into_iter().zip(all(before));
        pairs.filter(|(new, old)| new != old).map(|(new, _)| new).collect()
    }
}
