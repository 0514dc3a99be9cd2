//! A triangle mesh from an OBJ, glTF, GLB, PLY or STL file.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `file` | path of the file, relative to the scene file | | required |
//! | `scene` | number from 0 or name of a scene in a glTF file | | the file's default |
//! | `variant` | name of a material variant of a glTF file | | the file's default materials |
//! | `lights` | `true` or `false`: whether the lights of a glTF file shine | | `false`, with a warning |
//! | `light_units` | unit of these lights: `"auto"`, `"photometric"` or `"unitless"` | | `"auto"` |
//! | `light_radius` | radius of its point lights and spots, at least 0; files do not say it, and soft shadows need it | m | 0 |
//! | `light_factor` | number of at least 0, which multiplies the intensities of its point lights and spots: the square of a scale keeps the light of a model that `transform` scales | | 1 |
//! | `animation` | name of an animation of a glTF file, a list of names, or `"all"`: those that are played | | none, with a warning |
//! | `start` | number: the time at which they begin | s | 0 |
//! | `speed` | number: seconds of the animation in a second; below 0 they run backwards from their last key | | 1 |
//! | `repeat` | `true`, `false`, or how often they are played, a whole number above 0 | | `false` |
//! | `radius` | number above 0: the radius of the points of a PLY file without faces | m | their mean distance to the nearest one |
//! | `subdivide` | whole number from 0 to 12: how often every face is split into four | levels | 0 |
//! | `subdivision` | the rules of it: `"catmull-clark"`, `"loop"` or `"linear"` | | `"loop"` for triangles alone, else `"catmull-clark"` |
//! | `boundary` | `"smooth"`, or `"corners"`: whether open edges keep their corners, vertices of one face | | `"smooth"` |
//! | `crease_angle` | number of at least 0: edges between faces whose normals are farther apart are creases | degrees | none; 30 for `"linear"` |
//! | `crease_sharpness` | number of at least 0: on how many levels they are creases; later ones round them | levels | all |
//! | `displacement` | `{ height, scale, midlevel }`: how far vertices are moved along their normals | | none |
//!
//! ```toml
//! [[object]]
//! name = "cube"
//! shape.mesh = { file = "cube.obj" }
//! transform = { translate = [0, 1, 0] }
//! ```
//!
//! The model keeps its own materials unless the object has a `material`. Its cameras count only where the model itself is the
//! scene. A triangle's normal points to the side from which its corners run counterclockwise. A model without
//! normals is shaded flat.
//!
//! Vertices of OBJ files are read in double precision: a file in the coordinates of a map keeps its details. Texture coordinates of
//! OBJ and PLY files are read so as well. Those of any mesh that are all far from 0, by 1000 and more, are kept relative to a whole
//! number of repetitions.
//!
//! | file | what is read |
//! |---|---|
//! | `.obj` | positions with colours, normals, texture coordinates, smoothing groups, objects and groups; materials of MTL |
//! | `.gltf`, `.glb` | glTF 2.0 with its materials |
//! | `.ply` | text and bytes in either order: vertices with normals, colours and texture coordinates; faces, with colours and texture coordinates (`texcoord`) of their own; strips of triangles |
//! | `.stl` | text and bytes: triangles with the colours of facets (VisCAM's and Magics' bits), shaded flat |
//! | `.obj.gz`, `.ply.gz`, `.stl.gz` | the same, packed: to at most 2 GiB and 1024 times the size of the file |
//!
//! **Unlit surfaces of glTF files** (KHR_materials_unlit) have their colour, times that of their vertices, for the camera, in
//! mirrors and through glass. They light nothing, as in Blender and in three.js. Surfaces with `doubleSided = false` are seen from
//! behind as well, as in Cycles, unless the object has `back_faces = "file"`: inverted hulls, which draw outlines, need it.
//!
//! **Lights of glTF files** move with the object, and belong to its light group. Their numbers are photometric by the format:
//! candela, and lux of a sun. Blender makes these of watts, at 683 lm/W, and its importer divides by 683 again. Most other programs
//! write numbers that look right where 1 is shown as white, as three.js reads them.
//!
//! | `light_units` | intensities and irradiances are |
//! |---|---|
//! | `"auto"` | divided by 683 in files of Blender's exporter (by `asset.generator`), else taken as they are |
//! | `"photometric"` | divided by 683: in W sr^-1 and W m^-2 they are those of Blender, and its lamps have the same brightness here |
//! | `"unitless"` | taken as they are, in W sr^-1 and W m^-2 |
//!
//! Where the exporter of Blender was told to write other lighting than `Standard`, choose `"unitless"`. Between the cones of a
//! spot light falls by a smoothstep over the cosine, as in three.js; the soft edge of a spot of Blender is as wide as in Cycles.
//!
//! **Animations of glTF files** are played as frames go by: frame n is at n divided by the frame rate, in s, as Blender exports it.
//! Before `start` and after the last key the pose is held. An animation without a name has its number in the file, from 0; one
//! whose name another one has already is `Walk#2`. Animations that move the same thing cannot be played together. See
//! [animation](../../animation.md).
//!
//! **Subdivision** makes a smooth surface of a coarse mesh. The rules are those of OpenSubdiv, and the vertices are on its limit
//! surface, as Blender's are. `subdivide = 2` or `3` is usual: each level has four times the triangles of the one before. A job
//! that has no memory for them ends before they are made, and says how many they would be; `check` tells what there are.
//!
//! ```toml
//! [[object]]
//! name = "pebble"
//! shape.mesh = { file = "cube.obj", subdivide = 3 }
//! ```
//!
//! - `"catmull-clark"` is for polygons, which OBJ and PLY files keep; glTF and STL files have triangles, for which `"loop"` is
//!   made. `"linear"` leaves faces where they are.
//! - Vertices at the same position are one, where they belong to one mesh of a glTF file or to one object of an OBJ file. So seams
//!   of texture coordinates and borders of materials do not tear.
//! - Open edges become smooth curves, so that a square becomes round; `boundary = "corners"` keeps its corners. Edges of three and
//!   more faces, and those whose faces point to opposite sides, are creases.
//! - Normals of the file are not used. Texture coordinates are smoothed as positions are, but for seams and boundaries, which stay;
//!   colours are interpolated linearly.
//! - Meshes that an animation deforms cannot be subdivided. Those that move as a whole can.
//!
//! **Displacement** moves every vertex along its smooth normal by `scale` times the height less `midlevel`. `height` is a number or
//! a channel of a texture, `"texture.NAME"` or `"texture.NAME.g"`, red by default. It is read by the first texture coordinates of
//! the mesh, or with the mapping `object` or `planar` by the place in the model. `scale` is 1 and `midlevel` 0 where nothing else
//! is given. Lengths are those of the mesh in the file, before all transforms, also those of the nodes of a glTF file. Normals are
//! those of the displaced triangles.
//!
//! ```toml
//! [texture.rocks]
//! image = { file = "rocks.png", color_space = "raw" }
//!
//! [[object]]
//! name = "ground"
//! shape.mesh = { file = "ground.obj", subdivide = 7, subdivision = "linear", displacement = { height = "texture.rocks", scale = 0.2, midlevel = 0.5 } }
//! ```
//!
//! - Heights are read at the vertices, without a filter: as many vertices as the picture has texels show all of it. A square of
//!   `subdivide = 8` has 257 along a side.
//! - A height is a number or a texture that reads no other ones: not `mix`, `multiply`, `ramp`, `invert` or `remap`, nor a texture
//!   with a `warp` by another one. Render such a texture to a picture first.
//! - Pictures of heights are data: `color_space = "raw"`. Those of 8 bits have steps; take 16 bits or EXR.
//! - A flat mesh stays where it is with `subdivision = "linear"`; the others move its boundary.
//! - Where texture coordinates have a seam, vertices take the mean of the heights on both sides, so that it does not tear.
//! - All objects of one file with one displacement have one mesh. A `scale` that changes over
//!   frames makes it anew for each of them.
//!
//! The loader reads these statements of MTL files:
//!
//! | statement | becomes |
//! |---|---|
//! | `Kd`, `map_Kd` | the base colour; a surface with nothing else is matte |
//! | `Ks`, `map_Ks`, `Ns`, `map_Ns` | a reflection of that tint, of roughness (2 / (Ns + 2))^(1/4); none with `illum` 0 and 1; a mirror's with `illum` 3 and 8, and with 5 where `Ni` is not above 1 |
//! | `Ni` | the index of refraction |
//! | `d`, `Tr`, `map_d`, `map_Tr` | the opacity, see below |
//! | `illum` 4, 6, 7, 9 with `Tf`, `Ni` or `d` | glass: 6 and 7 bound a body, 4 and 9 are thin sheets |
//! | `Ke`, `map_Ke` | emitted radiance, on both sides |
//! | `norm` | a normal map |
//! | `bump` | heights, see below; a normal map where the picture is one |
//! | `Pr`, `Pm`, `Ps`, `Pc`, `Pcr`, `aniso`, `anisor` and their textures | roughness and metal (`Ks` does not count then), sheen, clear coat, anisotropy |
//! | `-s`, `-o`, `-mm`, `-clamp`, `-imfchan`, `-bm` | factor and offset of texture coordinates, factor of the texture, no repetition, channel, strength of `norm` and `bump` |
//!
//! Of opacities `d` counts before `Tr`, which is 1 - `d`. `Tr 1` of all materials of a textured model without `d` is read as
//! opaque, as programs of photogrammetry mean it, with a warning. A picture has its alpha as opacity, or its first channel where it
//! has none. Shading normals of `bump` are those of a surface that is raised by the texture's luminance (or the channel of
//! `-imfchan`) times `-bm`, in the model's unit of length.
//!
//! Not rendered are displacement (`disp`), `decal`, `refl`, the base of `-mm`, and the points of OBJ files. A missing library or
//! texture is a warning; the surface is rendered without it. Colours of vertices multiply those of the material, white where there
//! is none; those of OBJ files and whole numbers are display values, floats of PLY files are linear, and all are cut to 0 and 1.
//! What is not finite in a file costs its vertex, normal or facet, and a warning counts it.
//!
//! # Implementation
//!
//! Meshes are indexed arrays, which the loaders fill and from which a scene is compiled.

