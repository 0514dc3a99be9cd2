//! Validation of a geometry before a build.
//!
//! Coordinates that are not finite, or so large that a product of three overflows, are rejected
//! with the id of the primitive or instance. Builders would panic or never finish with them.

use std::ops::Range;

use super::{
    arrays::Geometry,
    error::{BuildError, MAX_COORDINATE},
    ids::PrimId,
    padding,
};
use crate::math::{Aabb, Vec3, parallel};

/// The smallest number of items that is worth another thread.
pub(crate) const PAR_MIN_LEN: usize = 4096;

/// Returns whether the coordinates of a point are finite and not too large.
pub(crate) fn is_sound(p: Vec3) -> bool {
    p.is_finite() && p.abs().max_element() <= MAX_COORDINATE
}

/// Validates all that a build validates.
pub(crate) fn whole(arrays: &Geometry) -> Result<(), BuildError> {
    geometry(arrays)?;
    for shape in arrays.triangles.len()..arrays.prim_count() {
        shape_bounds(arrays, PrimId::new(shape as u32))?;
    }
    let groups: Vec<Aabb> = arrays.groups.iter().map(|g| arrays.group_bounds(g)).collect();
    for (i, instance) in arrays.instances.iter().enumerate() {
        instance_bounds(arrays, i, &groups[instance.group as usize])?;
    }
    Ok(())
}

/// Validates all arrays, except for coordinates that depend on the transforms of instances.
pub(crate) fn geometry(geometry: &Geometry) -> Result<(), BuildError> {
    let count = geometry.prim_count() + geometry.instances.len();
    if count + 1 >= PrimId::MAX as usize {
        return Err(BuildError::TooMany { count });
    }
    groups(geometry)?;
    if geometry.groups.is_empty() {
        return triangles(geometry, 0..geometry.triangles.len());
    }
    for run in geometry.world_triangles() {
        let run = run.start as usize..run.end as usize;
        triangles(geometry, run.clone())?;
        let taken = |v: &u32| {
            let after = geometry.groups.partition_point(|g| g.vertices.start <= *v);
            geometry.groups[..after].iter().any(|g| g.vertices.contains(v))
        };
        let start = run.start;
        if let Some(i) = first(&geometry.triangles[run], |t| t.iter().any(taken)) {
            return Err(BuildError::SharedVertex { prim: start + i });
        }
    }
    geometry.groups.iter().try_for_each(|g| group_triangles(geometry, g))
}

/// Checks that groups are sorted, and that all indices of groups and instances are valid.
fn groups(geometry: &Geometry) -> Result<(), BuildError> {
    let (mut triangle, mut vertex) = (0, 0);
    for (group, g) in geometry.groups.iter().enumerate() {
        let sound = triangle <= g.triangles.start
            && vertex <= g.vertices.start
            && g.triangles.start <= g.triangles.end
            && g.vertices.start <= g.vertices.end
            && g.triangles.end as usize <= geometry.triangles.len()
            && g.vertices.end as usize <= geometry.vertices.len();
        if !sound {
            return Err(BuildError::BadGroup { group });
        }
        (triangle, vertex) = (g.triangles.end, g.vertices.end);
    }
    let bad = first(&geometry.instances, |i| {
        i.group as usize >= geometry.groups.len() || i.transform as usize >= geometry.transforms.len()
    });
    bad.map_or(Ok(()), |instance| Err(BuildError::BadInstance { instance }))
}

fn group_triangles(geometry: &Geometry, group: &super::arrays::MeshGroup) -> Result<(), BuildError> {
    let run = group.triangles.start as usize..group.triangles.end as usize;
    triangles(geometry, run.clone())?;
    let foreign = |t: &[u32; 3]| t.iter().any(|v| !group.vertices.contains(v));
    match geometry.triangles[run.clone()].iter().position(foreign) {
        Some(i) => Err(BuildError::SharedVertex { prim: run.start + i }),
        None => Ok(()),
    }
}

fn triangles(geometry: &Geometry, run: Range<usize>) -> Result<(), BuildError> {
    let vertices = geometry.vertices.len();
    let bad_vertex = |v: &u32| {
        let v = *v as usize;
        v >= vertices || !is_sound(geometry.vertices[v])
    };
    let bad = first(&geometry.triangles[run.clone()], |corners| {
        corners.iter().any(bad_vertex)
    });
    let Some(at) = bad else { return Ok(()) };
    let prim = run.start + at;
    let corners = geometry.triangles[prim];
    Err(match corners.iter().find(|&&v| v as usize >= vertices) {
        Some(&vertex) => BuildError::NoSuchVertex { prim, vertex, vertices },
        None if geometry.corners(prim).iter().all(|p| p.is_finite()) => BuildError::TooLarge { prim },
        None => BuildError::NotFinite { prim },
    })
}

/// The index of the first value for which `is` holds.
fn first<T: Sync>(values: &[T], is: impl Fn(&T) -> bool + Sync) -> Option<usize> {
    let found = parallel::map(values.chunks(PAR_MIN_LEN).enumerate(), |(chunk, values)| {
        Some(chunk * PAR_MIN_LEN + values.iter().position(&is)?)
    });
    found.into_iter().flatten().next()
}

/// Returns the bounds of a shape, or `None` if it is unbounded.
pub(crate) fn shape_bounds(geometry: &Geometry, id: PrimId) -> Result<Option<Aabb>, BuildError> {
    let prim = id.index() as usize;
    let placed = geometry.shape(id).expect("a primitive after the triangles is a shape");
    let local = placed.shape.bounds();
    if local.min.is_nan() || local.max.is_nan() {
        return Err(BuildError::NotFinite { prim });
    }
    if !local.is_finite() {
        return Ok(None);
    }
    let bounds = geometry.bounds(id);
    if !bounds.is_finite() {
        return Err(BuildError::NotFinite { prim });
    }
    if bounds.min.abs().max(bounds.max.abs()).max_element() > MAX_COORDINATE {
        return Err(BuildError::TooLarge { prim });
    }
    Ok(Some(bounds))
}

/// Returns the bounds of an instance whose group has the bounds `group`; they are empty if the
/// group is.
pub(crate) fn instance_bounds(geometry: &Geometry, instance: usize, group: &Aabb) -> Result<Aabb, BuildError> {
    let placed = &geometry.instances[instance];
    let bounds = padding::bounds(&geometry.transforms[placed.transform as usize], group);
    if bounds.is_empty() || (is_sound(bounds.min) && is_sound(bounds.max)) {
        Ok(bounds)
    } else {
        Err(BuildError::InstanceTooLarge { instance })
    }
}
