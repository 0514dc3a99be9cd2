//! Pictures stay as they were: each row of [`PICTURES`] is rendered small and compared with the picture of its name in
//! `tests/golden`.
//!
//! A golden picture is the mean of many renderings, with the standard deviation of one (channel `deviation.Y`); so other random
//! numbers pass, and other light does not. Data are compared exactly. With `BLESS=1` the pictures are made anew: look at them.

use std::path::{Path, PathBuf};

use crate::common::{Folder, repo, repo_str};
use batch_render::film::{PassSpec, passes::PASSES};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, Layer, LayerAttributes, ReadChannels,
    ReadLayers, SmallVec, WritableImage, f16, read,
};
use libtest_mimic::{Failed, Trial};

/// The channels that a picture shows.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Light,
    /// The pass of this name, rendered alone.
    Pass(&'static str),
}

impl Kind {
    /// The channels that a picture is compared by; a golden picture holds them as R, G and B.
    fn channels(self) -> [String; 3] {
        let Self::Pass(name) = self else {
            return ["R", "G", "B"].map(str::to_owned);
        };
        let spec: &PassSpec = PASSES.iter().find(|spec| spec.name == name).expect("a pass");
        // The last channel stands in for those that the pass does not have.
        let channel = |i: usize| spec.channels[i.min(spec.channels.len() - 1)];
        [0, 1, 2].map(|i| format!("{name}.{}", channel(i)))
    }
}

/// The name of the picture, its scene and what it shows.
const PICTURES: &[(&str, &str, Kind)] = &[
    ("assignment", "scenes/assignment/extended.toml", Kind::Light),
    ("cornell", "tests/reference/cornell.toml", Kind::Light),
    ("environment", "scenes/kinds/environment.toml", Kind::Light),
    ("glass", "scenes/kinds/glass.toml", Kind::Light),
    ("metal", "scenes/kinds/metal.toml", Kind::Light),
    ("mesh", "scenes/kinds/mesh.toml", Kind::Light),
    ("principled", "scenes/kinds/principled.toml", Kind::Light),
    ("depth", "scenes/passes/scene.toml", Kind::Pass("depth")),
    ("normals", "scenes/passes/scene.toml", Kind::Pass("N")),
];

const SIZE: [usize; 2] = [48, 27];
const SAMPLES: &str = "128";
/// Renderings that a golden picture is the mean of.
const RUNS: usize = 24;
/// A chance of one in a hundred that one of the picture's numbers is farther off, by Sidak's correction: 1 - 0.99^(1/n) for
/// n = 48 x 27 x 3.
const FAR: f64 = 4.7;
/// This part of the numbers must not be farther off.
const MOST: f64 = 0.9975;
/// The rounding of a half, and the part of the deviation that 24 renderings do not see.
const ROUNDING: f64 = 2e-3;

type Pixels = Vec<[f64; 3]>;

pub fn trials() -> Vec<Trial> {
    let trials = PICTURES.iter().map(|&(name, scene, kind)| {
        trial!(name, move || {
            if std::env::var_os("BLESS").is_some() {
                bless(&golden(name), scene, kind)
            } else {
                compare(&golden(name), scene, kind)
            }
        })
    });
    let biased = trial!("a_percent_more_light_is_found", || {
        let more = |p: &[f64; 3]| p.map(|v| 1.01 * v);
        let found: Pixels = render("scenes/kinds/principled.toml", Kind::Light, 0)
            .iter()
            .map(more)
            .collect();
        let missed = wrong(&golden("principled"), &found).is_none();
        if missed { Err("it is not".into()) } else { Ok(()) }
    });
    trials.chain([biased]).collect()
}

fn golden(name: &str) -> PathBuf {
    repo(&format!("tests/golden/{name}.exr"))
}

fn render(scene: &str, kind: Kind, seed: usize) -> Pixels {
    let (folder, size) = (Folder::new(), format!("{}x{}", SIZE[0], SIZE[1]));
    let (scene, seed) = (repo_str(scene), seed.to_string());
    let mut args = vec![
        scene.as_str(),
        "--resolution",
        &size,
        "--progress",
        "none",
        "-o",
        "f.exr",
        "--seed",
        &seed,
    ];
    args.extend(["--samples", SAMPLES]);
    if scene.contains("/kinds/") && kind == Kind::Light {
        args.extend(["--integrator", "path"]);
    }
    if let Kind::Pass(name) = kind {
        args.extend(["--show", name]);
    }
    folder.succeed(&args);
    read_channels(&folder.path("f.exr"), kind.channels().each_ref().map(String::as_str))
}

