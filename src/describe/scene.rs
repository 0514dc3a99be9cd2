//! A scene file describes everything that is rendered: materials, objects, lights, the camera and the output.
//!
//! It is a TOML file. A value whose kind can be chosen is named by a key: `shape.sphere = { radius = 1 }`. A kind without
//! keys may be a word: `mapping = "asin"`. An unknown key is an error that suggests the nearest known one.
//! `batch-render schema > scene.schema.json` writes its JSON Schema, by which editors with taplo, such as Visual Studio Code with
//! Even Better TOML, complete and check a file whose first line is `#:schema scene.schema.json`, the path from its own folder.
//!
//! - Lengths are in metres and angles in degrees. The space is right-handed; +y is up unless a camera says otherwise.
//! - Positions are in double precision. A scene far from the origin, by 1,000 m and more, is computed around its own
//!   centre, or around the first position of the camera where the scene is large, and keeps its millimetres there.
//!   Coordinates of an object's own space, under a `transform`, are in single precision.
//! - A colour is a number (gray) or `[r, g, b]`, scene-linear with the primaries of Rec. 709. Where a texture is allowed,
//!   `"texture.NAME"` is its colour and `"texture.NAME.r"` one of its channels.
//! - Files that are read are relative to the scene file; output files are relative to the current folder.
//!
//! ```toml
//! [camera]
//! perspective = { eye = [0, 1, 5], target = [0, 1, 0] }
//!
//! [material.red]
//! matte = { albedo = [0.8, 0.1, 0.1] }
//!
//! [[object]]
//! material = "red"
//! shape.sphere = { center = [0, 1, 0], radius = 1 }
//!
//! [[light]]
//! sun = { direction = [-1, -2, -1], irradiance = 3 }
//! ```

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{LightGroupName, ObjectPartDesc, OutputDesc, PartsDesc, RandomDesc, RenderDesc, Source, TransformDesc};
use crate::{
    camera::{CameraDesc, Timing},
    light::{LightDesc, environment::EnvironmentDesc, gradient::GradientDesc, sky::SkyDesc},
    material::{BumpDesc, MaterialDesc, NormalDesc},
    scene::{BackFaces, ObjectBackFaces, RayVisibility},
    shape::ShapeDesc,
    texture::{MappingDesc, PatternDesc, StTransformDesc, WarpDesc},
    value::{RgbFactor, Span, Spanned},
};

/// A scene file, read.
#[derive(Clone, Debug)]
pub struct SceneDesc {
    pub source: Source,
    /// The file of values that change over time, see [`Values`](super::Values).
    pub values: Option<Spanned<String>>,
    /// The values that are drawn at random for each frame.
    pub random: Option<RandomDesc>,
    pub render: RenderDesc,
    /// The scene's own camera. The table has a key that names the kind of camera, and may have a shutter.
    ///
    /// A camera path moves it and may change its lens; without one a single frame is rendered. It
    /// looks along its own -z, with +y up.
    ///
    /// ```toml
    /// [camera]
    /// perspective = { eye = [0, 1, 5], target = [0, 1, 0], fov = 40 }
    /// shutter = [0, 0.5]
    /// ```
    ///
    /// `shutter = [open, close]` are the times at which the shutter opens and closes, in frames from that of the
    /// picture: what moves between them is blurred. By default both are 0. `readout = 0.8` is a rolling shutter: the
    /// time in frames from the exposure of the first line to that of the last one. `readout_direction` is
    /// `"top_to_bottom"` (the default), `"bottom_to_top"`, `"left_to_right"` or `"right_to_left"`. Columns of the camera
    /// path win. The keys may stand without a kind of camera.
    pub camera: Option<Spanned<CameraDesc>>,
    /// The shutter of the scene's camera and the readout of its sensor.
    pub timing: Timing,
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

    /// The path of the background's environment map: relative to the scene file, or to the current folder where a flag names it.
    pub fn environment_file(&self) -> Option<PathBuf> {
        let file = &self.background.environment.as_ref()?.get_ref().file;
        Some(match self.source.overrides.is_of_stage(&file.span()) {
            true => PathBuf::from(file.get_ref()),
            false => self.folder().join(file.get_ref()),
        })
    }

    /// The names of the light groups, each once; the first has no name and holds the lights that are in no group.
    pub fn light_groups(&self) -> Vec<String> {
        let lights = self.lights.iter().filter_map(|light| light.group.as_ref());
        let objects = self.objects.iter().flat_map(ObjectDesc::groups);
        let mut names = vec![String::new()];
        for group in lights.chain(objects).chain(&self.background.group) {
            if names.iter().all(|name| name != group.as_str()) {
                names.push(group.as_str().to_owned());
            }
        }
        names
    }

