//! Subdivision of the meshes of a model.

use std::collections::HashMap;

use glam::DAffine3;

use super::{cage::CageRules, surface::Surface};
use crate::{
    assets::{
        MemoryBudget, MemoryKind, OverBudget,
        heights::LoadedDisplacement,
        model::{MAX_TRIANGLES, Model, UvSet},
        tangents,
    },
    shape::mesh::{BoundaryRule, Mesh, Scheme, Subdivision},
    texture::{Color, TextureId},
};

/// The most bytes of memory for each triangle of the last level while it is made, and of the mesh that is left.
const WORKING_BYTES: u64 = 180;
const MESH_BYTES: u64 = 56;

/// The angle of edges that look sharp on faces that stay where they are, in degrees.
const LINEAR_CREASE: f32 = 30.0;

/// Why a model cannot be subdivided.
#[derive(Debug, thiserror::Error)]
pub enum SubdivisionProblem {
    #[error("`subdivide = {levels}` makes {triangles} triangles of it: {cause}")]
    Memory {
        levels: u32,
        triangles: u64,
        cause: OverBudget,
    },
    #[error(
        "`subdivide = {levels}` makes {triangles} triangles of it, more than the {MAX_TRIANGLES} that there can be"
    )]
    TooMany { levels: u32, triangles: u64 },
    #[error(
        "meshes that an animation deforms cannot be subdivided: render it without `animation`, or subdivide it in the program that wrote it"
    )]
    Deforms,
    #[error("a cloud of points cannot be subdivided")]
    Points,
    #[error("a displacement by a texture needs texture coordinates, which a mesh has not")]
    NoUvs,
    #[error("its displacement moves a vertex to a position that is not finite")]
    NotFinite,
}

impl SubdivisionProblem {
    /// Whether the displacement is wrong, rather than the number of levels.
    pub fn is_of_displacement(&self) -> bool {
        matches!(self, Self::NoUvs | Self::NotFinite)
    }

    /// A hint for the correction, where there is one.
    pub fn help(&self) -> Option<&'static str> {
        match self {
            Self::NoUvs => Some("a texture with `mapping.object` or `mapping.planar` needs none"),
            _ => None,
        }
    }
}

/// Meshes that are one surface, by their indices.
struct Group {
    meshes: Vec<usize>,
    scheme: Scheme,
    /// The triangles of the last level.
    triangles: u64,
    /// The first part of the model that uses the meshes.
    part: usize,
}

impl Group {
    /// The most bytes of memory that are needed while it is subdivided.
    fn working_bytes(&self, model: &Model, uses: &[Option<usize>]) -> u64 {
        // Tangents are made when the surface is gone.
        let has_tangents = (self.meshes.iter()).any(|mesh| tangent_set(model, *mesh, uses[*mesh]).is_some());
        let bytes = match has_tangents {
            true => WORKING_BYTES.max(tangents::TRIANGLE_MEMORY),
            false => WORKING_BYTES,
        };
        self.triangles * bytes
    }
}

/// Subdivides the meshes of a model. Those that a node has in common are one surface and do not tear at the borders of materials;
/// with `joins_groups` also those below one node at the top.
///
/// # Errors
/// It needs more memory than there is, or cannot be subdivided.
pub fn subdivide(
    model: &mut Model,
    how: &Subdivision,
    displacement: Option<&LoadedDisplacement<'_>>,
    joins_groups: bool,
    memory: &MemoryBudget,
) -> Result<(), SubdivisionProblem> {
    if model.points.is_some() {
        return Err(SubdivisionProblem::Points);
    }
    if model.motion.as_ref().is_some_and(|motion| !motion.meshes.is_empty()) {
        return Err(SubdivisionProblem::Deforms);
    }
    let reads_uvs = displacement.is_some_and(LoadedDisplacement::reads_uvs);
    let uses = uses(model);
    let mut used = model.meshes.iter().zip(&uses).filter(|(_, part)| part.is_some());
    if reads_uvs && used.any(|(mesh, _)| mesh.uvs.is_empty()) {
        return Err(SubdivisionProblem::NoUvs);
    }
    let groups = groups(model, how, joins_groups, &uses);
    let (levels, triangles) = (
        how.levels,
        groups.iter().map(|group| group.triangles).fold(0, u64::saturating_add),
    );
    if triangles > MAX_TRIANGLES {
        return Err(SubdivisionProblem::TooMany { levels, triangles });
    }
    let largest = groups.iter().map(|group| group.working_bytes(model, &uses)).max();
    let _reserved = memory
        .reserve(MemoryKind::Models, largest.unwrap_or(0) + triangles * MESH_BYTES)
        .map_err(|cause| SubdivisionProblem::Memory {
            levels,
            triangles,
            cause,
        })?;
    for group in groups {
        let meshes: Vec<&Mesh> = group.meshes.iter().map(|mesh| &*model.meshes[*mesh]).collect();
        let place = model.instances[group.part].model_from_mesh;
        let fine = refined(&meshes, group.scheme, how, displacement.map(|given| (given, place)));
        if displacement.is_some() && !fine.iter().flat_map(|mesh| &mesh.positions).all(|p| p.is_finite()) {
            return Err(SubdivisionProblem::NotFinite);
        }
        for (number, mut mesh) in group.meshes.into_iter().zip(fine) {
            if let Some(set) = tangent_set(model, number, uses[number]) {
                tangents::add(&mut mesh, set);
            }
            if !mesh.triangles.is_empty() {
                model.meshes[number] = mesh.into();
            }
        }
    }
    Ok(())
}

