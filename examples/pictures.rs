//! The pictures of the manual: one for each kind, strips that vary a setting, and a frame before and after denoising.
//! `cargo run --release --example pictures [-- PART OF A NAME]` writes them into `docs/scene/pictures`.
//!
//! The manual finds its pictures by their names: `material/metal.jpg` and `material/metal-roughness.jpg` are on the page
//! `material/metal.md`, `output-views.jpg` on `output.md`.

#[path = "lettering/lettering.rs"]
mod lettering;
#[path = "pictures/strips.rs"]
mod strips;

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
};

use batch_render::{
    batch::{DenoiseOptions, FilterKind, Job, JobEvent, Observer, Request},
    camera::CameraDesc,
    describe::{self, BackgroundDesc, Diagnostics, Overrides, SceneDesc, Source},
    filter::FilterDesc,
    integrator::IntegratorDesc,
    light::LightDesc,
    material::MaterialDesc,
    math::srgb,
    render::Control,
    sampler::SamplerDesc,
    shape::ShapeDesc,
    texture::{MappingDesc, PatternDesc},
};
use exr::prelude::{ReadChannels as _, ReadLayers as _, read};
use image::{Rgb, RgbImage, codecs::jpeg::JpegEncoder, imageops};
use strips::{Strip, strips};

/// The kinds of the scene file, by the folder of their pictures.
const KINDS: [(&str, &[&str]); 10] = [
    ("background", BackgroundDesc::NAMES),
    ("camera", CameraDesc::NAMES),
    ("filter", FilterDesc::NAMES),
    ("integrator", IntegratorDesc::NAMES),
    ("light", LightDesc::NAMES),
    ("mapping", MappingDesc::NAMES),
    ("material", MaterialDesc::NAMES),
    ("sampler", SamplerDesc::NAMES),
    ("shape", ShapeDesc::NAMES),
    ("texture", PatternDesc::NAMES),
];

/// The most bytes of a picture.
const MOST_BYTES: usize = 60_000;
/// The space between the pictures of a strip, in pixels.
const MARGIN: u32 = 4;
/// The height of the line above each of them.
const LINE: u32 = 14;
const PAPER: Rgb<u8> = Rgb([40, 40, 40]);
/// The size of the picture of a kind.
const KIND_SIZE: [u32; 2] = [320, 180];
/// Samples of the frame that is denoised, and of the one to compare it with.
const NOISY: &str = "32";
const CONVERGED: &str = "512";

/// Reports nothing.
struct Quiet;

