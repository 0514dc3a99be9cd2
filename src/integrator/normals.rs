//! The normals of what the camera sees, as colours.
//!
//! No keys. R, G, B are x, y, z of the unit shading normal in world space, from -1 to 1, as authored: a face that points away
//! from the camera shows it. An EXR has them once more as `N.X`, `N.Y`, `N.Z`; a PNG shows half of them plus one half (view
//! `signed`). Where nothing is met they are 0, as is alpha.
//!
//! These are numbers and no light, so every pixel shows what one ray through its centre, and the centre of the lens, meets:
//! `samples` and `filter` have no say.
//!
//! ```toml
//! [render]
//! integrator = "normals"
//! ```

use serde::Deserialize;

use super::{Departures, Integrator, Layer, Shown, Vertex, Visit};
use crate::{math::Rgb, value::Problem};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NormalsDesc {}

impl NormalsDesc {
    pub fn compile(&self) -> Result<Normals, Problem> {
        Ok(Normals)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Normals;

const LAYERS: &[Layer] = &[
    Layer {
        name: "N.X",
        channel: 0,
    },
    Layer {
        name: "N.Y",
        channel: 1,
    },
    Layer {
        name: "N.Z",
        channel: 2,
    },
];

impl Integrator for Normals {
    fn vertex(&self, visit: &Visit<'_>, out: &mut Departures) {
        if let Vertex::Surface(surface, _) = visit.vertex {
            out.add(Rgb::from_array(surface.ns.to_array()));
        }
    }

    fn shown(&self) -> Shown {
        Shown::Signed
    }

    fn layers(&self) -> &'static [Layer] {
        LAYERS
    }
}
