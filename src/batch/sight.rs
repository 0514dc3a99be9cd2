//! Warnings of pictures that show next to nothing.

use super::{Plan, plan::metering::surfaces};
use crate::{
    camera::FrameCamera,
    film::{Film, passes::Display},
    light::Light,
    math::{Rgb, parallel},
    output::{Coverage, PixelDisplay},
    render::{Content, Control, Renderer},
    scene::Scene,
};

/// The brightness from which on a pixel is called clipped: more than white, which backgrounds are on purpose.
const CLIPPED: f32 = 1.05;

/// Why more than half of a picture is black, or of what is lit in it clipped, where it is. A dark background alone is not a fault.
pub(super) fn fault(
    (film, coverage): (&Film, Coverage),
    plan: &Plan,
    scene: &Scene,
    camera: &FrameCamera,
) -> Option<String> {
    if plan.picture.settings.content != Content::Light || plan.picture.integrator.as_dyn().wants_cost() {
        return None;
    }
    let display = PixelDisplay::new(
        Display::Light,
        plan.picture.view,
        plan.picture.exposure,
        plan.picture.working_space,
    );
    let shown = |pixel: &[f32; 4]| display.rgb8(coverage.shown(*pixel));
    let is_black = |pixel: &[f32; 4]| shown(pixel) == [0; 3];
    let is_clipped = |pixel: &[f32; 4]| {
        let [r, g, b] = coverage.shown(*pixel);
        display.gain() * r.max(g).max(b) > CLIPPED && shown(pixel).contains(&255)
    };
    let pixels = film.beauty();
    let black = parallel::count(pixels, is_black);
    let lit = pixels.len() - black;
    let clipped = parallel::count(pixels, is_clipped);
    if 2 * clipped > lit {
        let exposure = match &plan.picture.metering_camera {
            None => "; `--exposure auto` shows it as bright as suits it",
            Some(_) => "",
        };
        let (percent, brightest) = (100 * clipped / lit, brightest(scene));
        return Some(format!("{percent} % of what is lit is clipped: {brightest}{exposure}"));
    }
    if 2 * black <= pixels.len() {
        return None;
    }
    let is_all_black = black == pixels.len();
    let black = 100 * black / pixels.len();
    if is_all_black && is_dark(scene) {
        let why = "there is no light: no `[[light]]`, no material that emits, and a black background";
        return Some(format!("{black} % of the picture is black: {why}"));
    }
    let (mut seen, mut black_seen) = (0, 0);
    let hits = first_hits(plan, scene, camera)?;
    let hits_nothing = hits.beauty().iter().all(|hit| hit[3] <= 0.0);
    // A catcher without shadow is black and transparent, and no fault.
    for (pixel, _) in pixels.iter().zip(surfaces(scene, &hits)).filter(|(_, shown)| *shown) {
        seen += 1;
        black_seen += usize::from(is_black(pixel));
    }
    let why = if hits_nothing {
        "the camera sees nothing of the scene"
    } else if 2 * black_seen > seen {
        "no light reaches what the camera sees, or it is black itself"
    } else {
        return None;
    };
    Some(format!("{black} % of the picture is black: {why}"))
}

/// A picture whose alpha tells where the camera sees something, and the objects there.
fn first_hits(plan: &Plan, scene: &Scene, camera: &FrameCamera) -> Option<Film> {
    let settings = plan.settings_of_objects(None);
    let integrator = plan.picture.integrator.as_dyn();
    let film = Renderer::new().render(scene, camera, integrator, &settings, &Control::default());
    film.ok()
}

fn is_dark(scene: &Scene) -> bool {
    let is_black = scene.shading.background.radiance.is_black();
    is_black && scene.lights.all().is_empty() && !scene.shading.materials.iter().any(|m| m.emission().is_some())
}

/// The light that is probably too bright.
fn brightest(scene: &Scene) -> String {
    let strengths = scene.lights.all().iter().map(Light::strength);
    let brightest = strengths.max_by(|a, b| a.0.max_component().total_cmp(&b.0.max_component()));
    match brightest {
        Some((strength, unit)) if strength.max_component() > 10.0 => format!(
            "its brightest light has {} {unit}, and lights in candela or lux are to be divided by 683 (`light_units`, \
             --light-units)",
            shown(strength)
        ),
        Some((strength, unit)) => format!("its brightest light has {} {unit}", shown(strength)),
        None => "what emits is brighter than white".to_owned(),
    }
}

fn shown(strength: Rgb) -> String {
    let v = strength.max_component();
    if v >= 100.0 {
        format!("{v:.0}")
    } else {
        format!("{v:.3}")
    }
}
