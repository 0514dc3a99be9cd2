//! Colours and numbers of materials, constant or textured.

use super::TextureId;
use crate::{
    math::{Rgb, WorkingSpace},
    value::{Channel, ColorSource, Problem, ScalarSource, Spanned},
};

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

    /// The colour where its texture has the one that `of` tells.
    #[inline(always)]
    pub(super) fn with(&self, of: impl FnOnce(TextureId) -> Rgb) -> Rgb {
        match self {
            Self::Constant(color) => *color,
            Self::Texture(id) => of(*id),
            Self::Tinted(id, tint) => of(*id) * *tint,
        }
    }

    /// The texture that it reads.
    pub fn texture(&self) -> Option<TextureId> {
        match self {
            Self::Constant(_) => None,
            Self::Texture(id) | Self::Tinted(id, _) => Some(*id),
        }
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

/// The lookup of the colour of a source.
pub type FindColor<'a> = dyn Fn(&Spanned<ColorSource>) -> Result<Color, Problem> + 'a;

impl Scalar {
    /// Compiles a source; a texture without a channel is read in `channel`.
    pub fn compile(source: &Spanned<ScalarSource>, channel: Channel, find: &FindColor<'_>) -> Result<Self, Problem> {
        Ok(match source.get_ref() {
            ScalarSource::Constant(v) => Self::Constant(*v),
            ScalarSource::Texture { name, channel: given } => {
                match find(&Spanned::new(source.span(), ColorSource::Texture(name.clone())))? {
                    Color::Constant(color) => Self::Constant(color.r),
                    Color::Texture(id) | Color::Tinted(id, _) => Self::Texture(id, given.unwrap_or(channel), 1.0),
                }
            }
        })
    }

    /// Compiles a source of numbers from 0 to 1.
    pub fn compile_unit(
        source: &Spanned<ScalarSource>,
        channel: Channel,
        find: &FindColor<'_>,
    ) -> Result<Self, Problem> {
        match source.get_ref() {
            ScalarSource::Constant(v) if *v > 1.0 => {
                let message = format!("expected a number from 0 to 1, found {v}");
                Err(Problem::at(source.span(), message))
            }
            _ => Self::compile(source, channel, find),
        }
    }

    /// Whether it is the same everywhere.
    pub fn is_constant(&self) -> bool {
        matches!(self, Self::Constant(_))
    }

    /// The texture and its channel.
    #[inline(always)]
    pub fn texture(&self) -> Option<(TextureId, Channel)> {
        match self {
            Self::Constant(_) => None,
            Self::Texture(id, channel, _) | Self::Inverted(id, channel, _) => Some((*id, *channel)),
        }
    }

    /// The scalar where the channel of its texture is `number`.
    #[inline(always)]
    pub(super) fn at_number(&self, number: f32) -> f32 {
        match self {
            Self::Constant(v) => *v,
            Self::Texture(.., scale) => number * scale,
            Self::Inverted(.., scale) => 1.0 - number * scale,
        }
    }
}

/// Numbers without those that are not finite: none becomes 0, an infinite one the largest that there is.
#[inline]
pub(super) fn finite(numbers: Rgb) -> Rgb {
    if numbers.is_finite() {
        return numbers;
    }
    numbers.map(finite_number)
}

/// The same of one number.
pub(super) fn finite_number(v: f32) -> f32 {
    if v.is_nan() { 0.0 } else { v.clamp(f32::MIN, f32::MAX) }
}

/// A channel of a colour, which is opaque.
#[inline(always)]
pub(super) fn channel_of(color: Rgb, channel: Channel) -> f32 {
    match channel {
        Channel::R => color.r,
        Channel::G => color.g,
        Channel::B => color.b,
        Channel::A => 1.0,
    }
}
