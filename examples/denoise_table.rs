//! The error of frames before and after they are denoised: `cargo run --release --example denoise_table -- FOLDER [OIDN_LIBRARY]`.
//!
//! Scenes, a still and a moving camera, and 8 to 256 samples, filtered with one frame on each side. It fails where the error rises by
//! more than `MOST`. Frames that are in the folder already are not rendered again.

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

use batch_render::{
    batch::{
        DenoiseOptions, FilterKind, Job, JobEvent, Observer, Request,
        denoise::{DenoiseObserver, DenoiseRequest, Helpers, denoise},
    },
    describe::Overrides,
    output::{ExrFile, FilePattern, Numbers},
    render::Control,
    simd::Isa,
};

/// The scenes, from the folder `scenes`.
const SCENES: [&str; 10] = [
    "kinds/checker",
    "kinds/emitter",
    "kinds/environment",
    "kinds/glass",
    "kinds/metal",
    "kinds/occlusion",
    "kinds/perspective",
    "kinds/principled",
    "kinds/sun",
    "passes/scene",
];

const RESOLUTION: [u32; 2] = [128, 72];

/// The frames of a path, and the one that is compared.
const FRAMES: i32 = 3;
const COMPARED: i32 = 2;

/// The error after, in parts of that before.
const MOST: f64 = 1.02;

const SAMPLES: [u32; 4] = [8, 16, 64, 256];
const REFERENCE_SAMPLES: u32 = 1024;

type Failure = Box<dyn std::error::Error>;

/// Receives the events of jobs, and ignores them.
struct Quiet;

impl Observer for Quiet {
    fn event(&self, _event: &JobEvent<'_>) {}
}

impl DenoiseObserver for Quiet {}

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let home = PathBuf::from(args.next().ok_or("give a folder for the rendered frames")?);
    let library = args.next().map(PathBuf::from);
    let mut changes = Vec::new();
    println!("| scene | camera | 8 samples | 16 | 64 | 256 |\n|---|---|---|---|---|---|");
    for name in SCENES {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"));
        let folder = home.join(name.replace('/', "-"));
        let reference = render_scene(&scene, &folder)?;
        for camera in ["still", "moving"] {
            let mut row = format!("| {name} | {camera} |");
            for samples in SAMPLES {
                let input = folder.join(format!("{camera}/{samples}/f.####.exr"));
                let own = clean(&input, FilterKind::NonLocalMeans, &reference)?;
                let noisy = error(&frame_path(&input), &reference)?;
                changes.push(own / noisy);
                write!(row, " {noisy:.5} {:.2}", own / noisy)?;
                if library.is_some() {
                    let filter = FilterKind::Oidn {
                        library: library.clone(),
                    };
                    write!(row, " ({:.2})", clean(&input, filter, &reference)? / noisy)?;
                }
                row.push_str(" |");
            }
            println!("{row}");
        }
    }
    let worst = changes.iter().copied().fold(0.0, f64::max);
    println!("\nThe error after, in parts of that before, is at most {worst:.3}.");
    // No number is not at most another one.
    if changes.iter().all(|change| *change <= MOST) {
        Ok(())
    } else {
        Err("an error was raised".into())
    }
}

/// Renders the frames of a scene that are not there. Returns the path of the reference.
fn render_scene(scene: &Path, folder: &Path) -> Result<PathBuf, Failure> {
    fs::create_dir_all(folder)?;
    for (camera, degrees) in [("still", 0.0), ("moving", 2.0)] {
        let path = folder.join(format!("{camera}.csv"));
        fs::write(&path, camera_path(&fs::read_to_string(scene)?, degrees)?)?;
        for samples in SAMPLES {
            let pattern = folder.join(format!("{camera}/{samples}/f.####.exr"));
            let settings = Overrides::default()
                .with("render.samples", samples)
                .with("output.aovs", vec!["denoise"]);
            let request = request(settings, &path, &pattern);
            render(scene, &request, &frame_path(&pattern))?;
        }
    }
    let reference = folder.join("reference.exr");
    let settings = Overrides::default()
        .with("render.samples", REFERENCE_SAMPLES)
        .with("render.seed", 77)
        .with("output.aovs", vec!["depth"]);
    let request = Request {
        range: Some(COMPARED.to_string().parse()?),
        ..request(settings, &folder.join("still.csv"), &reference)
    };
    render(scene, &request, &reference)?;
    Ok(reference)
}

