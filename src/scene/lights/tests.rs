//! Properties of every light: a kind gets these tests by an example.

use std::f64::consts::PI;

use super::{LightFamily, LightSampleContext, LightSource};
use crate::{
    accel::AccelKind,
    light::Light,
    material::{Emission, Material, Sidedness, emitter::Emitter},
    math::{
        DVec3, Plain, Ray, Rgb, Transform, Vec2, Vec3,
        hash::{pcg4d, unit_f32},
        warp,
    },
    scene::{Background, LightId, Scene, SceneBuilder},
    shape::{ShapeDesc, mesh::Mesh},
    texture::{
        Bitmap, Color, Mapping, Pattern, Texture,
        checker::Checker,
        image::{ImagePattern, TextureFilter, Wrap},
        mapping::MappingDesc,
        two_colors::TwoColors,
        voronoi::{CellValue, Voronoi},
    },
};

mod batches;
mod choice;

/// Two pairs of numbers for each `i`.
pub fn numbers(seed: u32, i: u32) -> [Vec2; 2] {
    let [a, b, c, d] = pcg4d([seed, i, 17, 4]).map(unit_f32);
    [Vec2::new(a, b), Vec2::new(c, d)]
}

pub fn shining(radiance: Color, sidedness: Sidedness) -> Material {
    Material::Emitter(Emitter {
        radiance,
        scale: 1.0,
        sidedness,
    })
}

/// Radiance 2 from the front.
pub fn lamp() -> Material {
    shining(Color::Constant(Rgb::gray(2.0)), Sidedness::Front)
}

pub fn dark() -> SceneBuilder {
    SceneBuilder::new(Background::new(Rgb::BLACK))
}

/// One shape that shines.
pub fn shape_scene(shape: &str, transform: Option<Transform>, material: Material) -> Scene {
    let mut builder = dark();
    let material = builder.material(material);
    add(&mut builder, shape, transform, material);
    builder.build(AccelKind::Linear).expect("a scene")
}

pub fn add(
    builder: &mut SceneBuilder,
    shape: &str,
    transform: Option<Transform>,
    material: crate::material::MaterialId,
) {
    let desc: ShapeDesc = toml::from_str(shape).expect("a shape");
    builder.shape("shape", desc.compile(DVec3::ZERO).expect("valid"), transform, material);
}

pub fn place(translate: [f64; 3], rotate: [f64; 3], scale: [f64; 3]) -> Option<Transform> {
    Some(Transform::from_parts(translate.into(), rotate.into(), scale.into()).expect("invertible"))
}

/// A mean and its variance.
#[derive(Clone, Copy, Debug, Default)]
pub struct Estimate {
    sum: f64,
    squares: f64,
    n: f64,
}

impl Estimate {
    pub fn add(&mut self, v: f64) {
        self.sum += v;
        self.squares += v * v;
        self.n += 1.0;
    }

    pub fn mean(&self) -> f64 {
        self.sum / self.n
    }

    /// The variance of the mean.
    pub fn variance(&self) -> f64 {
        (self.squares / self.n - self.mean() * self.mean()).max(0.0) / self.n
    }

    /// The difference between two estimates, in standard deviations.
    pub fn z(&self, other: &Self) -> f64 {
        let scale = 1e-5 * self.mean().abs();
        (self.mean() - other.mean()).abs() / (self.variance() + other.variance()).sqrt().max(scale).max(1e-30)
    }
}

/// The light that sample `i` of each family brings to a white surface at `at`, with its density.
fn light_samples<'a>(
    scene: &'a Scene,
    at: &'a LightSampleContext,
    i: u32,
) -> impl Iterator<Item = (Vec3, f64, f64)> + 'a {
    let families = scene.lights.families();
    families.filter_map(move |family| light_sample(scene, family, at, numbers(91 + 1000 * family as u32, i)))
}

/// The light that a sample of one family brings to a white surface at `at`, and its density.
pub fn light_sample(
    scene: &Scene,
    family: LightFamily,
    at: &LightSampleContext,
    [u, v]: [Vec2; 2],
) -> Option<(Vec3, f64, f64)> {
    let choice = scene.lights.choose(Plain, family, at, v.x.into())?;
    let sample = scene.sample_light(choice.light, at.p, u)?;
    let cos = at.n.dot(sample.wi);
    if cos <= 0.0 {
        return None;
    }
    let mut blocked = [false];
    let end = if sample.distance.is_finite() {
        sample.distance
    } else {
        f32::INFINITY
    };
    scene
        .geometry
        .accel
        .occluded(&[Ray::segment(at.p, sample.wi, end)], &mut blocked);
    let pdf = f64::from(sample.pdf.unwrap_or(1.0)) * f64::from(choice.pmf);
    (!blocked[0]).then(|| (sample.wi, f64::from(sample.li.g * cos), pdf))
}

