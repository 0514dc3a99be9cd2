//! Camera rays that meet holdouts and shadow catchers, and the samples that they become.

use super::Wave;
use crate::{
    film::SampleRecord,
    geometry::Hit,
    integrator::PathState,
    math::Rgb,
    render::context::RenderContext,
    scene::{ObjectRole, Scene},
};

impl Wave {
    /// Ends the camera rays that meet a holdout: their samples are black and transparent.
    pub(super) fn remove_holdouts(&mut self, scene: &Scene) {
        let mut kept = 0;
        for k in 0..self.hit_indices.len() {
            let i = self.hit_indices[k];
            let is_holdout = self.hits[i as usize].is_some_and(|hit| scene.role_at(&hit) == ObjectRole::Holdout);
            if is_holdout {
                self.alpha[self.paths[i as usize].sample as usize] = 0.0;
            }
            (self.hit_indices[kept], self.prims[kept]) = (i, self.prims[k]);
            kept += usize::from(!is_holdout);
        }
        self.hit_indices.truncate(kept);
        self.prims.truncate(kept);
    }

    /// Splits the paths that meet a shadow catcher: a second path of the same random numbers meets catchers alone, and a
    /// third one the background behind them, if the camera sees it. Their radiances are those of samples beyond those of the
    /// wave, by once and twice their number.
    pub(super) fn split_catchers(&mut self, context: &RenderContext<'_>) {
        let scene = context.scene;
        let samples = self.weights.len() as u32;
        // Of camera rays there may be more paths.
        self.paths.truncate(self.rays.len());
        for k in 0..self.hit_indices.len() {
            let i = self.hit_indices[k] as usize;
            let Some(hit) = self.hits[i].filter(|hit| scene.role_at(hit) == ObjectRole::ShadowCatcher) else {
                continue;
            };
            let sample = self.paths[i].sample;
            self.is_caught[sample as usize] = true;
            self.hit_indices.push(self.rays.len() as u32);
            self.prims.push(hit.prim);
            self.add_world(i, Some(hit), sample + samples);
            // It spawns no rays, so the paths that go on stay in the order of their samples.
            if context.shows_plate() {
                self.miss_indices.push(self.rays.len() as u32);
                self.add_world(i, None, sample + 2 * samples);
            }
        }
    }

    /// Adds the ray and the path with this index again, with this hit, for another sample.
    fn add_world(&mut self, index: usize, hit: Option<Hit>, sample: u32) {
        self.rays.push(self.rays[index]);
        self.hits.push(hit);
        self.paths.push(PathState {
            sample,
            ..self.paths[index]
        });
    }

    /// The finished sample with this index in the wave, whose number in its pixel is `index`.
    #[inline(always)]
    pub(super) fn record(&self, context: &RenderContext<'_>, sample: usize, index: u32) -> SampleRecord<'_> {
        let layers = self.out.layers.as_ref().filter(|_| context.needs.light_layers);
        let without = self.without(sample);
        SampleRecord {
            l: self.out.radiance[sample],
            without,
            behind: without.and_then(|_| self.behind(context, sample)),
            alpha: self.alpha[sample],
            weight: self.weights[sample],
            index,
            distance_squared: self.distances_squared.get(sample).copied().unwrap_or(0.0),
            first: self.first_hits.get(sample).and_then(Option::as_ref),
            light: layers.map_or(&[], |layers| layers.of_sample(sample)),
        }
    }

    /// The radiance of a sample without other objects than catchers, if it meets a catcher.
    fn without(&self, sample: usize) -> Option<Rgb> {
        let is_caught = self.is_caught.get(sample).copied().unwrap_or(false);
        is_caught.then(|| self.out.radiance[self.weights.len() + sample])
    }

    /// The radiance of the background behind the catcher that this sample meets, if the camera sees one that is not black.
    fn behind(&self, context: &RenderContext<'_>, sample: usize) -> Option<Rgb> {
        context
            .shows_plate()
            .then(|| self.out.radiance[2 * self.weights.len() + sample])
    }
}
