//! Curved shapes against fine meshes of them, made by turning a profile around an axis.

use std::f64::consts::PI;

use super::examples::{Random, shape};
use crate::{
    math::{DVec3, Ray, Vec3},
    shape::{axis::Axis, triangle},
};

const TURNS: usize = 256;

struct Lathe {
    base: Vec3,
    axis: Vec3,
    /// Heights along the axis and distances from it, from the bottom to the top, so that normals
    /// point outwards.
    profile: Vec<(f64, f64)>,
}

impl Lathe {
    fn triangles(&self) -> Vec<[Vec3; 3]> {
        let axis = Axis::new(self.axis);
        let at = |(z, rho): (f64, f64), i: usize| -> DVec3 {
            self.base.as_dvec3() + axis.0 * z + axis.ring(i as f64 / TURNS as f64) * rho
        };
        let mut triangles = Vec::new();
        for pair in self.profile.windows(2) {
            for i in 0..TURNS {
                let corners = [at(pair[0], i), at(pair[1], i), at(pair[1], i + 1), at(pair[0], i + 1)];
                let [a, b, c, d] = corners.map(|p| p.as_vec3());
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        triangles
    }
}

/// Rays around a shape and around its mesh must meet the same, but for those at an outline.
fn agrees(text: &str, lathe: &Lathe) {
    const RAYS: usize = 1500;
    let shape = shape(text);
    let triangles = lathe.triangles();
    let (center, size) = (shape.bounds().center(), shape.bounds().extent().length() * 0.5);
    let mut random = Random(31);
    let (mut both, mut differ) = (0, 0);
    for i in 0..RAYS {
        // Every fourth from inside.
        let distance = if i % 4 == 0 { 0.05 } else { 2.0 };
        let origin = center + random.direction() * size * distance;
        let target = center + random.direction() * size * random.next() * 0.8;
        let ray = Ray::new(origin, (target - origin).normalize());
        let nearest = triangles
            .iter()
            .filter_map(|t| Some((triangle::intersect(&ray, t[0], t[1], t[2])?, t)))
            .min_by(|x, y| x.0.t.total_cmp(&y.0.t));
        match (shape.intersect(&ray), nearest) {
            (None, None) => {}
            (Some(hit), Some((on_mesh, corners))) => {
                let (s, m) = (
                    shape.surface(&ray, &hit),
                    triangle::surface(*corners, None, on_mesh.u, on_mesh.v),
                );
                let graze = s.ng.dot(ray.d).abs().max(0.02);
                let near = (hit.t - on_mesh.t).abs() * graze <= 1e-3 * size;
                if near && s.ng.dot(m.ng) > 0.999 {
                    both += 1;
                } else {
                    differ += 1;
                }
            }
            _ => differ += 1,
        }
    }
    assert!(both > RAYS / 3, "{text}: {both}");
    assert!(differ * 100 <= both, "{text}: {differ} of {both} differ");
}

#[test]
fn a_sphere_agrees_with_its_mesh() {
    let arc = |i: i32| {
        let latitude = (f64::from(i) / 128.0 - 0.5) * PI;
        (2.0 * libm::sin(latitude), 2.0 * libm::cos(latitude))
    };
    let lathe = Lathe {
        base: Vec3::new(1.0, 2.0, 3.0),
        axis: Vec3::Y,
        profile: (0..=128).map(arc).collect(),
    };
    agrees("sphere = { center = [1, 2, 3], radius = 2 }", &lathe);
}

#[test]
fn a_cylinder_agrees_with_its_mesh() {
    let mut lathe = Lathe {
        base: Vec3::new(1.0, 2.0, 3.0),
        axis: Vec3::new(1.0, -1.0, 2.0),
        profile: vec![(0.0, 0.0), (0.0, 0.5), (1.5, 0.5), (1.5, 0.0)],
    };
    let size = "base = [1, 2, 3], axis = [1, -1, 2], radius = 0.5, height = 1.5";
    agrees(&format!("cylinder = {{ {size} }}"), &lathe);
    lathe.profile = vec![(0.0, 0.5), (1.5, 0.5)];
    agrees(&format!("cylinder = {{ {size}, caps = false }}"), &lathe);
}

#[test]
fn a_cone_agrees_with_its_mesh() {
    let mut lathe = Lathe {
        base: Vec3::new(1.0, 2.0, 3.0),
        axis: Vec3::new(1.0, -1.0, 2.0),
        profile: vec![(0.0, 0.0), (0.0, 0.75), (1.5, 0.0)],
    };
    let size = "base = [1, 2, 3], axis = [1, -1, 2], radius = 0.75, height = 1.5";
    agrees(&format!("cone = {{ {size} }}"), &lathe);
    lathe.profile = vec![(0.0, 0.75), (1.5, 0.0)];
    agrees(&format!("cone = {{ {size}, caps = false }}"), &lathe);
}

#[test]
fn a_disk_agrees_with_its_mesh() {
    let lathe = Lathe {
        base: Vec3::new(3.0, 1.0, -2.0),
        axis: Vec3::new(1.0, -2.0, 0.5),
        profile: vec![(0.0, 0.3), (0.0, 0.0)],
    };
    agrees(
        "disk = { center = [3, 1, -2], normal = [1, -2, 0.5], radius = 0.3 }",
        &lathe,
    );
}
