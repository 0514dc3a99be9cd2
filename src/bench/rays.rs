//! Generation of the rays: camera rays of a scene, and secondary rays from their hits.

use std::f32::consts::TAU;

use crate::{
    accel::{Accelerator, BatchLayout},
    camera::Camera,
    geometry::Hit,
    kind::named,
    math::{
        Frame, Ray, Vec2, Vec3,
        hash::{pcg4d, unit_f32},
        parallel, trig,
    },
    scene::{LightId, Scene, SurfaceInteraction},
};

named! {
    /// The kinds of rays.
    pub enum RayKind: "rays" {
        /// Camera rays, in tiles of 16 x 16 pixels.
        Primary = "primary",
        /// Rays from the camera rays' hits to the scene's first light, or to a point above the scene.
        Shadow = "shadow",
        /// Cosine-distributed rays from the camera rays' hits.
        Diffuse1 = "diffuse1",
        /// Cosine-distributed rays from the hits of the first bounce.
        Diffuse2 = "diffuse2",
    }
}

impl RayKind {
    /// Returns the layout of the rays. Those of tiles keep their order, but a few are missing.
    pub fn layout(self) -> BatchLayout {
        match self {
            Self::Primary | Self::Shadow => BatchLayout::Rows(TILE),
            Self::Diffuse1 | Self::Diffuse2 => BatchLayout::Unordered,
        }
    }

    /// Returns whether these are occlusion rays.
    pub fn is_occlusion(self) -> bool {
        self == Self::Shadow
    }
}

/// The width and height of the image whose camera rays are measured.
pub const SIDE: u32 = 1024;

/// The number of rays of each kind: 1,048,576.
pub const COUNT: usize = (SIDE * SIDE) as usize;

/// The number of rays that a thread takes at a time; the size of a wave.
pub const BATCH: usize = 16 * 1024;

/// The largest number of passes over the image that collect the rays, if many of them leave the
/// scene.
const PASSES: u32 = 16;

const TILE: u32 = 16;

/// The width of the square of pixels whose rays Embree's packets hold, as its own tutorials group them.
const SQUARE: u32 = 4;

/// The rays of all kinds. A kind is empty if the camera sees nothing.
pub struct Buffers {
    rays: [Vec<Ray>; 4],
    /// The pixel of each camera ray and of each shadow ray, tile by tile.
    pixels: [Vec<u32>; 2],
}

impl Buffers {
    pub fn of(&self, kind: RayKind) -> &[Ray] {
        &self.rays[kind as usize]
    }

    /// The order in which packets take the rays of a kind: those of the 4 x 4 pixels of a square together.
    pub fn packet_order(&self, kind: RayKind) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.of(kind).len() as u32).collect();
        let Some(pixels) = self.pixels.get(kind as usize) else {
            return order;
        };
        let pixel = |ray: &u32| pixels[*ray as usize];
        for tile in order.chunk_by_mut(|a, b| pixel(a) / (TILE * TILE) == pixel(b) / (TILE * TILE)) {
            tile.sort_by_key(|ray| square(pixel(ray)));
        }
        order
    }

    /// Generates all rays; `camera` has a film of [`SIDE`] x [`SIDE`] pixels.
    pub fn new(scene: &Scene, camera: &Camera) -> Self {
        let accel = &*scene.geometry.accel;
        let camera = &camera.moved(-scene.origin);
        let light = light(scene);
        let mut rays: [Vec<Ray>; 4] = Default::default();
        let mut pixels: [Vec<u32>; 2] = Default::default();
        for pass in 0..PASSES {
            let (primary, seen) = primary(camera, pass);
            let ends = ends(scene, accel, &primary);
            pixels[1].extend(ends.iter().map(|end| seen[end.0]));
            let ends: Vec<SurfaceInteraction> = ends.into_iter().map(|end| end.1).collect();
            rays[1].extend(ends.iter().map(|s| shadow_ray(s, light)));
            let first: Vec<Ray> = ends.iter().zip(0..).map(|(s, i)| bounce(s, [i, pass, 1])).collect();
            let second = self::ends(scene, accel, &first);
            rays[2].extend(first);
            rays[3].extend(second.iter().zip(0..).map(|((_, s), i)| bounce(s, [i, pass, 2])));
            if pass == 0 {
                (rays[0], pixels[0]) = (primary, seen);
            }
            if ends.is_empty() || rays.iter().all(|r| r.len() >= COUNT) {
                break;
            }
        }
        rays.iter_mut().for_each(repeat);
        pixels.iter_mut().for_each(repeat);
        Self { rays, pixels }
    }
}

