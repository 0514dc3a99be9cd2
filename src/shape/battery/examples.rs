//! Examples of every kind, and the random numbers and rays to try them with.

use std::{fs, path::PathBuf};

use serde::Deserialize;

use crate::{
    math::{DVec3, Ray, Vec2, Vec3, hash},
    shape::{Shape, ShapeDesc, ShapeHit},
};

/// Every kind at several sizes and places, as scene files say it.
const EXAMPLES: &[&str] = &[
    "sphere = { radius = 1 }",
    "sphere = { center = [5, -2, 3], radius = 0.25 }",
    "sphere = { center = [-0.01, 0.02, 0.005], radius = 0.001 }",
    "sphere = { center = [2e4, -1e4, 5e3], radius = 1e4 }",
    "disk = { radius = 1 }",
    "disk = { center = [3, 1, -2], normal = [1, -2, 0.5], radius = 0.3 }",
    "disk = { center = [1e4, 2e4, 0], normal = [0, 0, -1], radius = 1e4 }",
    "quad = { corners = [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]] }",
    "quad = { corners = [[0, 0, 0], [2, 0, 1], [3, 1, 1], [1, 1, 0]] }",
    "quad = { corners = [[0, 0, 0], [3, 0, 0], [2, 1, 0], [0.5, 0.75, 0]] }",
    "quad = { corners = [[5, 5, 5], [5.001, 5, 5], [5.001, 5.003, 5], [5, 5.003, 5]] }",
    "quad = { corners = [[0, 1e4, 0], [1e4, 1e4, 0], [1e4, 2e4, 1e4], [0, 2e4, 1e4]] }",
    "quad = { corners = [[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 1, 0]] }",
    "cuboid = { min = [-1, -1, -1], max = [1, 1, 1] }",
    "cuboid = { min = [-3, 0, 2], max = [-2, 0.25, 5] }",
    "cuboid = { min = [0.01, 0, 0], max = [0.011, 0.003, 0.002] }",
    "cuboid = { min = [-1e4, -2e4, 0], max = [2e4, -1e4, 3e4] }",
    "cylinder = { base = [0, 0, 0], radius = 1, height = 2 }",
    "cylinder = { base = [1, 2, 3], axis = [1, -1, 2], radius = 0.5, height = 1.5 }",
    "cylinder = { base = [1, 2, 3], axis = [0, 0, -1], radius = 0.5, height = 1.5, caps = false }",
    "cylinder = { base = [0, -1, 0], radius = 1, height = 2, caps = false, outside_only = true }",
    "cylinder = { base = [0.01, 0, 0], axis = [1, 2, 3], radius = 0.001, height = 0.001 }",
    "cylinder = { base = [1e4, 0, -1e4], axis = [3, 2, 1], radius = 1e4, height = 2e4 }",
    "cone = { base = [0, 0, 0], radius = 1, height = 2 }",
    "cone = { base = [1, 2, 3], axis = [1, -1, 2], radius = 1.5, height = 0.5 }",
    "cone = { base = [1, 2, 3], axis = [0, 0, -1], radius = 0.5, height = 1.5, caps = false }",
    "cone = { base = [0, -1, 0], radius = 1, height = 2, caps = false, outside_only = true }",
    "cone = { base = [0.01, 0, 0], axis = [1, 2, 3], radius = 0.001, height = 0.001 }",
    "cone = { base = [1e4, 0, -1e4], axis = [3, 2, 1], radius = 1e4, height = 2e4 }",
    "plane = {}",
    "plane = { point = [1, 2, 3], normal = [1, 2, -3] }",
    "plane = { point = [1e4, -2e4, 0], normal = [-1, 0, 2] }",
];

/// The snippets of the manual pages of this room: a kind is tried as soon as its file is there.
fn snippets() -> Vec<String> {
    let room = concat!(env!("CARGO_MANIFEST_DIR"), "/src/shape");
    let mut files: Vec<_> = fs::read_dir(room)
        .expect("the room is there")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .collect();
    files.sort();
    let snippet = |path: &PathBuf| {
        let manual = fs::read_to_string(path).expect("readable");
        let snippet = manual.split("//! ```toml\n").nth(1)?;
        let snippet = snippet.split("//! ```").next()?.replace("//! ", "");
        (!snippet.contains("shape.mesh")).then_some(snippet)
    };
    files.iter().filter_map(snippet).collect()
}

