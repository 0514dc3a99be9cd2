//! The exposure that suits a scene: that of its first frame, seen small.
//!
//! Each process of a job finds the same exposure, whichever frames, tiles and samples it renders: the picture that is metered
//! depends on the scene, the integrator and the first camera alone.
//!
//! Source: the log-average of Reinhard, Stark, Shirley, Ferwerda, "Photographic Tone Reproduction for Digital Images", SIGGRAPH
//! 2002, doi:10.1145/566570.566575, equation 1.

use super::cameras::metered_resolution;
use crate::{
    batch::{
        Plan, PlannedFrame,
        products::coco::categories::{CategoryKind, MATERIALS},
    },
    camera::FrameCamera,
    film::{Film, PassRequest},
    math::{Rgb, exponential},
    render::{Cancel, Content, Control, FrameScenes, RenderError, Renderer, SampleBudget, Settings},
    scene::{ObjectRole, Scene},
};

const SAMPLES: u32 = 16;

/// The pass that tells which objects are seen.
pub(in crate::batch) const OBJECTS: &str = "objectId";

/// The brightness that the log-average is shown with.
const MIDDLE_GRAY: f32 = 0.18;
/// The brightness that at most a tenth of the pixels may exceed: deep shadows must not burn out what is lit.
const BRIGHT: f32 = 0.8;
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
        let settings = Settings {
            passes: vec![objects_pass()],
            ..Settings::new(metered_resolution(self.picture.settings.resolution), SAMPLES)
        };
        let control = Control {
            cancel,
            ..Control::default()
        };
        let film = Renderer::new().render(scene, camera, self.picture.integrator.as_dyn(), &settings, &control)?;
        // Surfaces count, if there are any: what is behind them may be of any brightness.
        let is_surface = surfaces(scene, &film);
        let has_surfaces = is_surface.contains(&true);
        let counts = |at: usize| !has_surfaces || is_surface[at];
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

    /// The settings of a picture of the objects in the middle of each pixel, with one sample.
    pub(in crate::batch) fn settings_of_objects(&self, frame: Option<i32>) -> Settings {
        Settings {
            noise_frame: frame.map_or(0, |frame| self.picture.seed_mode.frame(frame)),
            content: Content::FirstHits,
            samples: SampleBudget::fixed(1),
            // A range of samples shows what all of them show.
            ranges: None,
            filter: None,
            passes: vec![objects_pass()],
            ..self.picture.settings.clone()
        }
    }

    /// Renders such a picture of a frame, where the files beside the pictures need it.
    ///
    /// # Errors
    /// The frame was cancelled.
    pub(in crate::batch) fn render_objects<S: FrameScenes>(
        &self,
        scenes: &mut S,
        (frame, camera): (&PlannedFrame, &FrameCamera),
        cancel: Option<&Cancel>,
    ) -> Result<Film, S::Error> {
        let control = Control {
            cancel,
            ..Control::default()
        };
        let integrator = self.picture.integrator.as_dyn();
        let mut settings = self.settings_of_objects(Some(frame.number));
        if self.files.categories == CategoryKind::Material {
            settings.passes.push(pass(MATERIALS));
        }
        Renderer::new().render_moving(scenes, camera, integrator, &settings, &control)
    }
}

/// The pass that [`surfaces`] reads.
pub(in crate::batch) fn objects_pass() -> PassRequest {
    pass(OBJECTS)
}

fn pass(name: &str) -> PassRequest {
    PassRequest::parse(name).expect("the table has the row")
}

/// Whether each pixel shows an object that is neither a shadow catcher nor a holdout, at the sample nearest to its middle.
///
/// # Panics
/// The film has no [`objects_pass`].
pub(in crate::batch) fn surfaces(scene: &Scene, film: &Film) -> Vec<bool> {
    let shows = |number: &f32| {
        let part = number.to_bits().checked_sub(1);
        let object = part.map(|part| scene.mattes().parts()[part as usize].object);
        object.is_some_and(|object| scene.geometry.objects[object.0 as usize].role == ObjectRole::Ordinary)
    };
    let numbers = film.plane(OBJECTS).expect("the pass was requested");
    numbers.values.iter().map(shows).collect()
}

/// The stops that show the log-average of what is lit as middle gray, or fewer, so that a tenth of it at most exceeds
/// [`BRIGHT`]; 0 where nothing is lit.
fn stops(luminances: impl Iterator<Item = f32>) -> f32 {
    let mut lit: Vec<f32> = luminances.filter(|l| *l > 0.0 && l.is_finite()).collect();
    if lit.is_empty() {
        return 0.0;
    }
    let sum: f64 = lit.iter().map(|l| f64::from(exponential::log2(*l))).sum();
    let mean = (sum / lit.len() as f64) as f32;
    let at = (lit.len() - 1) * 9 / 10;
    let (_, bright, _) = lit.select_nth_unstable_by(at, f32::total_cmp);
    let by_mean = exponential::log2(MIDDLE_GRAY) - mean;
    let by_bright = exponential::log2(BRIGHT) - exponential::log2(*bright);
    by_mean.min(by_bright).clamp(-MAX_STOPS, MAX_STOPS)
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

    #[test]
    fn what_is_lit_does_not_burn_out_before_deep_shadows() {
        let dark_half = (0..100).map(|i| if i < 50 { 1e-5 } else { 0.4 });
        assert!((stops(dark_half) - 1.0).abs() < 1e-5);
        // A lamp may be brighter than white.
        let with_lamp = (0..100).map(|i| if i < 95 { 0.18 } else { 100.0 });
        let lamp = 0.05 * exponential::log2(100.0 / 0.18);
        assert!((stops(with_lamp) + lamp).abs() < 1e-4);
    }
}
