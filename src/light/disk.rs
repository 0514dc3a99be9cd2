//! A disk that emits light on one side.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `position` | its centre, `[x, y, z]` | m | required |
//! | `target` | a point that it faces, `[x, y, z]` | m | this or `direction` |
//! | `direction` | direction in which it shines, `[x, y, z]` | | this or `target` |
//! | `radius` | number above 0 | m | required |
//! | `power` | number or `[r, g, b]`, of all its light | W | this, `radiance` or `ies` |
//! | `radiance` | number or `[r, g, b]` | W m^-2 sr^-1 | this, `power` or `ies` |
//! | `temperature` | of a black body, which colours the light and keeps its luminance, from 500 to 100000 | K | white |
//! | `exposure` | number of stops from -100 to 100: the light is `2^exposure` times as strong | | 0 |
//! | `ies` | path of an IES file, relative to the scene file: the intensity in each direction, as seen from afar | cd | none |
//! | `up` | the direction of the top of its texture, and in which the horizontal angle 0 of `ies` lies | | `[0, 1, 0]`; for a lamp that faces up or down `[0, 0, -1]` |
//! | `spread` | how far the light spreads from the normal, from 0, a parallel beam, to 1: up to `spread` times 90 degrees | | 1 |
//! | `texture` | `"texture.NAME"`: the picture that the surface shows, a factor of its `radiance`; with `power` or `ies` the light of all the picture is that of these | | none |
//! | `two_sided` | whether both sides emit | | `false` |
//! | `camera` | whether the camera sees the light; mirrors and glass always show it | | `false` |
//! | `reflections` | whether mirrors and other surfaces reflect its picture | | `true` |
//!
//! ```toml
//! [[light]]
//! disk = { position = [0, 3, 0], direction = [0, -1, 0], radius = 0.5, power = 40, spread = 0.5 }
//! ```
//!
//! The page of [`rect`](rect.md) says how lights with a surface behave, also with an IES file.

use super::{
    IesFile, LightFind, Sidedness, aim,
    beam::Beam,
    lamp::{Lamp, Outlet, lamp_desc},
    picture::{Outline, Picture, Screen},
};
use crate::{
    shape::disk,
    value::{ColorSource, Direction, Point, Positive, Problem, Spanned, UnitInterval},
};

lamp_desc! {
    pub struct DiskDesc {
        pub position: Spanned<Point>,
        pub target: Option<Spanned<Point>>,
        pub direction: Option<Spanned<Direction>>,
        pub up: Option<Direction>,
        pub radius: Positive,
        pub spread: Option<Spanned<UnitInterval>>,
        pub texture: Option<Spanned<ColorSource>>,
        pub ies: Option<Spanned<String>>,
        pub two_sided: Option<bool>,
    }
}

impl DiskDesc {
    /// The file of its profile, if it has one.
    pub fn ies(&self) -> Option<IesFile<'_>> {
        let sidedness = self.sidedness();
        self.ies.as_ref().map(|name| IesFile { name, sidedness })
    }

    fn sidedness(&self) -> Sidedness {
        Sidedness::new(self.two_sided == Some(true))
    }

    pub fn compile(&self, find: &LightFind<'_>) -> Result<Lamp, Problem> {
        let axis = aim::axis("disk", &self.position, &self.target, &self.direction)?;
        let disk = disk::DiskDesc {
            center: *self.position.get_ref(),
            normal: Direction(axis),
            radius: self.radius,
        };
        let shape = disk.compile(find.origin)?.into();
        let half = aim::across(axis, self.up).map(|side| side * f64::from(self.radius.0));
        let screen = Screen::new(self.position.get_ref().0, half, axis, Outline::Ellipse, find.origin);
        let outlet = Outlet {
            sidedness: self.sidedness(),
            spread: self.spread.as_ref().map(|spread| (spread, screen)),
            beam: Some(&|scale| Beam::new(&self.ies, (axis, self.up), scale, find)),
            picture: Picture::new(&self.texture, screen, find)?,
        };
        self.glow(self.position.span()).lamp(shape, &outlet)
    }
}
