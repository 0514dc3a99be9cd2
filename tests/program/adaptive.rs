//! Adaptive sampling: blocks stop where their noise is low, and their bits depend on nothing but themselves.

use crate::common::Folder;
use batch_render::{
    batch::{Job, Request},
    describe::Overrides,
    film::{Film, Window, noise},
    render::{AdaptiveSampling, Control, Renderer, SampleBudget, Settings},
    scene::Scene,
};

/// A floor and a ball under a lamp, before an empty background. Its size is no multiple of that of a block.
const SCENE: &str = "[render]\nwidth = 70\nheight = 50\nsamples = { min = 8, max = 64, threshold = 0.03 }\n\
    [camera]\nperspective = { eye = [0, 1.5, 6], target = [0, 0.9, 0], fov = 40, aperture_radius = 0.02, focus_distance = 6 }\n\
    [background]\ncolor = [0.2, 0.3, 0.4]\n\
    [material.floor]\nmatte = { albedo = [0.7, 0.6, 0.5] }\n\
    [material.metal]\nmetal = { preset = \"gold\", roughness = 0.3 }\n\
    [material.lamp]\nemitter = { radiance = [40, 36, 30] }\n\
    [[object]]\nmaterial = \"floor\"\nshape.quad = { corners = [[-4, 0, 4], [4, 0, 4], [4, 0, -4], [-4, 0, -4]] }\n\
    [[object]]\nmaterial = \"metal\"\nshape.sphere = { center = [-0.6, 0.6, 0], radius = 0.6 }\n\
    [[object]]\nmaterial = \"lamp\"\nshape.sphere = { center = [1.5, 2, 1], radius = 0.2 }\n";

/// Everything that depends on the samples.
const PASSES: &str = "sampleCount,variance,denoise,depth,CryptoObject,diffuse_direct";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SCENE);
    folder
}

/// The values of a channel of an EXR file, row by row.
fn channel(folder: &Folder, file: &str, name: &str) -> Vec<f32> {
    let image = folder.open_exr(file);
    let mut channels = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
    let found = channels.find(|channel| channel.name.to_string() == name);
    found.expect("a channel").sample_data.values_as_f32().collect()
}

struct Prepared {
    job: Job,
    scene: Scene,
}

impl Prepared {
    fn new(scene: &str, request: Request) -> Self {
        let folder = Folder::new();
        let job = Job::open(&folder.write("s.toml", scene), &request).expect("a scene");
        let scene = job.compile().expect("a scene");
        Self { job, scene }
    }

    fn render(&self, settings: &Settings) -> Film {
        let plan = &self.job.plan;
        let camera = &plan.frames[0].camera;
        let integrator = plan.picture.integrator.as_dyn();
        Renderer::new()
            .render(&self.scene, camera, integrator, settings, &Control::default())
            .expect("a film")
    }
}

fn all_passes() -> Request {
    Request {
        overrides: Overrides::default().with("output.aovs", "all"),
        ..Request::default()
    }
}

fn bits(film: &Film) -> Vec<Vec<u32>> {
    let plane = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect();
    film.planes().iter().map(|p| plane(&p.values)).collect()
}

/// The squared error of what is shown of a pixel.
fn squared_error(pixel: [f32; 3], truth: [f32; 3]) -> f64 {
    let l = f64::from(truth.iter().sum::<f32>()) / 3.0;
    let square = |c: usize| f64::from(pixel[c] - truth[c]).powi(2);
    (square(0) + square(1) + square(2)) / 3.0 / l.max(l * l).max(noise::DARKEST)
}

fn counts(film: &Film) -> &[f32] {
    &film.plane("sampleCount").expect("a pass").values
}

#[test]
fn blocks_stop_at_powers_of_two_and_rounds_do_not_change_a_bit() {
    let prepared = Prepared::new(SCENE, all_passes());
    let settings = &prepared.job.plan.picture.settings;
    let once = prepared.render(settings);
    let mut seen: Vec<f32> = counts(&once).to_vec();
    seen.sort_by(f32::total_cmp);
    seen.dedup();
    assert!(seen.len() >= 3 && seen.first() == Some(&8.0), "{seen:?}");
    assert!(seen.iter().all(|n| [8.0, 16.0, 32.0, 64.0].contains(n)), "{seen:?}");
    for min in [1, 5, 16] {
        let in_rounds = Settings {
            samples: SampleBudget {
                min,
                ..settings.samples
            },
            ..settings.clone()
        };
        assert!(
            bits(&prepared.render(&in_rounds)) == bits(&once),
            "rounds from {min} on"
        );
    }
}

