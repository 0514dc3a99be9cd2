//! Every accelerator against the linear scan, in scenes where all shapes, under all sorts of transforms, mix with triangles.

use std::sync::Arc;

use batch_render::{
    accel::{self, AccelKind, Accelerator, BuildOptions},
    geometry::{Geometry, Hit, PrimId},
    math::{
        DVec3, Ray, Transform, Vec3,
        hash::{pcg4d, unit_f32},
    },
    shape::{Shape, ShapeDesc},
    simd::Isa,
};

const RAYS: u32 = 100_000;

const SHAPES: [&str; 12] = [
    "sphere = { radius = 0.3 }",
    "sphere = { center = [0.1, 0.2, 0], radius = 0.02 }",
    "quad = { corners = [[-0.4, 0, 0.4], [0.4, 0, 0.4], [0.4, 0, -0.4], [-0.4, 0, -0.4]] }",
    "quad = { corners = [[0, 0, 0], [0.6, 0, 0], [0.4, 0.3, 0], [0.1, 0.25, 0]] }",
    "cylinder = { radius = 0.1, height = 0.6 }",
    "cylinder = { radius = 0.2, height = 0.3, caps = false }",
    "cylinder = { radius = 0.2, height = 0.3, caps = false, outside_only = true }",
    "cone = { radius = 0.25, height = 0.5 }",
    "cone = { radius = 0.25, height = 0.5, caps = false }",
    "disk = { radius = 0.3 }",
    "cuboid = { min = [-0.1, -0.2, -0.3], max = [0.1, 0.2, 0.3] }",
    "plane = { point = [0, -3, 0] }",
];

fn shape(text: &str) -> Shape {
    #[derive(serde::Deserialize)]
    struct Row {
        shape: ShapeDesc,
    }
    let row: Row = toml::from_str(&format!("shape.{text}")).expect("a shape");
    row.shape
        .compile(batch_render::math::DVec3::ZERO)
        .expect("a sound shape")
}

/// Numbers in [-1, 1).
fn random(i: u32, purpose: u32) -> Vec3 {
    let [x, y, z, _] = pcg4d([i, purpose, 3, 9]);
    Vec3::new(unit_f32(x), unit_f32(y), unit_f32(z)) * 2.0 - 1.0
}

fn mixed_scene() -> Geometry {
    let mut g = Geometry::default();
    for i in 0..400 {
        let shape = shape(SHAPES[i as usize % SHAPES.len()]);
        // A third stand as they are but for their place, a third are turned and scaled, a third mirrored as well.
        let (turn, scale) = match i % 3 {
            0 => (Vec3::ZERO, Vec3::ONE),
            1 => (random(i, 1) * 180.0, random(i, 2).abs() + 0.2),
            _ => (
                random(i, 1) * 180.0,
                random(i, 2).abs() * Vec3::new(-1.0, 1.0, 1.0) - Vec3::X * 0.2 + Vec3::Y * 0.1 + Vec3::Z * 0.1,
            ),
        };
        let wide = |v: Vec3| -> DVec3 { v.as_dvec3() };
        let transform =
            Transform::from_parts(wide(random(i, 3) * 2.0), wide(turn), wide(scale)).expect("it has an inverse");
        g.add_shape(shape, Some(transform));
    }
    for i in 0..2000 {
        let a = random(i, 4) * 2.0;
        let first = g.vertices.len() as u32;
        g.vertices.extend([a, a + random(i, 5) * 0.3, a + random(i, 6) * 0.3]);
        g.triangles.push([first, first + 1, first + 2]);
    }
    // Some that are as large as the scene or thin as a thread, half of them in planes across an axis.
    for i in 0..120 {
        let (a, mut b, mut c) = (random(i, 7) * 2.0, random(i, 8) * 3.0, random(i, 9) * 3.0);
        if i % 3 == 0 {
            c = b * 0.5 + random(i, 17) * 1e-3;
        }
        if i % 2 == 0 {
            let across = (i / 2 % 3) as usize;
            (b[across], c[across]) = (0.0, 0.0);
        }
        let first = g.vertices.len() as u32;
        g.vertices.extend([a, a + b, a + c]);
        g.triangles.push([first, first + 1, first + 2]);
    }
    g
}

