//! One shape in several forms: the same hits and the same picture.

#[path = "../../examples/procedural_scene.rs"]
mod procedural_scene;

use std::{f32::consts::TAU, fmt::Write};

use crate::common::{Folder, repo, repo_str};
use batch_render::{
    batch::{Job, Request},
    geometry::Hit,
    math::{Ray, Vec3},
    scene::{Scene, SurfaceInteraction},
};

/// The forms that are compared with `cuboid`.
const FORMS: [&str; 4] = ["quads", "obj", "gltf", "mirrored"];

fn scene(path: &std::path::Path) -> Scene {
    let job = Job::open(path, &Request::default()).unwrap_or_else(|e| panic!("{e}"));
    job.compile().unwrap_or_else(|e| panic!("{e}"))
}

fn surfaces(scene: &Scene, rays: &[Ray]) -> Vec<Option<SurfaceInteraction>> {
    let mut hits: Vec<Option<Hit>> = vec![None; rays.len()];
    scene.geometry.accel.nearest(rays, &mut hits);
    rays.iter()
        .zip(&hits)
        .map(|(r, h)| h.map(|h| scene.surface(r, &h)))
        .collect()
}

/// Well spread numbers in `[0, 1)`.
///
/// Source: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.
fn spread(i: u32) -> [f32; 4] {
    // Powers of the inverse of the root of x^5 = x + 1.
    [0.856_674_9, 0.733_891_9, 0.628_706_7, 0.538_597_2].map(|a: f32| (f64::from(a) * f64::from(i + 1)).fract() as f32)
}

/// Rays from a sphere of that radius through points of a box around `center`.
fn rays(count: u32, center: Vec3, radius: f32, reach: f32) -> Vec<Ray> {
    let ray = |i| {
        let [a, b, c, d] = spread(i);
        let (z, turn) = (2.0 * a - 1.0, TAU * b);
        let r = (1.0 - z * z).sqrt();
        let o = center + Vec3::new(r * libm::cosf(turn), z, r * libm::sinf(turn)) * radius;
        let to = center + (Vec3::new(c, d, (c + 7.0 * d).fract()) * 2.0 - 1.0) * reach;
        Ray::new(o, (to - o).normalize())
    };
    (0..count).map(ray).collect()
}

#[test]
fn every_form_of_the_cube_has_the_same_hits() {
    let truth = scene(&repo("scenes/cube/cuboid.toml"));
    let rays = rays(20_000, Vec3::new(0.0, 1.1, 0.0), 6.0, 1.3);
    let expected = surfaces(&truth, &rays);
    assert!(expected.iter().flatten().count() > 15_000);
    let files = FORMS.map(|form| (form, scene(&repo(&format!("scenes/cube/{form}.toml")))));
    let in_code = ("procedural", procedural_scene::cube_scene().expect("sound"));
    for (form, scene) in files.into_iter().chain([in_code]) {
        let found = surfaces(&scene, &rays);
        let mut odd = 0;
        for (e, f) in expected.iter().zip(&found) {
            match (e, f) {
                (None, None) => {}
                (Some(e), Some(f))
                    if (e.t / f.t - 1.0).abs() < 1e-5
                        && (e.ng - f.ng).length() < 1e-5
                        && (e.ns - f.ns).length() < 1e-5 => {}
                // An edge belongs to either side.
                _ => odd += 1,
            }
        }
        assert!(odd <= 2, "{form}: {odd} of {} hits differ", rays.len());
    }
}

