//! Textures: colours that vary over a surface.
//!
//! A texture consists of a *mapping*, which maps a point of a surface to the coordinates s and t,
//! an optional transform of these coordinates, and a *pattern*, which maps s and t to a colour. t =
//! 0 is the bottom row of an image.

use crate::{
    kind::kinds,
    math::{ColorConversion, DVec2, Rgb, Vec2, WorkingSpace},
    value::{Channel, Problem},
};

pub mod bitmap;
pub mod checker;
pub mod constant;
pub mod image;
pub mod mapping;
pub mod mipmap;
mod point;
pub mod stripes;
pub mod transform;

pub use bitmap::Bitmap;
pub use mapping::{Mapping, MappingDesc};
pub use point::{TexturePoint, TextureSpace, VertexAttributes};
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
    /// The colour at `st`.
    fn eval(&self, bitmaps: &[Bitmap], st: Vec2) -> Rgb;

    /// The largest value of each channel.
    fn max_value(&self, bitmaps: &[Bitmap]) -> Rgb;

    /// A bound on the largest value of each channel between two corners of a rectangle of `st`.
    fn max_within(&self, bitmaps: &[Bitmap], _corners: [Vec2; 2]) -> Rgb {
        self.max_value(bitmaps)
    }

    /// The opacity at `st`, from 0 to 1.
    fn alpha(&self, _bitmaps: &[Bitmap], _st: Vec2) -> f32 {
        1.0
    }

    /// Whether a channel is known to pass `test` everywhere.
    fn all(&self, _bitmaps: &[Bitmap], _channel: Channel, _test: &dyn Fn(f32) -> bool) -> bool {
        false
    }

    /// The bitmap that it shows, if any.
    fn bitmap(&self) -> Option<BitmapId> {
        None
    }

    /// The bitmap whose mip levels [`PatternKind::mean`] reads; `None` where the pattern is evaluated at points only.
    fn filtered_bitmap(&self) -> Option<BitmapId> {
        None
    }

    /// The mean over the ellipse around `st` whose axes, from end to end, are `axes`. Patterns without mip levels are evaluated
    /// at `st`.
    fn mean(&self, bitmaps: &[Bitmap], st: Vec2, _axes: [Vec2; 2]) -> Rgb {
        self.eval(bitmaps, st)
    }

    /// The lengths after which the pattern repeats along s and t; 0 where it never does.
    fn periods(&self) -> DVec2 {
        DVec2::ZERO
    }

    /// The number of steps per unit of s and t that tell neighbouring values apart: texels, if there are any.
    fn steps(&self, _bitmaps: &[Bitmap]) -> Vec2 {
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
    }
    described only {}
    compiled by fn compile(&self, find: &FindBitmap<'_>) -> Result<Pattern, Problem>;
    /// See [`PatternKind::eval`].
    fn eval(&self, bitmaps: &[Bitmap], st: Vec2) -> Rgb;
    /// See [`PatternKind::max_value`].
    fn max_value(&self, bitmaps: &[Bitmap]) -> Rgb;
    /// See [`PatternKind::max_within`].
    fn max_within(&self, bitmaps: &[Bitmap], corners: [Vec2; 2]) -> Rgb;
    /// See [`PatternKind::alpha`].
    fn alpha(&self, bitmaps: &[Bitmap], st: Vec2) -> f32;
    /// See [`PatternKind::all`].
    fn all(&self, bitmaps: &[Bitmap], channel: Channel, test: &dyn Fn(f32) -> bool) -> bool;
    /// See [`PatternKind::bitmap`].
    fn bitmap(&self) -> Option<BitmapId>;
    /// See [`PatternKind::filtered_bitmap`].
    fn filtered_bitmap(&self) -> Option<BitmapId>;
    /// See [`PatternKind::mean`].
    fn mean(&self, bitmaps: &[Bitmap], st: Vec2, axes: [Vec2; 2]) -> Rgb;
    /// See [`PatternKind::periods`].
    fn periods(&self) -> DVec2;
    /// See [`PatternKind::steps`].
    fn steps(&self, bitmaps: &[Bitmap]) -> Vec2;
}

/// A mapping, where the pattern lies, and the pattern.
#[derive(Clone, Copy, Debug)]
pub struct Texture {
    pub mapping: Mapping,
    pub transform: StTransform,
    pub pattern: Pattern,
    /// The conversion of its numbers to colours of the working space; the identity for data.
    pub colors: ColorConversion,
}

impl Texture {
    /// The same texture, its offset less by whole repetitions if it is far from 0.
    pub fn near(self) -> Self {
        let transform = self.transform.near(self.pattern.periods());
        Self { transform, ..self }
    }

    /// A bound on the colour over a triangle with these corners.
    fn max_within(&self, bitmaps: &[Bitmap], corners: &[TexturePoint; 3]) -> Rgb {
        let max_value = if self.mapping.is_affine() {
            let [a, b, c] = corners.each_ref().map(|at| self.st(at));
            self.pattern.max_within(bitmaps, [a.min(b).min(c), a.max(b).max(c)])
        } else {
            self.pattern.max_value(bitmaps)
        };
        self.colors.convert(max_value)
    }