/// The light along the ray from `at` in direction `w`, each part with the density of light sampling
/// for it.
fn met(scene: &Scene, at: &LightSampleContext, w: Vec3) -> Vec<(f64, f64)> {
    let wide = |(l, pdf): (Rgb, f32)| (f64::from(l.g), f64::from(pdf));
    let ray = Ray::new(at.p, w);
    let mut hits = [None];
    scene.geometry.accel.nearest(&[ray], &mut hits);
    let Some(hit) = hits[0] else {
        let sky = (scene.background_radiance(w), scene.pdf_background(at, w));
        return std::iter::once(sky)
            .chain(scene.suns(at, w).map(|(_, l, pdf)| (l, pdf)))
            .map(wide)
            .collect();
    };
    let surface = scene.surface(&ray, &hit);
    let Some(emission) = scene.material(surface.material).emission() else {
        return Vec::new();
    };
    let l = emission.radiance(&scene.textures(), &surface.texture, surface.ng.dot(-w));
    vec![wide((l, scene.pdf_hit(at, w, &hit)))]
}

/// The irradiance at `at` by light sampling, by cosine-weighted directions, and by both with
/// weights.
pub fn irradiances(scene: &Scene, at: &LightSampleContext, n: u32) -> [Estimate; 3] {
    let mut estimates = [Estimate::default(); 3];
    let frame = crate::math::Frame::from_normal(at.n);
    for i in 0..n {
        let (mut of_light, mut of_both) = (0.0, 0.0);
        for (wi, l, pdf) in light_samples(scene, at, i) {
            let other = f64::from(warp::cosine_hemisphere_pdf(at.n.dot(wi)));
            of_light += l / pdf;
            of_both += l / pdf * pdf * pdf / (pdf * pdf + other * other);
        }
        estimates[0].add(of_light);
        let [u, _] = numbers(92, i);
        let w = frame.to_world(warp::Sample2D::from(u).cosine_hemisphere()).normalize();
        let own = f64::from(warp::cosine_hemisphere_pdf(at.n.dot(w)));
        let mut of_cosine = 0.0;
        for (l, pdf) in met(scene, at, w) {
            of_cosine += l * PI;
            of_both += l * PI * own * own / (own * own + pdf * pdf);
        }
        estimates[1].add(of_cosine);
        estimates[2].add(of_both);
    }
    estimates
}

/// Shapes about 1 large around the origin.
const SHAPES: [&str; 9] = [
    "sphere = { radius = 0.5 }",
    "disk = { radius = 0.6, normal = [0.2, -1, 0.1] }",
    "quad = { corners = [[-0.5, 0, -0.5], [0.5, 0, -0.5], [0.5, 0, 0.5], [-0.5, 0, 0.5]] }",
    "quad = { corners = [[-0.5, 0, -0.5], [0.7, 0, -0.3], [0.5, 0, 0.5], [-0.5, 0, 0.2]] }",
    "cuboid = { min = [-0.5, -0.3, -0.4], max = [0.5, 0.3, 0.4] }",
    "cylinder = { base = [0, -0.4, 0], radius = 0.4, height = 0.8 }",
    "cylinder = { base = [0, -0.4, 0], radius = 0.4, height = 0.8, caps = false }",
    "cone = { base = [0, -0.4, 0], radius = 0.5, height = 0.8 }",
    "cone = { base = [0, 0.4, 0], axis = [0.3, -1, 0], radius = 0.5, height = 0.8, caps = false }",
];

fn transforms() -> [Option<Transform>; 4] {
    [
        place([0.0, 2.0, 0.0], [0.0; 3], [1.0; 3]),
        place([0.3, 2.0, 0.1], [20.0, 40.0, -30.0], [1.4, 0.7, 0.9]),
        place([0.0, 1.6, 0.5], [10.0, 0.0, 60.0], [0.4, 1.1, -1.3]),
        place([-0.2, 2.5, 0.0], [0.0, 0.0, 15.0], [2.5; 3]),
    ]
}