mod displacement;
mod playback;
mod polygons;
mod subdivision;

use serde::Deserialize;
use thiserror::Error;

use crate::{
    kind::named,
    math::{Aabb, DVec2, DVec3, Vec2, Vec3, Vec4, origin},
    value::{NonNegative, Positive, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshDesc {
    pub file: Spanned<String>,
    pub scene: Option<SceneChoice>,
    pub variant: Option<String>,
    /// Whether its lights shine; without it they do not, and a warning says so.
    pub lights: Option<bool>,
    #[serde(default)]
    pub light_units: LightUnits,
    /// The radius of its point lights and spots.
    pub light_radius: Option<NonNegative>,
    /// The factor of their intensities.
    pub light_factor: Option<NonNegative>,
    /// The animations that are played; without it none are, and a warning says so.
    pub animation: Option<AnimationChoice>,
    pub start: Option<Precise>,
    pub speed: Option<Precise>,
    #[serde(default)]
    pub repeat: Repeat,
    /// The radius of points, in the space of the model.
    pub radius: Option<Positive>,
    /// The number of times that its faces are split into four.
    pub subdivide: Option<Spanned<Levels>>,
    pub subdivision: Option<Scheme>,
    #[serde(default)]
    pub boundary: BoundaryRule,
    /// In degrees.
    pub crease_angle: Option<NonNegative>,
    /// In levels.
    pub crease_sharpness: Option<NonNegative>,
    pub displacement: Option<DisplacementDesc>,
}

impl MeshDesc {
    /// When its animations are played.
    pub fn playback(&self) -> Playback {
        Playback {
            start: self.start.map_or(0.0, |v| v.0),
            speed: self.speed.map_or(1.0, |v| v.0),
            repeat: self.repeat,
        }
    }

    /// The subdivision, if there is one; it has 0 levels where the mesh is displaced only.
    pub fn subdivision(&self) -> Option<Subdivision> {
        let levels = self.subdivide.as_ref().map_or(0, |levels| levels.get_ref().0);
        (levels > 0 || self.displacement.is_some()).then(|| Subdivision {
            scheme: self.subdivision,
            boundary: self.boundary,
            crease_angle: self.crease_angle.map(|angle| Bits::new(angle.0)),
            crease_sharpness: Bits::new(self.crease_sharpness.map_or(f32::INFINITY, |s| s.0)),
            ..Subdivision::of_levels(levels)
        })
    }

    /// Returns `None`: the file tells where a mesh is.
    pub fn anchor(&self) -> Option<DVec3> {
        None
    }
}

pub use displacement::DisplacementDesc;
pub use playback::{AnimationChoice, Playback, Precise, Repeat};
pub use polygons::Polygons;
pub use subdivision::{Bits, BoundaryRule, Levels, Scheme, Subdivision};

/// The scene of a file that has several.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Deserialize)]
#[serde(untagged)]
pub enum SceneChoice {
    /// By its number, from 0.
    Number(usize),
    Name(String),
}

named! {
    /// The unit of the lights of a glTF file.
    #[derive(Default, Hash, PartialOrd, Ord)]
    pub enum LightUnits: "unit of lights" {
        /// The unit of the program that wrote the file.
        #[default]
        Auto = "auto",
        /// Candela and lux, at 683 lm/W.
        Photometric = "photometric",
        /// W sr^-1 and W m^-2.
        Unitless = "unitless",
    }
}

/// Triangles over shared vertices, in the mesh's own space, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    /// Three indices into `positions` each, counterclockwise as seen from where the normal points
    /// to.
    pub triangles: Vec<[u32; 3]>,
    /// The faces of which the triangles are made, where somebody asks for them and not all are triangles; else none.
    pub polygons: Polygons,
    /// Unit shading normals, or 0 where only the face knows: none, or one for each vertex.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, v up: none, or one for each vertex.
    pub uvs: Vec<Vec2>,
    /// More texture coordinates, for textures that lie in another way.
    pub second_uvs: Vec<Vec2>,
    /// Whole numbers to which `uvs` and `second_uvs` are relative, see [`around_origin`].
    pub uv_origins: [Vec2; 2],
    /// Linear colours with opacity, which multiply those of the material: none, or one for each vertex.
    pub colors: Vec<Vec4>,
    /// Tangents along u, perpendicular to the normals, and 1 or -1 for the side of the bitangent: none, or one for each
    /// vertex. Where there are none, normal maps follow the texture coordinates.
    pub tangents: Vec<Vec4>,
}

/// Why a mesh cannot be rendered. Numbers count from 0.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum MeshError {
    #[error("triangle {triangle} names vertex {vertex}, but there are only {vertices}")]
    IndexOutOfRange {
        triangle: usize,
        vertex: u32,
        vertices: usize,
    },
    #[error("face {face} names vertex {vertex}, but there are only {vertices}")]
    FaceOutOfRange { face: usize, vertex: u32, vertices: usize },
    #[error("vertex {vertex} has a position that is not finite")]
    PositionNotFinite { vertex: usize },
    #[error("vertex {vertex} has a normal that is not finite")]
    NormalNotFinite { vertex: usize },
    #[error("vertex {vertex} has texture coordinates that are not finite")]
    UvNotFinite { vertex: usize },
    #[error("vertex {vertex} has a colour that is not finite")]
    ColorNotFinite { vertex: usize },
    #[error("vertex {vertex} has a tangent that is not finite")]
    TangentNotFinite { vertex: usize },
    #[error("there are {found} {what} for {vertices} vertices")]
    WrongLength {
        what: &'static str,
        found: usize,
        vertices: usize,
    },
    #[error("there are {vertices} vertices, more than 32 bits can count")]
    TooManyVertices { vertices: usize },
}

