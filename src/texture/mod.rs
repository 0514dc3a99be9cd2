//! Textures: colours that vary over a surface.
//!
//! A texture consists of a *mapping*, which maps a point of a surface to the coordinates s and t,
//! an optional transform of these coordinates, and a *pattern*, which maps s and t to a colour. t =
//! 0 is the bottom row of an image. Mappings to three coordinates are for patterns that fill space.

use crate::{
    kind::kinds,
    math::{ColorConversion, DVec2, Rgb, Vec2},
    value::{Channel, Problem},
};

mod band_limit;
#[cfg(test)]
mod battery;
pub mod bitmap;
pub mod brick;
mod cellular;
pub mod checker;
pub mod constant;
pub mod gradient;
pub mod image;
mod lattice;
mod lookup;
pub mod mapping;
pub mod mipmap;
pub mod noise;
mod point;
mod solid;
mod source;
pub mod stripes;
mod textures;
pub mod transform;
pub mod voronoi;

pub use bitmap::Bitmap;
pub use lookup::Lookup;
pub use mapping::{Mapping, MappingDesc};
pub use point::{ScenePlace, TexturePoint, TextureSpace, VertexAttributes};
pub use source::{Color, Scalar};
pub use textures::Textures;
pub use transform::{StTransform, StTransformDesc};

/// Steps per unit of a pattern without texels, where its slope is asked for.
const PATTERN_STEPS: f32 = 1000.0;

/// An index into the scene's textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureId(pub u32);

/// An index into the scene's bitmaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitmapId(pub u32);

/// The contract of every pattern.
pub trait PatternKind {
    /// The numbers at a point, over the footprint where the pattern can be averaged over it.
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb;

    /// The largest value of each channel.
    fn max_value(&self, textures: &Textures<'_>) -> Rgb;

    /// A bound on the largest value of each channel between two corners of a rectangle of s and t.
    fn max_within(&self, textures: &Textures<'_>, _corners: [Vec2; 2]) -> Rgb {
        self.max_value(textures)
    }

    /// The opacity at a point, from 0 to 1.
    fn alpha(&self, _lookup: &Lookup<'_>) -> f32 {
        1.0
    }

    /// Whether a channel is known to pass `test` everywhere.
    fn all(&self, _textures: &Textures<'_>, _channel: Channel, _test: &dyn Fn(f32) -> bool) -> bool {
        false
    }

    /// The bitmap that it shows, if any.
    fn bitmap(&self) -> Option<BitmapId> {
        None
    }

    /// The bitmap whose mip levels it reads; `None` where it has none.
    fn filtered_bitmap(&self) -> Option<BitmapId> {
        None
    }

    /// Whether it is averaged over the footprint without a bitmap.
    fn is_band_limited(&self) -> bool {
        false
    }

    /// The lengths after which the pattern repeats along s and t; 0 where it never does.
    fn periods(&self) -> DVec2 {
        DVec2::ZERO
    }

    /// The number of steps per unit of the coordinates that tell neighbouring values apart: texels, if there are any.
    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        Vec2::splat(PATTERN_STEPS)
    }
}

/// A function that finds the bitmap of an image file in a colour space.
pub type FindBitmap<'a> = dyn Fn(&image::ImageDesc) -> Result<BitmapId, Problem> + 'a;

