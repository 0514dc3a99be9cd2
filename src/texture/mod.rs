//! Textures: colours that vary over a surface.
//!
//! A texture consists of a *mapping*, which maps a point of a surface to the coordinates s and t,
//! an optional transform of these coordinates, and a *pattern*, which maps s and t to a colour. t =
//! 0 is the bottom row of an image. Mappings to three coordinates are for patterns that fill space.

use crate::{
    kind::kinds,
    math::{ColorConversion, DVec2, Rgb, Vec2},
    value::{Channel, ColorSource, Problem, ScalarSource, Spanned},
};

mod band_limit;
#[cfg(test)]
mod battery;
pub mod bitmap;
pub mod brick;
mod cellular;
pub mod checker;
pub mod constant;
mod footprint;
pub mod gradient;
pub mod image;
pub mod invert;
mod lattice;
mod lookup;
pub mod mapping;
pub mod mipmap;
pub mod mix;
pub mod multiply;
pub mod noise;
mod point;
pub mod ramp;
pub mod remap;
mod solid;
mod source;
pub mod stripes;
mod textures;
pub mod transform;
mod triplanar;
pub mod two_colors;
pub mod voronoi;
pub mod warp;

pub use bitmap::Bitmap;
pub use footprint::{Footprint, SharedFootprint};
pub use lookup::Lookup;
pub use mapping::{Mapping, MappingDesc};
pub use point::{ScenePlace, TexturePoint, TextureSpace, VertexAttributes};
pub use source::{Color, FindColor, Scalar};
pub use textures::Textures;
pub use transform::{StTransform, StTransformDesc};
pub use warp::{Warp, WarpDesc};

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

    /// The numbers, and their standard deviation within the footprint, a mean over the channels; 0 where it is not known.
    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        (self.numbers(lookup), 0.0)
    }

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

    /// The other textures that it reads.
    fn sources(&self) -> [Option<TextureId>; 3] {
        [None; 3]
    }

    /// The lengths after which the pattern repeats along s and t; 0 where it never does.
    fn periods(&self) -> DVec2 {
        DVec2::ZERO
    }

    /// The number of steps per unit of the coordinates that tell neighbouring values apart: texels, if there are any; 0 for a
    /// pattern that reads no coordinates.
    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        Vec2::splat(PATTERN_STEPS)
    }
}

/// The lookup of what patterns refer to when they are compiled.
pub struct FindSources<'a> {
    /// The bitmap of an image file in a colour space.
    pub bitmap: &'a dyn Fn(&image::ImageDesc) -> Result<BitmapId, Problem>,
    pub color: &'a FindColor<'a>,
}

impl FindSources<'_> {
    /// The colour of a source.
    fn color(&self, source: &Spanned<ColorSource>) -> Result<Color, Problem> {
        (self.color)(source)
    }

    /// The number of a source; a texture without a channel is read in red.
    fn scalar(&self, source: &Spanned<ScalarSource>) -> Result<Scalar, Problem> {
        Scalar::compile(source, Channel::R, self.color)
    }

    /// The number of a source, from 0 to 1.
    fn unit_scalar(&self, source: &Spanned<ScalarSource>) -> Result<Scalar, Problem> {
        Scalar::compile_unit(source, Channel::R, self.color)
    }
}

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
        "mix" => Mix(mix::MixPattern, mix::MixPatternDesc),
        "multiply" => Multiply(multiply::Multiply, multiply::MultiplyDesc),
        "ramp" => Ramp(ramp::ColorRamp, ramp::ColorRampDesc),
        "invert" => Invert(invert::Invert, invert::InvertDesc),
        "remap" => Remap(remap::Remap, remap::RemapDesc),
    }
    described only {}
    compiled by fn compile(&self, find: &FindSources<'_>) -> Result<Pattern, Problem>;
    /// See [`PatternKind::numbers`].
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb;
    /// See [`PatternKind::moments`].
    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32);
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
    /// See [`PatternKind::sources`].
    fn sources(&self) -> [Option<TextureId>; 3];
    /// See [`PatternKind::periods`].
    fn periods(&self) -> DVec2;
    /// See [`PatternKind::steps`].
    fn steps(&self, textures: &Textures<'_>) -> Vec2;
}

