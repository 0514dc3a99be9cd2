//! The BSDFs of materials. Those of materials that are the same everywhere are made once.

use std::{borrow::Cow, sync::OnceLock};

use crate::{
    bsdf::Bsdf,
    material::{BatchKind, Material, MaterialId},
    texture::{TexturePoint, Textures},
};

/// What a scene knows of the BSDFs of its materials.
#[derive(Default)]
pub struct MaterialBsdfs {
    all: Vec<MaterialBsdf>,
    /// One bit for each kind of batch that there is.
    batch_kinds: u8,
}

struct MaterialBsdf {
    batch_kind: BatchKind,
    /// Where it does not vary over surfaces; made when it is first asked for.
    constant: Option<OnceLock<Bsdf>>,
}

impl MaterialBsdfs {
    pub fn new(materials: &[Material]) -> Self {
        let of = |material: &Material| MaterialBsdf {
            batch_kind: material.batch_kind(),
            constant: (!material.is_spatially_varying()).then(OnceLock::new),
        };
        let kinds = materials.iter().map(Material::batch_kind);
        Self {
            all: materials.iter().map(of).collect(),
            batch_kinds: kinds.fold(0, |bits, kind| bits | 1 << kind as u8),
        }
    }

    /// The BSDF of `material`, whose index is `id`, at a point.
    #[inline]
    pub fn at(&self, id: MaterialId, material: &Material, textures: &Textures<'_>, at: &TexturePoint) -> Cow<'_, Bsdf> {
        match &self.all[id.0 as usize].constant {
            Some(bsdf) => Cow::Borrowed(bsdf.get_or_init(|| material.bsdf(textures, at))),
            None => Cow::Owned(material.bsdf(textures, at)),
        }
    }

    /// Whether surfaces of a material are shaded together in this way.
    #[inline]
    pub fn has_batch_kind(&self, kind: BatchKind) -> bool {
        self.batch_kinds >> kind as u8 & 1 == 1
    }

    /// The way in which surfaces of a material are shaded together.
    #[inline]
    pub fn batch_kind(&self, id: MaterialId) -> BatchKind {
        self.all[id.0 as usize].batch_kind
    }
}
