//! Pictures agree with those of a renderer that nobody here wrote: `reference/references.py` made them with Mitsuba 3.

use std::{fmt::Write, fs, path::Path};

use crate::common::{Folder, pixels, repo, repo_str};
use libtest_mimic::{Failed, Trial};

const BLOCK: usize = 8;

/// Means of blocks of 8x8 pixels, each red, green and blue.
type Blocks = Vec<[f64; 3]>;

/// Renders a scene of `reference/` with each of the seeds 1, 2, 3...
fn render_runs(scene: &str, samples: &str) -> Vec<Blocks> {
    let folder = Folder::new();
    let file = repo_str(&format!("tests/reference/{scene}.toml"));
    let render = |seed: usize| {
        let seed = seed.to_string();
        let args = [
            &file,
            "--seed",
            &seed,
            "--samples",
            samples,
            "--progress",
            "none",
            "-o",
            "f.exr",
        ];
        folder.succeed(&args);
        blocks(&folder.path("f.exr"))
    };
    (1..=RUNS).map(render).collect()
}

/// The blocks of a picture.
fn blocks(file: &Path) -> Blocks {
    let (width, pixels) = pixels(file);
    let columns = width / BLOCK;
    let mut blocks = vec![[0.0; 3]; pixels.len() / (BLOCK * BLOCK)];
    for (i, pixel) in pixels.iter().enumerate() {
        let (x, y) = (i % width / BLOCK, i / width / BLOCK);
        for c in 0..3 {
            blocks[y * columns + x][c] += f64::from(pixel[c]) / (BLOCK * BLOCK) as f64;
        }
    }
    blocks
}

/// Means and standard errors.
fn reference(scene: &str) -> Vec<[[f64; 3]; 2]> {
    let text = fs::read_to_string(repo(&format!("tests/reference/{scene}.csv"))).expect("a reference");
    let rows = text.lines().filter(|l| !l.starts_with('#'));
    let row = |line: &str| {
        let v: Vec<f64> = line.split(',').map(|v| v.parse().expect("a number")).collect();
        [[v[0], v[1], v[2]], [v[3], v[4], v[5]]]
    };
    rows.map(row).collect()
}

/// Renderings with seeds of their own: so many that their spread says how sure each block is.
const RUNS: usize = 12;

/// Standard errors of both pictures together that a block may be off. The errors are estimated from 12 and 8 renderings, so
/// they are uncertain themselves (Student's t with about 16 degrees of freedom): beyond 5 lies one of 8,000.
const SURE: f64 = 5.0;

/// Every block is within 1 % or what noise explains, whichever is larger, and the whole picture within half a percent.
fn agree(scene: &str, runs: &[Blocks]) {
    let expected = reference(scene);
    assert_eq!(runs[0].len(), expected.len());
    let mean = |at: usize, c: usize| runs.iter().map(|r| r[at][c]).sum::<f64>() / RUNS as f64;
    let variance = |at: usize, c: usize| {
        let m = mean(at, c);
        let squares: f64 = runs.iter().map(|r| (r[at][c] - m).powi(2)).sum();
        squares / ((RUNS - 1) * RUNS) as f64
    };
    // Rare bright paths may be in none of the runs: a block's error is at least that of all together, in proportion.
    let (mut noise, mut light) = (0.0, 0.0);
    for at in 0..expected.len() {
        for c in 0..3 {
            noise += variance(at, c);
            light += mean(at, c).powi(2);
        }
    }
    let relative = (noise / light).sqrt();
    let mut far = Vec::new();
    let mut sums = [0.0; 2];
    for (at, [means, errors]) in expected.iter().enumerate() {
        for c in 0..3 {
            let (found, wanted) = (mean(at, c), means[c]);
            let ours = variance(at, c).sqrt().max(relative * wanted);
            let allowed = (0.01 * wanted).max(SURE * ours.hypot(errors[c]));
            if (found - wanted).abs() > allowed {
                far.push(format!("block {at} channel {c}: {found} is not {wanted} +- {allowed}"));
            }
            sums[0] += found;
            sums[1] += wanted;
        }
    }
    let whole = sums[0] / sums[1];
    println!("{scene}: whole picture {whole:.5} of the reference, relative error of a block {relative:.5}");
    assert!(far.is_empty(), "{} blocks differ:\n{}", far.len(), far.join("\n"));
    assert!((whole - 1.0).abs() < 0.005, "{whole}");
}

pub fn trials() -> Vec<Trial> {
    let dragon = "obj/dragon/dragon_871k.obj";
    let trials = vec![
        trial!("a cornell box with glass and metal balls is as mitsuba has it", || {
            agree("cornell", &render_runs("cornell", "64"));
            Ok(())
        }),
        trial!("a rough metal ball under a sky is as mitsuba has it", || {
            agree("metal", &render_runs("metal", "64"));
            Ok(())
        }),
        asset_trial!(
            "the dragon under a white sky is as mitsuba has it",
            &[dragon],
            move |folder| the_dragon_agrees(&folder.join(dragon)),
        ),
    ];
    trials
}

fn the_dragon_agrees(mesh: &Path) -> Result<(), Failed> {
    let folder = Folder::new();
    let scene = fs::read_to_string(repo("tests/reference/dragon.toml")).expect("a scene");
    folder.write(
        "dragon.toml",
        &scene.replace("dragon_871k.obj", &mesh.to_string_lossy()),
    );
    // The mesh is large, so one process renders all: frames have seeds of their own.
    let (sin, cos) = libm::sincos(38.0_f64.to_radians());
    let mut path = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n".to_owned();
    for frame in 1..=RUNS {
        writeln!(path, "{frame},{},1.6,{},0,0.6,0", 3.56 * sin, 3.56 * cos).expect("a string takes all");
    }
    folder.write("path.csv", &path);
    folder.succeed(&[
        "dragon.toml",
        "--frames",
        "path.csv",
        "--progress",
        "none",
        "-o",
        "f.##.exr",
    ]);
    let file = |frame: usize| folder.path(&format!("f.{frame:02}.exr"));
    let runs: Vec<Blocks> = (1..=RUNS).map(|frame| blocks(&file(frame))).collect();
    agree("dragon", &runs);
    Ok(())
}
