//! The backs of surfaces: shaded as the fronts, black, or not there.
//!
//! A material has a setting, and an object may have one that wins over those of its materials. The back is the side that the
//! geometric normal does not point to, whatever shading normals say.

use serde::Deserialize;

use crate::{material::Material, math::Sidedness};

/// The backs of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BackFaces {
    /// They are shaded as the fronts are.
    #[default]
    Shaded,
    /// They reflect, transmit and emit nothing, and block light.
    Black,
    /// Rays of all kinds pass them as if they were not there.
    Culled,
}

/// The backs of all surfaces of an object, whatever their materials say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ObjectBackFaces {
    Shaded,
    Black,
    Culled,
    /// Culled where the material of the model's file has one side, as those of glTF without `doubleSided`.
    File,
}

/// The backs of the surfaces of a material.
#[derive(Clone, Copy, Debug, Default)]
pub struct MaterialBackFaces {
    pub own: BackFaces,
    /// The back faces on objects with [`ObjectBackFaces::File`].
    pub in_file: BackFaces,
}

/// The reason why surfaces of a material are the same from both sides, whatever is said of their backs; `None` where they are not.
pub fn two_sided_reason(material: &Material) -> Option<&'static str> {
    if material.medium().is_some() {
        Some("light enters a body through it")
    } else if material.emission().is_some_and(|e| e.sidedness == Sidedness::Both) {
        Some("it emits light from both sides")
    } else {
        None
    }
}

/// Whether any surface of a scene has backs of these kinds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UsedBackFaces {
    pub black: bool,
    pub culled: bool,
}

impl UsedBackFaces {
    /// Collects the settings of objects and materials.
    pub fn new(
        objects: impl Iterator<Item = Option<ObjectBackFaces>> + Clone,
        materials: &[MaterialBackFaces],
    ) -> Self {
        let has_object = |backs| objects.clone().any(|own| own == Some(backs));
        let reads_files = has_object(ObjectBackFaces::File);
        let has = |of_object, of_material| {
            let is_of = |m: &MaterialBackFaces| m.own == of_material || reads_files && m.in_file == of_material;
            has_object(of_object) || materials.iter().any(is_of)
        };
        Self {
            black: has(ObjectBackFaces::Black, BackFaces::Black),
            culled: has(ObjectBackFaces::Culled, BackFaces::Culled),
        }
    }
}
