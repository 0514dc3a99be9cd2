//! The settings of subdivision surfaces.

use serde::{Deserialize, Deserializer, de};

use crate::{kind::named, value::number};

named! {
    /// The rules by which a mesh is subdivided.
    #[derive(Hash, PartialOrd, Ord)]
    pub enum Scheme: "subdivision" {
        CatmullClark = "catmull-clark",
        /// For triangles.
        Loop = "loop",
        /// Faces are split, and stay where they are.
        Linear = "linear",
    }
}

named! {
    /// The vertices at which a boundary has a corner.
    #[derive(Default, Hash, PartialOrd, Ord)]
    pub enum BoundaryRule: "boundary" {
        /// None: it is a smooth curve.
        #[default]
        Smooth = "smooth",
        /// The vertices of one face alone.
        Corners = "corners",
    }
}

/// A number of which the bits are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Bits(u32);

impl Bits {
    pub fn new(number: f32) -> Self {
        Self(number.to_bits())
    }

    pub fn get(self) -> f32 {
        f32::from_bits(self.0)
    }
}

/// The number of times that every face is split into four.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Levels(pub u32);

impl Levels {
    /// The most of them.
    pub const MAX: u32 = 12;
}

impl<'de> Deserialize<'de> for Levels {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let levels = number(d)?;
        match (0.0..=f64::from(Self::MAX)).contains(&levels) && levels.fract() == 0.0 {
            true => Ok(Self(levels as u32)),
            false => Err(de::Error::custom(format_args!(
                "expected a whole number from 0 to {}, found {levels}",
                Self::MAX
            ))),
        }
    }
}

/// A subdivision of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Subdivision {
    /// At least 1, unless it is displaced as it is.
    pub levels: u32,
    /// `None` for that of the faces: Loop for triangles alone, else Catmull-Clark.
    pub scheme: Option<Scheme>,
    pub boundary: BoundaryRule,
    /// Edges between faces whose normals are more than this many degrees apart are creases.
    pub crease_angle: Option<Bits>,
    /// The number of levels on which they are creases.
    pub crease_sharpness: Bits,
}

impl Subdivision {
    /// A number of levels with the defaults of everything else.
    pub fn of_levels(levels: u32) -> Self {
        Self {
            levels,
            scheme: None,
            boundary: BoundaryRule::default(),
            crease_angle: None,
            crease_sharpness: Bits::new(f32::INFINITY),
        }
    }

    /// Whether it needs faces of any number of corners, not their triangles alone.
    pub fn reads_polygons(&self) -> bool {
        self.levels > 0 && self.scheme != Some(Scheme::Loop)
    }
}
