//! Scenes that move while the shutter is open, compared with what algebra says of them, and with still pictures of their moments.

use std::sync::{
    Mutex,
    atomic::{AtomicU32, Ordering},
};

use batch_render::{
    batch::{Job, Request},
    camera::{Camera, FrameCamera, PictureCamera, Shutter, Timing},
    describe::{self, Source},
    film::{Film, PassRequest, Window},
    math::{DVec3, Transform},
    render::{
        AdaptiveSampling, Cancel, Control, FrameScenes, Interrupts, PartialFrame, RenderError, Renderer, SampleBudget,
        SceneTime, Settings,
    },
    scene::{ObjectId, Scene, SceneUpdate},
};

mod cameras;
mod motion_vectors;
mod rolling_shutter;

const SIDE: u32 = 64;

/// A white square of a metre and a ball before nothing; a pixel is a sixteenth of a metre.
const SQUARE: &str = r#"
[camera]
orthographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 4 }
[background]
color = [0, 0, 0]
visible = false
[material.white]
emitter = { radiance = [1, 1, 1], two_sided = true }
[[object]]
material = "white"
shape.quad = { corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]] }
"#;

/// A ball between a lamp, a mirror and a floor.
const ROOM: &str = r#"
[camera]
perspective = { eye = [0, 2, 5], target = [0, 0.8, 0], fov = 45 }
[material.floor]
matte = { albedo = [0.6, 0.6, 0.6] }
[material.mirror]
mirror = { reflectance = [0.9, 0.9, 0.9] }
[material.lamp]
emitter = { radiance = [8, 8, 8] }
[[object]]
name = "ball"
material = "floor"
shape.sphere = { center = [0, 0.5, 0], radius = 0.5 }
[[object]]
name = "lamp"
material = "lamp"
shape.sphere = { center = [0, 3, 0], radius = 0.3 }
[[object]]
material = "floor"
shape.quad = { corners = [[-4, 0, 4], [4, 0, 4], [4, 0, -4], [-4, 0, -4]] }
[[object]]
material = "mirror"
shape.quad = { corners = [[-3, 0, -2], [3, 0, -2], [3, 3, -2], [-3, 3, -2]] }
"#;

type Motion = dyn Fn(f64) -> Vec<(ObjectId, Transform)> + Sync;

/// A scene whose objects move by time in frames, in a frame whose shutter is open for the first frame.
struct Moving<'a> {
    scene: Scene,
    motion: &'a Motion,
    is_still: bool,
}

impl FrameScenes for Moving<'_> {
    type Error = RenderError;

    fn is_still(&self, _: impl Iterator<Item = SceneTime>) -> bool {
        self.is_still
    }

    fn at(&mut self, time: SceneTime) -> Result<&Scene, RenderError> {
        let time = match time {
            SceneTime::Before => -1.0,
            SceneTime::Shutter(u) => u,
            SceneTime::After => 1.0,
        };
        let update = SceneUpdate {
            transforms: (self.motion)(time),
            ..SceneUpdate::default()
        };
        self.scene.apply(&update).expect("everything that moves can be moved");
        Ok(&self.scene)
    }
}

struct Stage<'a> {
    job: Job,
    motion: &'a Motion,
    settings: Settings,
    camera: FrameCamera,
    is_still: bool,
}

impl<'a> Stage<'a> {
    fn new(scene: &str, samples: u32, motion: &'a Motion) -> Self {
        let text = format!("[render]\nwidth = {SIDE}\nheight = {SIDE}\nsamples = {samples}\nfilter = \"box\"\n{scene}");
        let desc = describe::parse(Source::new("moving.toml".into(), text)).expect("a scene");
        let job = Job::new(desc, &Request::default()).expect("a plan");
        Self {
            settings: job.plan.picture.settings.clone(),
            camera: job.plan.frames[0].camera.clone().with_timing(shutter(1.0)),
            job,
            motion,
            is_still: false,
        }
    }