impl PatternDesc {
    /// Whether it reads the coordinates of a point. A pattern that is made of other textures leaves them to these.
    pub fn has_coordinates(&self) -> bool {
        use PatternDesc::{Invert, Mix, Multiply, Ramp, Remap};
        !matches!(self, Mix(_) | Multiply(_) | Ramp(_) | Invert(_) | Remap(_))
    }

    /// The image of a file, if it is one.
    pub fn image(&self) -> Option<&image::ImageDesc> {
        match self {
            Self::Image(image) => Some(image),
            _ => None,
        }
    }
}

/// A mapping, where the pattern lies, and the pattern.
#[derive(Clone, Copy, Debug)]
pub struct Texture {
    pub mapping: Mapping,
    /// The transform of the coordinates s and t; mappings to three coordinates have their own.
    pub transform: StTransform,
    pub pattern: Pattern,
    /// The displacement of the coordinates.
    pub warp: Option<Warp>,
    /// The factor of the pattern's numbers.
    pub factor: Rgb,
    /// The conversion of its numbers to colours of the working space; the identity for data.
    pub colors: ColorConversion,
    /// The conversion of its numbers to colours of Rec. 709, as other textures read them.
    pub rec709: ColorConversion,
    /// Whether it is known that it shows its pattern as it is: nothing moves, scales or blends it. See [`Texture::prepared`].
    pub is_plain: bool,
    /// Whether it is known that it is plain and that its coordinates are `uv`. See [`Texture::prepared`].
    pub lies_on_uv: bool,
}

impl Texture {
    /// A pattern that lies as its mapping tells, with colours of the working space.
    pub fn new(mapping: Mapping, pattern: Pattern) -> Self {
        Self {
            mapping,
            transform: StTransform::IDENTITY,
            pattern,
            warp: None,
            factor: Rgb::WHITE,
            colors: ColorConversion::default(),
            rec709: ColorConversion::default(),
            is_plain: false,
            lies_on_uv: false,
        }
    }

    /// The same texture for look-ups, which are faster: its offset is less by whole repetitions if it is far from 0.
    pub fn prepared(self) -> Self {
        let is_plain = self.warp.is_none() && self.factor == Rgb::WHITE && self.mapping.triplanar().is_none();
        Self {
            transform: self.transform.near(self.pattern.periods()),
            is_plain,
            lies_on_uv: is_plain && self.mapping.is_uv() && self.transform == StTransform::IDENTITY,
            ..self
        }
    }

    /// Whether it reads the place of a point in the scene.
    pub fn reads_scene(&self) -> bool {
        self.mapping.solid().is_some_and(solid::Solid::reads_scene)
    }

    /// A bound on the colour over a triangle with these corners.
    pub(super) fn max_within(&self, textures: &Textures<'_>, corners: &[TexturePoint; 3]) -> Rgb {
        let max_value = if self.mapping.is_affine() && self.warp.is_none() {
            let [a, b, c] = self.sts(corners);
            self.pattern.max_within(textures, [a.min(b).min(c), a.max(b).max(c)])
        } else {
            self.pattern.max_value(textures)
        };
        self.colors.convert(max_value * self.factor)
    }

    /// The coordinates of the corners of a triangle, less by the same whole periods.
    fn sts(&self, corners: &[TexturePoint; 3]) -> [Vec2; 3] {
        let Some(solid) = self.mapping.solid() else {
            return corners.each_ref().map(|at| self.st(at));
        };
        let places = corners.each_ref().map(|at| solid.place(at).truncate());
        let whole = transform::whole_periods(places[0], self.pattern.periods());
        places.map(|place| (place - whole).as_vec2())
    }