    /// Whether any object is a shadow catcher.
    pub fn has_catchers(&self) -> bool {
        let is_given = |given: &Option<Spanned<bool>>| given.as_ref().is_some_and(|given| *given.get_ref());
        let is_catcher = |object: &ObjectDesc| {
            is_given(&object.shadow_catcher) || object.part.iter().any(|part| is_given(&part.shadow_catcher))
        };
        self.objects.iter().any(is_catcher)
    }

    /// The file's name without its ending.
    pub fn name(&self) -> String {
        let stem = self.source.path.file_stem();
        stem.map_or_else(|| "scene".into(), |s| s.to_string_lossy().into_owned())
    }
}

/// The surroundings of the scene: the radiance of rays that hit nothing.
///
/// | key | type | unit | default |
/// |---|---|---|---|
/// | `color` | number or `[r, g, b]`: a constant radiance | W m^-2 sr^-1 | black |
/// | `environment` | an environment map, instead of `color` | | none |
/// | `sky` | a clear sky with its sun, instead of `color` | | none |
/// | `gradient` | light that changes from below to above, instead of `color` | | none |
/// | `backdrop` | number or `[r, g, b]`: the radiance that the camera sees in place of all of these and of the disks of suns; it lights nothing, and mirrors and glass do not show it | W m^-2 sr^-1 | none |
/// | `visible` | whether the camera sees the background; if not, R, G, B and A are 0 there. It lights the scene all the same | | `true` |
/// | `group` | the name of its light group, see `[[light]]` | | none |
///
/// ```toml
/// [background]
/// color = [0.3, 0.5, 0.8]
/// ```
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BackgroundDesc {
    pub color: Option<RgbFactor>,
    pub environment: Option<Spanned<EnvironmentDesc>>,
    pub sky: Option<Box<Spanned<SkyDesc>>>,
    pub gradient: Option<Spanned<GradientDesc>>,
    pub backdrop: Option<RgbFactor>,
    pub visible: bool,
    pub group: Option<LightGroupName>,
}

impl BackgroundDesc {
    /// The names of the kinds of background.
    pub const NAMES: &[&str] = &["color", "environment", "sky", "gradient"];
}

impl Default for BackgroundDesc {
    fn default() -> Self {
        Self {
            color: None,
            environment: None,
            sky: None,
            gradient: None,
            backdrop: None,
            visible: true,
            group: None,
        }
    }
}

/// A texture: a colour that varies over a surface, used by materials as `"texture.NAME"`.
///
/// | key | type | default |
/// |---|---|---|
/// | one of the textures below | | required |
/// | `mapping` | how a point gets its texture coordinates s and t | `"uv"` |
/// | `transform` | scales, rotates and moves the texture | none |
/// | `warp` | `{ by = "texture.NAME", amount }`: another texture moves the coordinates | none |
/// | `factor` | number or `[r, g, b]` of at least 0, which multiplies the texture | 1 |
///
/// A texture moves with its object: `mapping.planar` reads the object's own coordinates. The bottom row of an image is t = 0.
///
/// `warp` moves s by the red channel of another texture, t by green and a third coordinate by blue: by `amount` (a number or one
/// for each coordinate, in units of the coordinates) where the channel is 1, by nothing where it is 0.5, and back by `amount`
/// where it is 0. Textures that read others (`mix`, `ramp`) take their numbers in linear light of Rec. 709. At most 64 are
/// nested; none may contain itself.
///
/// ```toml
/// [texture.bricks]
/// image = { file = "bricks.png" }
/// transform = { scale = 4 }
///
/// [material.wall]
/// matte = { albedo = "texture.bricks" }
/// ```
#[derive(Clone, Debug)]
pub struct TextureEntry {
    pub name: Spanned<String>,
    pub pattern: PatternDesc,
    pub mapping: MappingDesc,
    pub transform: StTransformDesc,
    pub warp: Option<WarpDesc>,
    pub factor: Option<RgbFactor>,
    /// The keys that are given and tell where the texture lies.
    pub placed_by: Vec<Spanned<&'static str>>,
}