    fn moving(&self) -> Moving<'a> {
        Moving {
            scene: self.job.compile().expect("a scene"),
            motion: self.motion,
            is_still: self.is_still,
        }
    }

    fn try_render(&self, settings: &Settings, control: &Control<'_>) -> Result<Film, RenderError> {
        let integrator = self.job.plan.picture.integrator.as_dyn();
        Renderer::new().render_moving(&mut self.moving(), &self.camera, integrator, settings, control)
    }

    fn render(&self) -> Film {
        self.try_render(&self.settings, &Control::default()).expect("a film")
    }

    /// The mean of still pictures of so many times.
    fn mean_of_stills(&self, count: u32, seed: u32) -> Vec<[f32; 4]> {
        let mut moving = self.moving();
        let mut sum = vec![[0.0; 4]; (SIDE * SIDE) as usize];
        for i in 0..count {
            let u = (f64::from(i) + 0.5) / f64::from(count);
            let scene = moving.at(SceneTime::Shutter(u)).expect("a scene");
            let camera = FrameCamera::from(self.camera.camera(u as f32));
            let settings = Settings {
                seed: seed + i,
                samples: SampleBudget::fixed(2),
                ..self.settings.clone()
            };
            let integrator = self.job.plan.picture.integrator.as_dyn();
            let film = Renderer::new().render(scene, &camera, integrator, &settings, &Control::default());
            for (sum, pixel) in sum.iter_mut().zip(film.expect("a film").beauty()) {
                *sum = std::array::from_fn(|c| sum[c] + pixel[c] / count as f32);
            }
        }
        sum
    }
}

fn moved(to: DVec3) -> Transform {
    Transform::from_parts(to, DVec3::ZERO, DVec3::ONE).expect("a transform")
}

fn turned(degrees: f64) -> Transform {
    Transform::from_parts(DVec3::ZERO, DVec3::Z * degrees, DVec3::ONE).expect("a transform")
}

fn bits(film: &Film) -> Vec<Vec<u32>> {
    let plane = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect();
    film.planes().iter().map(|p| plane(&p.values)).collect()
}

/// The mean of the squared differences of all channels.
fn squared_error(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let pixels = a.iter().zip(b);
    let of = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>() / 4.0;
    pixels.map(of).sum::<f32>() / a.len() as f32
}

/// The means of blocks of eight by eight pixels.
fn blocks(pixels: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let mut means = vec![[0.0; 4]; (SIDE * SIDE / 64) as usize];
    for (i, pixel) in (0..).zip(pixels) {
        let mean = &mut means[(i / SIDE / 8 * (SIDE / 8) + i % SIDE / 8) as usize];
        *mean = std::array::from_fn(|c| mean[c] + pixel[c] / 64.0);
    }
    means
}

#[test]
fn the_coverage_of_a_moving_edge_is_a_ramp() {
    // Two metres to the left: 32 pixels.
    let motion = |t: f64| vec![(ObjectId(0), moved(DVec3::X * (1.0 - 2.0 * t)))];
    let stage = Stage::new(SQUARE, 16, &motion);
    let film = stage.render();
    for column in 0..SIDE {
        let x = f64::from(column) / 16.0 - 2.0;
        // The square covers the middle of the pixel from the time at which its left edge arrives until its right edge leaves.
        let (arrives, leaves) = ((1.0 - (x + 1.0 / 32.0)) / 2.0, (2.0 - (x + 1.0 / 32.0)) / 2.0);
        let expected = (leaves.clamp(0.0, 1.0) - arrives.clamp(0.0, 1.0)) as f32;
        let rows: Vec<f32> = (17..31)
            .map(|y| film.beauty()[(y * SIDE + column) as usize][3])
            .collect();
        let mean = rows.iter().sum::<f32>() / rows.len() as f32;
        assert!((mean - expected).abs() < 0.02, "{column}: {mean} is not {expected}");
        // Noise of a pixel: far less than that of 16 independent samples.
        assert!(
            rows.iter().all(|alpha| (alpha - expected).abs() < 0.13),
            "{column}: {rows:?}"
        );
    }
}

#[test]
fn a_spinning_square_covers_arcs_by_its_part_of_the_turn() {
    let motion = |t: f64| vec![(ObjectId(0), turned(360.0 * t))];
    let film = Stage::new(SQUARE, 64, &motion).render();
    // A quarter of a circle within a metre; then the angle between the square's edges, up to its corner.
    let coverage = |r: f64| match r {
        r if r < 1.0 => 0.25,
        r if r < 2.0_f64.sqrt() => 0.25 - libm::acos(1.0 / r) / std::f64::consts::PI,
        _ => 0.0,
    };
    let mut rings = vec![[0.0; 3]; 32];
    for (i, pixel) in film.beauty().iter().enumerate() {
        let [x, y] = [i as u32 % SIDE, i as u32 / SIDE].map(|n| (f64::from(n) + 0.5) / 16.0 - 2.0);
        let r = x.hypot(y);
        if let Some([sum, expected, count]) = rings.get_mut((16.0 * r) as usize) {
            *sum += f64::from(pixel[3]);
            *expected += coverage(r);
            *count += 1.0;
        }
    }
    // The pixels in the middle are few, and see all of the turn in each of them.
    for (ring, [sum, expected, count]) in rings.into_iter().enumerate().skip(3) {
        assert!(
            (sum - expected).abs() < 0.02 * count,
            "{ring}: {} is not {}",
            sum / count,
            expected / count
        );
    }
}

