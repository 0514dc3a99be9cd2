//! The rays of a row of pixels: from random numbers by way of the filter and the lens to rays.

use std::ops::Range;

use super::wave::Job;
use crate::{
    math::{Ray, Vec2},
    sampler::{Dimension, SampleKeys},
};

/// The samples of a row of pixels, a pixel's beside each other.
#[derive(Default)]
pub(super) struct CameraRays {
    /// What each sample weighs.
    pub weights: Vec<f32>,
    keys: SampleKeys,
    u: Vec<Vec2>,
    /// Of each sample: where on the film, and the numbers that choose a point of the lens.
    film: Vec<Vec2>,
    lens: Vec<Vec2>,
}

impl CameraRays {
    /// Appends the rays of `samples` of each pixel in `columns` of row `y` to `rays`, [`Ray::NOWHERE`] where no light reaches the
    /// film. Each step is taken for all of them before the next.
    pub fn look(&mut self, job: &Job<'_>, y: u32, columns: Range<u32>, samples: &Range<u32>, rays: &mut Vec<Ray>) {
        let settings = job.settings;
        let sampler = &settings.sampler;
        let measured = job.integrator.shown().is_measured();
        self.keys.start(settings.seed, settings.frame);
        self.film.clear();
        for x in columns {
            self.keys.push([x, y], samples.clone());
            self.film
                .resize(self.keys.len(), Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
        }
        self.weights.clear();
        self.weights.resize(self.keys.len(), 1.0);
        if let Some(filter) = &settings.filter {
            sampler.pairs(job.simd, &self.keys, Dimension::FILM, &mut self.u);
            filter.samples(job.simd, &self.u, &mut self.film, &mut self.weights);
        }
        self.lens.clear();
        if job.shot.has_lens() && !measured {
            sampler.pairs(job.simd, &self.keys, Dimension::LENS, &mut self.lens);
        } else {
            self.lens.resize(self.keys.len(), Vec2::splat(0.5));
        }
        if job.shot.moves() && !measured {
            sampler.pairs(job.simd, &self.keys, Dimension::TIME, &mut self.u);
            for ((time, film), lens) in self.u.iter().zip(&self.film).zip(&self.lens) {
                let ray = job.shot.camera(time.x).ray(*film, *lens);
                rays.push(ray.unwrap_or(Ray::NOWHERE));
            }
        } else {
            job.camera.rays(job.simd, &self.film, &self.lens, rays);
        }
    }
}
