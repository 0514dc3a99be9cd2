//! Models from files to triangles in world space.

use std::{collections::HashMap, path::PathBuf, sync::Arc};

use glam::{DAffine3, DMat3};
use rayon::prelude::*;

use crate::{
    accel::Geometry,
    assets::{
        AssetError, Store,
        model::{Model, Part, Surfacing},
        store::ImageRequest,
    },
    material::{Material, MaterialId, matte::Matte},
    math::{Transform, Vec3},
    scene::{MeshRecord, Object, ObjectId},
    shape::mesh::Mesh,
    texture::{
        BitmapId, Color, Mapping, Pattern, StTransform, Texture, TextureId, bitmap::ColorSpace, image::ImagePattern,
    },
};

/// The most triangles of a scene: every copy of a mesh has its own.
const MOST_TRIANGLES: u64 = 1 << 27;

/// Below so many items a task is not worth another thread.
const MIN_LEN: usize = 16384;

/// An object whose geometry is in a file.
#[derive(Clone, Debug)]
pub(super) struct PlacedModel {
    pub object: ObjectId,
    pub file: PathBuf,
    /// Instead of the model's own.
    pub material: Option<MaterialId>,
    pub transform: Option<Transform>,
}

/// The arrays of a scene that models add to.
pub(super) struct Parts {
    pub geometry: Geometry,
    pub objects: Vec<Object>,
    pub meshes: Vec<MeshRecord>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub images: Vec<ImageRequest>,
}

impl Parts {
    /// Loads every file once and places its model as often as it is named.
    pub fn place(&mut self, placed: &[PlacedModel], store: &Store) -> Result<(), Vec<AssetError>> {
        let files: Vec<PathBuf> = placed.iter().map(|p| p.file.clone()).collect();
        let models = store.models(&files)?;
        let mut errors = Vec::new();
        let mut looks: HashMap<*const Model, u32> = HashMap::new();
        for (placed, model) in placed.iter().zip(&models) {
            if let Err(e) = self.check(placed, model) {
                errors.push(e);
                continue;
            }
            let first_material = match placed.material {
                Some(_) => 0,
                // Objects of one model share its materials.
                None => *looks.entry(Arc::as_ptr(model)).or_insert_with(|| self.add_looks(model)),
            };
            let material_of = |part: &Part| {
                placed
                    .material
                    .unwrap_or(MaterialId(first_material + part.material as u32))
            };
            self.objects[placed.object.0 as usize].material = material_of(&model.parts[0]);
            let dropped: usize = model
                .parts
                .iter()
                .map(|part| self.bake(placed, model, part, material_of(part)))
                .sum();
            if dropped > 0 {
                let plural = if dropped == 1 { "triangle" } else { "triangles" };
                tracing::warn!("{dropped} {plural} without area left out: {}", placed.file.display());
            }
        }
        if errors.is_empty() { Ok(()) } else { Err(errors) }
    }

    fn check(&self, placed: &PlacedModel, model: &Model) -> Result<(), AssetError> {
        let path = placed.file.clone();
        if model.parts.is_empty() {
            return Err(AssetError::NoTriangles { path });
        }
        let triangles = self.geometry.triangles.len() as u64 + model.triangle_count();
        let vertices: usize = model.parts.iter().map(|p| model.meshes[p.mesh].positions.len()).sum();
        let vertices = (self.geometry.vertices.len() + vertices) as u64;
        if triangles > MOST_TRIANGLES || vertices > u64::from(u32::MAX) {
            let limit = MOST_TRIANGLES;
            return Err(AssetError::TooManyTriangles { triangles, limit, path });
        }
        Ok(())
    }

    /// Adds a model's materials, textures and images; returns the number of its first material.
    fn add_looks(&mut self, model: &Model) -> u32 {
        let first_material = self.materials.len() as u32;
        let first_image = self.images.len();
        self.images
            .extend(model.images.iter().map(|i| (i.clone(), ColorSpace::Srgb)));
        for surfacing in &model.materials {
            let albedo = self.color(surfacing, first_image);
            self.materials.push(Material::Matte(Matte { albedo }));
        }
        first_material
    }