/// A material: how a surface reflects, transmits and emits light.
///
/// The table has one key that names the kind of material, and may have others:
///
/// | key | type | unit | default |
/// |---|---|---|---|
/// | `back_faces` | `"shaded"`, `"black"` or `"culled"`: how the side looks to which normals do not point, see [`[[object]]`](object.md) | | `"shaded"` |
/// | `bump` | `{ height = "texture.NAME", distance }`: heights above the surface, 0 where the texture (channel r) is 0 and `distance` where it is 1 | m | none |
/// | `normal` | `{ map = "texture.NAME", scale }`, in place of `bump`: a tangent-space normal map, raw, and its strength | | none; 1 |
///
/// Objects use the material by its NAME. Objects whose material emits light are area lights.
///
/// `bump` and `normal` turn the shading normal; the surface stays where it is. Heights may come from any texture, with any mapping,
/// and are as high as `distance` in the object's own space: a `transform` stretches them with the object. Their slope is measured
/// over a texel, or over what a ray sees of the surface where that is more, so that they fade from afar. The normals of a map
/// belong to its s and t, so that it is no texture that is made of others. A clear coat keeps the normal of the bare surface. A
/// mixture takes those of its materials.
///
/// ```toml
/// [material.wall]
/// matte = { albedo = [0.7, 0.7, 0.7] }
///
/// [[object]]
/// material = "wall"
/// shape.cuboid = { min = [-1, 0, -1], max = [1, 2, 1] }
///
/// [material.hammered]
/// metal = { preset = "copper", roughness = 0.2 }
/// bump = { height = "texture.dents", distance = 0.01 }
///
/// [texture.dents]
/// voronoi = { scale = 20 }
/// mapping = "object"
/// ```
#[derive(Clone, Debug)]
pub struct MaterialEntry {
    pub name: Spanned<String>,
    pub back_faces: Option<Spanned<BackFaces>>,
    pub material: MaterialDesc,
    pub bump: Option<Spanned<BumpDesc>>,
    pub normal: Option<Spanned<NormalDesc>>,
}

/// A light that is no object. The table has one key that names the kind of light, and may have others:
///
/// | key | type | default |
/// |---|---|---|
/// | `name` | text, unique among the lights: what values are set by | `light N`, N from 1 |
/// | `group` | the name of a light group: letters, digits, `_` and `-`, at most 18 | none |
///
/// The pass `lightgroup_NAME` shows what the lights, the emitting objects and the background of a group add to the picture.
///
/// Objects with a material that emits light, an environment map and a sky light the scene as well. Each shadow ray goes to one
/// light, chosen by how much it may bring to a matt surface, so thousands of lights cost about as much as ten. A smooth surface that
/// mirrors a small one among many needs more samples: its highlight is found as rarely as that light is chosen. An infinite `plane` that
/// emits light is found by chance only. Lights with a surface (`rect`, `disk`, `sphere`, `tube`, points and spots with a
/// `radius`) cast soft shadows and block nothing; the camera sees them only where they say so. The `whitted` integrator samples
/// lights differently: see its page.
///
/// Light is radiometric: 1 cd is 1 W/sr and 1 lux is 1 W/m^2 per channel. IES files of lamps are photometric, and
/// 683 of their candela are 1 W/sr.
///
/// ```toml
/// [[light]]
/// point = { position = [0, 3, 0], intensity = [40, 40, 36] }
/// group = "key"
/// ```
#[derive(Clone, Debug)]
pub struct LightEntry {
    pub span: Span,
    pub name: Option<Spanned<String>>,
    pub group: Option<LightGroupName>,
    pub light: LightDesc,
}

