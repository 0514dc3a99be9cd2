//! The exposure that suits a scene: that of its first frame, seen small.
//!
//! Each process of a job finds the same exposure, whichever frames, tiles and samples it renders: the picture that is metered
//! depends on the scene, the integrator and the first camera alone.
//!
//! Source: the log-average of Reinhard, Stark, Shirley, Ferwerda, "Photographic Tone Reproduction for Digital Images", SIGGRAPH
//! 2002, doi:10.1145/566570.566575, equation 1.

use super::cameras::metered_resolution;
use crate::{
    batch::Plan,
    camera::FrameCamera,
    math::{Rgb, exponential},
    render::{Cancel, Content, Control, RenderError, Renderer, SampleBudget, Settings},
    scene::Scene,
};

const SAMPLES: u32 = 16;

/// The brightness that the log-average is shown with.
const MIDDLE_GRAY: f32 = 0.18;
/// The most stops either way.
const MAX_STOPS: f32 = 64.0;

impl Plan {
    /// The plan with the exposure that suits the scene, where that is wanted.
    ///
    /// # Errors
    /// The job was cancelled.
    pub fn metered(&self, scene: &Scene, cancel: Option<&Cancel>) -> Result<Self, RenderError> {
        let mut plan = self.clone();
        let Some(camera) = &self.picture.metering_camera else {
            return Ok(plan);
        };
        if self.picture.settings.content != Content::Light || self.picture.integrator.as_dyn().wants_cost() {
            return Ok(plan);
        }
        let settings = Settings::new(metered_resolution(self.picture.settings.resolution), SAMPLES);
        let control = Control {
            cancel,
            ..Control::default()
        };
        let film = Renderer::new().render(scene, camera, self.picture.integrator.as_dyn(), &settings, &control)?;
        let is_seen = match scene.shading.background.backdrop {
            Some(_) => self.surfaces(scene, camera, &settings, &control)?,
            None => Vec::new(),
        };
        // A backdrop is no light: the surfaces before it count, if there are any.
        let counts = |at: usize| !is_seen.contains(&true) || is_seen[at];
        let colors = film.beauty().iter().enumerate().filter(|(at, _)| counts(*at));
        let colors = colors.map(|(_, &[r, g, b, _])| Rgb::new(r, g, b));
        let luminances = colors.map(|color| self.picture.working_space.to_rec709(color).luminance());
        plan.picture.exposure = stops(luminances);
        tracing::info!("the exposure is {:.2} stops, by the first frame", plan.picture.exposure);
        if let Some(adaptive) = &mut plan.picture.settings.samples.adaptive {
            adaptive.gain = exponential::pow(2.0, plan.picture.exposure);
        }
        Ok(plan)
    }

    /// Whether the middle of each pixel shows a surface, in a picture with these settings.
    fn surfaces(
        &self,
        scene: &Scene,
        camera: &FrameCamera,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Vec<bool>, RenderError> {
        let settings = Settings {
            content: Content::FirstHits,
            samples: SampleBudget::fixed(1),
            filter: None,
            ..settings.clone()
        };
        let film = Renderer::new().render(scene, camera, self.picture.integrator.as_dyn(), &settings, control)?;
        Ok(film.beauty().iter().map(|pixel| pixel[3] > 0.0).collect())
    }
}

/// The stops that show the log-average of what is lit as middle gray; 0 where nothing is.
fn stops(luminances: impl Iterator<Item = f32>) -> f32 {
    let lit = luminances.filter(|l| *l > 0.0 && l.is_finite());
    let (sum, count) = lit.fold((0.0, 0), |(sum, count), l| {
        (sum + f64::from(exponential::log2(l)), count + 1)
    });
    if count == 0 {
        return 0.0;
    }
    let mean = (sum / f64::from(count)) as f32;
    (exponential::log2(MIDDLE_GRAY) - mean).clamp(-MAX_STOPS, MAX_STOPS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_log_average_of_what_is_lit_becomes_middle_gray() {
        assert!((stops([0.18; 4].into_iter())).abs() < 1e-5);
        assert!((stops([0.09, 0.36, 0.0, f32::NAN].into_iter())).abs() < 1e-5);
        assert!((stops([0.18 * 1024.0].into_iter()) + 10.0).abs() < 1e-4);
        assert_eq!(stops([0.0].into_iter()), 0.0);
    }
}