    /// The coordinates at which the pattern is evaluated.
    #[inline]
    fn st(&self, at: &TexturePoint) -> Vec2 {
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

    /// The opacity, from 0 to 1.
    pub fn alpha(&self, bitmaps: &[Bitmap], at: &TexturePoint) -> f32 {
        self.pattern.alpha(bitmaps, self.st(at))
    }

    /// The directions in which s and t grow, each while the other stays, in the frame of the surface's tangent and bitangent, at a
    /// right angle to each other; `None` where they are these axes.
    fn axes(&self, at: &TexturePoint) -> Option<[Vec2; 2]> {
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
    pub fn eval(&self, bitmaps: &[Bitmap], at: &TexturePoint) -> Rgb {
        self.colors.convert(self.data(bitmaps, at))
    }

    /// The numbers at a point. Images with mip levels are averaged over the footprint; procedural
    /// patterns are evaluated at the point.
    fn data(&self, bitmaps: &[Bitmap], at: &TexturePoint) -> Rgb {
        let st = self.st(at);
        if self.pattern.filtered_bitmap().is_none() || at.footprint == [Vec2::ZERO; 2] {
            return self.pattern.eval(bitmaps, st);
        }
        let footprint = self.mapping.footprint(at).map(|d| self.transform.vector(d));
        self.pattern.mean(bitmaps, st, footprint)
    }
}

/// A colour of a material, constant or textured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Color {
    Constant(Rgb),
    Texture(TextureId),
    /// A texture times a colour.
    Tinted(TextureId, Rgb),
}

impl Color {
    /// Whether it is the same everywhere.
    pub fn is_constant(&self) -> bool {
        matches!(self, Self::Constant(_))
    }

    /// Converts a constant or a tint from Rec. 709 to a working space; the texture converts its own colours.
    pub fn convert(&mut self, space: WorkingSpace) {
        match self {
            Self::Constant(color) | Self::Tinted(_, color) => *color = space.from_rec709(*color),
            Self::Texture(_) => {}
        }
    }
}

/// A scalar of a material, constant or textured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scalar {
    Constant(f32),
    /// A channel of a texture, times a number.
    Texture(TextureId, Channel, f32),
    /// 1 minus the channel of a texture, times a number.
    Inverted(TextureId, Channel, f32),
}

impl Scalar {
    /// Whether it is the same everywhere.
    pub fn is_constant(&self) -> bool {
        matches!(self, Self::Constant(_))
    }

    /// The texture and its channel.
    #[inline(always)]
    fn texture(&self) -> Option<(TextureId, Channel)> {
        match self {
            Self::Constant(_) => None,
            Self::Texture(id, channel, _) | Self::Inverted(id, channel, _) => Some((*id, *channel)),
        }
    }

    /// The scalar where the channel of its texture is `number`.
    #[inline(always)]
    fn at_number(&self, number: f32) -> f32 {
        match self {
            Self::Constant(v) => *v,
            Self::Texture(.., scale) => number * scale,
            Self::Inverted(.., scale) => 1.0 - number * scale,
        }
    }
}

/// The textures and bitmaps of a scene, for lookups.
#[derive(Clone, Copy, Debug)]
pub struct Textures<'a> {
    pub textures: &'a [Texture],
    pub bitmaps: &'a [Bitmap],
}

