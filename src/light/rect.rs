//! A rectangle that emits light on one side, such as a soft box or a window.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `position` | its centre, `[x, y, z]` | m | required |
//! | `target` | a point that it faces, `[x, y, z]` | m | this or `direction` |
//! | `direction` | direction in which it shines, `[x, y, z]` | | this or `target` |
//! | `up` | direction of its height, of the top of its texture and of the horizontal angle 0 of `ies` | | `[0, 1, 0]`; for a lamp that faces up or down `[0, 0, -1]` |
//! | `size` | `[width, height]` | m | required |
//! | `power` | number or `[r, g, b]`, of all its light | W | this, `radiance` or `ies` |
//! | `radiance` | number or `[r, g, b]` | W m^-2 sr^-1 | this, `power` or `ies` |
//! | `temperature` | of a black body, which colours the light and keeps its luminance, from 500 to 100000 | K | white |
//! | `exposure` | number of stops from -100 to 100: the light is `2^exposure` times as strong | | 0 |
//! | `ies` | path of an IES file, relative to the scene file: the intensity in each direction, as seen from afar, see below | cd | none |
//! | `spread` | how far the light spreads from the normal, from 0, a parallel beam, to 1: up to `spread` times 90 degrees | | 1 |
//! | `texture` | `"texture.NAME"`: the picture that the surface shows, a factor of its `radiance`; with `power` or `ies` the light of all the picture is that of these | | none |
//! | `two_sided` | whether both sides emit | | `false` |
//! | `camera` | whether the camera sees the light; mirrors and glass always show it | | `false` |
//! | `reflections` | whether mirrors and other surfaces reflect its picture | | `true` |
//!
//! ```toml
//! [[light]]
//! rect = { position = [0, 3, 1], target = [0, 0, 0], size = [2, 1], power = 60, temperature = 4000 }
//! ```
//!
//! Lights with a surface are no objects: no ray is blocked by them, and they cast no shadow. Their names and sizes are those of
//! UsdLux and of Blender, whose area lights of as many watts give the same picture. A picture that the camera sees of a light is
//! added to what is behind it, and leaves alpha as it is: PNG files show it only before a background that is visible.
//!
//! With a `spread` below 1 the light is concentrated as the grid of a soft box does, and its power stays the same. With a `spread`
//! of 0, or below 0.0001, all light goes along the normal: a beam as wide as the light, whose irradiance does not fall with the
//! distance. Neither the camera nor reflections see the surface of such a light.
//!
//! With `reflections = false` only light sampling finds the light: mirrors and clear glass do not show it,
//! and rough surfaces have more noise.
//!
//! A `texture` is the picture of a screen or a window: the camera, reflections and light sampling see it alike. It is upright as
//! seen from where the light shines, and fills the rectangle; a disk shows the part within the circle that touches its sides.
//! Bright parts of a dark picture are sampled more often, so that a small lamp in a large picture has little noise. An `image` with
//! `wrap = "clamp"` does not mix the colours of opposite edges.
//!
//! ```toml
//! [texture.screen]
//! image = { file = "screen.png", wrap = "clamp" }
//!
//! [[light]]
//! rect = { position = [0, 1.2, -1], direction = [0, 0, 1], size = [1.6, 0.9], power = 40, texture = "texture.screen", camera = true }
//! ```
//!
//! With `ies` the light has the intensities of an IES file as seen from afar: the radiance in a direction is the intensity by the
//! area that is seen from there. The page of [`point`](point.md#ies-files) tells how the file is turned and which unit it has.
//! Light that the file sends backwards needs `two_sided = true`, else it is left out, with a warning where nothing remains;
//! `power` is that of the light which leaves the surface. Within half a degree of the plane of the surface the light fades.
//! `radiance` and `spread` cannot be given.
//!
//! Source of the spread: the light that passes the cells of a grid as deep as its cells are wide divided by
//! the tangent of the largest angle.

use super::{
    IesFile, LightFind, Sidedness, aim,
    beam::Beam,
    lamp::{Lamp, Outlet, lamp_desc, without_area},
    picture::{Outline, Picture, Screen},
};
use crate::{
    shape::quad::QuadDesc,
    value::{ColorSource, Direction, List, Point, Positive, Problem, Spanned, UnitInterval},
};

lamp_desc! {
    pub struct RectDesc {
        pub position: Spanned<Point>,
        pub target: Option<Spanned<Point>>,
        pub direction: Option<Spanned<Direction>>,
        pub up: Option<Direction>,
        pub size: Spanned<List<Positive, 2>>,
        pub spread: Option<Spanned<UnitInterval>>,
        pub texture: Option<Spanned<ColorSource>>,
        pub ies: Option<Spanned<String>>,
        pub two_sided: Option<bool>,
    }
}

impl RectDesc {
    /// The file of its profile, if it has one.
    pub fn ies(&self) -> Option<IesFile<'_>> {
        let sidedness = self.sidedness();
        self.ies.as_ref().map(|name| IesFile { name, sidedness })
    }

    fn sidedness(&self) -> Sidedness {
        Sidedness::new(self.two_sided == Some(true))
    }

    pub fn compile(&self, find: &LightFind<'_>) -> Result<Lamp, Problem> {
        let axis = aim::axis("rect", &self.position, &self.target, &self.direction)?;
        let [right, up] = aim::across(axis, self.up);
        let List([width, height]) = *self.size.get_ref();
        let [right, up] = [right * f64::from(width.0 * 0.5), up * f64::from(height.0 * 0.5)];
        let center = self.position.get_ref().0;
        // Wound about the axis.
        let corners = [-right - up, up - right, right + up, right - up].map(|d| Point::new(center + d));
        let quad = QuadDesc {
            corners: Spanned::new(self.position.span(), List(corners)),
        };
        // Corners that are this close are one point.
        let shape = quad
            .compile(find.origin)
            .map_err(|_| without_area(self.size.span()))?
            .into();
        let screen = Screen::new(center, [right, up], axis, Outline::Rectangle, find.origin);
        let outlet = Outlet {
            sidedness: self.sidedness(),
            spread: self.spread.as_ref().map(|spread| (spread, screen)),
            beam: Some(&|scale| Beam::new(&self.ies, (axis, self.up), scale, find)),
            picture: Picture::new(&self.texture, screen, find)?,
        };
        self.glow(self.position.span()).lamp(shape, &outlet)
    }
}
