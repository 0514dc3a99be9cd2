//! A tube that emits light, such as a fluorescent lamp: the wall of a cylinder, without its ends.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `from`, `to` | its ends, `[x, y, z]` | m | required |
//! | `radius` | number above 0 | m | required |
//! | `power` | number or `[r, g, b]`, of all its light | W | this or `radiance` |
//! | `radiance` | number or `[r, g, b]` | W m^-2 sr^-1 | this or `power` |
//! | `temperature` | of a black body, which colours the light and keeps its luminance, from 500 to 100000 | K | white |
//! | `exposure` | number of stops from -100 to 100: the light is `2^exposure` times as strong | | 0 |
//! | `camera` | whether the camera sees the light | | `false` |
//! | `reflections` | whether mirrors and other surfaces reflect its picture | | `true` |
//!
//! ```toml
//! [[light]]
//! tube = { from = [-1, 2.5, 0], to = [1, 2.5, 0], radius = 0.02, power = 36, temperature = 4000 }
//! ```
//!
//! It shines outwards. The page of [`rect`](rect.md) says how lights with a surface behave.

use super::{
    IesFile, LightFind,
    lamp::{Lamp, Outlet, lamp_desc},
};
use crate::{
    shape::cylinder::Cylinder,
    value::{Point, Positive, Problem, Spanned},
};

lamp_desc! {
    pub struct TubeDesc {
        pub from: Spanned<Point>,
        pub to: Spanned<Point>,
        pub radius: Positive,
    }
}

impl TubeDesc {
    /// It has no file.
    pub fn ies(&self) -> Option<IesFile<'_>> {
        None
    }

    pub fn compile(&self, find: &LightFind<'_>) -> Result<Lamp, Problem> {
        let (from, to) = (*self.from.get_ref(), *self.to.get_ref());
        let along = to.0 - from.0;
        let (Some(axis), length) = (along.try_normalize(), along.length() as f32) else {
            return Err(Problem::at(self.to.span(), "`to` lies at `from`"));
        };
        if length <= 0.0 {
            return Err(Problem::at(self.to.span(), "`to` lies at `from`"));
        }
        let wall = Cylinder::wall(from.relative_to(find.origin), axis.as_vec3(), length, self.radius.0);
        self.glow(self.from.span()).lamp(wall.into(), &Outlet::PLAIN)
    }
}
