//! The surface parameters of what the camera sees, as colours.
//!
//! No keys. R and G are u and v, which `mapping = "uv"` textures read. An EXR has them once more as `UV.U` and `UV.V`; a PNG
//! shows their fractions, so that every repetition looks alike (view `fraction`). Where nothing is met they are 0, as is alpha.
//!
//! These are numbers and no light, so every pixel shows what one ray through its centre, and the centre of the lens, meets:
//! `samples` and `filter` have no say.
//!
//! ```toml
//! [render]
//! integrator = "uv"
//! ```

use serde::Deserialize;

use super::{Departures, Integrator, Layer, Shown, Vertex, Visit};
use crate::{math::Rgb, value::Problem};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UvDesc {}

impl UvDesc {
    pub fn compile(&self) -> Result<Uv, Problem> {
        Ok(Uv)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Uv;

const LAYERS: &[Layer] = &[
    Layer {
        name: "UV.U",
        channel: 0,
    },
    Layer {
        name: "UV.V",
        channel: 1,
    },
];

impl Integrator for Uv {
    fn vertex(&self, visit: &Visit<'_>, out: &mut Departures) {
        if let Vertex::Surface(surface, _) = visit.vertex {
            let uv = surface.texture.uv;
            out.add(Rgb::new(uv.x, uv.y, 0.0));
        }
    }

    fn shown(&self) -> Shown {
        Shown::Fraction
    }

    fn layers(&self) -> &'static [Layer] {
        LAYERS
    }
}
