//! Intersection of the stream's rays with analytic primitives, by their scalar routines.

use super::{query::Best, ray_state::RayState};
use crate::{
    geometry::{Geometry, PrimId, slab::Slabs},
    math::{Ray, Vec3},
};

/// Tests shape `index` of the geometry's primitives. Returns whether it is now the nearest hit.
pub fn test(slot: &mut RayState, index: u32, geometry: &Geometry, rays: &[Ray]) -> bool {
    let Some(placed) = geometry.shape(PrimId::new(index)) else {
        return false;
    };
    let ray = Ray {
        tmax: slot.best.t,
        ..rays[slot.ray as usize]
    };
    // Shapes are in world space, and so is the slot's line here.
    let [x, y, z] = slot.state.inv;
    let slabs = Slabs {
        o: ray.o,
        inv: Vec3::new(x, y, z),
    };
    let Some(hit) = geometry.intersect_shape(placed, &ray, || slabs) else {
        return false;
    };
    let nearer = slot.best.loses_to(hit.t, index + 1);
    if nearer {
        slot.set_best(Best {
            t: hit.t,
            u: hit.u,
            v: hit.v,
            id: index + 1,
        });
    }
    nearer
}
