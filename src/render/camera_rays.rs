//! Camera rays of a row of pixels, or of listed samples, from random numbers, the pixel filter and the lens.

use super::{Content, context::RenderContext, schedule::BlockSpec};
use crate::{
    math::{Ray, Vec2},
    sampler::{Dimension, Filled, SampleKeys, UnitBits},
};

/// The camera rays of a row of pixels, whose samples are adjacent, or of listed samples.
#[derive(Default)]
pub(super) struct CameraRays {
    /// The filter weight of each sample.
    pub weights: Vec<f32>,
    /// The film position of each sample, in pixels.
    pub film: Vec<Vec2>,
    keys: SampleKeys,
    u: Vec<Vec2>,
    /// The time of each sample, as a fraction of the shutter; of a moving camera.
    times: Vec<UnitBits>,
    /// The random numbers for the lens, of each sample.
    lens: Vec<Vec2>,
}

impl CameraRays {
    /// Appends the rays of the block's samples in row `y` to `rays`, [`Ray::NONE`] if no light reaches the film. Each step is
    /// done for all samples before the next.
    pub fn generate(&mut self, context: &RenderContext<'_>, block: &BlockSpec, y: i32, rays: &mut Vec<Ray>) {
        self.keys.start(context.settings.seed, context.settings.noise_frame);
        self.film.clear();
        for x in block.tile.x0..block.tile.x1 {
            self.keys.push([x as u32, y as u32], block.samples.clone());
            self.film.resize(self.keys.len(), pixel_center(x, y));
        }
        self.append(context, rays);
    }

    /// Appends the rays of these samples to `rays`, as [`CameraRays::generate`] does.
    pub fn generate_listed(&mut self, context: &RenderContext<'_>, keys: &SampleKeys, rays: &mut Vec<Ray>) {
        self.keys.clone_from(keys);
        self.film.clear();
        let places = keys.columns.iter().zip(&keys.rows);
        self.film
            .extend(places.map(|(x, y)| pixel_center(*x as i32, *y as i32)));
        self.append(context, rays);
    }

    /// Appends the rays of `keys`, whose film positions are the centres of their pixels.
    fn append(&mut self, context: &RenderContext<'_>, rays: &mut Vec<Ray>) {
        let settings = context.settings;
        let sampler = &settings.sampler;
        let spread = settings.content == Content::Light;
        self.weights.clear();
        self.weights.resize(self.keys.len(), 1.0);
        let moves = context.camera_moves && (spread || !context.frame_camera.readout().is_global());
        let filter = settings.filter.as_ref().filter(|_| spread);
        if moves && !spread {
            self.times.clear();
            self.times.resize(self.keys.len(), UnitBits::default());
        }
        if spread && (filter.is_some() || moves) {
            let numbers = Filled {
                pairs: &mut self.u,
                thirds: moves.then_some(&mut self.times),
            };
            sampler.fill(context.simd, &self.keys, Dimension::FILM, numbers);
        }
        if let Some(filter) = filter {
            filter.samples(context.simd, &self.u, &mut self.film, &mut self.weights);
        }
        self.lens.clear();
        if context.frame_camera.has_lens() && spread {
            let numbers = Filled {
                pairs: &mut self.lens,
                thirds: None,
            };
            sampler.fill(context.simd, &self.keys, Dimension::LENS, numbers);
        } else {
            self.lens.resize(self.keys.len(), Vec2::splat(0.5));
        }
        let camera = context.frame_camera;
        if moves {
            let pixels = self.keys.columns.iter().zip(&self.keys.rows);
            for (((time, film), lens), (x, y)) in self.times.iter().zip(&self.film).zip(&self.lens).zip(pixels) {
                let time = camera.time_of_pixel(time.f64(), [*x as i32, *y as i32], settings.resolution);
                let ray = camera.cameras().at(time).ray(*film, *lens);
                rays.push(ray.unwrap_or(Ray::NONE));
            }
        } else {
            context.camera.rays(context.simd, &self.film, &self.lens, rays);
        }
    }

    /// Appends the squared distances of the generated samples from their pixels' centres.
    pub fn distances_squared(&self, out: &mut Vec<f32>) {
        let centers = self.keys.columns.iter().zip(&self.keys.rows);
        let centers = centers.map(|(x, y)| pixel_center(*x as i32, *y as i32));
        out.extend(
            self.film
                .iter()
                .zip(centers)
                .map(|(at, center)| at.distance_squared(center)),
        );
    }
}

fn pixel_center(x: i32, y: i32) -> Vec2 {
    Vec2::new(x as f32 + 0.5, y as f32 + 0.5)
}
