//! Which rays meet an object.

use serde::Deserialize;

use crate::bsdf::Lobe;

/// The kinds of rays, by where they come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RayKind {
    #[default]
    Camera,
    /// Reflected by a diffuse lobe.
    Diffuse,
    /// Reflected by another lobe.
    Reflection,
    Transmission,
    Shadow,
}

impl From<Lobe> for RayKind {
    #[inline(always)]
    fn from(lobe: Lobe) -> Self {
        match lobe {
            Lobe::Diffuse => Self::Diffuse,
            Lobe::Specular => Self::Reflection,
            Lobe::Transmission => Self::Transmission,
        }
    }
}

/// The rays that meet an object; the others pass as if it were not there.
///
/// | key | the object is met by rays |
/// |---|---|
/// | `camera` | from the camera |
/// | `diffuse` | that a diffuse lobe has reflected |
/// | `reflection` | that another lobe has reflected, such as a mirror |
/// | `transmission` | that a surface has let through |
/// | `shadow` | from surfaces to lights |
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RayVisibility {
    pub camera: bool,
    pub diffuse: bool,
    pub reflection: bool,
    pub transmission: bool,
    pub shadow: bool,
}

impl Default for RayVisibility {
    fn default() -> Self {
        Self {
            camera: true,
            diffuse: true,
            reflection: true,
            transmission: true,
            shadow: true,
        }
    }
}

impl RayVisibility {
    #[inline]
    pub(super) fn is_met(self, by: RayKind) -> bool {
        match by {
            RayKind::Camera => self.camera,
            RayKind::Diffuse => self.diffuse,
            RayKind::Reflection => self.reflection,
            RayKind::Transmission => self.transmission,
            RayKind::Shadow => self.shadow,
        }
    }

    /// Whether rays that surfaces scatter and shadow rays meet the same: all of them, or none.
    fn is_even(self) -> bool {
        let Self {
            diffuse,
            reflection,
            transmission,
            shadow,
            ..
        } = self;
        [diffuse, reflection, transmission].iter().all(|seen| *seen == shadow)
    }
}

/// Whether any of the objects that these rays meet is hidden from some, and whether light sampling alone must find what lights
/// bring: rays that surfaces scatter meet other objects than shadow rays do, so that the two techniques look for different light.
pub(super) fn of_objects(rays: impl Iterator<Item = RayVisibility> + Clone, emits: bool) -> (bool, bool) {
    let hides = rays.clone().any(|rays| rays != RayVisibility::default());
    let is_odd = |rays: RayVisibility| !rays.is_even() || (emits && !rays.shadow);
    (hides, hides && rays.into_iter().any(is_odd))
}