fn request(settings: Overrides, camera_path: &Path, output: &Path) -> Request {
    Request {
        camera_path: Some(camera_path.to_owned()),
        overrides: settings
            .with("output.files", &*output.to_string_lossy())
            .with("output.exr_type", "float")
            .with("render.width", RESOLUTION[0])
            .with("render.height", RESOLUTION[1]),
        ..Request::default()
    }
}

fn render(scene: &Path, request: &Request, file: &Path) -> Result<(), Failure> {
    if !file.exists() {
        let job = Job::open(scene, request)?;
        job.run(job.load()?, &Quiet, &Control::default())?;
    }
    Ok(())
}

/// A camera path that orbits the target of the scene's camera by so many degrees a frame, and shows the scene's view in the frame
/// that is compared.
fn camera_path(scene: &str, degrees: f64) -> Result<String, Failure> {
    let scene: toml::Table = scene.parse()?;
    let camera = scene["camera"].as_table().and_then(|camera| camera.values().next());
    let vector = |key: &str| -> Option<Vec<f64>> {
        let values = camera?.get(key)?.as_array()?.iter();
        values
            .map(|v| v.as_float().or(v.as_integer().map(|v| v as f64)))
            .collect()
    };
    let eye = vector("eye").ok_or("the scene's camera has no eye")?;
    let target = vector("target").ok_or("the scene's camera has no target")?;
    let mut text = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n".to_owned();
    let (x, z) = (eye[0] - target[0], eye[2] - target[2]);
    for frame in 1..=FRAMES {
        let (sin, cos) = libm::sincos(f64::from(frame - COMPARED) * degrees.to_radians());
        let (x, z) = (x * cos + z * sin + target[0], z * cos - x * sin + target[2]);
        writeln!(
            text,
            "{frame},{x},{},{z},{},{},{}",
            eye[1], target[0], target[1], target[2]
        )?;
    }
    Ok(text)
}

/// The file of the frame that is compared.
fn frame_path(pattern: &Path) -> PathBuf {
    PathBuf::from(pattern.display().to_string().replace("####", &format!("{COMPARED:04}")))
}

/// The error of the frame, denoised by this filter.
fn clean(input: &Path, filter: FilterKind, reference: &Path) -> Result<f64, Failure> {
    let output = input.with_file_name("clean.####.exr");
    let pattern = |path: &Path| FilePattern::parse(&path.display().to_string());
    let request = DenoiseRequest {
        input: pattern(input)?,
        output: pattern(&output)?,
        frames: Some(COMPARED.to_string().parse()?),
        helpers: Helpers::Complete,
        options: DenoiseOptions { temporal: 1, filter },
        skip_existing: false,
        simd: Isa::best(),
    };
    denoise(&request, &Quiet, None)?;
    error(&frame_path(&output), reference)
}

/// The relative mean square error of the light in a file: the mean of (x - r)^2 / (r^2 + 0.01).
fn error(file: &Path, reference: &Path) -> Result<f64, Failure> {
    let (file, reference) = (ExrFile::read(file)?, ExrFile::read(reference)?);
    let (mut sum, mut count) = (0.0, 0);
    for channel in ["R", "G", "B"] {
        for (x, r) in numbers(&file, channel)?.iter().zip(numbers(&reference, channel)?) {
            let (x, r) = (f64::from(*x), f64::from(*r));
            sum += (x - r) * (x - r) / (r * r + 0.01);
            count += 1;
        }
    }
    Ok(sum / f64::from(count))
}

fn numbers<'a>(file: &'a ExrFile, channel: &str) -> Result<&'a [f32], Failure> {
    let plane = file.planes().find(|plane| plane.name == channel);
    match plane.map(|plane| &plane.numbers) {
        Some(Numbers::Half(values) | Numbers::Float(values)) => Ok(values),
        _ => Err(format!("the file has no channel {channel}").into()),
    }
}