#[test]
fn every_form_of_the_cube_has_the_same_picture_but_for_its_edges() {
    let folder = Folder::new();
    let render = |form: &str| {
        let scene = repo_str(&format!("scenes/cube/{form}.toml"));
        let name = format!("{form}.png");
        folder.succeed(&[&scene, "--samples", "1", "--progress", "none", "-o", &name]);
        image::load_from_memory(&folder.read(&name))
            .expect("a picture")
            .into_rgb8()
    };
    let truth = render("cuboid");
    for form in FORMS {
        let found = render(form);
        let different: Vec<_> = truth
            .enumerate_pixels()
            .filter(|(x, y, p)| {
                let q = found.get_pixel(*x, *y);
                (0..3).any(|k| p[k].abs_diff(q[k]) > 1)
            })
            .collect();
        let most = truth.width() as usize * truth.height() as usize / 1000;
        assert!(different.len() <= most, "{form}: {} pixels differ", different.len());
        for (x, y, _) in different {
            let near = |x: u32, y: u32| *truth.get_pixel(x.min(truth.width() - 1), y.min(truth.height() - 1));
            let around = [
                near(x + 1, y),
                near(x.saturating_sub(1), y),
                near(x, y + 1),
                near(x, y.saturating_sub(1)),
            ];
            let is_edge = around.iter().any(|p| (0..3).any(|k| p[k].abs_diff(around[0][k]) > 8));
            assert!(is_edge, "{form}: pixel {x}, {y} differs inside of a face");
        }
    }
}

/// A unit sphere of `2 n` by `n` faces, smooth.
fn sphere_obj(n: u32) -> String {
    let mut text = String::from("s 1\n");
    for i in 0..=n {
        for j in 0..2 * n {
            let (polar, turn) = (TAU / 2.0 * i as f32 / n as f32, TAU * j as f32 / (2 * n) as f32);
            let r = if i % n == 0 { 0.0 } else { libm::sinf(polar) };
            writeln!(
                text,
                "v {} {} {}",
                r * libm::cosf(turn),
                libm::cosf(polar),
                -r * libm::sinf(turn)
            )
            .expect("text");
        }
    }
    for i in 0..n {
        for j in 0..2 * n {
            let at = |i: u32, j: u32| 1 + i * 2 * n + j % (2 * n);
            writeln!(
                text,
                "f {} {} {} {}",
                at(i, j),
                at(i + 1, j),
                at(i + 1, j + 1),
                at(i, j + 1)
            )
            .expect("text");
        }
    }
    text
}

#[test]
fn a_fine_mesh_of_a_sphere_agrees_with_the_sphere_within_its_own_error() {
    let n = 48;
    let folder = Folder::new();
    folder.write("sphere.obj", &sphere_obj(n));
    let object = |shape: &str| {
        format!(
            "[camera]\nperspective = {{ eye = [0, 0, 4], target = [0, 0, 0], fov = 40 }}\n[material.m]\nmatte = {{ albedo = [1, 1, 1] }}\n[[object]]\nmaterial = \"m\"\n{shape}\n[[light]]\nsun = {{ direction = [0, -1, 0], irradiance = 1 }}\n"
        )
    };
    let sphere = scene(&folder.write("sphere.toml", &object("shape.sphere = { radius = 1 }")));
    let mesh = scene(&folder.write("mesh.toml", &object("shape.mesh = { file = \"sphere.obj\" }")));
    let rays = rays(20_000, Vec3::ZERO, 4.0, 0.9);
    // How deep a face lies under the sphere: its diagonal is seen from the centre under this angle.
    let half_angle = 0.5 * (TAU / 2.0 / n as f32) * 2.0_f32.sqrt();
    let depth = 1.0 - libm::cosf(half_angle);
    let mut compared = 0;
    for (s, m) in surfaces(&sphere, &rays).iter().zip(&surfaces(&mesh, &rays)) {
        let (Some(s), Some(m)) = (s, m) else { continue };
        let cos = s.ng.dot(s.wo);
        if cos < 0.3 {
            continue;
        }
        compared += 1;
        assert!(
            m.t >= s.t - 1e-5 && m.t - s.t < 1.1 * depth / cos,
            "{} and {}",
            s.t,
            m.t
        );
        assert!(
            m.ns.dot(m.p.normalize()) > libm::cosf(0.2 * half_angle),
            "{} at {}",
            m.ns,
            m.p
        );
        assert!(m.ng.dot(m.p.normalize()) > libm::cosf(1.1 * half_angle));
    }
    assert!(compared > 10_000, "{compared}");
}
