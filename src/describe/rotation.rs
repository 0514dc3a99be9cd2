//! Rotations: three angles, or a quaternion.

use glam::{DMat3, DQuat};
use serde::{Deserialize, Deserializer, de};

use crate::{
    math::{keys, transform},
    shape::mesh::Precise,
    value::Point,
};

/// A rotation.
#[derive(Clone, Copy, Debug)]
pub enum RotationDesc {
    /// Degrees about the fixed x, y and z axes in this order.
    Angles(Point),
    Quaternion(QuaternionDesc),
}

impl Default for RotationDesc {
    fn default() -> Self {
        Self::Angles(Point::default())
    }
}

/// A quaternion of length 1.
#[derive(Clone, Copy, Debug)]
pub struct QuaternionDesc(pub DQuat);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Components {
    qx: Precise,
    qy: Precise,
    qz: Precise,
    qw: Precise,
}

impl RotationDesc {
    pub fn matrix(&self) -> DMat3 {
        match self {
            Self::Angles(angles) => transform::rotation(angles.0),
            Self::Quaternion(QuaternionDesc(rotation)) => DMat3::from_quat(*rotation),
        }
    }
}

impl<'de> Deserialize<'de> for QuaternionDesc {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let Components { qx, qy, qz, qw } = Components::deserialize(d)?;
        let rotation = DQuat::from_xyzw(qx.0, qy.0, qz.0, qw.0);
        let length = rotation.length();
        if length > 0.0 && length.is_finite() {
            Ok(Self(keys::normalized(rotation)))
        } else {
            Err(de::Error::custom("a quaternion has a length above 0"))
        }
    }
}

impl<'de> Deserialize<'de> for RotationDesc {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = RotationDesc;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("[x, y, z] in degrees, or a quaternion { qx, qy, qz, qw }")
            }
            fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<RotationDesc, A::Error> {
                Point::deserialize(de::value::SeqAccessDeserializer::new(seq)).map(RotationDesc::Angles)
            }
            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<RotationDesc, A::Error> {
                QuaternionDesc::deserialize(de::value::MapAccessDeserializer::new(map)).map(RotationDesc::Quaternion)
            }
        }
        d.deserialize_any(Visitor)
    }
}
