//! What a scene file says, as one value.

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Deserializer, de};

use super::{LightGroupName, OutputDesc, RenderDesc, Source};
use crate::{
    camera::CameraDesc,
    light::{LightDesc, environment::EnvironmentDesc},
    material::MaterialDesc,
    math::Transform,
    shape::ShapeDesc,
    texture::{MappingDesc, PatternDesc, StTransformDesc},
    value::{Point, Problem, Real, Span, Spanned, Tint},
};

/// A scene file, read.
#[derive(Clone, Debug)]
pub struct SceneDesc {
    pub source: Source,
    pub render: RenderDesc,
    pub camera: Option<Spanned<CameraDesc>>,
    pub background: BackgroundDesc,
    pub textures: Vec<TextureEntry>,
    pub materials: Vec<MaterialEntry>,
    pub objects: Vec<ObjectDesc>,
    pub lights: Vec<LightEntry>,
    pub output: OutputDesc,
}

impl SceneDesc {
    /// The folder that the file's paths are relative to.
    pub fn folder(&self) -> &Path {
        self.source.path.parent().unwrap_or(Path::new(""))
    }

    /// The names of the light groups, each once; the first has no name and holds the lights that are in no group.
    pub fn light_groups(&self) -> Vec<String> {
        let lights = self.lights.iter().map(|light| &light.group);
        let objects = self.objects.iter().map(|object| &object.group);
        let mut names = vec![String::new()];
        for group in lights.chain(objects).chain([&self.background.group]).flatten() {
            if names.iter().all(|name| name != group.as_str()) {
                names.push(group.as_str().to_owned());
            }
        }
        names
    }

    /// The file's name without its ending.
    pub fn name(&self) -> String {
        let stem = self.source.path.file_stem();
        stem.map_or_else(|| "scene".into(), |s| s.to_string_lossy().into_owned())
    }
}

/// `[background]`.
///
/// | key | type | unit | default |
/// |---|---|---|---|
/// | `color` | `[r, g, b]` | W m^-2 sr^-1 | black |
/// | `environment` | `{ file, intensity, rotate }`, see [`crate::light::environment`]; instead of `color` | | none |
/// | `visible` | whether camera rays see it; where not, RGB and A are 0. It lights the scene all the same | | true |
/// | `group` | the name of a light group: letters, digits, `_`, `-`, at most 18 | | none |
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BackgroundDesc {
    pub color: Option<Tint>,
    pub environment: Option<Spanned<EnvironmentDesc>>,
    pub visible: bool,
    pub group: Option<LightGroupName>,
}

impl BackgroundDesc {
    /// What a background can be.
    pub const NAMES: &[&str] = &["color", "environment"];
}

impl Default for BackgroundDesc {
    fn default() -> Self {
        Self {
            color: None,
            environment: None,
            visible: true,
            group: None,
        }
    }
}

/// `[texture.NAME]`.
#[derive(Clone, Debug)]
pub struct TextureEntry {
    pub name: Spanned<String>,
    pub pattern: PatternDesc,
    pub mapping: MappingDesc,
    pub transform: StTransformDesc,
}

/// `[material.NAME]`.
#[derive(Clone, Debug)]
pub struct MaterialEntry {
    pub name: Spanned<String>,
    pub material: MaterialDesc,
}

/// `[[light]]`.
///
/// | key | type | default |
/// |---|---|---|
/// | `point`, `spot`, `sun` or another kind | the light, see [`crate::light`] | one is required |
/// | `group` | the name of a light group: letters, digits, `_`, `-`, at most 18 | none |
///
/// What lights of one group, objects that emit light and the background add to the picture can be written as a picture
/// of its own.
///
/// ```toml
/// [[light]]
/// group = "key"
/// sun = { direction = [-1, -2, -1], irradiance = 3 }
/// ```
#[derive(Clone, Debug)]
pub struct LightEntry {
    pub span: Span,
    pub group: Option<LightGroupName>,
    pub light: LightDesc,
}

/// `[[object]]`.
///
/// | key | type | default |
/// |---|---|---|
/// | `name` | text, once in a file | `object N`, N from 1 |
/// | `material` | the name of a `[material.NAME]` | required; a mesh has its own |
/// | `shape` | a shape | required |
/// | `transform` | `{ translate, rotate, scale }` or `{ matrix }` | none |
/// | `group` | the name of the light group of the light that it emits: letters, digits, `_`, `-`, at most 18 | none |
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectDesc {
    pub name: Option<Spanned<String>>,
    /// Only a mesh goes without: it has its own.
    pub material: Option<Spanned<String>>,
    pub shape: Spanned<ShapeDesc>,
    pub transform: Option<Spanned<TransformDesc>>,
    pub group: Option<LightGroupName>,
}

/// An object's place: `scale` first, then `rotate` (degrees about the fixed x, y and z axes in this order), then
/// `translate` (m); or `matrix`, four rows of four numbers, the last `0 0 0 1`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransformDesc {
    translate: Option<Point>,
    rotate: Option<Point>,
    scale: Option<Scale>,
    matrix: Option<[[Real; 4]; 4]>,
}

impl TransformDesc {
    pub fn compile(&self, span: Span) -> Result<Transform, Problem> {
        if self.matrix.is_some() && (self.translate.is_some() || self.rotate.is_some() || self.scale.is_some()) {
            let message = "`matrix` stands alone, without `translate`, `rotate` and `scale`";
            return Err(Problem::at(span, message));
        }
        let wide = |p: Option<Point>, default: DVec3| p.map_or(default, |p| p.0.as_dvec3());
        let transform = match &self.matrix {
            Some(rows) => Transform::from_rows(rows.map(|row| row.map(|v| f64::from(v.0)))),
            None => Transform::from_parts(
                wide(self.translate, DVec3::ZERO),
                wide(self.rotate, DVec3::ZERO),
                self.scale.as_ref().map_or(DVec3::ONE, |s| s.0),
            ),
        };
        transform.ok_or_else(|| {
            Problem::at(span, "the transform has no inverse").with_help("it flattens its object; no scale may be 0")
        })
    }
}

/// One factor, or one for each axis.
#[derive(Clone, Debug)]
struct Scale(DVec3);

impl<'de> Deserialize<'de> for Scale {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct ScaleVisitor;
        impl<'de> de::Visitor<'de> for ScaleVisitor {
            type Value = Scale;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a number or [x, y, z]")
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<Scale, E> {
                Ok(Scale(DVec3::splat(v)))
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<Scale, E> {
                self.visit_f64(v as f64)
            }
            fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<Scale, A::Error> {
                let p = Point::deserialize(de::value::SeqAccessDeserializer::new(seq))?;
                Ok(Scale(p.0.as_dvec3()))
            }
        }
        d.deserialize_any(ScaleVisitor)
    }
}
