//! Point clouds as spheres.

use super::{
    models::{ModelPlacer, ModelUse},
    placed::PlacedModel,
};
use crate::{
    assets::points::PointCloud,
    math::{DAffine3, Vec4},
    shape::{Shape, sphere::Sphere},
};

/// The largest relative difference of the scales along the axes of a similarity.
const SCALE_ERROR: f64 = 1e-5;

/// The scale of a similarity; `None` for other maps, which turn spheres into ellipsoids.
fn uniform_scale(map: &DAffine3) -> Option<f64> {
    let m = &map.matrix3;
    let scale = m.x_axis.length();
    // The matrix times its transpose is a multiple of the identity.
    let products = m.transpose() * *m;
    let expected = glam::DMat3::from_diagonal(glam::DVec3::splat(scale * scale));
    let is_uniform = products.abs_diff_eq(expected, 2.0 * SCALE_ERROR * scale * scale);
    (scale > 0.0 && is_uniform).then_some(scale)
}

impl ModelPlacer<'_> {
    /// Adds a sphere for each point to an object.
    pub(super) fn add_points(&mut self, placed: &PlacedModel, points: &PointCloud, model_use: &ModelUse) {
        let material = model_use.material(points.material, placed.material);
        self.scene.set_object_material(placed.object, material);
        let radius = placed.point_radius.unwrap_or(points.radius);
        let color = |i: usize| points.colors.get(i).copied().unwrap_or(Vec4::ONE);
        let scene_from_points = placed.place.of(&points.model_from_points);
        // The file's own material has no textures, which would need the object's own space.
        let transform = placed.place.transform.filter(|_| placed.material.is_some());
        let (map, radius, transform) = match (transform, uniform_scale(&scene_from_points)) {
            (None, Some(scale)) if !placed.moved => (scene_from_points, radius * scale as f32, None),
            _ => (points.model_from_points, radius, placed.place.transform),
        };
        self.scene.reserve_shapes(points.positions.len());
        for (i, p) in points.positions.iter().enumerate() {
            let center = map.transform_point3(p.as_dvec3()).as_vec3();
            let sphere = Shape::Sphere(Sphere { center, radius });
            self.scene.object_shape(placed.object, sphere, transform, color(i));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, transform::from_parts};

    #[test]
    fn turns_and_mirrors_keep_spheres_and_stretching_does_not() {
        let map = |scale: DVec3| from_parts(DVec3::X, DVec3::new(10.0, 20.0, 30.0), scale);
        for scale in [DVec3::splat(3.0), DVec3::new(3.0, -3.0, 3.0)] {
            assert!(uniform_scale(&map(scale)).is_some_and(|s| (s - 3.0).abs() < 1e-12));
        }
        assert_eq!(uniform_scale(&map(DVec3::new(3.0, 3.1, 3.0))), None);
        assert_eq!(uniform_scale(&map(DVec3::ZERO)), None);
    }
}