impl Textures<'_> {
    #[inline(always)]
    pub fn color(&self, color: &Color, at: &TexturePoint) -> Rgb {
        match color {
            Color::Constant(c) => *c,
            Color::Texture(id) => self.look_up(*id, at),
            Color::Tinted(id, tint) => self.look_up(*id, at) * *tint,
        }
    }

    /// The numbers of a source of data, which belong to no colour space.
    pub fn data(&self, source: &Color, at: &TexturePoint) -> Rgb {
        match source {
            Color::Constant(c) => *c,
            Color::Texture(id) => self.numbers(*id, at),
            Color::Tinted(id, tint) => self.numbers(*id, at) * *tint,
        }
    }

    /// A direction along the s and t of a source, in the frame of the surface's tangent and bitangent.
    pub fn turned(&self, source: &Color, direction: Vec2, at: &TexturePoint) -> Vec2 {
        let axes = match source {
            Color::Constant(_) => None,
            Color::Texture(id) | Color::Tinted(id, _) => self.textures[id.0 as usize].axes(at),
        };
        axes.map_or(direction, |[s, t]| s * direction.x + t * direction.y)
    }

    #[inline(always)]
    pub fn scalar(&self, scalar: &Scalar, at: &TexturePoint) -> f32 {
        match scalar {
            Scalar::Constant(v) => *v,
            Scalar::Texture(id, channel, _) | Scalar::Inverted(id, channel, _) => {
                scalar.at_number(self.channel(*id, *channel, at))
            }
        }
    }

    /// Two scalars at a point. Channels of the same texture, which are common in models, need only one lookup.
    #[inline]
    pub fn pair(&self, [a, b]: [&Scalar; 2], at: &TexturePoint) -> [f32; 2] {
        if let (Some((id, of_a)), Some((other, of_b))) = (a.texture(), b.texture())
            && id == other
            && ![of_a, of_b].contains(&Channel::A)
        {
            let color = self.numbers(id, at);
            return [
                a.at_number(channel_of(color, of_a)),
                b.at_number(channel_of(color, of_b)),
            ];
        }
        [self.scalar(a, at), self.scalar(b, at)]
    }

    /// Whether a scalar is known to pass `test` everywhere.
    pub fn all(&self, scalar: &Scalar, test: &dyn Fn(f32) -> bool) -> bool {
        match scalar.texture() {
            None => test(scalar.at_number(0.0)),
            Some((id, channel)) => {
                let pattern = &self.textures[id.0 as usize].pattern;
                pattern.all(self.bitmaps, channel, &|number| test(scalar.at_number(number)))
            }
        }
    }

    /// The size of a texel along u and along v; of a pattern without texels, a small part of the unit.
    pub fn texel(&self, id: TextureId, at: &TexturePoint) -> Vec2 {
        let texture = &self.textures[id.0 as usize];
        let size = texture.pattern.steps(self.bitmaps);
        let unit = TexturePoint {
            footprint: [Vec2::X, Vec2::Y],
            ..*at
        };
        let texels = texture
            .mapping
            .footprint(&unit)
            .map(|d| (texture.transform.vector(d) * size).length());
        Vec2::from_array(texels.map(|n| 1.0 / n.max(1.0)))
    }

    /// The largest channel of a colour over the whole surface.
    pub fn max_value(&self, color: &Color) -> f32 {
        let of = |id: &TextureId| {
            let texture = &self.textures[id.0 as usize];
            texture.colors.convert(texture.pattern.max_value(self.bitmaps))
        };
        let max_value = match color {
            Color::Constant(c) => *c,
            Color::Texture(id) => of(id),
            Color::Tinted(id, tint) => of(id) * *tint,
        };
        max_value.max_component()
    }

    /// A bound on the largest channel of a colour over a triangle with these corners, as it is without a footprint.
    pub fn max_within(&self, color: &Color, corners: &[TexturePoint; 3]) -> f32 {
        let of = |id: &TextureId| self.textures[id.0 as usize].max_within(self.bitmaps, corners);
        let max_value = match color {
            Color::Constant(c) => *c,
            Color::Texture(id) => of(id),
            Color::Tinted(id, tint) => of(id) * *tint,
        };
        max_value.max_component()
    }

    fn look_up(&self, id: TextureId, at: &TexturePoint) -> Rgb {
        self.textures[id.0 as usize].eval(self.bitmaps, at)
    }

    fn numbers(&self, id: TextureId, at: &TexturePoint) -> Rgb {
        self.textures[id.0 as usize].data(self.bitmaps, at)
    }

    pub fn channel(&self, id: TextureId, channel: Channel, at: &TexturePoint) -> f32 {
        match channel {
            Channel::A => self.textures[id.0 as usize].alpha(self.bitmaps, at),
            _ => channel_of(self.numbers(id, at), channel),
        }
    }
}

/// A channel of a colour, which is opaque.
#[inline(always)]
fn channel_of(color: Rgb, channel: Channel) -> f32 {
    match channel {
        Channel::R => color.r,
        Channel::G => color.g,
        Channel::B => color.b,
        Channel::A => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn two_channels_of_one_texture_are_as_each_alone() {
        let color = Rgb::new(0.2, 0.5, 0.7);
        let texture = |color| Texture {
            mapping: Mapping::Uv,
            transform: StTransform::IDENTITY,
            pattern: Pattern::Constant(constant::Constant { color }),
            colors: ColorConversion::default(),
        };
        let all = [texture(color), texture(Rgb::gray(0.9))];
        let textures = Textures {
            textures: &all,
            bitmaps: &[],
        };
        let at = TexturePoint::new(Vec3::ZERO, Vec3::Z);
        let [first, second] = [TextureId(0), TextureId(1)];
        let scalars = [
            Scalar::Constant(0.4),
            Scalar::Texture(first, Channel::G, 0.5),
            Scalar::Inverted(first, Channel::B, 1.0),
            Scalar::Texture(first, Channel::A, 1.0),
            Scalar::Texture(second, Channel::R, 2.0),
        ];
        for a in &scalars {
            for b in &scalars {
                let alone = [a, b].map(|scalar| textures.scalar(scalar, &at));
                assert_eq!(textures.pair([a, b], &at), alone, "{a:?} {b:?}");
            }
        }
        assert_eq!(textures.pair([&scalars[1], &scalars[2]], &at), [0.25, 1.0 - 0.7]);
    }
}
