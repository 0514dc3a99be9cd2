//! The rays of a row of pixels: from random numbers by way of the filter and the lens to rays.

use std::ops::Range;

use super::wave::Job;
use crate::{
    filter::FilterSample,
    math::{Ray, Vec2},
    sampler::{Dimension, SampleKeys},
};

/// The samples of a row of pixels, a pixel's beside each other.
#[derive(Default)]
pub(super) struct CameraRays {
    /// `None` where no light reaches the film.
    pub rays: Vec<Option<Ray>>,
    /// What each sample weighs.
    pub weights: Vec<f32>,
    keys: SampleKeys,
    u: Vec<Vec2>,
    /// Of each sample: where on the film, and the numbers that choose a point of the lens.
    film: Vec<Vec2>,
    lens: Vec<Vec2>,
}

impl CameraRays {
    /// Finds the rays of `samples` of each pixel in `columns` of row `y`. Each step is taken for all of them before the next.
    pub fn look(&mut self, job: &Job<'_>, y: u32, columns: Range<u32>, samples: &Range<u32>) {
        let settings = job.settings;
        let sampler = &settings.sampler;
        let measured = job.integrator.shown().is_measured();
        self.keys.start(settings.seed, settings.frame);
        for x in columns {
            for sample in samples.clone() {
                self.keys.push([x, y], sample);
            }
        }
        self.film.clear();
        self.weights.clear();
        let centers = self
            .keys
            .columns
            .iter()
            .map(|&x| Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
        match &settings.filter {
            None => {
                self.film.extend(centers);
                self.weights.resize(self.keys.len(), 1.0);
            }
            Some(filter) => {
                sampler.pairs(job.simd, &self.keys, Dimension::FILM, &mut self.u);
                for (center, u) in centers.zip(&self.u) {
                    let FilterSample { offset, weight } = filter.sample(*u);
                    self.film.push(center + offset);
                    self.weights.push(weight);
                }
            }
        }
        self.lens.clear();
        if job.shot.has_lens() && !measured {
            sampler.pairs(job.simd, &self.keys, Dimension::LENS, &mut self.lens);
        } else {
            self.lens.resize(self.keys.len(), Vec2::splat(0.5));
        }
        self.rays.clear();
        if job.shot.moves() && !measured {
            sampler.pairs(job.simd, &self.keys, Dimension::TIME, &mut self.u);
            for ((time, film), lens) in self.u.iter().zip(&self.film).zip(&self.lens) {
                self.rays.push(job.shot.camera(time.x).ray(*film, *lens));
            }
        } else {
            job.camera.rays(&self.film, &self.lens, &mut self.rays);
        }
    }
}
