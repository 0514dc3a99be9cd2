//! A contact sheet for the eye: each model of a folder beside its reference pictures, in one PNG file.
//! `cargo run --release --example contact_sheet -- FOLDER OUT.png [PART OF A NAME]`.
//!
//! A model's references are the picture of its own name beside it, the first picture in a folder `screenshot` beside it or up
//! to two folders above, and one of a path tracer in `FOLDER/refs/goldens`, in a folder of the model's name. Lights and cameras
//! of the references are not known: flat models are seen from the front, others from the front, right and above.

#[path = "lettering/lettering.rs"]
mod lettering;

use std::{
    error::Error,
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
};

use batch_render::{
    assets::Store,
    batch::{Job, JobEvent, Observer, Request},
    describe::Overrides,
    math::DVec3,
    render::Control,
};
use image::{Rgb, RgbImage, imageops};

/// The side of a picture on the sheet, in pixels.
const SIDE: u32 = 220;
/// The height of the line that names a model.
const LINE: u32 = 14;
/// Pictures of a model: ours, and two references.
const PICTURES: u32 = 3;
/// Models beside each other.
const COLUMNS: u32 = 3;
const MARGIN: u32 = 4;
const SAMPLES: u32 = 48;
const PAPER: Rgb<u8> = Rgb([40, 40, 40]);
/// The angle over the height of our pictures, in degrees.
const FOV: f64 = 35.0;
/// Models that are thinner than this part of their width or height are seen from the front.
const FLAT: f64 = 0.35;

/// The renderers whose pictures are preferred as references: path tracers first.
const RENDERERS: [&str; 4] = [
    "blender-cycles",
    "three-gpu-pathtracer",
    "dspbr-pt",
    "gltf-sample-viewer",
];

/// Keeps quiet.
struct Quiet;

impl Observer for Quiet {
    fn event(&self, _: &JobEvent<'_>) {}
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, out, part @ ..] = &args[..] else {
        return Err("usage: contact_sheet FOLDER OUT.png [PART OF A NAME]".into());
    };
    let folder = Path::new(folder);
    let mut models = models(folder)?;
    models.retain(|entry| part.iter().all(|part| entry.model.to_string_lossy().contains(part)));
    let [width, height] = [MARGIN + PICTURES * (SIDE + MARGIN), MARGIN + LINE + SIDE + MARGIN];
    let rows = (models.len() as u32).div_ceil(COLUMNS).max(1);
    let mut sheet = RgbImage::from_pixel(width * COLUMNS, height * rows, PAPER);
    for (i, Entry { model, references }) in models.iter().enumerate() {
        let name = model.strip_prefix(folder).unwrap_or(model).display().to_string();
        println!("{name}");
        let (x, y) = (i as u32 % COLUMNS * width, i as u32 / COLUMNS * height);
        lettering::write(&mut sheet, [x + MARGIN, y + MARGIN], &name);
        let ours = render(model).inspect_err(|e| println!("  {e}")).ok();
        let theirs = references.iter().map(|picture| Some(picture.clone()));
        for (k, picture) in std::iter::once(ours).chain(theirs).enumerate() {
            let Some(picture) = picture else { continue };
            let picture = fit(&picture);
            let [left, top] = [x + MARGIN + k as u32 * (SIDE + MARGIN), y + MARGIN + LINE];
            let [left, top] = [left + (SIDE - picture.width()) / 2, top + (SIDE - picture.height()) / 2];
            imageops::replace(&mut sheet, &picture, left.into(), top.into());
        }
    }
    sheet.save(out)?;
    Ok(())
}

/// The picture, as large as its place allows.
fn fit(picture: &RgbImage) -> RgbImage {
    let scale = f64::from(SIDE) / f64::from(picture.width().max(picture.height()).max(1));
    let side = |length: u32| ((f64::from(length) * scale).round() as u32).clamp(1, SIDE);
    let [width, height] = [side(picture.width()), side(picture.height())];
    imageops::resize(picture, width, height, imageops::FilterType::Triangle)
}

