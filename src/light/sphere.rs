//! A sphere that emits light, such as a bulb.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `position` | its centre, `[x, y, z]` | m | required |
//! | `radius` | number above 0 | m | required |
//! | `power` | number or `[r, g, b]`, of all its light | W | this or `radiance` |
//! | `radiance` | number or `[r, g, b]` | W m^-2 sr^-1 | this or `power` |
//! | `temperature` | of a black body, which colours the light and keeps its luminance, from 500 to 100000 | K | white |
//! | `exposure` | number of stops from -100 to 100: the light is `2^exposure` times as strong | | 0 |
//! | `camera` | whether the camera sees the light; mirrors and glass always show it | | `false` |
//! | `reflections` | whether mirrors and other surfaces reflect its picture | | `true` |
//!
//! ```toml
//! [[light]]
//! sphere = { position = [0, 2.5, 0], radius = 0.1, power = 60, temperature = 2700, camera = true }
//! ```
//!
//! It shines outwards: what is inside of it gets no light. The page of [`rect`](rect.md) says how lights with a surface behave.

use super::{
    IesFile, LightFind,
    lamp::{Lamp, Outlet, lamp_desc},
};
use crate::{
    shape::sphere,
    value::{Point, Positive, Problem, Spanned},
};

lamp_desc! {
    pub struct SphereDesc {
        pub position: Spanned<Point>,
        pub radius: Positive,
    }
}

impl SphereDesc {
    /// It has no file.
    pub fn ies(&self) -> Option<IesFile<'_>> {
        None
    }

    pub fn compile(&self, find: &LightFind<'_>) -> Result<Lamp, Problem> {
        let sphere = sphere::SphereDesc {
            center: *self.position.get_ref(),
            radius: self.radius,
        };
        let shape = sphere.compile(find.origin)?.into();
        self.glow(self.position.span()).lamp(shape, &Outlet::PLAIN)
    }
}