#[test]
fn a_falling_square_is_where_its_parabola_says() {
    let motion = |t: f64| vec![(ObjectId(0), moved(DVec3::Y * (0.9 - 2.5 * t * t)))];
    let film = Stage::new(SQUARE, 64, &motion).render();
    for row in 0..SIDE {
        // The time at which a height is passed.
        let passed = |height: f64, y: f64| ((0.9 + height - y) / 2.5).max(0.0).sqrt().min(1.0);
        let within = (0..64).map(|k| 2.0 - (f64::from(row) + (f64::from(k) + 0.5) / 64.0) / 16.0);
        let expected = (within.map(|y| passed(1.0, y) - passed(0.0, y)).sum::<f64>() / 64.0) as f32;
        let pixels = (34..46).map(|x| film.beauty()[(row * SIDE + x) as usize][3]);
        let mean = pixels.sum::<f32>() / 12.0;
        assert!((mean - expected).abs() < 0.02, "{row}: {mean} is not {expected}");
    }
}

#[test]
fn shadows_mirrors_and_lamps_are_those_of_the_same_moment_with_every_camera() {
    let motion = |t: f64| {
        vec![
            (ObjectId(0), moved(DVec3::new(2.0 * t - 1.0, t, 0.0))),
            (ObjectId(1), moved(DVec3::X * (1.0 - 3.0 * t))),
        ]
    };
    let opening = move |_| motion(0.0);
    for camera in [
        "perspective = { eye = [0, 2, 5], target = [0, 0.8, 0], fov = 45 }",
        "orthographic = { eye = [0, 2, 5], target = [0, 0.8, 0], height = 4 }",
        "panorama = { eye = [0, 1.5, 1.5], target = [0, 1, 0] }",
        "fisheye = { eye = [0, 1.5, 2], target = [0, 0.8, 0], fov = 150 }",
    ] {
        let scene = ROOM.replace(
            "perspective = { eye = [0, 2, 5], target = [0, 0.8, 0], fov = 45 }",
            camera,
        );
        let stage = Stage::new(&scene, 16, &motion);
        let blurred = stage.render();
        let [a, b] = [100, 200].map(|seed| blocks(&stage.mean_of_stills(16, seed)));
        let mean = |(a, b): (&[f32; 4], &[f32; 4])| std::array::from_fn(|c| (a[c] + b[c]) / 2.0);
        let stills: Vec<[f32; 4]> = a.iter().zip(&b).map(mean).collect();
        let noise = squared_error(&blocks(blurred.beauty()), &stills);
        let again = Settings {
            seed: 3,
            ..stage.settings.clone()
        };
        let other = stage.try_render(&again, &Control::default()).expect("a film");
        // Half of the difference of two blurred pictures is their noise, and a quarter that of the mean of two pictures.
        let own = squared_error(&blocks(blurred.beauty()), &blocks(other.beauty())) / 2.0 + squared_error(&a, &b) / 4.0;
        assert!(noise < 2.0 * own, "{camera}: {noise} is more than {own}");
        let opening = Stage::new(&scene, 16, &opening);
        assert!(
            squared_error(&blocks(opening.render().beauty()), &stills) > 4.0 * own,
            "{camera}"
        );
    }
}

#[test]
fn an_object_that_the_camera_carries_along_is_sharp() {
    let motion = |t: f64| vec![(ObjectId(0), moved(DVec3::X * 1.5 * t))];
    let mut stage = Stage::new(SQUARE, 16, &motion);
    let still = Renderer::new().render(
        &stage.job.compile().expect("a scene"),
        &stage.camera,
        stage.job.plan.picture.integrator.as_dyn(),
        &stage.settings,
        &Control::default(),
    );
    let camera = stage.camera.camera(0.0);
    let carried = |u: f64| Ok::<Camera, RenderError>(camera.moved(DVec3::X * 1.5 * u));
    stage.camera = FrameCamera::from(PictureCamera::moving(carried).expect("a camera")).with_timing(shutter(1.0));
    let error = squared_error(stage.render().beauty(), still.expect("a film").beauty());
    assert!(error < 1e-6, "{error}");
}