/// A model and its reference pictures.
struct Entry {
    model: PathBuf,
    references: Vec<RgbImage>,
}

/// The models below a folder that have references, with these.
fn models(folder: &Path) -> Result<Vec<Entry>, Box<dyn Error>> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if has_ending(&path, &["gltf", "glb", "obj", "ply", "stl"]) {
                let references = references(&path, folder);
                if !references.is_empty() {
                    found.push(Entry {
                        model: path,
                        references,
                    });
                }
            }
        }
    }
    found.sort_by(|a: &Entry, b: &Entry| a.model.cmp(&b.model));
    Ok(found)
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().and_then(OsStr::to_str).unwrap_or_default();
    endings.iter().any(|e| e.eq_ignore_ascii_case(ending))
}

/// The reference pictures of a model, without those that cannot be read.
fn references(model: &Path, folder: &Path) -> Vec<RgbImage> {
    let own = ["png", "jpg"].map(|ending| model.with_extension(ending));
    let mut found: Vec<PathBuf> = own.into_iter().filter(|file| file.is_file()).collect();
    for above in model.ancestors().skip(1).take(3).take_while(|above| *above != folder) {
        let entries = fs::read_dir(above.join("screenshot")).into_iter().flatten().flatten();
        let mut shots: Vec<PathBuf> = entries.map(|e| e.path()).collect();
        shots.retain(|file| has_ending(file, &["png", "jpg", "jpeg", "webp"]));
        shots.sort();
        found.extend(shots.into_iter().next());
        let goldens = folder.join("refs/goldens").join(above.file_name().unwrap_or_default());
        let golden = |renderer: &&str| goldens.join(format!("{renderer}-golden.thumb.webp"));
        found.extend(RENDERERS.iter().map(golden).find(|file| file.is_file()));
    }
    let pictures = found.iter().filter_map(|file| Some(image::open(file).ok()?.to_rgb8()));
    pictures.take(PICTURES as usize - 1).collect()
}

/// Our picture of a model: by its own camera, or from where all of it is seen.
fn render(model: &Path) -> Result<RgbImage, Box<dyn Error>> {
    let files = tempfile::tempdir()?;
    let picture = files.path().join("ours.png");
    let mut request = Request {
        overrides: Overrides::default()
            .with("output.files", &*picture.to_string_lossy())
            .with("render.width", SIDE)
            .with("render.height", SIDE)
            .with("render.samples", SAMPLES),
        ..Request::default()
    };
    let loaded = Store::default().model(&model.into())?;
    let bounds = loaded.bounds();
    let [least, most] = [bounds.min, bounds.max];
    if loaded.cameras.is_empty() && least.is_finite() && most.is_finite() {
        let size = most - least;
        let is_flat = size.z < FLAT * size.x.max(size.y);
        let back = if is_flat {
            DVec3::Z
        } else {
            DVec3::new(0.6, 0.36, 1.0).normalize()
        };
        let half = if is_flat {
            0.5 * size.truncate().max_element()
        } else {
            0.5 * size.length()
        };
        let center = 0.5 * (least + most);
        let distance =
            0.5 * size.dot(back.abs()) * f64::from(u8::from(is_flat)) + half / libm::tan(0.5 * FOV.to_radians());
        let eye = center + back * distance * 1.05;
        let keys = format!(
            "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov\n1,{},{},{},{},{},{},{FOV}\n",
            eye.x, eye.y, eye.z, center.x, center.y, center.z,
        );
        let path = files.path().join("view.csv");
        fs::write(&path, keys)?;
        request.camera_path = Some(path);
    }
    let job = Job::open(model, &request)?;
    job.run(job.load()?, &Quiet, &Control::default())?;
    let entries = fs::read_dir(files.path())?.flatten().map(|e| e.path());
    let written = entries
        .into_iter()
        .find(|file| has_ending(file, &["png"]))
        .ok_or("no picture was written")?;
    Ok(image::open(written)?.to_rgb8())
}
