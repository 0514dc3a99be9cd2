//! Warnings of pictures that show next to nothing.

use super::{
    Plan,
    plan::{cameras::metered_resolution, metering::surfaces},
};
use crate::{
    camera::FrameCamera,
    film::{Film, Window, passes::Display},
    math::{Rgb, Vec3, parallel},
    output::{Coverage, PixelDisplay},
    render::{Content, Control, Renderer, Settings},
    scene::Scene,
    value::one_line,
};

/// The brightness from which on a pixel is called clipped: more than white, which backgrounds are on purpose.
const CLIPPED: f32 = 1.05;

/// The number of points of a cubic grid along each axis. The background is sampled in the directions from its middle to all others.
const STEPS: u32 = 5;
/// The number of points of the grid, its middle among them.
const DIRECTIONS: u32 = STEPS.pow(3);

/// Why more than half of a picture is black, or of what is lit in it clipped, where it is, or why it shows nothing but the
/// background. A dark background alone is not a fault.
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
    let (mut lit, mut clipped) = (pixels.len() - black, parallel::count(pixels, is_clipped));
    // A background that is seen is not lit by what clips: surfaces count alone, where more than a few pixels clip.
    if shows_background(scene) && 100 * clipped > pixels.len() && 2 * clipped <= lit {
        let shown = of_surfaces(film, plan, scene, camera)?;
        lit = shown.iter().filter(|pixel| !is_black(pixel)).count();
        clipped = shown.iter().filter(|pixel| is_clipped(pixel)).count();
    }
    if 2 * clipped > lit {
        let exposure = match &plan.picture.metering_camera {
            None => "; `--exposure auto` shows it as bright as suits it",
            Some(_) => "",
        };
        let (percent, brightest) = (100 * clipped / lit, brightest(scene, plan.picture.own_lights));
        return Some(format!("{percent} % of what is lit is clipped: {brightest}{exposure}"));
    }
    if 2 * black <= pixels.len() {
        let is_empty = shows_background(scene) && sees_nothing(plan, scene, camera);
        return is_empty.then(|| "the camera sees nothing of the scene but its background".to_owned());
    }
    let is_all_black = black == pixels.len();
    let black = 100 * black / pixels.len();
    if is_all_black && is_dark(scene) {
        let why = "there is no light: no `[[light]]`, no material that emits, and a black background";
        return Some(format!("{black} % of the picture is black: {why}"));
    }
    let (mut seen, mut black_seen) = (0, 0);
    let hits = hits(&plan.settings_of_objects(None), plan, scene, camera)?;
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
fn hits(settings: &Settings, plan: &Plan, scene: &Scene, camera: &FrameCamera) -> Option<Film> {
    let integrator = plan.picture.integrator.as_dyn();
    let film = Renderer::new().render(scene, camera, integrator, settings, &Control::default());
    film.ok()
}

/// Whether the camera may see a background that is not black.
fn shows_background(scene: &Scene) -> bool {
    let background = &scene.shading.background;
    let is_black = background
        .backdrop
        .map_or(background.radiance.is_black(), Rgb::is_black);
    background.visible && !is_black
}

/// Whether a whole picture of a scene with objects shows none of them. A small picture tells it nearly always.
fn sees_nothing(plan: &Plan, scene: &Scene, camera: &FrameCamera) -> bool {
    let whole = plan.settings_of_objects(None);
    if whole.window != Window::full(whole.resolution) || scene.geometry.objects.is_empty() {
        return false;
    }
    let mut settings = [small(&whole), whole].into_iter();
    settings.all(|settings| {
        let film = hits(&settings, plan, scene, camera);
        film.is_some_and(|film| film.beauty().iter().all(|hit| hit[3] <= 0.0))
    })
}

/// The pixels of `film` that show surfaces, of a whole picture those on a grid.
fn of_surfaces(film: &Film, plan: &Plan, scene: &Scene, camera: &FrameCamera) -> Option<Vec<[f32; 4]>> {
    let hits = hits(&small(&plan.settings_of_objects(None)), plan, scene, camera)?;
    let [own, grid] = [film, &hits].map(|film| [film.window.width(), film.window.height()].map(|n| n as usize));
    let place = |at: usize, axis: usize| (2 * at + 1) * own[axis] / (2 * grid[axis]);
    let shown = surfaces(scene, &hits)
        .into_iter()
        .enumerate()
        .filter(|(_, shown)| *shown);
    let pixel = |(i, _)| film.beauty()[place(i / grid[0], 1) * own[0] + place(i % grid[0], 0)];
    Some(shown.map(pixel).collect())
}

/// These settings for a small picture; those of a part of a picture, or of a smaller one, as they are.
fn small(whole: &Settings) -> Settings {
    let resolution = metered_resolution(whole.resolution);
    if whole.window != Window::full(whole.resolution) || resolution[0] >= whole.resolution[0] {
        return whole.clone();
    }
    Settings {
        resolution,
        window: Window::full(resolution),
        ..whole.clone()
    }
}

fn is_dark(scene: &Scene) -> bool {
    let is_black = scene.shading.background.radiance.is_black();
    is_black && scene.lights.all().is_empty() && !scene.shading.materials.iter().any(|m| m.emission().is_some())
}

/// What is probably too bright: a light, a material that emits or the background. Lights of models are those between the numbers of
/// `own_lights`.
fn brightest(scene: &Scene, [first, last]: [usize; 2]) -> String {
    let all = scene.lights.all();
    let of_model = first..all.len().saturating_sub(last);
    let lights = all.iter().enumerate().map(|(at, light)| {
        let (strength, unit) = light.strength();
        let strength = strength.max_component();
        let advice = match of_model.contains(&at) && strength > 10.0 {
            true => ", and lights of models in candela or lux are to be divided by 683 (`light_units`, --light-units)",
            false => "",
        };
        (
            strength,
            format!("its brightest light has {} {unit}{advice}", shown(strength)),
        )
    });
    let textures = scene.textures();
    let names = &scene.shading.material_names;
    let emitters = scene
        .shading
        .materials
        .iter()
        .zip(names)
        .filter_map(|(material, name)| {
            let emission = material.emission()?;
            let radiance = textures.max_value(&emission.radiance) * emission.scale;
            let name = one_line(name, 40);
            Some((
                radiance,
                format!("the material `{name}` emits {} W m^-2 sr^-1", shown(radiance)),
            ))
        });
    let background = background_radiance(scene);
    let background = (
        background,
        format!("the background has {} W m^-2 sr^-1 on average", shown(background)),
    );
    let all = lights.chain(emitters).chain([background]);
    let brightest = all.max_by(|a, b| a.0.total_cmp(&b.0));
    brightest.map(|(_, text)| text).unwrap_or_default()
}

/// The mean radiance of the background, in W m^-2 sr^-1, of its brightest channel.
fn background_radiance(scene: &Scene) -> f32 {
    let middle = DIRECTIONS / 2;
    let place = |i: u32| [i, i / STEPS, i / STEPS.pow(2)].map(|i| (i % STEPS) as f32 - 2.0);
    let directions = (0..DIRECTIONS).filter(|i| *i != middle);
    let radiances = directions.map(|i| scene.background_radiance(Vec3::from_array(place(i)).normalize()));
    (radiances.fold(Rgb::BLACK, |a, b| a + b) / (DIRECTIONS - 1) as f32).max_component()
}

fn shown(strength: f32) -> String {
    match strength {
        1e6.. => format!("{strength:.2e}"),
        100.0.. => format!("{strength:.0}"),
        _ => format!("{strength:.3}"),
    }
}