fn floor(x: f32) -> LightSampleContext {
    LightSampleContext {
        p: Vec3::new(x, 0.1, 0.3),
        n: Vec3::new(0.1, 1.0, -0.2).normalize(),
    }
}

#[test]
fn every_shape_under_every_transform_shines_alike_however_it_is_looked_for() {
    for shape in SHAPES {
        for (i, transform) in transforms().into_iter().enumerate() {
            let sides = if i % 2 == 0 { Sidedness::Both } else { Sidedness::Front };
            let scene = shape_scene(shape, transform, shining(Color::Constant(Rgb::gray(2.0)), sides));
            let [light, cosine, both] = irradiances(&scene, &floor(0.4), 6000);
            assert!(light.mean() > 0.0 || sides == Sidedness::Front, "{shape} {i}");
            for (name, other) in [("cosine", cosine), ("both", both)] {
                let z = light.z(&other);
                assert!(z < 4.5, "{shape} {i}: light {light:?}, {name} {other:?}, {z}");
            }
        }
    }
}

#[test]
fn a_sampled_direction_has_the_density_that_its_hit_is_told() {
    for shape in SHAPES {
        for (k, transform) in transforms().into_iter().enumerate() {
            let both = shining(Color::Constant(Rgb::WHITE), Sidedness::Both);
            let scene = shape_scene(shape, transform, both);
            let at = floor(0.7);
            let mut found = 0;
            for i in 0..300 {
                let [u, _] = numbers(93, i);
                let Some(sample) = scene.sample_light(LightId(0), at.p, u) else {
                    continue;
                };
                let ray = Ray::new(at.p, sample.wi);
                let mut hits = [None];
                scene.geometry.accel.nearest(&[ray], &mut hits);
                let Some(hit) = hits[0].filter(|h| (h.t / sample.distance - 1.0).abs() < 1e-4) else {
                    continue;
                };
                // A ray that grazes ends where rounding leads it.
                if scene.surface(&ray, &hit).ng.dot(sample.wi).abs() < 0.2 {
                    continue;
                }
                found += 1;
                let (pdf, told) = (sample.pdf.expect("it has size"), scene.pdf_hit(&at, sample.wi, &hit));
                assert!((told / pdf - 1.0).abs() < 5e-3, "{shape} {k}: {told} is not {pdf}");
            }
            assert!(found > 20, "{shape} {k}: {found}");
        }
    }
}

#[test]
fn a_mesh_of_triangles_shines_as_the_shape_that_it_is() {
    let quad = "quad = { corners = [[-0.5, 0, -0.5], [0.5, 0, -0.5], [0.5, 0, 0.5], [-0.5, 0, 0.5]] }";
    let there = place([0.0, 1.0, 0.0], [0.0; 3], [1.0; 3]);
    let shape = shape_scene(quad, there, lamp());
    let mut builder = dark();
    let material = builder.material(lamp());
    let corners = [[-0.5, 1.0, -0.5], [0.5, 1.0, -0.5], [0.5, 1.0, 0.5], [-0.5, 1.0, 0.5]];
    let mesh = Mesh {
        positions: corners.map(Vec3::from).into(),
        // The last has no area.
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 0, 3]],
        ..Mesh::default()
    };
    builder.mesh("mesh", mesh, material).expect("valid");
    let mesh = builder.build(AccelKind::Linear).expect("a scene");
    let [of_shape, ..] = irradiances(&shape, &floor(0.2), 4000);
    for estimate in irradiances(&mesh, &floor(0.2), 8000) {
        assert!(of_shape.z(&estimate) < 4.5, "{of_shape:?} {estimate:?}");
    }
}

#[test]
fn textured_emitters_shine_with_the_texture_at_the_sampled_point() {
    let checker = Pattern::Checker(Checker {
        colors: [Rgb::gray(4.0), Rgb::gray(0.25)],
        scale: 3.0,
    });
    let cells = Pattern::Voronoi(Voronoi {
        colors: TwoColors([Rgb::gray(0.25), Rgb::gray(4.0)]),
        value: CellValue::Cell,
        scale: 3.0,
        seed: 2,
    });
    let mappings = [
        MappingDesc::Object(Default::default()),
        MappingDesc::World(Default::default()),
    ];
    let solid = mappings.map(|desc| desc.compile(DVec3::ZERO).expect("a mapping"));
    let textures = [(Mapping::Uv, checker), (solid[0], cells), (solid[1], cells)];
    for (shape, (mapping, pattern)) in SHAPES.into_iter().flat_map(|shape| textures.map(|t| (shape, t))) {
        let mut builder = dark();
        let texture = builder.texture(Texture::new(mapping, pattern));
        let material = builder.material(shining(Color::Texture(texture), Sidedness::Both));
        let transform = place([0.0, 1.5, 0.0], [20.0, 10.0, 5.0], [1.0, 0.8, 1.2]);
        add(&mut builder, shape, transform, material);
        let scene = builder.build(AccelKind::Linear).expect("a scene");
        let [light, cosine, both] = irradiances(&scene, &floor(0.3), 10_000);
        for other in [cosine, both] {
            assert!(light.z(&other) < 4.5, "{shape} {mapping:?}: {light:?} {other:?}");
        }
    }
}