#[test]
fn a_threshold_of_zero_is_the_picture_of_the_most_samples() {
    let prepared = Prepared::new(SCENE, all_passes());
    let settings = &prepared.job.plan.picture.settings;
    let with = |samples| {
        let settings = Settings {
            samples,
            ..settings.clone()
        };
        prepared.render(&settings)
    };
    let adaptive = settings
        .samples
        .adaptive
        .map(|rule| AdaptiveSampling { threshold: 0.0, ..rule });
    let exhaustive = with(SampleBudget {
        adaptive,
        ..settings.samples
    });
    assert!(bits(&exhaustive) == bits(&with(SampleBudget::fixed(64))));
}

#[test]
fn a_picture_without_noise_stops_at_the_least_samples() {
    let scene = "[render]\nwidth = 40\nheight = 40\nsamples = { min = 16, max = 4096, threshold = 0.001 }\n\
        [camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n[background]\ncolor = [0.5, 0.5, 0.5]\n";
    let prepared = Prepared::new(scene, all_passes());
    let film = prepared.render(&prepared.job.plan.picture.settings);
    assert!(counts(&film).iter().all(|n| *n == 16.0));
    // Noise is judged at powers of two, and never by fewer than four samples.
    for (min, first) in [("1", 4.0), ("20", 32.0), ("4096", 4096.0)] {
        let scene = scene.replace("min = 16", &format!("min = {min}"));
        let prepared = Prepared::new(&scene, all_passes());
        let film = prepared.render(&prepared.job.plan.picture.settings);
        assert!(counts(&film).iter().all(|n| *n == first), "{min}");
    }
}

#[test]
fn a_lower_threshold_means_more_samples_and_a_lower_error() {
    let prepared = Prepared::new(SCENE, all_passes());
    let settings = &prepared.job.plan.picture.settings;
    let truth = prepared.render(&Settings {
        samples: SampleBudget::fixed(4096),
        seed: 77,
        ..settings.clone()
    });
    let (mut samples, mut last) = (0.0, f64::INFINITY);
    for threshold in [0.2, 0.05, 0.0125] {
        let rule = AdaptiveSampling {
            min: 4,
            threshold,
            gain: 1.0,
        };
        let film = prepared.render(&Settings {
            samples: SampleBudget {
                adaptive: Some(rule),
                ..SampleBudget::fixed(1024)
            },
            ..settings.clone()
        });
        let rgb = |p: &[f32; 4]| [p[0], p[1], p[2]];
        let pixels = film.beauty().iter().zip(truth.beauty());
        let squares = pixels.map(|(a, b)| squared_error(rgb(a), rgb(b)));
        let error = (squares.sum::<f64>() / film.window.area() as f64).sqrt();
        let taken: f32 = counts(&film).iter().sum();
        assert!(
            taken > samples && error < last,
            "{threshold}: {taken} {error} after {samples} {last}"
        );
        assert!(error < f64::from(threshold), "{threshold}: {error}");
        (samples, last) = (taken, error);
    }
}

