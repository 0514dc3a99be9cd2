//! The scenes of `benches/README.md` that are made by formulas, as OBJ files: `cargo run --release --example bench_scenes -- FOLDER`.
//!
//! The same files on every machine: numbers come from the library's hashes and its own sine.

use std::{
    error::Error,
    f32::consts::{PI, TAU},
    fs::{self, File},
    io::{BufWriter, Write},
    path::Path,
};

use batch_render::math::{
    Vec2, Vec3,
    hash::{pcg4d, unit_f32},
    trig,
};

/// A function that makes a scene.
type Recipe = fn() -> Triangles;

/// Each scene with its name.
const SCENES: &[(&str, Recipe)] = &[
    ("terrain", terrain),
    ("meadow", meadow),
    ("room", room),
    ("city", city),
    ("noodles", noodles),
];

/// Corners, and which three of them make a triangle.
#[derive(Default)]
struct Triangles {
    corners: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Triangles {
    fn add(&mut self, corners: &[Vec3], faces: &[&[u32]]) {
        let first = self.corners.len() as u32;
        self.corners.extend(corners);
        for face in faces {
            for pair in face[1..].windows(2) {
                self.triangles.push([face[0], pair[0], pair[1]].map(|k| first + k));
            }
        }
    }

    /// A box of which each half side is given, without what is below.
    fn cuboid(&mut self, center: Vec3, sides: [Vec3; 3]) {
        let corner = |k: usize| {
            let side = |axis: usize| if k >> axis & 1 == 1 { sides[axis] } else { -sides[axis] };
            center + side(0) + side(1) + side(2)
        };
        let corners: [Vec3; 8] = std::array::from_fn(corner);
        let faces: [&[u32]; 5] = [
            &[2, 6, 7, 3],
            &[0, 4, 6, 2],
            &[1, 3, 7, 5],
            &[0, 2, 3, 1],
            &[4, 5, 7, 6],
        ];
        self.add(&corners, &faces);
    }

    /// Points in `rows` of as many, of which neighbours are joined.
    fn grid(&mut self, rows: &[Vec<Vec3>]) {
        let (first, width) = (self.corners.len() as u32, rows[0].len() as u32);
        self.corners.extend(rows.iter().flatten());
        for row in 0..rows.len() as u32 - 1 {
            for column in 0..width - 1 {
                let a = first + row * width + column;
                self.triangles
                    .extend([[a, a + width, a + 1], [a + 1, a + width, a + width + 1]]);
            }
        }
    }

    fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        let mut file = BufWriter::new(File::create(path)?);
        for c in &self.corners {
            writeln!(file, "v {} {} {}", c.x, c.y, c.z)?;
        }
        for t in &self.triangles {
            writeln!(file, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1)?;
        }
        Ok(file.flush()?)
    }
}

/// Four numbers from 0 to 1 of thing `i`.
fn random(i: u32, seed: u32) -> [f32; 4] {
    pcg4d([i, seed, 7, 11]).map(unit_f32)
}

fn between(u: f32, [least, most]: [f32; 2]) -> f32 {
    least + (most - least) * u
}

fn around(angle: f32) -> Vec2 {
    Vec2::new(trig::cos(angle), trig::sin(angle))
}

/// Hills of 20 m in 980,000 triangles.
fn terrain() -> Triangles {
    const SIDE: u32 = 700;
    let waves = [[0.4, 0.9], [1.1, 0.35], [2.9, 0.12], [7.3, 0.04], [17.0, 0.015]];
    let height = |x: f32, z: f32| {
        let wave = |[f, a]: [f32; 2]| a * trig::sin(f * x + 0.7 * f) * trig::cos(f * z - 0.3 * f * x);
        waves.map(wave).iter().sum()
    };
    let place = |k: u32| 20.0 * (k as f32 / SIDE as f32 - 0.5);
    let point = |i: u32, j: u32| Vec3::new(place(i), height(place(i), place(j)), place(j));
    let rows: Vec<_> = (0..=SIDE).map(|j| (0..=SIDE).map(|i| point(i, j)).collect()).collect();
    let mut all = Triangles::default();
    all.grid(&rows);
    all
}

/// 200,000 bent blades of three triangles each, on a square of 20 m.
fn meadow() -> Triangles {
    let mut all = Triangles::default();
    for i in 0..200_000 {
        let ([x, z, turn, tall], [bend, wide, ..]) = (random(i, 1), random(i, 2));
        let foot = Vec3::new(20.0 * x - 10.0, 0.0, 20.0 * z - 10.0);
        let (along, height) = (around(6.3 * turn), between(tall, [0.3, 0.9]));
        let half = Vec3::new(along.y, 0.0, -along.x) * between(wide, [0.01, 0.025]);
        let lean = Vec3::new(along.x, 0.0, along.y) * height * between(bend, [0.1, 0.8]);
        let middle = foot + 0.3 * lean + Vec3::Y * 0.6 * height;
        let tip = foot + lean + Vec3::Y * height;
        let corners = [foot - half, foot + half, middle + 0.7 * half, middle - 0.7 * half, tip];
        all.add(&corners, &[&[0, 1, 2, 3], &[3, 2, 4]]);
    }
    all
}

