//! The textures of a scene.

use super::{
    Bitmap, Color, Scalar, Texture, TextureId, TexturePoint,
    source::{channel_of, finite, finite_number},
};
use crate::{
    math::{Rgb, Vec2},
    value::Channel,
};

/// The textures and bitmaps of a scene, for lookups.
#[derive(Clone, Copy, Debug)]
pub struct Textures<'a> {
    pub textures: &'a [Texture],
    pub bitmaps: &'a [Bitmap],
}

impl Textures<'_> {
    #[inline(always)]
    pub fn color(&self, color: &Color, at: &TexturePoint) -> Rgb {
        color.with(|id| self.look_up(id, at))
    }

    /// The numbers of a source of data, which belong to no colour space.
    pub fn data(&self, source: &Color, at: &TexturePoint) -> Rgb {
        source.with(|id| self.numbers(id, at))
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
                let Texture { pattern, factor, .. } = &self.textures[id.0 as usize];
                let factor = match channel {
                    Channel::A => 1.0,
                    _ => channel_of(*factor, channel),
                };
                pattern.all(self, channel, &|number| test(scalar.at_number(number * factor)))
            }
        }
    }

    /// The size of a texel along u and along v; of a pattern without texels, a small part of the unit.
    pub fn texel(&self, id: TextureId, at: &TexturePoint) -> Vec2 {
        let steps = self.textures[id.0 as usize].steps_per_uv(self, at);
        1.0 / steps.max(Vec2::ONE)
    }

    /// Whether a texture shows the texels of an image, its own or that of a texture that it reads.
    pub fn has_image(&self, id: TextureId) -> bool {
        let texture = &self.textures[id.0 as usize];
        texture.pattern.bitmap().is_some() || texture.sources().any(|source| self.has_image(source))
    }

    /// The largest channel of a colour over the whole surface.
    pub fn max_value(&self, color: &Color) -> f32 {
        let of = |id: TextureId| {
            let texture = &self.textures[id.0 as usize];
            texture.colors.convert(texture.max_numbers(self))
        };
        color.with(of).max_component()
    }

    /// The largest value of each channel of a source that another texture reads.
    pub(super) fn max_numbers(&self, source: &Color) -> Rgb {
        let of = |id: TextureId| {
            let texture = &self.textures[id.0 as usize];
            texture.rec709.convert(texture.max_numbers(self))
        };
        source.with(of)
    }

    /// The numbers of a source that another texture reads.
    pub(super) fn source_numbers(&self, source: &Color, at: &TexturePoint) -> Rgb {
        let of = |id: TextureId| self.textures[id.0 as usize].source_numbers(self, at);
        finite(source.with(of))
    }

    /// The numbers of a source that another texture reads, and their standard deviation within the footprint.
    pub(super) fn source_moments(&self, source: &Color, at: &TexturePoint) -> (Rgb, f32) {
        if at.footprint == [Vec2::ZERO; 2] {
            return (self.source_numbers(source, at), 0.0);
        }
        let of = |id: TextureId| self.textures[id.0 as usize].source_moments(self, at);
        match source {
            Color::Constant(c) => (*c, 0.0),
            Color::Texture(id) => of(*id),
            Color::Tinted(id, tint) => {
                let (numbers, spread) = of(*id);
                (finite(numbers * *tint), finite_number(spread * tint.mean()))
            }
        }
    }

    /// A bound on the largest channel of a colour over a triangle with these corners, as it is without a footprint.
    pub fn max_within(&self, color: &Color, corners: &[TexturePoint; 3]) -> f32 {
        let of = |id: TextureId| self.textures[id.0 as usize].max_within(self, corners);
        color.with(of).max_component()
    }

    fn look_up(&self, id: TextureId, at: &TexturePoint) -> Rgb {
        self.textures[id.0 as usize].eval(self, at)
    }

    fn numbers(&self, id: TextureId, at: &TexturePoint) -> Rgb {
        self.textures[id.0 as usize].data(self, at)
    }

    pub fn channel(&self, id: TextureId, channel: Channel, at: &TexturePoint) -> f32 {
        match channel {
            Channel::A => self.textures[id.0 as usize].alpha(self, at),
            _ => channel_of(self.numbers(id, at), channel),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::Vec3,
        texture::{Mapping, Pattern, constant::Constant},
    };

    #[test]
    fn two_channels_of_one_texture_are_as_each_alone() {
        let color = Rgb::new(0.2, 0.5, 0.7);
        let texture = |color| Texture::new(Mapping::Uv, Pattern::Constant(Constant { color }));
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