/// A shutter that opens at the frame and closes after `close` frames.
fn shutter(close: f64) -> Timing {
    Shutter { open: 0.0, close }.into()
}

fn passes(names: &str) -> Vec<PassRequest> {
    PassRequest::parse_list(names.split(' ')).expect("passes")
}

fn room<'a>(motion: &'a Motion) -> Stage<'a> {
    let mut stage = Stage::new(ROOM, 20, motion);
    stage.settings.passes = passes("depth N forward CryptoObject denoise variance sampleCount diffuse_direct");
    stage
}

fn swing(t: f64) -> Vec<(ObjectId, Transform)> {
    vec![(ObjectId(0), moved(DVec3::X * (1.6 * t - 0.8)))]
}

#[test]
fn threads_and_crops_do_not_change_a_bit_of_any_pass() {
    let stage = room(&swing);
    let whole = stage.render();
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        assert!(
            bits(&pool.install(|| stage.render())) == bits(&whole),
            "{threads} threads"
        );
    }
    let crop = Window::new(13, 21, 50, 40);
    let settings = Settings {
        window: crop,
        ..stage.settings.clone()
    };
    let part = stage.try_render(&settings, &Control::default()).expect("a film");
    for (y, x) in (crop.y0..crop.y1).flat_map(|y| (crop.x0..crop.x1).map(move |x| (y, x))) {
        let (own, all) = (crop.index(x, y), Window::full([SIDE; 2]).index(x, y));
        for (own_plane, all_plane) in part.planes().iter().zip(whole.planes()) {
            assert_eq!(
                own_plane.pixel(own),
                all_plane.pixel(all),
                "{x},{y} {}",
                own_plane.spec.name
            );
        }
    }
}

#[test]
fn adaptive_sampling_gives_the_same_bits_on_every_number_of_threads_and_saves_samples() {
    let mut stage = room(&swing);
    stage.settings.samples.max = 32;
    stage.settings.samples.adaptive = Some(AdaptiveSampling {
        min: 8,
        threshold: 0.05,
        gain: 1.0,
    });
    let film = stage.render();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
    assert!(bits(&pool.install(|| stage.render())) == bits(&film));
    let counts = &film.plane("sampleCount").expect("a plane").values;
    assert!(counts.iter().all(|count| [8.0, 16.0, 32.0].contains(count)));
    assert!(counts.contains(&8.0) && counts.iter().any(|count| *count > 8.0));
}

/// Cancels the frame at the `at`th block, and keeps its state.
struct Ended {
    cancel: Cancel,
    left: AtomicU32,
    state: Mutex<Option<Vec<u8>>>,
}

impl Interrupts for Ended {
    fn are_due(&self) -> bool {
        if self.left.fetch_sub(1, Ordering::SeqCst) == 1 {
            self.cancel.cancel();
        }
        false
    }

    fn pause(&self, frame: &PartialFrame<'_>) {
        let film = frame.film();
        assert!(film.beauty().as_flattened().iter().all(|value| value.is_finite()));
        *self.state.lock().expect("a state") = Some(frame.state());
    }

    fn keep_state(&self) -> bool {
        true
    }

    fn earlier_state(&self, _range: Option<u32>) -> Option<Vec<u8>> {
        self.state.lock().expect("a state").clone()
    }
}

#[test]
fn a_frame_that_is_ended_within_its_shutter_goes_on_with_the_same_bits() {
    let stage = room(&swing);
    let whole = bits(&stage.render());
    for at in [1, 30, 200, 500] {
        let mut ended = Ended {
            cancel: Cancel::default(),
            left: AtomicU32::new(at),
            state: Mutex::default(),
        };
        let control = Control {
            cancel: Some(&ended.cancel),
            interrupts: Some(&ended),
            ..Control::default()
        };
        let cancelled = stage.try_render(&stage.settings, &control);
        assert!(matches!(cancelled, Err(RenderError::Cancelled(_))), "{at}");
        (ended.cancel, ended.left) = (Cancel::default(), AtomicU32::new(0));
        let control = Control {
            cancel: Some(&ended.cancel),
            interrupts: Some(&ended),
            ..Control::default()
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
        let film = pool
            .install(|| stage.try_render(&stage.settings, &control))
            .expect("a film");
        assert!(bits(&film) == whole, "{at}");
    }
}
