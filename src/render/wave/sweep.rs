//! The samples of a moment of a moving scene, from several tiles.

use super::Wave;
use crate::{
    render::{
        Cancelled, Control, context::RenderContext, moments::Sweep, sample_block::SampleBlock, wave_stats::WaveStats,
    },
    sampler::SampleKeys,
};

/// The number of samples by which the sums of their pixels are prefetched.
const AHEAD: usize = 8;

impl Wave {
    /// Renders those samples of a sweep that belong to its moment, that of the context, and adds them to the accumulators of their
    /// tiles. Returns their number as well.
    ///
    /// # Errors
    /// [`Cancelled`] if `control` was cancelled; drop the wave then.
    pub fn run_moment(
        &mut self,
        context: &RenderContext<'_>,
        sweep: &mut Sweep<'_>,
        control: &Control<'_>,
    ) -> Result<(WaveStats, u64), Cancelled> {
        let mut stats = WaveStats::default();
        self.out.clock.start(control.stages.is_some());
        let mut listed = std::mem::take(&mut self.listed);
        listed.start(context.settings.seed, context.settings.noise_frame);
        let mut ends = Vec::with_capacity(sweep.tiles.len());
        for (tile, _) in &sweep.tiles {
            sweep.moment.list(*tile, sweep.samples, &mut listed);
            ends.push(listed.len());
        }
        let count = listed.len() as u64;
        self.start_listed(context, &listed);
        self.trace(context, &SampleBlock::Listed(&listed), control, &mut stats)?;
        let (passes, mut first) = (context.passes(), 0);
        for ((tile, accumulator), end) in sweep.tiles.iter_mut().zip(ends) {
            let index = |i: usize| tile.index(listed.columns[i] as i32, listed.rows[i] as i32);
            for i in first..end {
                if i + AHEAD < end {
                    accumulator.prefetch(index(i + AHEAD));
                }
                let record = std::iter::once(self.record(context, i, listed.samples[i]));
                let pixel = [listed.columns[i] as i32, listed.rows[i] as i32];
                let own = context.opening_for(|| pixel);
                let passes = passes.with_camera(own.as_ref());
                let count = accumulator.add(context.accumulators, &passes, index(i), record);
                if count > 0 {
                    stats.invalid.count_pixel(pixel, count);
                }
            }
            first = end;
        }
        self.listed = listed;
        self.end(control, &stats);
        Ok((stats, count))
    }

    /// Generates the camera rays of listed samples.
    fn start_listed(&mut self, context: &RenderContext<'_>, listed: &SampleKeys) {
        self.clear();
        self.camera_rays.generate_listed(context, listed, &mut self.rays);
        self.start_samples(context, 0);
        self.start_paths(context);
    }
}
