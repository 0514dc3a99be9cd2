//! Which object the camera sees.
//!
//! No keys. R is the object's number, 1 for the first of the scene file, 0 where nothing is met, as is alpha. G is the hash of its
//! name as Cryptomatte has it (MurmurHash3_32 of the UTF-8 bytes as a float): the same for one name in all scenes, whatever
//! its number is. An EXR has them once more as `objectId.Y` and `objectHash.Y`; a PNG shows a colour for each hash (view `id`).
//!
//! These are numbers and no light, so every pixel shows what one ray through its centre, and the centre of the lens, meets:
//! `samples` and `filter` have no say.
//!
//! ```toml
//! [render]
//! integrator = "object_id"
//! ```
//!
//! Source: Friedman and Jones, "Cryptomatte Specification", version 1.2.0, for the hash.

use serde::Deserialize;

use super::{Departures, Integrator, Layer, Shown, Vertex, Visit};
use crate::{
    math::{Rgb, hash},
    value::Problem,
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectIdDesc {}

impl ObjectIdDesc {
    pub fn compile(&self) -> Result<ObjectId, Problem> {
        Ok(ObjectId)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct ObjectId;

const LAYERS: &[Layer] = &[
    Layer {
        name: "objectId.Y",
        channel: 0,
    },
    Layer {
        name: "objectHash.Y",
        channel: 1,
    },
];

impl Integrator for ObjectId {
    fn vertex(&self, visit: &Visit<'_>, out: &mut Departures) {
        let Vertex::Surface(surface, _) = visit.vertex else {
            return;
        };
        let index = surface.object.0;
        let name = &visit.scene.objects[index as usize].name;
        out.add(Rgb::new((index + 1) as f32, hash::name_as_float(name), 0.0));
    }

    fn shown(&self) -> Shown {
        Shown::Id
    }

    fn layers(&self) -> &'static [Layer] {
        LAYERS
    }
}