/// Three channels of a file.
fn read_channels(path: &Path, names: [&str; 3]) -> Pixels {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes();
    let image = image
        .from_file(path)
        .unwrap_or_else(|e| panic!("{e}: {}", path.display()));
    let channels = &image.layer_data.channel_data.list;
    let values = names.map(|name| {
        let channel = channels.iter().find(|c| c.name.eq(name)).expect("a channel");
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        values
    });
    (0..values[0].len())
        .map(|i| [0, 1, 2].map(|c| f64::from(values[c][i])))
        .collect()
}

fn bless(path: &Path, scene: &str, kind: Kind) -> Result<(), Failed> {
    let count = if kind == Kind::Light { RUNS } else { 1 };
    let runs: Vec<Pixels> = (1..=count).map(|seed| render(scene, kind, 100 + seed)).collect();
    let mean = |i: usize, c: usize| runs.iter().map(|r| r[i][c]).sum::<f64>() / count as f64;
    let pixels = SIZE[0] * SIZE[1];
    let channel = |name: &str, value: &dyn Fn(usize) -> f64| {
        let samples = match kind {
            Kind::Pass(_) => FlatSamples::F32((0..pixels).map(|i| value(i) as f32).collect()),
            Kind::Light => FlatSamples::F16((0..pixels).map(|i| f16::from_f64(value(i))).collect()),
        };
        AnyChannel::new(name, samples)
    };
    let mut channels = SmallVec::new();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(channel(name, &|i| mean(i, c)));
    }
    if kind == Kind::Light {
        let variance =
            |i: usize, c: usize| runs.iter().map(|r| (r[i][c] - mean(i, c)).powi(2)).sum::<f64>() / (RUNS - 1) as f64;
        channels.push(channel("deviation.Y", &|i| {
            (0..3).map(|c| variance(i, c)).fold(0.0, f64::max).sqrt()
        }));
    }
    let layer = Layer::new(
        (SIZE[0], SIZE[1]),
        LayerAttributes::default(),
        Encoding {
            compression: exr::prelude::Compression::ZIP16,
            ..Encoding::FAST_LOSSLESS
        },
        AnyChannels::sort(channels),
    );
    let image = Image::new(ImageAttributes::with_size((SIZE[0], SIZE[1])), layer);
    image.write().to_file(path)?;
    Ok(())
}

fn compare(path: &Path, scene: &str, kind: Kind) -> Result<(), Failed> {
    let expected = read_channels(path, ["R", "G", "B"]);
    let found = render(scene, kind, 0);
    if kind != Kind::Light {
        let off = expected.iter().zip(&found).filter(|(a, b)| a != b).count();
        return if off == 0 {
            Ok(())
        } else {
            Err(format!("{off} pixels differ").into())
        };
    }
    match wrong(path, &found) {
        None => Ok(()),
        Some(what) => Err(what.into()),
    }
}

/// The faults in the light of `found` beside the golden picture at `path`.
fn wrong(path: &Path, found: &Pixels) -> Option<String> {
    let expected = read_channels(path, ["R", "G", "B"]);
    let deviation = read_channels(path, ["deviation.Y"; 3]);
    // A rare bright path may be in none of the renderings: neighbours know of it too.
    let around = |i: usize| {
        let (x, y) = (i % SIZE[0], i / SIZE[0]);
        let near = |v: usize, end: usize| v.saturating_sub(1)..(v + 2).min(end);
        let rows = near(y, SIZE[1]).flat_map(|y| near(x, SIZE[0]).map(move |x| y * SIZE[0] + x));
        let squares: Vec<f64> = rows.map(|j| deviation[j][0].powi(2)).collect();
        squares.iter().sum::<f64>() / squares.len() as f64
    };
    let (mut far, mut off, mut variance, mut light) = (0, 0.0, 0.0, 0.0);
    for (i, (expected, found)) in expected.iter().zip(found).enumerate() {
        let noise = around(i).max(deviation[i][0].powi(2)) * (1.0 + 1.0 / RUNS as f64);
        for c in 0..3 {
            let rounding = ROUNDING * expected[c].abs().max(0.01);
            let sigma = (noise + rounding * rounding).sqrt();
            far += usize::from((found[c] - expected[c]).abs() > FAR * sigma || found[c].is_nan());
            off += found[c] - expected[c];
            light += expected[c];
        }
        // The channels of a pixel are noisy together.
        variance += 9.0 * deviation[i][0].powi(2) * (1.0 + 1.0 / RUNS as f64);
    }
    let all = 3 * SIZE[0] * SIZE[1];
    if far as f64 > (1.0 - MOST) * all as f64 {
        return Some(format!(
            "{far} of {all} numbers are off by more than {FAR} standard deviations"
        ));
    }
    let allowed = 3.0 * variance.sqrt() + 2e-4 * light;
    if off.abs() > allowed {
        return Some(format!(
            "the mean is off by {} of itself, {} allowed",
            off / light,
            allowed / light
        ));
    }
    None
}