/// An object: a shape with a material.
///
/// | key | type | default |
/// |---|---|---|
/// | `name` | text, unique in the file | `object N`, N from 1 |
/// | `material` | NAME of a `[material.NAME]` | required, but a mesh has its own |
/// | `shape` | a shape | required |
/// | `transform` | `{ translate, rotate, scale }` or `{ matrix }` | none |
/// | `visible` | whether it is there at all: `false` hides it from the camera, from mirrors and from light | `true` |
/// | `ray_visibility` | the rays that meet it: `{ camera, diffuse, reflection, transmission, shadow }`, each `true` or `false` | all `true` |
/// | `holdout` | whether it cuts a hole into the picture: black with an alpha of 0 where the camera sees it, and in no matte | `false` |
/// | `shadow_catcher` | whether the camera sees only how other objects change its light: a transparent surface for shadows and reflections | `false` |
/// | `lights` | names of the lights that light it, see below | all |
/// | `exclude_lights` | names of lights that do not light it | none |
/// | `group` | the name of the light group of the light that it emits, see `[[light]]` | none |
/// | `back_faces` | `"shaded"`, `"black"`, `"culled"` or, of a model, `"file"`: how the sides look to which normals do not point | those of its materials |
/// | `nodes` | names of nodes of its model that are there, with all below them; `*` is any text, `?` any character | all |
/// | `part` | tables `[[object.part]]` with settings of some nodes, see below | none |
/// | `node` | tables by the names of nodes of its model: `transform` and `visible` | those of the file |
/// | `material_overrides` | by the names of materials of its model: NAME of a `[material.NAME]`, or a table of factors | those of the file |
///
/// Rays of a kind that `ray_visibility` leaves out pass the object as if it were not there: `{ camera = false }` hides it
/// and keeps its shadow and its reflections, `{ shadow = false }` keeps it from blocking lights. Where shadow rays and other
/// rays meet different objects, lights are found by light sampling alone, which adds noise on glossy surfaces and near
/// lamps. A holdout blocks light and is reflected as any object. PNG files have no alpha where the camera sees the
/// background, and show a holdout as black.
///
/// **A shadow catcher** stands for a surface of a photograph, the plate, that the picture is put over. Each of its pixels is
/// rendered twice with the same random numbers: as it is, `W`, and with lights and catchers alone, `O`. With `m`, the least of 1
/// and of the channels of `W / O`, its alpha is `1 - m` and its light `W - m O`, so that the plate is scaled by `W / O` where that
/// is gray: shadows, also those of environments and of light from other surfaces. Coloured light, reflections and what is brighter
/// than before is added as it would look on the catcher itself, so give it the material, and the scene the exposure, of the plate.
/// Over a darker plate, or none, the light that is left of a shadow between lights of different colours glows: one alpha cannot
/// tint. A background that the camera sees, unless it is black, is the plate, and is known: it shows through the catcher, each
/// channel times its own ratio, and darker where the plate is. Where objects change nothing, its pixels are exactly 0. An emitting
/// object counts as one of the objects, unless it is a catcher, too; lights are those of the plate. Mirrors and surfaces that light
/// bounces from meet a catcher as any object. Passes of light components and light groups leave it out; data and mattes have it.
///
/// Catchers take time: where they fill the picture, all paths are traced twice, and the frame takes two to three times as long. A
/// holdout throws its shadow on catchers as any object does. What lies behind glass, also behind a thin pane, is seen through an
/// object: its alpha is 1 there, and a catcher shows as the surface that it is.
///
/// **One-sided surfaces**: the back of a surface is the side that its geometric normal does not point to: of a shape the inside, of
/// a triangle the side from which its corners run clockwise. With `back_faces = "shaded"` both sides look the same. `"black"`: the
/// back reflects, transmits and emits nothing, and blocks light, as in Mitsuba without `twosided`. `"culled"`: rays that meet the
/// back pass as if it were not there (backface culling): those of the camera, of mirrors and of light that bounces, and shadow
/// rays, which run from the lit surface to the light. So one looks into a room through the outside of its walls, while the light
/// stays in it; and a plane whose back faces the floor throws no shadow on it. `"file"` culls the backs of those materials of a
/// glTF file that have no `doubleSided`, as glTF says. The key of an object wins over those of its materials. Surfaces through
/// which light enters a body (`glass` without `thin_walled`) and those that emit from both sides (`two_sided`) are never one-sided.
///
/// **Light linking**: `lights` and `exclude_lights` take names of lights, of emitting objects (of a model also its lights), of
/// light groups, `group:NAME` for a group alone, and `background`. Other lights neither light the surfaces of the object nor appear
/// in its reflections, but the object blocks and reflects light for others as before. `exclude_lights` wins over `lights`. The
/// `ambient` light of `whitted` has no name.
///
/// A transform scales first, then rotates about the fixed x, y and z axes in this order (degrees), then translates (m).
/// `rotate` is `[x, y, z]`, or a quaternion `{ qx, qy, qz, qw }`. `scale` is a number or `[x, y, z]`. A `matrix` has four rows of
/// four numbers, the last of them `[0, 0, 0, 1]`.
///
/// ```toml
/// [material.ball]
/// matte = { albedo = 0.5 }
///
/// [[object]]
/// name = "ball"
/// material = "ball"
/// shape.sphere = { radius = 1 }
/// transform = { translate = [0, 1, 0], scale = [1, 2, 1] }
/// ```
///
/// **Nodes and materials of a model** take other values than those of its file by their names:
///
/// ```text
/// [[object]]
/// name = "car"
/// shape.mesh = { file = "car.glb" }
///
/// [object.node.Wheel_L]
/// transform = { rotate = { x = 30 } }
///
/// [object.node.Roof]
/// visible = false
///
/// [object.material_overrides.Paint]
/// base_color = [0.6, 0.02, 0.02]
/// roughness = 0.3
///
/// [object.material_overrides]
/// Glass = "clear"
/// ```
///
/// **Parts of a model** have settings of their own by the names of nodes:
///
/// ```text
/// [[object]]
/// shape.mesh = { file = "car.glb" }
/// nodes = ["Body*", "Wheel*"]
///
/// [[object.part]]
/// nodes = ["Wheel*"]
/// material = "rubber"
/// exclude_lights = ["rim"]
///
/// [[object.part]]
/// nodes = ["Wheel_R", "Antenna"]
/// visible = false
/// ```
///
/// With `nodes` the object has no others. A part is `nodes` and all below them, with `material`, `visible`, `ray_visibility`,
/// `holdout`, `shadow_catcher`, `lights`, `exclude_lights`, `group` and `back_faces` in place of those of the object; what it does
/// not give is the object's. A node belongs to the last part that names it or a node above it, and to no other. Names are those of
/// `node` (a second `Wheel` is `Wheel#2`); in them `*` stands for any text and `?` for any character, and each must name a node.
/// Lights of the file go with their nodes. Mattes and numbers stay those of the object's nodes. Over frames
/// `object.NAME.part.0.visible` is a value of the first part.
///
/// `translate`, `rotate` and `scale` take the place of those of the node in its parent. Each is `[x, y, z]`, or a table of some of
/// `x`, `y` and `z`, whose others stay as in the rest pose. A node that is not visible hides those below it. A colour is a number,
/// `[r, g, b]` or a table of some of them. Names, factors and what they do are in [animation](../animation.md#parts-of-models).
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectDesc {
    pub name: Option<Spanned<String>>,
    /// Only a mesh goes without: it has its own.
    pub material: Option<Spanned<String>>,
    pub shape: Spanned<ShapeDesc>,
    pub transform: Option<Spanned<TransformDesc>>,
    /// Without it no ray meets the object, but its names and numbers stay.
    #[serde(default = "yes")]
    pub visible: bool,
    #[serde(default)]
    pub ray_visibility: RayVisibility,
    #[serde(default)]
    pub holdout: bool,
    pub shadow_catcher: Option<Spanned<bool>>,
    pub lights: Option<Vec<Spanned<String>>>,
    #[serde(default)]
    pub exclude_lights: Vec<Spanned<String>>,
    pub group: Option<LightGroupName>,
    pub back_faces: Option<Spanned<ObjectBackFaces>>,
    /// Names with wildcards of the nodes of a model that are there, with all below them.
    pub nodes: Option<Vec<Spanned<String>>>,
    /// The settings of some nodes.
    #[serde(default)]
    pub part: Vec<ObjectPartDesc>,
    /// The keys `node` and `material_overrides`.
    #[serde(skip)]
    pub parts: PartsDesc,
}