/// 700 lumps in a room of ten triangles, open in front; its ceiling is in the way of what light comes from above.
fn room() -> Triangles {
    let mut all = Triangles::default();
    let (half, height) = (Vec2::new(6.0, 5.0), 3.0);
    let corner = |k: usize| {
        let side = |axis: usize| if k >> axis & 1 == 1 { 1.0 } else { -1.0 };
        Vec3::new(
            side(0) * half.x,
            if k >> 1 & 1 == 1 { height } else { 0.0 },
            side(2) * half.y,
        )
    };
    let walls: [&[u32]; 5] = [
        &[2, 3, 7, 6],
        &[0, 4, 5, 1],
        &[0, 2, 6, 4],
        &[1, 5, 7, 3],
        &[0, 1, 3, 2],
    ];
    all.add(&std::array::from_fn::<_, 8, _>(corner), &walls);
    for i in 0..700 {
        let ([x, y, z, size], [a, b, c, phase]) = (random(i, 3), random(i, 4));
        let size = between(size * size, [0.05, 0.4]);
        let place = |u: f32, half: f32| (2.0 * u - 1.0) * (half - 1.3 * size);
        let center = Vec3::new(
            place(x, half.x),
            1.3 * size + y * y * (height - 2.6 * size),
            place(z, half.y),
        );
        let [a, b, c] = [a, b, c].map(|u| between(u, [2.0, 6.0]).round());
        let point = |row: u32, column: u32| {
            let (polar, turn) = ((row as f32 + 0.5) / 26.0 * PI, column as f32 / 25.0 * TAU);
            let (down, flat) = (around(polar), around(turn));
            let lump = 1.0 + 0.25 * trig::sin(a * turn + 6.0 * phase) * trig::sin(b * polar) * trig::cos(c * polar);
            center + size * lump * Vec3::new(down.y * flat.x, down.x, down.y * flat.y)
        };
        let rows: Vec<_> = (0..=25).map(|r| (0..=25).map(|c| point(r, c)).collect()).collect();
        all.grid(&rows);
    }
    all
}

/// 48,400 boxes, half of them turned, on blocks of different heights.
fn city() -> Triangles {
    const SIDE: u32 = 220;
    let mut all = Triangles::default();
    for i in 0..SIDE * SIDE {
        let ([x, z, wide, deep], [tall, turn, turned, _]) = (random(i, 5), random(i, 6));
        let district = random(i % SIDE / 11 + SIDE * (i / SIDE / 11), 7)[0];
        let height = between(tall * tall, [0.2, 1.0]) * between(district * district, [0.6, 6.0]);
        let place = |k: u32, u: f32| k as f32 - 0.5 * SIDE as f32 + 0.3 * (u - 0.5);
        let center = Vec3::new(place(i % SIDE, x), 0.5 * height, place(i / SIDE, z));
        let angle = if turned < 0.5 { 6.3 * turn } else { 0.0 };
        let (along, half) = (around(angle), [wide, deep].map(|u| between(u, [0.2, 0.45])));
        let sides = [
            Vec3::new(along.x, 0.0, along.y) * half[0],
            Vec3::Y * 0.5 * height,
            Vec3::new(-along.y, 0.0, along.x) * half[1],
        ];
        all.cuboid(center, sides);
    }
    all
}

/// 700 tubes that bend through one another.
fn noodles() -> Triangles {
    let mut all = Triangles::default();
    for i in 0..700 {
        let ([x, y, z, size], [a, b, c, d]) = (random(i, 8), random(i, 9));
        let center = Vec3::new(x - 0.5, y - 0.5, z - 0.5) * 6.0;
        let reach = between(size, [0.8, 2.0]);
        let axis = |t: f32| {
            let wave = |f: f32, shift: f32| trig::sin((1.0 + 2.0 * f) * t + 6.0 * shift);
            center + reach * Vec3::new(wave(a, b), 0.7 * wave(b, c), wave(c, d))
        };
        let rows: Vec<Vec<Vec3>> = (0..=60)
            .map(|row| {
                let t = row as f32 / 60.0 * 4.0;
                let along = (axis(t + 0.01) - axis(t - 0.01)).normalize_or(Vec3::X);
                let turn = glam::Quat::from_rotation_arc(Vec3::Z, along);
                let ring = |k: u32| around(k as f32 / 8.0 * TAU) * 0.05;
                (0..=8).map(|k| axis(t) + turn * ring(k).extend(0.0)).collect()
            })
            .collect();
        all.grid(&rows);
    }
    all
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("name a folder to write to")?;
    fs::create_dir_all(&folder)?;
    for (name, scene) in SCENES {
        let (path, scene) = (Path::new(&folder).join(name).with_extension("obj"), scene());
        scene.write(&path)?;
        println!("{}: {} triangles", path.display(), scene.triangles.len());
    }
    Ok(())
}