#[test]
fn the_estimated_error_is_the_true_one_and_the_mean_has_no_bias() {
    const SEEDS: u32 = 24;
    let prepared = Prepared::new(SCENE, all_passes());
    let settings = Settings {
        resolution: [64, 48],
        window: Window::full([64, 48]),
        ..prepared.job.plan.picture.settings.clone()
    };
    let with = |samples, seed| {
        prepared.render(&Settings {
            samples,
            seed,
            ..settings.clone()
        })
    };
    let mut truth = vec![[0.0; 3]; settings.window.area()];
    for seed in 1000..1004 {
        for (sum, pixel) in truth.iter_mut().zip(with(SampleBudget::fixed(1024), seed).beauty()) {
            *sum = std::array::from_fn(|c| sum[c] + pixel[c] / 4.0);
        }
    }
    let blocks = settings.window.area() / 256;
    let (mut estimated, mut real) = (vec![0.0; blocks], vec![0.0; blocks]);
    let mut total = 0.0;
    for seed in 0..SEEDS {
        let film = with(settings.samples, seed);
        let halves = film.plane("beauty_a").expect("a pass").values.chunks_exact(3);
        for (i, (half, pixel)) in halves.zip(film.beauty()).enumerate() {
            let (x, y) = (i % 64, i / 64);
            let block = y / 16 * 4 + x / 16;
            let mean = [pixel[0], pixel[1], pixel[2]];
            estimated[block] += noise::squared_error(mean, [half[0], half[1], half[2]], 1.0);
            real[block] += squared_error(mean, truth[i]);
            total += f64::from(mean.iter().sum::<f32>());
        }
    }
    // Blocks without noise differ by rounding alone.
    let mut ratios: Vec<f64> = real
        .iter()
        .zip(&estimated)
        .filter(|(_, e)| **e > 1e-6)
        .map(|(r, e)| (r / e).sqrt())
        .collect();
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    assert!(ratios.len() >= 6 && (0.8..1.2).contains(&median), "{ratios:?}");
    let expected: f64 = truth.iter().flatten().map(|v| f64::from(*v)).sum();
    let bias = total / f64::from(SEEDS) / expected - 1.0;
    assert!(bias.abs() < 1e-3, "{bias}");
}

#[test]
fn one_two_and_seven_threads_tiles_and_lines_have_the_same_bits() {
    let folder = folder();
    for threads in ["1", "2", "7"] {
        let (exr, png) = (format!("t{threads}.exr"), format!("t{threads}.png"));
        folder.succeed(&["s.toml", "--threads", threads, "-o", &exr, "-o", &png, "--aovs", PASSES]);
    }
    for file in ["t2.exr", "t7.exr", "t2.png", "t7.png"] {
        assert!(
            folder.read(file) == folder.read(&file.replace(['2', '7'], "1")),
            "{file}"
        );
    }
    folder.succeed(&["s.toml", "-o", "tiled.exr", "--tiled", "--aovs", PASSES]);
    for name in ["R", "B", "sampleCount.Y", "beauty_a.G", "N_variance.X"] {
        assert!(
            channel(&folder, "tiled.exr", name) == channel(&folder, "t1.exr", name),
            "{name}"
        );
    }
}

#[test]
fn crops_render_whole_blocks_and_become_the_file_of_the_frame() {
    let folder = folder();
    let render = |name: &str, more: &[&str]| {
        let job = ["s.toml", "-o", name, "--aovs", PASSES];
        folder.succeed(&[&job[..], more].concat());
    };
    render("whole.exr", &[]);
    // No edge of theirs is one of a block.
    for (i, crop) in ["0,0,33,50", "33,0,70,17", "33,17,70,50"].iter().enumerate() {
        render(&format!("crop{i}.exr"), &["--crop", crop]);
    }
    folder.succeed(&["merge", "merged.exr", "crop0.exr", "crop1.exr", "crop2.exr"]);
    assert!(folder.read("merged.exr") == folder.read("whole.exr"));
    render("wide.exr", &["--overscan", "9"]);
    for name in ["R", "sampleCount.Y", "beauty_b.R"] {
        let (whole, wide) = (channel(&folder, "whole.exr", name), channel(&folder, "wide.exr", name));
        let inner = wide.chunks(88).skip(9).take(50).flat_map(|row| &row[9..79]);
        assert!(inner.eq(&whole), "{name}");
    }
}

#[test]
fn figures_count_the_samples_that_the_pass_shows() {
    let folder = folder();
    folder.succeed(&[
        "s.toml",
        "-o",
        "f.exr",
        "--aovs",
        "sampleCount",
        "--exr-type",
        "float",
        "--stats",
        "st.json",
    ]);
    let stats: serde_json::Value = serde_json::from_slice(&folder.read("st.json")).expect("JSON");
    let counted: f32 = channel(&folder, "f.exr", "sampleCount.Y").iter().sum();
    assert_eq!(stats["frames"][0]["samples"].as_f64(), Some(f64::from(counted)));
    assert!(counted < 64.0 * 70.0 * 50.0);
    assert_eq!((&stats["samples"], &stats["min_samples"]), (&64.into(), &8.into()));
    assert!((stats["noise_threshold"].as_f64().expect("a number") - 0.03).abs() < 1e-6);
    assert!(stats["frames"][0].get("samples_per_pixel").is_none());
}