    fn color(&mut self, surfacing: &Surfacing, first_image: usize) -> Color {
        let Some(texture) = &surfacing.base_texture else {
            return Color::Constant(surfacing.base_color);
        };
        self.textures.push(Texture {
            mapping: Mapping::Uv,
            transform: StTransform::IDENTITY,
            pattern: Pattern::Image(ImagePattern {
                bitmap: BitmapId((first_image + texture.image) as u32),
                filter: texture.filter,
                wrap: texture.wrap,
            }),
        });
        let id = TextureId(self.textures.len() as u32 - 1);
        Color::Tinted(id, surfacing.base_color)
    }

    /// Adds a part in world space; returns how many of its triangles have no area and were left out.
    fn bake(&mut self, placed: &PlacedModel, model: &Model, part: &Part, material: MaterialId) -> usize {
        let mesh = &model.meshes[part.mesh];
        let world_from_model = placed.transform.map_or(DAffine3::IDENTITY, |t| t.widened());
        let place = Place::new(world_from_model * part.model_from_mesh);
        let first_vertex = self.geometry.vertices.len() as u32;
        let first_triangle = self.geometry.triangles.len() as u32;
        self.geometry.vertices.par_extend(place.points(mesh));
        let vertices = &self.geometry.vertices;
        let triangles = mesh.triangles.par_iter().with_min_len(MIN_LEN).filter_map(|t| {
            let [a, b, c] = t.map(|v| v + first_vertex);
            let corners = [a, b, c].map(|v| vertices[v as usize]);
            has_area(corners).then_some(if place.mirrors { [a, c, b] } else { [a, b, c] })
        });
        self.geometry.triangles.par_extend(triangles);
        let end = self.geometry.triangles.len() as u32;
        if end > first_triangle {
            self.meshes.push(MeshRecord {
                object: placed.object,
                material,
                transform: placed.transform,
                triangles: first_triangle..end,
                vertices: first_vertex..self.geometry.vertices.len() as u32,
                normals: mesh.normals.iter().map(|n| place.normal(*n)).collect(),
                uvs: mesh.uvs.clone(),
            });
        }
        mesh.triangles.len() - (end - first_triangle) as usize
    }
}

fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let a = a.as_dvec3();
    // What is not a number is for the acceleration structure to refuse.
    (b.as_dvec3() - a).cross(c.as_dvec3() - a).length_squared() != 0.0
}

/// Where a mesh stands, and what its normals become.
struct Place {
    world_from_mesh: DAffine3,
    /// The inverse transpose times the determinant's magnitude: it exists for flattened meshes too.
    normals: DMat3,
    /// Whether the order of corners must change for the front to stay the front.
    mirrors: bool,
}

impl Place {
    fn new(world_from_mesh: DAffine3) -> Self {
        let m = world_from_mesh.matrix3;
        let mirrors = m.determinant() < 0.0;
        let cofactors = DMat3::from_cols(
            m.y_axis.cross(m.z_axis),
            m.z_axis.cross(m.x_axis),
            m.x_axis.cross(m.y_axis),
        );
        Self {
            world_from_mesh,
            normals: if mirrors { -cofactors } else { cofactors },
            mirrors,
        }
    }

    fn points<'a>(&'a self, mesh: &'a Mesh) -> impl IndexedParallelIterator<Item = Vec3> + 'a {
        let is_identity = self.world_from_mesh == DAffine3::IDENTITY;
        mesh.positions.par_iter().with_min_len(MIN_LEN).map(move |p| {
            if is_identity {
                *p
            } else {
                self.world_from_mesh.transform_point3(p.as_dvec3()).as_vec3()
            }
        })
    }

    fn normal(&self, n: Vec3) -> Vec3 {
        (self.normals * n.as_dvec3()).normalize_or_zero().as_vec3()
    }
}
