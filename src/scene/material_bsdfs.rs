//! The BSDFs of materials. Those of constant materials are made once.

use std::{borrow::Cow, sync::OnceLock};

use crate::{
    bsdf::Bsdf,
    material::{BatchKind, Material, MaterialId},
    texture::{TexturePoint, Textures},
};

/// The BSDFs of all materials of a scene.
#[derive(Default)]
pub struct MaterialBsdfs {
    all: Vec<MaterialBsdf>,
    /// A bit for each kind of block that a material uses.
    batch_kinds: u8,
}

struct MaterialBsdf {
    batch_kind: BatchKind,
    /// The BSDF of a constant material, made at its first use; `None` if it varies over surfaces.
    constant: Option<OnceLock<Bsdf>>,
}

impl MaterialBsdfs {
    /// Precomputes these materials, some of which are given a normal map.
    pub fn new(materials: &[Material], is_given_map: impl Fn(MaterialId) -> bool) -> Self {
        let of = |(i, material): (usize, &Material)| MaterialBsdf {
            batch_kind: match material.batch_kind() {
                BatchKind::Diffuse if is_given_map(MaterialId(i as u32)) => BatchKind::Alone,
                kind => kind,
            },
            constant: (!material.is_spatially_varying()).then(OnceLock::new),
        };
        let all: Vec<_> = materials.iter().enumerate().map(of).collect();
        Self {
            batch_kinds: all
                .iter()
                .fold(0, |bits, material| bits | 1 << material.batch_kind as u8),
            all,
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

    /// Whether any material is shaded by this kind of block.
    #[inline]
    pub fn has_batch_kind(&self, kind: BatchKind) -> bool {
        self.batch_kinds >> kind as u8 & 1 == 1
    }

    /// Whether the scene has blocks of several kinds.
    pub fn mixes_batch_kinds(&self) -> bool {
        (self.batch_kinds & !(1 << BatchKind::Alone as u8)).count_ones() > 1
    }

    /// The kind of block that shades surfaces of a material.
    #[inline]
    pub fn batch_kind(&self, id: MaterialId) -> BatchKind {
        self.all[id.0 as usize].batch_kind
    }
}