/// The origin of texture coordinates, and the coordinates relative to it. It is 0 unless they are far from 0, where single
/// precision would round them.
pub fn around_origin(uvs: impl Iterator<Item = DVec2> + Clone) -> (Vec2, Vec<Vec2>) {
    let origin = origin::of_uvs(uvs.clone());
    let far = origin.as_dvec2();
    let relative = |uv: DVec2| if origin == Vec2::ZERO { uv } else { uv - far }.as_vec2();
    (origin, uvs.map(relative).collect())
}

impl Mesh {
    /// The bytes of its arrays.
    pub fn bytes(&self) -> u64 {
        let of = |bytes: usize| bytes as u64;
        of(size_of_val(&self.positions[..]))
            + of(size_of_val(&self.triangles[..]))
            + of(size_of_val(&self.normals[..]))
            + of(size_of_val(&self.uvs[..]))
            + of(size_of_val(&self.second_uvs[..]))
            + of(size_of_val(&self.colors[..]))
            + of(size_of_val(&self.tangents[..]))
            + self.polygons.bytes()
    }

    /// The first thing that is wrong with the arrays. Triangles without area are not wrong.
    pub fn validate(&self) -> Result<(), MeshError> {
        let vertices = self.positions.len();
        if u32::try_from(vertices).is_err() {
            return Err(MeshError::TooManyVertices { vertices });
        }
        for (what, found) in [
            ("normals", self.normals.len()),
            ("texture coordinates", self.uvs.len()),
            ("texture coordinates", self.second_uvs.len()),
            ("colours", self.colors.len()),
            ("tangents", self.tangents.len()),
        ] {
            if found != 0 && found != vertices {
                return Err(MeshError::WrongLength { what, found, vertices });
            }
        }
        if let Some(vertex) = self.positions.iter().position(|p| !p.is_finite()) {
            return Err(MeshError::PositionNotFinite { vertex });
        }
        if let Some(vertex) = self.normals.iter().position(|n| !n.is_finite()) {
            return Err(MeshError::NormalNotFinite { vertex });
        }
        for uvs in [&self.uvs, &self.second_uvs] {
            if let Some(vertex) = uvs.iter().position(|t| !t.is_finite()) {
                return Err(MeshError::UvNotFinite { vertex });
            }
        }
        if let Some(vertex) = self.colors.iter().position(|c| !c.is_finite()) {
            return Err(MeshError::ColorNotFinite { vertex });
        }
        if let Some(vertex) = self.tangents.iter().position(|t| !t.is_finite()) {
            return Err(MeshError::TangentNotFinite { vertex });
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|v| **v as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange {
                    triangle,
                    vertex,
                    vertices,
                });
            }
        }
        for (face, corners) in self.polygons.faces().enumerate() {
            if let Some(&vertex) = corners.iter().find(|v| **v as usize >= vertices) {
                return Err(MeshError::FaceOutOfRange { face, vertex, vertices });
            }
        }
        Ok(())
    }

    /// The box around all vertices that a triangle uses; [`Aabb::EMPTY`] without triangles. The
    /// mesh is valid.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.triangles.iter().flatten().map(|v| self.positions[*v as usize]))
    }

    /// The corners of a triangle. The mesh is valid.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// A normal for each vertex: the mean of its triangles' normals, weighted by their areas; +y
    /// for a vertex whose triangles have none or cancel. The mesh is valid.
    pub fn smooth_normals(&self) -> Vec<Vec3> {
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for (i, triangle) in self.triangles.iter().enumerate() {
            let [a, b, c] = self.corners(i).map(|p| p.as_dvec3());
            let twice_area = (b - a).cross(c - a);
            for &v in triangle {
                sums[v as usize] += twice_area;
            }
        }
        sums.into_iter()
            .map(|sum| sum.normalize_or(DVec3::Y).as_vec3())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that fold around the edge from vertex 0 to vertex 1.
    fn fold() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::Z, Vec3::X, Vec3::new(0.0, 3.0, 0.0), Vec3::splat(9.0)],
            triangles: vec![[0, 1, 2], [0, 3, 1]],
            ..Mesh::default()
        }
    }

    fn message(change: impl FnOnce(&mut Mesh)) -> String {
        let mut mesh = fold();
        change(&mut mesh);
        mesh.validate().unwrap_err().to_string()
    }

    #[test]
    fn broken_arrays_are_refused_with_the_place() {
        assert_eq!(fold().validate(), Ok(()));
        assert_eq!(Mesh::default().validate(), Ok(()));
        assert_eq!(
            message(|m| m.triangles[1][2] = 5),
            "triangle 1 names vertex 5, but there are only 5"
        );
        assert_eq!(
            message(|m| m.positions[3].y = f32::NAN),
            "vertex 3 has a position that is not finite"
        );
        assert_eq!(
            message(|m| m.normals = vec![Vec3::Y, Vec3::Y, Vec3::INFINITY, Vec3::Y, Vec3::Y]),
            "vertex 2 has a normal that is not finite"
        );
        assert_eq!(
            message(|m| m.uvs = vec![Vec2::NAN; 5]),
            "vertex 0 has texture coordinates that are not finite"
        );
        assert_eq!(
            message(|m| m.normals = vec![Vec3::Y; 4]),
            "there are 4 normals for 5 vertices"
        );
        assert_eq!(
            message(|m| m.uvs = vec![Vec2::ZERO; 6]),
            "there are 6 texture coordinates for 5 vertices"
        );
    }

    #[test]
    fn smooth_normals_weigh_triangles_by_area() {
        let normals = fold().smooth_normals();
        let expected = Vec3::new(3.0, 1.0, 0.0).normalize();
        for v in [0, 1] {
            assert!((normals[v] - expected).length() < 1e-7, "{}", normals[v]);
        }
        assert_eq!((normals[2], normals[3]), (Vec3::Y, Vec3::X));
    }

    #[test]
    fn a_vertex_without_triangles_is_out_of_bounds_and_has_some_normal() {
        let mesh = fold();
        assert_eq!(mesh.bounds().max, Vec3::new(1.0, 3.0, 1.0));
        assert_eq!(mesh.smooth_normals()[4], Vec3::Y);
        assert!(Mesh::default().bounds().is_empty());
    }
}