kinds! {
    /// A pattern, flat and without pointers.
    enum Pattern / PatternDesc {
        "constant" => Constant(constant::Constant, constant::ConstantDesc),
        "checker" => Checker(checker::Checker, checker::CheckerDesc),
        "stripes" => Stripes(stripes::Stripes, stripes::StripesDesc),
        "image" => Image(image::ImagePattern, image::ImageDesc),
        "noise" => Noise(noise::Noise, noise::NoiseDesc),
        "voronoi" => Voronoi(voronoi::Voronoi, voronoi::VoronoiDesc),
        "brick" => Brick(brick::Brick, brick::BrickDesc),
        "gradient" => Gradient(gradient::GradientPattern, gradient::GradientPatternDesc),
    }
    described only {}
    compiled by fn compile(&self, find: &FindBitmap<'_>) -> Result<Pattern, Problem>;
    /// See [`PatternKind::numbers`].
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb;
    /// See [`PatternKind::max_value`].
    fn max_value(&self, textures: &Textures<'_>) -> Rgb;
    /// See [`PatternKind::max_within`].
    fn max_within(&self, textures: &Textures<'_>, corners: [Vec2; 2]) -> Rgb;
    /// See [`PatternKind::alpha`].
    fn alpha(&self, lookup: &Lookup<'_>) -> f32;
    /// See [`PatternKind::all`].
    fn all(&self, textures: &Textures<'_>, channel: Channel, test: &dyn Fn(f32) -> bool) -> bool;
    /// See [`PatternKind::bitmap`].
    fn bitmap(&self) -> Option<BitmapId>;
    /// See [`PatternKind::filtered_bitmap`].
    fn filtered_bitmap(&self) -> Option<BitmapId>;
    /// See [`PatternKind::is_band_limited`].
    fn is_band_limited(&self) -> bool;
    /// See [`PatternKind::periods`].
    fn periods(&self) -> DVec2;
    /// See [`PatternKind::steps`].
    fn steps(&self, textures: &Textures<'_>) -> Vec2;
}

/// A mapping, where the pattern lies, and the pattern.
#[derive(Clone, Copy, Debug)]
pub struct Texture {
    pub mapping: Mapping,
    /// Of the coordinates s and t; mappings to three coordinates have their own.
    pub transform: StTransform,
    pub pattern: Pattern,
    /// The conversion of its numbers to colours of the working space; the identity for data.
    pub colors: ColorConversion,
}

impl Texture {
    /// A pattern that lies as its mapping tells, with colours of the working space.
    pub fn new(mapping: Mapping, pattern: Pattern) -> Self {
        Self {
            mapping,
            transform: StTransform::IDENTITY,
            pattern,
            colors: ColorConversion::default(),
        }
    }

    /// The same texture, its offset less by whole repetitions if it is far from 0.
    pub fn near(self) -> Self {
        let transform = self.transform.near(self.pattern.periods());
        Self { transform, ..self }
    }

    /// Whether it reads the place of a point in the scene.
    pub fn reads_scene(&self) -> bool {
        self.mapping.solid().is_some_and(|solid| solid.reads_scene())
    }

    /// A bound on the colour over a triangle with these corners.
    pub(super) fn max_within(&self, textures: &Textures<'_>, corners: &[TexturePoint; 3]) -> Rgb {
        let max_value = if self.mapping.is_affine() {
            let [a, b, c] = corners.each_ref().map(|at| self.st(at));
            self.pattern.max_within(textures, [a.min(b).min(c), a.max(b).max(c)])
        } else {
            self.pattern.max_value(textures)
        };
        self.colors.convert(max_value)
    }

    /// The coordinates at which the pattern is evaluated.
    #[inline]
    pub(super) fn st(&self, at: &TexturePoint) -> Vec2 {
        if let Some(solid) = self.mapping.solid() {
            return transform::less_periods(solid.place(at).truncate(), self.pattern.periods());
        }
        let (st, origin) = (self.mapping.st(at), self.mapping.origin(at));
        if origin != Vec2::ZERO {
            return self.far(st, origin);
        }
        self.transform.point(st)
    }

    /// The same for coordinates relative to an origin that is not 0.
    #[cold]
    fn far(&self, st: Vec2, origin: Vec2) -> Vec2 {
        let origin = self.transform.offset_of(origin, self.pattern.periods());
        self.transform.vector(st) + origin
    }

    fn lookup<'a>(&'a self, textures: &'a Textures<'a>, at: &'a TexturePoint) -> Lookup<'a> {
        let texture = self;
        Lookup { textures, texture, at }
    }

    /// The opacity, from 0 to 1.
    pub fn alpha(&self, textures: &Textures<'_>, at: &TexturePoint) -> f32 {
        self.pattern.alpha(&self.lookup(textures, at))
    }

    /// The directions in which s and t grow, each while the other stays, in the frame of the surface's tangent and bitangent, at a
    /// right angle to each other; `None` where they are these axes.
    pub(super) fn axes(&self, at: &TexturePoint) -> Option<[Vec2; 2]> {
        let is_own = self.mapping.has_tangents();
        if is_own && self.transform == StTransform::IDENTITY {
            return None;
        }
        let unit = TexturePoint {
            footprint: [Vec2::X, Vec2::Y],
            ..*at
        };
        let per_uv = if is_own {
            unit.footprint
        } else {
            self.mapping.footprint(&unit)
        };
        let [per_u, per_v] = per_uv.map(|d| self.transform.vector(d));
        let side = per_u.perp_dot(per_v);
        let [u, v] = self.mapping.steps_in_tangents(at);
        let s = ((u * per_v.y - v * per_u.y) * side.signum()).try_normalize()?;
        (side != 0.0).then(|| [s, s.perp() * side.signum()])
    }

    /// The colour at a point, in the working space.
    pub fn eval(&self, textures: &Textures<'_>, at: &TexturePoint) -> Rgb {
        self.colors.convert(self.data(textures, at))
    }

    /// The numbers at a point.
    pub(super) fn data(&self, textures: &Textures<'_>, at: &TexturePoint) -> Rgb {
        self.pattern.numbers(&self.lookup(textures, at))
    }

    /// The steps of its pattern per unit of u and of v.
    pub(super) fn steps_per_uv(&self, textures: &Textures<'_>, at: &TexturePoint) -> Vec2 {
        let steps = self.pattern.steps(textures);
        if let Some(solid) = self.mapping.solid() {
            let along = |duv| solid.step(at, duv).length() * steps.max_element();
            return Vec2::new(along(Vec2::X), along(Vec2::Y));
        }
        let unit = TexturePoint {
            footprint: [Vec2::X, Vec2::Y],
            ..*at
        };
        let per_uv = self.mapping.footprint(&unit);
        Vec2::from_array(per_uv.map(|d| (self.transform.vector(d) * steps).length()))
    }
}