    /// The largest value of each channel of its numbers.
    pub(super) fn max_numbers(&self, textures: &Textures<'_>) -> Rgb {
        self.pattern.max_value(textures) * self.factor
    }

    /// The other textures that it reads, one as often as it is looked up.
    pub fn sources(&self) -> impl Iterator<Item = TextureId> {
        let of_warp = self.warp.and_then(|warp| warp.by.texture());
        self.pattern.sources().into_iter().chain([of_warp]).flatten()
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

    /// The look-up of a plain texture.
    #[inline]
    fn plain_lookup<'a>(&'a self, textures: &'a Textures<'a>, at: &'a TexturePoint) -> Lookup<'a> {
        Lookup {
            textures,
            texture: self,
            at,
            shift: None,
            side: None,
        }
    }

    /// The mean of `read`, a colour and a number, over the sides of a body that a point shows; without sides what it reads.
    fn over_sides(
        &self,
        textures: &Textures<'_>,
        at: &TexturePoint,
        read: impl Fn(&Lookup<'_>) -> (Rgb, f32),
    ) -> (Rgb, f32) {
        let lookup = Lookup {
            shift: self.warp.as_ref().map(|warp| warp.shift(textures, at)),
            ..self.plain_lookup(textures, at)
        };
        let Some(triplanar) = self.mapping.triplanar() else {
            return read(&lookup);
        };
        let shown = triplanar.sides(at).into_iter().filter(|(_, share)| *share > 0.0);
        shown.fold((Rgb::BLACK, 0.0), |(color, number), (side, share)| {
            let side = Some(side);
            let of_side = read(&Lookup { side, ..lookup });
            (color + of_side.0 * share, number + of_side.1 * share)
        })
    }

    /// The opacity, from 0 to 1.
    pub fn alpha(&self, textures: &Textures<'_>, at: &TexturePoint) -> f32 {
        if self.is_plain {
            return self.pattern.alpha(&self.plain_lookup(textures, at));
        }
        let (_, alpha) = self.over_sides(textures, at, |lookup| (Rgb::BLACK, self.pattern.alpha(lookup)));
        alpha.min(1.0)
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
        if self.is_plain {
            return self.pattern.numbers(&self.plain_lookup(textures, at));
        }
        self.composed_data(textures, at)
    }

    /// The same for a texture that is not plain.
    #[inline(never)]
    fn composed_data(&self, textures: &Textures<'_>, at: &TexturePoint) -> Rgb {
        let (numbers, _) = self.over_sides(textures, at, |lookup| (self.pattern.numbers(lookup), 0.0));
        source::finite(numbers * self.factor)
    }

    /// The numbers at a point as other textures read them, all of them finite.
    pub(super) fn source_numbers(&self, textures: &Textures<'_>, at: &TexturePoint) -> Rgb {
        source::finite(self.rec709.convert(self.data(textures, at)))
    }

    /// The moments as other textures read them, all of them finite, see [`PatternKind::moments`].
    pub(super) fn source_moments(&self, textures: &Textures<'_>, at: &TexturePoint) -> (Rgb, f32) {
        let (numbers, spread) = self.over_sides(textures, at, |lookup| self.pattern.moments(lookup));
        let numbers = source::finite(self.rec709.convert(numbers * self.factor));
        (numbers, source::finite_number(spread * self.factor.mean()))
    }

    /// The steps of its pattern per unit of u and of v.
    pub(super) fn steps_per_uv(&self, textures: &Textures<'_>, at: &TexturePoint) -> Vec2 {
        let own = self.own_steps_per_uv(textures, at);
        if self.is_plain && self.pattern.sources() == [None; 3] {
            return own;
        }
        let of_source = |id: TextureId| textures.textures[id.0 as usize].steps_per_uv(textures, at);
        self.sources().map(of_source).fold(own, Vec2::max)
    }

    fn own_steps_per_uv(&self, textures: &Textures<'_>, at: &TexturePoint) -> Vec2 {
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