/// At random, along the axes, past corners and edges of the scene's primitives, and nearly in the planes of triangles.
fn rays(g: &Geometry) -> Vec<Ray> {
    (0..RAYS)
        .map(|i| match i % 4 {
            3 => {
                let prim = g.triangles.len() - 1 - pcg4d([i, 18, 0, 0])[0] as usize % 300;
                let [a, b, c] = g.corners(prim);
                let inside = |purpose: u32| {
                    let [u, v, ..] = pcg4d([i, purpose, 0, 0]).map(unit_f32);
                    a + (b - a) * u + (c - a) * (v * (1.0 - u))
                };
                let (o, d) = (inside(19), (inside(20) - inside(21)).normalize_or_zero());
                let height = random(i, 22) * [0.0, 1e-6, 1e-3, 0.1][i as usize / 4 % 4];
                Ray::new(o + height - d, d - height * unit_f32(pcg4d([i, 23, 0, 0])[0]))
            }
            0 => Ray::new(random(i, 10) * 3.0, random(i, 11)),
            1 => {
                let mut d = Vec3::ZERO;
                d[(i / 3 % 3) as usize] = if i / 9 % 2 == 0 { 1.0 } else { -1.0 };
                if i % 2 == 0 {
                    // A zero may have a sign.
                    d = -(-d);
                }
                Ray::new(random(i, 12) * 2.5, d)
            }
            _ => {
                let prim = PrimId::new(pcg4d([i, 13, 0, 0])[0] % g.prim_count() as u32);
                let target = match g.shape(prim) {
                    None => {
                        let [a, b, _] = g.corners(prim.index() as usize);
                        a + (b - a) * unit_f32(pcg4d([i, 14, 0, 0])[0])
                    }
                    // A corner of the box lies on the rim of most shapes' silhouettes, or just off it.
                    Some(_) => {
                        let b = g.bounds(prim);
                        if b.is_finite() {
                            b.corner(i as usize % 8) * 0.5 + b.center() * 0.5
                        } else {
                            random(i, 15)
                        }
                    }
                };
                let o = random(i, 16) * 4.0;
                Ray::new(o, target - o)
            }
        })
        .collect()
}

fn trace(accel: &dyn Accelerator, rays: &[Ray]) -> (Vec<Option<Hit>>, Vec<bool>) {
    let (mut hits, mut blocked) = (vec![None; rays.len()], vec![false; rays.len()]);
    accel.nearest(rays, &mut hits);
    accel.occluded(rays, &mut blocked);
    (hits, blocked)
}

fn bits(hit: &Option<Hit>) -> Option<[u32; 4]> {
    hit.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim.index()])
}

#[test]
fn every_accelerator_equals_the_linear_scan_bit_for_bit_in_a_scene_of_all_shapes() {
    let g = Arc::new(mixed_scene());
    let rays = rays(&g);
    let linear = accel::build(AccelKind::Linear, g.clone()).expect("sound");
    let (truth, blocked) = trace(&*linear, &rays);
    let met = truth.iter().flatten().count();
    assert!(met > rays.len() / 3, "{met} hits prove little");
    let bvh2 = accel::build(AccelKind::Bvh2, g.clone()).expect("sound");
    let mut others: Vec<(String, Box<dyn Accelerator>)> = vec![("bvh2".to_owned(), bvh2)];
    for simd in Isa::available() {
        let kind = AccelKind::Wide;
        let accel = accel::build(BuildOptions { kind, simd }, g.clone()).expect("sound");
        others.push((format!("wide {}", simd.name()), accel));
    }
    for (name, accel) in others {
        let (hits, occluded) = trace(&*accel, &rays);
        for i in 0..rays.len() {
            assert_eq!(bits(&hits[i]), bits(&truth[i]), "{name}, ray {i}: {:?}", rays[i]);
            assert_eq!(occluded[i], blocked[i], "{name}, shadow ray {i}: {:?}", rays[i]);
        }
    }
}
