//! Changes of a geometry between two frames: new transforms and new vertex positions.

use std::sync::Arc;

use super::{arrays::Geometry, check::is_sound, error::BuildError, ids::InstanceId, padding};
use crate::math::{Aabb, Transform, Vec3};

/// A change of a geometry, for [`crate::accel::Accelerator::update`].
#[derive(Clone, Debug, Default)]
pub struct Edit {
    /// New transforms of instances.
    pub instances: Vec<(InstanceId, Transform)>,
    /// New transforms of shapes, by their index into [`Geometry::shapes`].
    pub shapes: Vec<(u32, Transform)>,
    /// New positions of consecutive vertices, from this index into [`Geometry::vertices`] on.
    pub vertices: Vec<(u32, Vec<Vec3>)>,
}

/// The triangles that an edit has changed in local space.
pub(crate) struct Changed {
    pub static_triangles: bool,
    /// In ascending order.
    pub groups: Vec<u32>,
}

impl Edit {
    /// Applies the edit to `geometry`, whose groups have the bounds `bounds` so far. If the edit is
    /// invalid, nothing is changed. Arrays that are shared are copied first.
    pub(crate) fn apply(&self, geometry: &mut Arc<Geometry>, bounds: &[Aabb]) -> Result<Changed, BuildError> {
        let changed = self.check(geometry, bounds)?;
        let geometry = Arc::make_mut(geometry);
        for &(instance, transform) in &self.instances {
            let at = geometry.instances[instance.0 as usize].transform;
            geometry.transforms[at as usize] = transform;
        }
        for &(shape, transform) in &self.shapes {
            geometry.place_shape(shape, transform);
        }
        for (first, positions) in &self.vertices {
            let first = *first as usize;
            geometry.vertices[first..first + positions.len()].copy_from_slice(positions);
        }
        Ok(changed)
    }

    fn check(&self, geometry: &Geometry, bounds: &[Aabb]) -> Result<Changed, BuildError> {
        let mut bounds = bounds.to_vec();
        let mut moved = vec![false; geometry.groups.len()];
        let mut static_triangles = false;
        for (first, positions) in &self.vertices {
            let run = *first as usize..*first as usize + positions.len();
            if run.end > geometry.vertices.len() {
                return Err(BuildError::NothingThere {
                    what: "vertex",
                    index: run.end - 1,
                });
            }
            if let Some(at) = positions.iter().position(|p| !is_sound(*p)) {
                return Err(BuildError::BadVertex { vertex: run.start + at });
            }
            let mut others = run.len();
            for (group, g) in geometry.groups.iter().enumerate() {
                let (start, end) = (g.vertices.start as usize, g.vertices.end as usize);
                let common = run.start.max(start)..run.end.min(end);
                if !common.is_empty() {
                    others -= common.len();
                    moved[group] = true;
                    let points = &positions[common.start - run.start..common.end - run.start];
                    bounds[group] = points.iter().copied().fold(bounds[group], Aabb::extended).padded(4.0);
                }
            }
            static_triangles |= others > 0;
        }
        for &(InstanceId(number), transform) in &self.instances {
            let Some(placed) = geometry.instances.get(number as usize) else {
                return Err(BuildError::NothingThere {
                    what: "instance",
                    index: number as usize,
                });
            };
            fits(&transform, &bounds[placed.group as usize], number as usize)?;
        }
        if moved.contains(&true) {
            for (number, placed) in geometry.instances.iter().enumerate() {
                if moved[placed.group as usize] {
                    fits(
                        &geometry.transforms[placed.transform as usize],
                        &bounds[placed.group as usize],
                        number,
                    )?;
                }
            }
        }
        for &(shape, transform) in &self.shapes {
            let Some(placed) = geometry.shapes.get(shape as usize) else {
                return Err(BuildError::NothingThere {
                    what: "shape",
                    index: shape as usize,
                });
            };
            let (prim, local) = (geometry.triangles.len() + shape as usize, placed.shape.bounds());
            let world = transform.bounds_to_world(&local);
            if local.is_finite() && !(is_sound(world.min) && is_sound(world.max)) {
                return Err(BuildError::TooLarge { prim });
            }
        }
        let groups = (0..).zip(moved).filter(|(_, moved)| *moved).map(|(group, _)| group);
        Ok(Changed {
            static_triangles,
            groups: groups.collect(),
        })
    }
}

fn fits(transform: &Transform, group: &Aabb, instance: usize) -> Result<(), BuildError> {
    let bounds = padding::bounds(transform, group);
    if bounds.is_empty() || (is_sound(bounds.min) && is_sound(bounds.max)) {
        Ok(())
    } else {
        Err(BuildError::InstanceTooLarge { instance })
    }
}