#[test]
fn triangles_over_black_texels_are_no_lights() {
    let mut builder = dark();
    // Light on the right third alone.
    let numbers = [0.0, 0.0, 0.0, 0.0, 0.0, 3.0];
    let bitmap = builder.bitmap(Bitmap::from_floats([6, 1], 1, numbers.into()));
    let texture = builder.texture(Texture::new(
        Mapping::Uv,
        Pattern::Image(ImagePattern {
            bitmap,
            filter: TextureFilter::Linear,
            wrap: [Wrap::Clamp; 2],
        }),
    ));
    let material = builder.material(shining(Color::Texture(texture), Sidedness::Both));
    let column = |x: f32| [Vec3::new(x - 0.5, 1.5, -0.5), Vec3::new(x - 0.5, 1.5, 0.5)];
    let mesh = Mesh {
        positions: [0.0, 0.5, 1.0].map(column).concat(),
        uvs: [0.0, 0.5, 1.0].map(|u| [Vec2::new(u, 0.0), Vec2::new(u, 1.0)]).concat(),
        triangles: vec![[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]],
        ..Mesh::default()
    };
    builder.mesh("mesh", mesh, material).expect("valid");
    let scene = builder.build(AccelKind::Linear).expect("a scene");
    let mut chosen = [0; 4];
    for i in 0..1000 {
        let u = (f64::from(i) + 0.5) / 1000.0;
        let choice = scene.lights.choose(Plain, LightFamily::Finite, &floor(0.0), u);
        chosen[choice.expect("two are lights").light.0 as usize] += 1;
    }
    assert!(
        chosen[0] == 0 && chosen[1] == 0 && chosen[2] > 0 && chosen[3] > 0,
        "{chosen:?}"
    );
    let [light, cosine, both] = irradiances(&scene, &floor(0.3), 20_000);
    for other in [cosine, both] {
        assert!(light.z(&other) < 4.5, "{light:?} {other:?}");
    }
}

#[test]
fn surfaces_without_end_or_without_light_are_not_asked() {
    for (shape, material) in [
        ("plane = { point = [0, 3, 0], normal = [0, -1, 0] }", lamp()),
        (
            "sphere = { radius = 1 }",
            shining(Color::Constant(Rgb::BLACK), Sidedness::Both),
        ),
    ] {
        let scene = shape_scene(shape, None, material);
        assert!(scene.lights.is_empty(), "{shape}");
        let chosen = LightFamily::ALL.map(|family| scene.lights.choose(Plain, family, &floor(0.0), 0.5));
        assert_eq!(chosen, [None; 3], "{shape}");
    }
    let plane = shape_scene("plane = { point = [0, 3, 0], normal = [0, -1, 0] }", None, lamp());
    let [_, cosine, both] = irradiances(&plane, &floor(0.0), 100);
    assert!(cosine.z(&both) < 1e-3, "it is met by chance alone");
}

fn irradiance_of(scene: &Scene, at: &LightSampleContext, n: u32) -> Estimate {
    irradiances(scene, at, n)[0]
}

/// Whether an estimate is what is `expected`, within 4.5 standard deviations and rounding.
fn agrees(estimate: &Estimate, expected: f64) -> bool {
    let off = (estimate.mean() - expected).abs();
    off <= 4.5 * estimate.variance().sqrt() + 1e-4 * expected
}

