//! A disk that emits light on one side.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `position` | its centre, `[x, y, z]` | m | required |
//! | `target` | a point that it faces, `[x, y, z]` | m | this or `direction` |
//! | `direction` | direction in which it shines, `[x, y, z]` | | this or `target` |
//! | `radius` | number above 0 | m | required |
//! | `power` | number or `[r, g, b]`, of all its light | W | this or `radiance` |
//! | `radiance` | number or `[r, g, b]` | W m^-2 sr^-1 | this or `power` |
//! | `temperature` | of a black body, which colours the light and keeps its luminance, from 500 to 100000 | K | white |
//! | `exposure` | number of stops: the light is `2^exposure` times as strong | | 0 |
//! | `spread` | how far the light spreads from the normal, from 0 to 1: up to `spread` times 90 degrees | | 1 |
//! | `two_sided` | whether both sides emit | | `false` |
//! | `camera` | whether the camera sees the light | | `false` |
//! | `reflections` | whether mirrors and other surfaces reflect its picture | | `true` |
//!
//! ```toml
//! [[light]]
//! disk = { position = [0, 3, 0], direction = [0, -1, 0], radius = 0.5, power = 40, spread = 0.5 }
//! ```
//!
//! The page of [`rect`](rect.md) says how lights with a surface behave.

use super::{
    Sidedness, aim,
    lamp::{Lamp, lamp_desc},
};
use crate::{
    math::DVec3,
    shape::disk,
    value::{Direction, Point, Positive, Problem, Spanned, UnitInterval},
};

lamp_desc! {
    pub struct DiskDesc {
        pub position: Spanned<Point>,
        pub target: Option<Spanned<Point>>,
        pub direction: Option<Spanned<Direction>>,
        pub radius: Positive,
        pub spread: Option<UnitInterval>,
        pub two_sided: Option<bool>,
    }
}

impl DiskDesc {
    pub fn compile(&self, origin: DVec3) -> Result<Lamp, Problem> {
        let axis = aim::axis("disk", &self.position, &self.target, &self.direction)?;
        let disk = disk::DiskDesc {
            center: *self.position.get_ref(),
            normal: Direction(axis),
            radius: self.radius,
        };
        let shape = disk.compile(origin)?.into();
        let sidedness = if self.two_sided == Some(true) {
            Sidedness::Both
        } else {
            Sidedness::Front
        };
        self.glow(self.position.span()).lamp(shape, sidedness, self.spread)
    }
}