impl Observer for Quiet {
    fn event(&self, _: &JobEvent<'_>) {}
}

fn main() -> Result<(), Box<dyn Error>> {
    let part = std::env::args().nth(1).unwrap_or_default();
    let is_wanted = |file: &str| file.contains(&part);
    for (folder, kinds) in KINDS {
        for kind in kinds {
            let file = format!("{folder}/{kind}");
            if is_wanted(&file) {
                save(&file, &kind_picture(folder, kind)?)?;
            }
        }
    }
    for strip in strips() {
        if is_wanted(strip.file) {
            save(strip.file, &strip_picture(&strip)?)?;
        }
    }
    if is_wanted("render-denoise") {
        save("render-denoise", &denoised_picture()?)?;
    }
    Ok(())
}

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Settings for a picture of this size.
fn sized([width, height]: [u32; 2]) -> Overrides {
    Overrides::default()
        .with("render.width", width)
        .with("render.height", height)
}

/// Settings for a picture of this size with little noise.
fn converged(size: [u32; 2]) -> Overrides {
    sized(size)
        .with("render.samples", 128)
        .with("render.samples.threshold", 0.02)
        .with("render.samples.min", 16)
}

/// Renders the scene of a kind. Samplers keep their own number of samples: their noise is what they show.
fn kind_picture(folder: &str, kind: &str) -> Result<RgbImage, Box<dyn Error>> {
    // The scene of a kind whose name two rooms have is `light-disk.toml`.
    let own = repository(&format!("scenes/kinds/{folder}-{kind}.toml"));
    let path = if own.exists() {
        own
    } else {
        repository(&format!("scenes/kinds/{kind}.toml"))
    };
    let text = fs::read_to_string(&path)?;
    let settings = match folder {
        "sampler" => sized(KIND_SIZE),
        _ => converged(KIND_SIZE),
    };
    render(path, &text, settings)
}

fn strip_picture(strip: &Strip) -> Result<RgbImage, Box<dyn Error>> {
    let cell = |value: &&str| {
        let setting = strip.setting.replace("VALUE", value);
        let scene = strip.scene.replace(strip.placeholder, &setting);
        let label = format!("{} {value}", strip.label);
        Ok((
            label.trim().to_owned(),
            render(repository("strip.toml"), &scene, converged(strip.size))?,
        ))
    };
    let cells: Result<Vec<_>, Box<dyn Error>> = strip.values.iter().map(cell).collect();
    Ok(arrange(&cells?, strip.columns))
}

/// The middle frame of a short sequence: with noise, denoised with the help of its neighbours, and with many samples.
fn denoised_picture() -> Result<RgbImage, Box<dyn Error>> {
    let room = |samples| include_str!("pictures/room.toml").replace("SHOWN", samples);
    let scene = repository("room.toml");
    let folder = tempfile::tempdir()?;
    let (path, clean) = (folder.path().join("path.csv"), folder.path().join("clean"));
    let frames: String = (-2..=2)
        .map(|i| format!("{},{},1,3.4,0,0.95,0\n", i + 3, f64::from(i) * 0.05))
        .collect();
    let header = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z";
    fs::write(&path, format!("{header}\n{frames}"))?;
    let request = Request {
        camera_path: Some(path),
        overrides: Overrides::default().with("output.files", &*clean.join("f.#.exr").to_string_lossy()),
        denoise: Some(DenoiseOptions {
            temporal: 2,
            filter: FilterKind::NonLocalMeans,
        }),
        ..Request::default()
    };
    let job = Job::new(parse(scene.clone(), &room(NOISY))?, &request)?;
    job.run(job.load()?, &Quiet, &Control::default())?;
    let cells = [
        (format!("{NOISY} samples"), read_exr(&clean.join("noisy/f.3.exr"))?),
        ("with --denoise".to_owned(), read_exr(&clean.join("f.3.exr"))?),
        (
            format!("{CONVERGED} samples"),
            render(scene, &room(CONVERGED), Overrides::default())?,
        ),
    ];
    Ok(arrange(&cells, cells.len() as u32))
}

/// Parses a scene. Rare bright paths are clamped, because they need many samples.
fn parse(path: PathBuf, text: &str) -> Result<SceneDesc, Diagnostics> {
    let clamped = |line: &str| match line.strip_suffix(" }") {
        Some(start) if line.starts_with("integrator.path") && !line.contains("clamp") => {
            format!("{start}, clamp_indirect = 2 }}\n")
        }
        _ => format!("{line}\n"),
    };
    let text: String = text.lines().map(clamped).collect();
    describe::parse(Source::new(path, text))
}

/// Renders one frame of a scene; `path` is the file of its text.
fn render(path: PathBuf, text: &str, settings: Overrides) -> Result<RgbImage, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let picture = folder.path().join("picture.png");
    let request = Request {
        overrides: settings.with("output.files", &*picture.to_string_lossy()),
        ..Request::default()
    };
    let job = Job::new(parse(path, text)?, &request)?;
    job.run(job.load()?, &Quiet, &Control::default())?;
    // The number of the frame is in the name.
    let entry = fs::read_dir(folder.path())?.next().ok_or("no picture was written")??;
    Ok(image::open(entry.path())?.to_rgb8())
}

/// The beauty of an EXR file as sRGB.
fn read_exr(path: &Path) -> Result<RgbImage, Box<dyn Error>> {
    let picture = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| RgbImage::new(size.width() as u32, size.height() as u32),
            |picture, at, (r, g, b, _): (f32, f32, f32, f32)| {
                let pixel = [r, g, b].map(srgb::encode8);
                picture.put_pixel(at.x() as u32, at.y() as u32, Rgb(pixel));
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path)?;
    Ok(picture.layer_data.channel_data.pixels)
}

/// Pictures of one size in rows of `columns`, each below its label.
fn arrange(cells: &[(String, RgbImage)], columns: u32) -> RgbImage {
    let (width, height) = cells[0].1.dimensions();
    let [right, down] = [width + MARGIN, height + MARGIN + LINE];
    let rows = (cells.len() as u32).div_ceil(columns);
    let mut sheet = RgbImage::from_pixel(columns * right + MARGIN, rows * down + MARGIN, PAPER);
    for (i, (label, picture)) in (0..).zip(cells) {
        let [x, y] = [MARGIN + i % columns * right, MARGIN + i / columns * down];
        lettering::write(&mut sheet, [x, y], label);
        imageops::replace(&mut sheet, picture, x.into(), (y + LINE).into());
    }
    sheet
}

/// Writes a picture of the manual, with the best quality that its bytes allow.
fn save(file: &str, picture: &RgbImage) -> Result<(), Box<dyn Error>> {
    let path = repository("docs/scene/pictures").join(format!("{file}.jpg"));
    fs::create_dir_all(path.parent().ok_or("a picture without a folder")?)?;
    for quality in (40..=92).rev().step_by(4) {
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(picture)?;
        if bytes.len() <= MOST_BYTES {
            println!("{file}: {} bytes, quality {quality}", bytes.len());
            return Ok(fs::write(path, bytes)?);
        }
    }
    Err(format!("{file} has more than {MOST_BYTES} bytes").into())
}
