//! Lights with a surface, as rays find them.
//!
//! They are no objects: rays pass through them, and collect the light of all that they meet.

use super::LightId;
use crate::{
    light::{Light, LightTables, Sight},
    math::{
        Aabb, Ray, Rgb,
        block::{Each, LANES},
    },
    shape::{Shape, ShapeHit},
};

/// The surfaces of lights.
#[derive(Clone, Debug, Default)]
pub struct Lamps {
    all: Vec<Lamp>,
    boxes: Vec<Boxes>,
}

#[derive(Clone, Copy, Debug)]
struct Lamp {
    light: LightId,
    shape: Shape,
    sight: Sight,
}

/// The bounds of a block of lamps; those of other lanes are empty.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Boxes {
    min: [Each; 3],
    max: [Each; 3],
}

/// The light of a lamp along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampHit {
    pub light: LightId,
    /// In lengths of the ray's direction.
    pub t: f32,
    /// In W m^-2 sr^-1.
    pub radiance: Rgb,
    /// The density with which the light samples the ray's direction from its origin, in sr^-1.
    pub pdf: f32,
}

impl Boxes {
    const EMPTY: Self = Self {
        min: [[f32::INFINITY; LANES]; 3],
        max: [[f32::NEG_INFINITY; LANES]; 3],
    };

    fn set(&mut self, lane: usize, bounds: &Aabb) {
        for axis in 0..3 {
            self.min[axis][lane] = bounds.min[axis];
            self.max[axis][lane] = bounds.max[axis];
        }
    }

    /// The lanes whose box the ray may meet. Bounds are padded by more than the rounding here.
    #[inline]
    fn met(&self, ray: &Ray) -> u32 {
        let inverse = ray.d.recip();
        let (mut enter, mut leave) = ([ray.tmin; LANES], [ray.tmax; LANES]);
        for axis in 0..3 {
            let (o, r) = (ray.o[axis], inverse[axis]);
            for lane in 0..LANES {
                let (a, b) = ((self.min[axis][lane] - o) * r, (self.max[axis][lane] - o) * r);
                // A ray within a face has 0 times infinity there, which `min` and `max` ignore.
                enter[lane] = enter[lane].max(a.min(b));
                leave[lane] = leave[lane].min(a.max(b));
            }
        }
        (0..LANES).fold(0, |met, lane| met | u32::from(enter[lane] <= leave[lane]) << lane)
    }
}

impl Lamps {
    /// Those of `lights`.
    pub fn of(lights: &[Light]) -> Self {
        let mut lamps = Self::default();
        for (light, id) in lights.iter().zip((0..).map(LightId)) {
            let Some((shape, sight)) = light.surface().filter(|(_, s)| s.camera || s.reflections) else {
                continue;
            };
            let lane = lamps.all.len() % LANES;
            if lane == 0 {
                lamps.boxes.push(Boxes::EMPTY);
            }
            if let Some(boxes) = lamps.boxes.last_mut() {
                boxes.set(lane, &shape.bounds());
            }
            lamps.all.push(Lamp {
                light: id,
                shape,
                sight,
            });
        }
        lamps
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The lamps among `lights` that `ray`, whose direction is unit, meets, in the order of the lights.
    pub fn along<'a>(
        &self,
        lights: &[Light],
        tables: impl Fn(LightId) -> LightTables<'a>,
        ray: Ray,
        is_from_camera: bool,
    ) -> impl Iterator<Item = LampHit> {
        let blocks = self.boxes.iter().zip(self.all.chunks(LANES));
        let met = blocks.flat_map(move |(boxes, lamps)| {
            let met = boxes.met(&ray);
            lamps.iter().enumerate().filter(move |(lane, _)| met >> lane & 1 == 1)
        });
        met.filter_map(move |(_, lamp)| {
            let Sight { camera, reflections } = lamp.sight;
            let is_seen = if is_from_camera { camera } else { reflections };
            let hit: ShapeHit = is_seen.then(|| lamp.shape.intersect(&ray)).flatten()?;
            let (radiance, pdf) = lights[lamp.light.0 as usize].seen(&tables(lamp.light), ray.o, ray.d, &hit);
            (!radiance.is_black()).then_some(LampHit {
                light: lamp.light,
                t: hit.t,
                radiance,
                pdf,
            })
        })
    }
}