/// The faces that a scheme subdivides; the triangles that are left without levels.
fn faces_of(mesh: &Mesh, scheme: Scheme, levels: u32) -> Vec<&[u32]> {
    match scheme == Scheme::Loop || levels == 0 || mesh.polygons.is_empty() {
        true => mesh.triangles.iter().map(<[u32; 3]>::as_slice).collect(),
        false => mesh.polygons.faces().collect(),
    }
}

fn refined(
    meshes: &[&Mesh],
    scheme: Scheme,
    how: &Subdivision,
    displacement: Option<(&LoadedDisplacement<'_>, DAffine3)>,
) -> Vec<Mesh> {
    let linear = (scheme == Scheme::Linear).then_some(LINEAR_CREASE);
    let angle = how.crease_angle.map(|angle| angle.get()).or(linear);
    let rules = CageRules {
        crease_cos: angle
            .filter(|angle| *angle < 180.0)
            .map_or(-2.0, |angle| libm::cos(f64::from(angle).to_radians())),
        crease_sharpness: how.crease_sharpness.get(),
        keeps_corners: how.boundary == BoundaryRule::Corners,
    };
    let parts: Vec<_> = meshes
        .iter()
        .map(|mesh| (*mesh, faces_of(mesh, scheme, how.levels)))
        .collect();
    let mut surface = Surface::new(&parts, &rules);
    for _ in 0..how.levels {
        surface = surface.refined(scheme);
    }
    surface.move_to_limit(scheme);
    if let Some((displacement, model_from_mesh)) = displacement {
        surface.displace(|part, p, uv| {
            let p = model_from_mesh.transform_point3(p);
            displacement.at(p, uv.as_vec2(), meshes[part].uv_origins[0])
        });
    }
    surface.meshes(meshes.iter().copied())
}

/// The first part of a model that uses each of its meshes.
fn uses(model: &Model) -> Vec<Option<usize>> {
    let mut uses = vec![None; model.meshes.len()];
    for (number, part) in model.instances.iter().enumerate() {
        uses[part.mesh].get_or_insert(number);
    }
    uses
}

/// The surfaces of a model. Meshes that no part uses are in none.
fn groups(model: &Model, how: &Subdivision, joins_groups: bool, uses: &[Option<usize>]) -> Vec<Group> {
    type Place = (Option<usize>, [u64; 12]);
    let mut places: Vec<Vec<Place>> = vec![Vec::new(); model.meshes.len()];
    for part in &model.instances {
        let node = match joins_groups {
            true => part.node.map(|node| top(model, node)),
            false => part.node,
        };
        places[part.mesh].push((node, bits(&part.model_from_mesh)));
    }
    let mut groups: Vec<Group> = Vec::new();
    let mut known: HashMap<&[Place], usize> = HashMap::new();
    for (number, own) in places.iter().enumerate() {
        let Some(part) = uses[number] else {
            continue;
        };
        match known.get(own.as_slice()) {
            Some(&at) => groups[at].meshes.push(number),
            None => {
                known.insert(own, groups.len());
                groups.push(Group {
                    meshes: vec![number],
                    scheme: Scheme::Loop,
                    triangles: 0,
                    part,
                });
            }
        }
    }
    for group in &mut groups {
        let meshes = || group.meshes.iter().map(|mesh| &model.meshes[*mesh]);
        let has_polygons = meshes().any(|mesh| !mesh.polygons.is_empty());
        let scheme = match (how.levels, how.scheme) {
            (0, _) => Scheme::Linear,
            (_, Some(scheme)) => scheme,
            (_, None) if has_polygons => Scheme::CatmullClark,
            (_, None) => Scheme::Loop,
        };
        let faces = || meshes().flat_map(|mesh| faces_of(mesh, scheme, how.levels));
        let splits_triangles = match scheme {
            Scheme::CatmullClark => false,
            Scheme::Loop => true,
            Scheme::Linear => !has_polygons,
        };
        let first: u64 = match splits_triangles {
            true => faces().count() as u64 * 4,
            false => faces().map(|face| 2 * face.len() as u64).sum(),
        };
        group.scheme = scheme;
        group.triangles = match how.levels.checked_sub(1) {
            None => faces().count() as u64,
            Some(later) => first.saturating_mul(4_u64.saturating_pow(later)),
        };
    }
    groups
}

/// The node at the top above `node`.
fn top(model: &Model, node: usize) -> usize {
    let mut at = node;
    // Nodes are a tree; the bound is for those of a file that are not.
    for _ in 0..model.nodes.len() {
        match model.nodes.get(at).and_then(|node| node.parent) {
            Some(parent) => at = parent,
            None => break,
        }
    }
    at
}

fn bits(transform: &DAffine3) -> [u64; 12] {
    transform.to_cols_array().map(f64::to_bits)
}

/// The texture coordinates that the tangents of a mesh follow, of which this part is the first use;
/// `None` if its material needs none.
fn tangent_set(model: &Model, mesh: usize, part: Option<usize>) -> Option<UvSet> {
    let surface = &model.materials[model.instances[part?].material].surface;
    match surface.maps().next() {
        Some(Color::Texture(TextureId(id)) | Color::Tinted(TextureId(id), _)) => {
            Some(model.textures.get(*id as usize)?.uv_set)
        }
        _ => (!model.meshes[mesh].tangents.is_empty()).then_some(UvSet::First),
    }
}
