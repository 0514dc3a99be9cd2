//! A look-up of a texture at a point of a surface, as patterns see it.

use super::{
    Color, Footprint, Scalar, Texture, TexturePoint, Textures, source::channel_of, transform::less_periods,
    triplanar::Side,
};
use crate::{
    math::{DVec2, DVec3, Rgb, Vec2, Vec3},
    value::Channel,
};

/// A look-up of a texture at a point.
#[derive(Clone, Copy)]
pub struct Lookup<'a> {
    /// All textures of the scene.
    pub textures: &'a Textures<'a>,
    pub(super) texture: &'a Texture,
    pub(super) at: &'a TexturePoint,
    /// The displacement of the coordinates, if there is one.
    pub(super) shift: Option<Vec3>,
    /// The side of a body that the mapping shows, if it has sides.
    pub(super) side: Option<Side>,
}

/// A place in the coordinates of a texture, in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// s and t.
    Plane(DVec2),
    /// The three coordinates of a mapping in space.
    Space(DVec3),
}

/// From here on cells of a pattern have no exact numbers.
const TOO_FAR: f64 = (1_u64 << 52) as f64;

impl Place {
    /// The place in a pattern that is `scale` times as fine; `None` where it is too far away, or not finite.
    pub fn scaled(self, scale: f32) -> Option<Self> {
        let scale = f64::from(scale);
        let (scaled, most) = match self {
            Self::Plane(p) => (Self::Plane(p * scale), (p * scale).abs().max_element()),
            Self::Space(p) => (Self::Space(p * scale), (p * scale).abs().max_element()),
        };
        (most < TOO_FAR && self.is_finite()).then_some(scaled)
    }

    fn is_finite(self) -> bool {
        match self {
            Self::Plane(p) => p.is_finite(),
            Self::Space(p) => p.is_finite(),
        }
    }

    /// The first two coordinates.
    pub fn st(self) -> DVec2 {
        match self {
            Self::Plane(p) => p,
            Self::Space(p) => p.truncate(),
        }
    }

    /// All three; in the plane the third is 0.
    pub fn xyz(self) -> DVec3 {
        match self {
            Self::Plane(p) => p.extend(0.0),
            Self::Space(p) => p,
        }
    }
}

/// The width of an interval over which numbers with a standard deviation of 1 are spread evenly.
pub const EVEN_WIDTH: f32 = 3.464_101_6;

impl Lookup<'_> {
    /// The coordinates s and t, of which whole periods of the pattern may be missing.
    #[inline]
    pub fn st(&self) -> Vec2 {
        match (self.side, self.shift) {
            (None, None) => self.texture.st(self.at),
            (None, Some(shift)) => self.texture.st(self.at) + shift.truncate(),
            (Some(_), _) => less_periods(self.place().st(), self.texture.pattern.periods()),
        }
    }

    /// The axes of the footprint in s and t, from end to end.
    #[inline]
    pub fn st_axes(&self) -> [Vec2; 2] {
        let texture = self.texture;
        if let (Some(side), Some(solid)) = (self.side, texture.mapping.solid()) {
            let step = |duv| side.st(solid.step(self.at, duv).as_dvec3()).as_vec2();
            return self.at.footprint.map(step);
        }
        // Not a map of the array, which is a call.
        let [a, b] = texture.mapping.footprint(self.at);
        [texture.transform.vector(a), texture.transform.vector(b)]
    }

    /// The footprint in the texels of a picture of this size, and its level, if the point knows it.
    #[inline(always)]
    pub fn shared_footprint(&self, size: Vec2) -> Option<(Footprint, f32)> {
        self.at.shared_footprint.on(size).filter(|_| self.texture.lies_on_uv)
    }

    /// Whether the point has no footprint.
    #[inline]
    pub fn is_at_point(&self) -> bool {
        self.at.footprint == [Vec2::ZERO; 2]
    }

    /// The coordinates without loss.
    pub fn place(&self) -> Place {
        let (mapping, at) = (&self.texture.mapping, self.at);
        let shift = self.shift.unwrap_or_default().as_dvec3();
        match mapping.solid() {
            Some(solid) => match self.side {
                None => Place::Space(solid.place(at) + shift),
                Some(side) => Place::Plane(side.st(solid.place(at) + shift)),
            },
            None => {
                let st = mapping.st(at).as_dvec2() + mapping.origin(at).as_dvec2();
                Place::Plane(self.texture.transform.exact(st) + shift.truncate())
            }
        }
    }

    /// The numbers of another texture at the same point, in linear light of Rec. 709.
    pub fn color(&self, source: &Color) -> Rgb {
        self.textures.source_numbers(source, self.at)
    }

    /// A number of another texture at the same point.
    pub fn scalar(&self, source: &Scalar) -> f32 {
        match source.texture() {
            None => source.at_number(0.0),
            Some((id, Channel::A)) => source.at_number(self.textures.channel(id, Channel::A, self.at)),
            Some((id, channel)) => source.at_number(channel_of(self.color(&Color::Texture(id)), channel)),
        }
    }

    /// The numbers of another texture at the same point, and their standard deviation within the
    /// footprint, a mean over the channels.
    pub fn moments(&self, source: &Color) -> (Rgb, f32) {
        self.textures.source_moments(source, self.at)
    }

    /// A number of another texture at the same point, and its standard deviation within the footprint.
    pub fn scalar_moments(&self, source: &Scalar) -> (f32, f32) {
        match source.texture() {
            None | Some((_, Channel::A)) => (self.scalar(source), 0.0),
            Some((id, channel)) => {
                let (numbers, spread) = self.moments(&Color::Texture(id));
                let spread = (source.at_number(spread) - source.at_number(0.0)).abs();
                (source.at_number(channel_of(numbers, channel)), spread)
            }
        }
    }

    /// The axes of the footprint in the coordinates of [`Lookup::place`], from end to end.
    pub fn axes(&self) -> [Vec3; 2] {
        if self.is_at_point() {
            return [Vec3::ZERO; 2];
        }
        match self.texture.mapping.solid() {
            Some(solid) if self.side.is_none() => self.at.footprint.map(|duv| solid.step(self.at, duv)),
            _ => self.st_axes().map(|d| d.extend(0.0)),
        }
    }

    /// The width of the footprint and its length, in the coordinates of [`Lookup::place`]; 0 for a point.
    pub fn widths(&self) -> [f32; 2] {
        let [a, b] = self.axes();
        let long = a.length().max(b.length());
        if long > 0.0 {
            [a.cross(b).length() / long, long]
        } else {
            [0.0; 2]
        }
    }
}