#[test]
fn files_say_the_rule_and_another_rule_makes_them_stale() {
    let folder = folder();
    let job = ["s.toml", "-o", "f.exr"];
    folder.succeed(&job);
    let meta = exr::meta::MetaData::read_from_file(folder.path("f.exr"), false).expect("an EXR");
    let attribute = |name: &str| {
        let name = exr::meta::attribute::Text::from(format!("batch-render/{name}").as_str());
        meta.headers[0].own_attributes.other.get(&name).cloned()
    };
    use exr::meta::attribute::AttributeValue::{F32, I32};
    assert_eq!(attribute("samples"), Some(I32(64)));
    assert_eq!(attribute("minSamples"), Some(I32(8)));
    assert_eq!(attribute("noiseThreshold"), Some(F32(0.03)));
    let stale = |more: &[&str]| folder.succeed(&[&job[..], &["--list-stale"], more].concat());
    assert_eq!(stale(&[]), "");
    assert_eq!(
        stale(&["--noise-threshold", "0.03", "--min-samples", "8", "--max-samples", "64"]),
        ""
    );
    for other in [
        &["--noise-threshold", "0.04"][..],
        &["--min-samples", "16"],
        &["--max-samples", "65"],
        &["--exposure", "1"],
    ] {
        assert!(stale(other).contains("other settings"), "{other:?}: {}", stale(other));
    }
}

#[test]
fn flags_switch_it_on_and_a_least_number_alone_is_wrong_usage() {
    let folder = Folder::new();
    let fixed = SCENE.replace("{ min = 8, max = 64, threshold = 0.03 }", "64");
    folder.write("s.toml", &fixed);
    let error = folder.fail(2, &["s.toml", "-o", "f.exr", "--min-samples", "4"]);
    assert!(
        error.contains("--min-samples: the number of samples is fixed"),
        "{error}"
    );
    folder.succeed(&[
        "s.toml",
        "-o",
        "f.exr",
        "--noise-threshold",
        "0.03",
        "--min-samples",
        "8",
        "--aovs",
        "sampleCount",
    ]);
    let other = self::folder();
    other.succeed(&["s.toml", "-o", "f.exr", "--aovs", "sampleCount"]);
    let counted = channel(&folder, "f.exr", "sampleCount.Y");
    assert!(counted == channel(&other, "f.exr", "sampleCount.Y"));
    // An upper limit below the lower one counts.
    other.succeed(&["s.toml", "-o", "f.exr", "--samples", "3", "--aovs", "sampleCount"]);
    assert!(channel(&other, "f.exr", "sampleCount.Y").iter().all(|n| *n == 3.0));
}

#[test]
fn a_time_limit_leaves_blocks_that_are_done_alone() {
    let folder = folder();
    let job = ["s.toml", "-o", "f.exr", "--aovs", "sampleCount", "--exr-type", "float"];
    folder.succeed(&job);
    let whole = folder.read("f.exr");
    folder.succeed(&[&job[..], &["--time-limit", "1h"]].concat());
    assert!(folder.read("f.exr") == whole);
    let short = [
        "--max-samples",
        "10000000",
        "--noise-threshold",
        "0.02",
        "--time-limit",
        "0.5s",
    ];
    let output = folder.run(&[&job[..], &short].concat());
    assert!(output.status.success());
    let counted = channel(&folder, "f.exr", "sampleCount.Y");
    let most = counted.iter().copied().fold(0.0, f32::max);
    let told = format!("frame 1 has {most} of 10000000 samples, the time limit is over");
    let message = crate::common::stderr(&output);
    // A machine that is fast enough has no noise left.
    assert!(message.contains(&told) || message.is_empty(), "{message} {most}");
    // Blocks that stopped have powers of two.
    assert!(
        counted.iter().all(|n| *n == most || (*n as u32).is_power_of_two()),
        "{most}"
    );
}