/// Brings a kind to [`COUNT`] rays: few rays hit the scene, so those that do are repeated.
fn repeat<T: Copy>(kind: &mut Vec<T>) {
    let met = kind.len();
    if met > 0 {
        kind.reserve(COUNT.saturating_sub(met));
        for i in met..COUNT {
            kind.push(kind[i - met]);
        }
    }
    kind.truncate(COUNT);
}

/// The square of a pixel within its tile.
fn square(pixel: u32) -> u32 {
    let inside = pixel % (TILE * TILE);
    inside / TILE / SQUARE * (TILE / SQUARE) + inside % TILE / SQUARE
}

/// Generates one ray through each pixel, its centre in the first pass, another point in the others; and the pixel of each.
fn primary(camera: &Camera, pass: u32) -> (Vec<Ray>, Vec<u32>) {
    let tiles = SIDE / TILE;
    (0..SIDE * SIDE)
        .filter_map(|k| {
            let (tile, inside) = (k / (TILE * TILE), k % (TILE * TILE));
            let x = tile % tiles * TILE + inside % TILE;
            let y = tile / tiles * TILE + inside / TILE;
            let offset = if pass == 0 {
                Vec2::splat(0.5)
            } else {
                uniform([k, pass, 0])
            };
            let ray = camera.ray(Vec2::new(x as f32, y as f32) + offset, Vec2::splat(0.5))?;
            Some((ray, k))
        })
        .unzip()
}

fn uniform([a, b, c]: [u32; 3]) -> Vec2 {
    let [x, y, _, _] = pcg4d([a, b, c, 0x5eed]);
    Vec2::new(unit_f32(x), unit_f32(y))
}

/// Returns the surfaces that the rays hit, with the number of the ray.
fn ends(scene: &Scene, accel: &dyn Accelerator, rays: &[Ray]) -> Vec<(usize, SurfaceInteraction)> {
    let mut hits: Vec<Option<Hit>> = vec![None; rays.len()];
    let batches = rays.chunks(BATCH).zip(hits.chunks_mut(BATCH));
    let found = parallel::map(batches.enumerate(), |(batch, (rays, hits))| -> Vec<_> {
        accel.nearest(rays, hits);
        let found = rays.iter().zip(hits).zip(BATCH * batch..);
        let surfaces = found.filter_map(|((ray, hit), i)| Some((i, scene.surface(ray, hit.as_ref()?))));
        surfaces.collect()
    });
    found.into_iter().flatten().collect()
}

/// Samples a cosine-distributed direction, on the side that the ray came from.
fn bounce(surface: &SurfaceInteraction, address: [u32; 3]) -> Ray {
    let n = if surface.ng.dot(surface.wo) < 0.0 {
        -surface.ng
    } else {
        surface.ng
    };
    let u = uniform(address);
    let (r, angle) = (u.x.sqrt(), u.y * TAU);
    let local = Vec3::new(r * trig::cos(angle), r * trig::sin(angle), (1.0 - u.x).max(0.0).sqrt());
    surface.spawn_ray(false, Frame::from_normal(n).to_world(local).normalize())
}

fn shadow_ray(surface: &SurfaceInteraction, light: Vec3) -> Ray {
    let to = light - surface.p;
    let distance = to.length();
    let behind = (to.dot(surface.ng) < 0.0) != (surface.wo.dot(surface.ng) < 0.0);
    surface.shadow_ray(behind, to / distance, distance)
}

/// Returns the position of the scene's first light, or a point above the scene.
fn light(scene: &Scene) -> Vec3 {
    let bounds = scene.geometry.accel.geometry().world_bounds();
    let (center, size) = if bounds.is_empty() {
        (Vec3::ZERO, 1.0)
    } else {
        (bounds.center(), bounds.extent().length())
    };
    let sample = scene
        .lights
        .all()
        .first()
        .and_then(|l| l.sample(&scene.light_tables(LightId(0)), center, Vec2::splat(0.5)));
    match sample {
        Some(s) => center + s.wi * s.distance.min(2.0 * size),
        None => center + Vec3::new(0.3, 1.0, 0.5) * size,
    }
}