/// A shape to try, and the text it comes from.
pub struct Example {
    pub text: String,
    pub name: &'static str,
    pub shape: Shape,
    /// A sphere around it, or around the part of it worth a try.
    pub center: Vec3,
    pub size: f32,
}

#[derive(Deserialize)]
struct Object {
    shape: ShapeDesc,
}

/// Every example.
pub fn all() -> Vec<Example> {
    EXAMPLES
        .iter()
        .map(|text| format!("shape.{text}"))
        .chain(snippets())
        .map(example)
        .collect()
}

/// The examples that have an end.
pub fn bounded() -> impl Iterator<Item = Example> {
    all().into_iter().filter(|e| e.shape.bounds().is_finite())
}

fn example(text: String) -> Example {
    let object: Object = toml::from_str(&text).unwrap_or_else(|e| panic!("{text}: {e}"));
    let shape = object
        .shape
        .compile(DVec3::ZERO)
        .unwrap_or_else(|e| panic!("{text}: {e:?}"));
    let bounds = shape.bounds();
    let (center, size) = if bounds.is_finite() {
        (bounds.center(), bounds.extent().length() * 0.5)
    } else {
        (Vec3::ZERO, 1e4)
    };
    Example {
        name: object.shape.name(),
        text,
        shape,
        center,
        size,
    }
}

/// A shape from its description.
pub fn shape(text: &str) -> Shape {
    example(format!("shape.{text}")).shape
}

/// Small, common and large, at the origin and aside.
pub const PLACES: [(f32, Vec3); 5] = [
    (1.0, Vec3::ZERO),
    (1e-3, Vec3::ZERO),
    (1e4, Vec3::ZERO),
    (1.0, Vec3::new(20.0, -30.0, 10.0)),
    (1e4, Vec3::new(-2e4, 1e4, 3e4)),
];

/// The shape `text`, with $x, $y, $z, $1 and $2 replaced by the place and one and two sizes.
pub fn placed(text: &str, size: f32, at: Vec3) -> Shape {
    let text = [
        ("$x", at.x),
        ("$y", at.y),
        ("$z", at.z),
        ("$1", size),
        ("$2", 2.0 * size),
    ]
    .into_iter()
    .fold(text.to_owned(), |text, (word, number)| {
        text.replace(word, &number.to_string())
    });
    shape(&text)
}

impl Example {
    pub fn point_near(&self, random: &mut Random) -> Vec3 {
        let offset = Vec3::from_array(std::array::from_fn(|_| random.next() * 2.0 - 1.0));
        self.center + offset * self.size
    }

    /// A ray towards a point near the shape, from `distance` sizes away, its direction of any
    /// length.
    pub fn ray(&self, random: &mut Random, distance: f32) -> Ray {
        let target = self.point_near(random);
        let origin = target + random.direction() * (self.size * distance);
        Ray::new(origin, (target - origin) * (0.1 + random.next()))
    }
}

/// All hits along a ray, nearest first.
pub fn hits(shape: &Shape, ray: &Ray) -> Vec<(Ray, ShapeHit)> {
    let mut ray = *ray;
    let next = || {
        let hit = shape.intersect(&ray)?;
        let found = (ray, hit);
        ray.tmin = hit.t;
        Some(found)
    };
    std::iter::from_fn(next).take(8).collect()
}

/// Random numbers that are the same in every run.
pub struct Random(pub u32);

impl Random {
    pub fn next(&mut self) -> f32 {
        self.0 += 1;
        hash::unit_f32(hash::pcg4d([self.0, 1, 2, 3])[0])
    }

    pub fn square(&mut self) -> Vec2 {
        Vec2::new(self.next(), self.next())
    }

    /// A unit vector, uniform over the sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0;
            let l2 = v.length_squared();
            if l2 > 0.01 && l2 <= 1.0 {
                return v / l2.sqrt();
            }
        }
    }
}
