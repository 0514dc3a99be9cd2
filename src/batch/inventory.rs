//! The inventory of a scene: its parts, and the treatment of each feature of its files.

use std::{collections::BTreeMap, path::Path};

use serde::Serialize;

use crate::{
    assets::{
        Store,
        model::{AnimationChoice, Treatment},
        motion::ModelClip,
        store::ModelReport,
    },
    math::{Vec3, sorting},
    scene::SceneBuilder,
    warnings::Warning,
};

/// The parts of a loaded scene. Its JSON has the same names.
#[derive(Clone, Debug, Serialize)]
pub struct Inventory {
    pub objects: usize,
    /// Stored triangles: those of an instanced mesh count once.
    pub triangles: usize,
    pub instances: usize,
    /// Shapes that are no meshes.
    pub shapes: usize,
    pub materials: usize,
    pub textures: usize,
    pub images: Vec<ImageEntry>,
    /// Without emitting surfaces.
    pub lights: usize,
    pub emitting_materials: usize,
    /// The box around all objects but infinite planes; `None` if there is nothing.
    pub bounds: Option<BoundsEntry>,
    pub models: Vec<ModelEntry>,
    /// Bytes of memory, by kind.
    pub memory: Vec<MemoryEntry>,
    pub warnings: Vec<Warning>,
}

/// A box in world space, in m.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BoundsEntry {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

impl BoundsEntry {
    fn new(scene: &SceneBuilder) -> Option<Self> {
        let bounds = scene.geometry().world_bounds();
        let world = |p: Vec3| (scene.origin() + p.as_dvec3()).to_array();
        (!bounds.is_empty()).then(|| Self {
            min: world(bounds.min),
            max: world(bounds.max),
        })
    }
}

#[derive(Clone, Debug, Serialize)]
pub struct ImageEntry {
    pub width: u32,
    pub height: u32,
    pub channels: usize,
}

#[derive(Clone, Debug, Serialize)]
pub struct MemoryEntry {
    pub kind: &'static str,
    pub bytes: u64,
}

/// A model file.
#[derive(Clone, Debug, Serialize)]
pub struct ModelEntry {
    pub file: String,
    /// The names of its cameras; may be empty.
    pub cameras: Vec<String>,
    /// The names of its material variants.
    pub variants: Vec<String>,
    pub animations: Vec<AnimationEntry>,
    pub lights: usize,
    pub features: Vec<FeatureEntry>,
}

/// An animation of a model file.
#[derive(Clone, Debug, Serialize)]
pub struct AnimationEntry {
    pub name: String,
    /// The time of its last key, in s; `None` if it cannot be read.
    pub seconds: Option<f32>,
    /// The kinds of targets that it moves, and the number of each.
    pub moves: BTreeMap<&'static str, usize>,
    /// Whether it is played.
    pub played: bool,
}

impl AnimationEntry {
    fn new(clip: &ModelClip, played: Option<&AnimationChoice>) -> Self {
        Self {
            name: clip.name.clone(),
            seconds: Some(clip.length).filter(|length| length.is_finite()),
            moves: sorting::ordered(clip.moves.iter().copied()),
            played: match played {
                None => false,
                Some(AnimationChoice::All) => true,
                Some(AnimationChoice::Named(names)) => names.contains(&clip.name),
            },
        }
    }
}

#[derive(Clone, Debug, Serialize)]
pub struct FeatureEntry {
    pub name: String,
    pub count: usize,
    /// The things that use it, in the singular.
    pub used_by: &'static str,
    /// `"rendered"`, `"in part"`, `"not needed"` or `"not rendered"`.
    pub treatment: &'static str,
    /// The part that is left out, or the reason; may be empty.
    pub detail: &'static str,
}

impl Inventory {
    pub(super) fn new(scene: &SceneBuilder, store: &Store) -> Self {
        let geometry = scene.geometry();
        let image = |b: &crate::texture::Bitmap| ImageEntry {
            width: b.width,
            height: b.height,
            channels: b.channels,
        };
        let emits = |m: &&crate::material::Material| m.emission().is_some();
        let memory = store.files().memory().taken();
        Self {
            // Parts of objects are none of their own.
            objects: scene.objects().iter().filter(|object| object.part_of.is_none()).count(),
            triangles: geometry.triangles.len(),
            instances: geometry.instances.len(),
            shapes: geometry.prim_count() - geometry.triangles.len(),
            materials: scene.materials().len(),
            textures: scene.texture_count(),
            images: scene.bitmaps().iter().map(image).collect(),
            lights: scene.lights().len(),
            emitting_materials: scene.materials().map(|(_, m)| m).filter(emits).count(),
            bounds: BoundsEntry::new(scene),
            models: store.model_reports().iter().map(ModelEntry::new).collect(),
            memory: memory
                .map(|(kind, bytes)| MemoryEntry {
                    kind: kind.name(),
                    bytes,
                })
                .to_vec(),
            warnings: store.warnings().list(),
        }
    }
}

impl ModelEntry {
    fn new(report: &ModelReport) -> Self {
        let file = |path: &Path| path.display().to_string();
        let features = report.features.iter().map(|feature| {
            let (treatment, detail) = match feature.treatment {
                Treatment::Rendered => ("rendered", ""),
                Treatment::Unneeded(why) => ("not needed", why),
                Treatment::InPart(part) => ("in part", part),
                Treatment::Without(instead) => ("not rendered", instead),
            };
            FeatureEntry {
                name: feature.name.clone(),
                count: feature.count,
                used_by: feature.used_by,
                treatment,
                detail,
            }
        });
        Self {
            file: file(&report.request.path),
            cameras: report.cameras.clone(),
            variants: report.variants.clone(),
            animations: (report.clips.iter())
                .map(|clip| AnimationEntry::new(clip, report.request.choice.animation.as_ref()))
                .collect(),
            lights: report.lights,
            features: features.collect(),
        }
    }
}
