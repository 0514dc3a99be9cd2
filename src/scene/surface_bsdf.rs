//! The BSDFs of surfaces. Those of materials that are the same everywhere are made once.

use std::{borrow::Cow, sync::OnceLock};

use super::{Scene, SurfaceInteraction};
use crate::{bsdf::Bsdf, material::Material};

/// The BSDFs of the materials of a scene, where they do not vary over surfaces; each is made when it is first asked for.
#[derive(Default)]
pub struct ConstantBsdfs(Vec<Option<OnceLock<Bsdf>>>);

impl ConstantBsdfs {
    pub fn new(materials: &[Material]) -> Self {
        let of = |material: &Material| (!material.is_spatially_varying()).then(OnceLock::new);
        Self(materials.iter().map(of).collect())
    }
}

impl Scene {
    /// The BSDF of a surface.
    #[inline]
    pub fn bsdf(&self, surface: &SurfaceInteraction) -> Cow<'_, Bsdf> {
        let id = surface.material;
        let make = || self.material(id).bsdf(&self.textures(), &surface.texture);
        match &self.constant_bsdfs.0[id.0 as usize] {
            Some(bsdf) => Cow::Borrowed(bsdf.get_or_init(make)),
            None => Cow::Owned(make()),
        }
    }
}