fn yes() -> bool {
    true
}

impl ObjectDesc {
    /// All names with wildcards of nodes of its model: of those that are there, and of its parts.
    pub fn node_patterns(&self) -> impl Iterator<Item = &Spanned<String>> {
        let of_parts = self.part.iter().map(|part| &part.nodes);
        self.nodes.iter().chain(of_parts).flatten()
    }

    /// The light groups that it and its parts name.
    fn groups(&self) -> impl Iterator<Item = &LightGroupName> {
        let of_parts = self.part.iter().filter_map(|part| part.group.as_ref());
        self.group.iter().chain(of_parts)
    }

    /// The object with the settings of one of its parts.
    pub fn with_part(&self, part: &ObjectPartDesc) -> Self {
        let (object, part) = (self.clone(), part.clone());
        Self {
            material: part.material.or(object.material),
            // Nothing of an object is there that is not visible itself.
            visible: object.visible && part.visible.unwrap_or(true),
            ray_visibility: part.ray_visibility.unwrap_or(object.ray_visibility),
            holdout: part.holdout.unwrap_or(object.holdout),
            shadow_catcher: part.shadow_catcher.or(object.shadow_catcher),
            lights: part.lights.or(object.lights),
            exclude_lights: part.exclude_lights.unwrap_or(object.exclude_lights),
            group: part.group.or(object.group),
            back_faces: part.back_faces.or(object.back_faces),
            ..object
        }
    }

    /// The factor that stands for a scale of exactly 0 in a table. It has an inverse, and an object of 1 m becomes one of 1 nm,
    /// which no picture shows, while its names, its numbers and its motion stay.
    const LEAST_SCALE: f64 = 1e-9;

    /// The same object, whose scales are not 0.
    pub(super) fn without_scales_of_zero(mut self) -> Self {
        let scale = self.transform.as_mut().and_then(|given| given.get_mut().scale.as_mut());
        for factor in scale.into_iter().flat_map(|scale| &mut scale.0) {
            if factor.0 == 0.0 {
                factor.0 = Self::LEAST_SCALE;
            }
        }
        self
    }
}
