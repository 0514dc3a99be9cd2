//! The surface under the pointer.

use super::message::Picked;
use crate::{
    camera::FrameCamera,
    math::{Ray, Vec2},
    scene::Scene,
};

/// The most transparent surfaces that a ray passes.
const MAX_PASSED: usize = 64;

/// The first surface at a point of the film, in pixels; surfaces that are less than half opaque are passed.
pub fn pick(scene: &Scene, camera: &FrameCamera, film: Vec2) -> Option<Picked> {
    let camera = camera.moved(-scene.origin).camera(0.0);
    let start = camera.ray(film, Vec2::splat(0.5))?;
    let mut ray = start;
    for _ in 0..MAX_PASSED {
        let mut hits = [None];
        scene.geometry.accel.nearest(&[ray], &mut hits);
        let hit = hits[0]?;
        if scene.opacity(&ray, &hit) < 0.5 {
            ray = Ray { tmin: hit.t, ..ray };
            continue;
        }
        let surface = scene.surface(&ray, &hit);
        let distance = f64::from(hit.t);
        let cos = camera.axis().map_or(1.0, |axis| f64::from(start.d.dot(axis)));
        let named = |name: Option<&String>| name.cloned().unwrap_or_default();
        return Some(Picked {
            object: named(scene.geometry.objects.get(surface.object.0 as usize).map(|o| &o.name)),
            material: named(scene.shading.material_names.get(surface.material.0 as usize)),
            distance,
            depth: distance * cos,
            point: (scene.origin + surface.p.as_dvec3()).to_array(),
        });
    }
    None
}