#[test]
fn irradiance_follows_the_closed_forms() {
    let up = LightSampleContext {
        p: Vec3::ZERO,
        n: Vec3::Y,
    };
    // Radiance 2 everywhere. A sphere of radius r at height h: pi L (r / h)^2, tilted by the cosine
    // while it is whole.
    let sphere = shape_scene("sphere = { center = [0, 3, 0], radius = 1 }", None, lamp());
    assert!(agrees(&irradiance_of(&sphere, &up, 3000), 2.0 * PI / 9.0));
    let tilted = LightSampleContext {
        n: Vec3::new(0.8, 0.6, 0.0),
        ..up
    };
    assert!(agrees(&irradiance_of(&sphere, &tilted, 3000), 2.0 * PI / 9.0 * 0.6));
    // A parallel disk: pi L r^2 / (r^2 + h^2).
    let disk = shape_scene(
        "disk = { center = [0, 2, 0], normal = [0, -1, 0], radius = 1 }",
        None,
        lamp(),
    );
    assert!(agrees(&irradiance_of(&disk, &up, 6000), 2.0 * PI / 5.0));
    // A polygon: L/2 times the sum over its edges of the angle that each fills, times the normal's
    // part along the edge's plane (Lambert, "Photometria", 1760).
    let corners = [[-1.0, 2.0, -1.0], [1.0, 2.0, -1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]].map(DVec3::from);
    let mut sum = 0.0;
    for i in 0..4 {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        let across = a.cross(b);
        let angle = libm::atan2(across.length(), a.dot(b));
        sum += angle * across.normalize().y;
    }
    let expected = 2.0 * 0.5 * sum.abs();
    let quad = "quad = { corners = [[-1, 2, -1], [1, 2, -1], [1, 1, 1], [-1, 1, 1]] }";
    let quad = shape_scene(quad, None, shining(Color::Constant(Rgb::gray(2.0)), Sidedness::Both));
    let found = irradiance_of(&quad, &up, 6000);
    assert!(agrees(&found, expected), "{found:?} is not {expected}");
    let mesh = crate::light::area::sample_triangle;
    let triangle = |i: u32, corners: [Vec3; 3]| {
        let s = mesh(corners, Vec3::ZERO, numbers(94, i)[0]).expect("seen");
        2.0 * f64::from(s.p.normalize().y) / f64::from(s.pdf)
    };
    let [a, b, c, d] = corners.map(|c| c.as_vec3());
    let mut both = Estimate::default();
    (0..6000).for_each(|i| both.add(triangle(i, [a, b, c]) + triangle(i + 6000, [a, c, d])));
    assert!(agrees(&both, expected), "{both:?} is not {expected}");
}

#[test]
fn a_shadow_ray_ends_before_the_emitter_that_it_asks_for() {
    for (shape, scale) in [
        (SHAPES[0], 1e-3),
        (SHAPES[2], 1.0),
        (SHAPES[4], 1.0),
        (SHAPES[7], 100.0),
    ] {
        for distance in [1.0, 100.0, 1e4] {
            let from = Vec3::new(0.3, -0.9, 0.2).normalize() * distance * scale as f32;
            let scene = shape_scene(
                shape,
                place([0.0; 3], [10.0, 20.0, 30.0], [scale; 3]),
                shining(Color::Constant(Rgb::WHITE), Sidedness::Both),
            );
            let (mut seen, mut all) = (0, 0);
            for i in 0..200 {
                let Some(sample) = scene.sample_light(LightId(0), from, numbers(95, i)[0]) else {
                    continue;
                };
                let ray = Ray::new(from, sample.wi);
                let mut hits = [None];
                scene.geometry.accel.nearest(&[ray], &mut hits);
                // Where it is seen at all, not its far side.
                let near = hits[0].is_some_and(|h| h.t > sample.distance * (1.0 - 1e-3 / distance));
                if near {
                    all += 1;
                    let mut blocked = [false];
                    scene
                        .geometry
                        .accel
                        .occluded(&[Ray::segment(from, sample.wi * sample.distance, 1.0)], &mut blocked);
                    seen += u32::from(!blocked[0]);
                }
            }
            assert!(all > 20 && seen == all, "{shape} from {distance}: {seen} of {all}");
        }
    }
}

#[test]
fn emission_is_what_materials_tell() {
    let scene = shape_scene(SHAPES[0], None, lamp());
    let LightSource::Emitter(_) = scene.lights.source(LightId(0)) else {
        panic!("a shape that shines is a light");
    };
    let Some(Emission { scale, .. }) = scene.shading.materials[0].emission() else {
        panic!("it shines");
    };
    assert_eq!(scale, 1.0);
    assert!(scene.lights.all().iter().all(|l: &Light| matches!(l, Light::Point(_))));
}
