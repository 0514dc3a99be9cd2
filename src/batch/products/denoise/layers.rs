//! Files as the denoiser reads them, and files with what it made.

use std::path::Path;

use crate::{
    batch::resume::fingerprint::SCENE,
    denoise::{CameraMatrices, CatcherAlpha, Color, DenoiseError, Denoised, Frame, Guides, Vectors},
    film::passes::{COVERAGE, GROUP_PREFIX, PASSES, PassSource},
    output::{ExrFile, FilePlane, Numbers, Value},
};

const RGB: [&str; 3] = ["R", "G", "B"];
const XYZ: [&str; 3] = ["X", "Y", "Z"];

/// The layers that are written beside the denoised ones: the picture before, and the estimated error after.
pub(super) const NOISY: &str = "noisy";
pub(super) const ERROR: &str = "error";

/// The layers of light beside the beauty, in the order of the file.
pub(super) fn light_layers(file: &ExrFile) -> Vec<String> {
    let is_light = |layer: &str| {
        let component = PASSES
            .iter()
            .any(|p| matches!(p.source, PassSource::Light(_)) && p.name == layer);
        component || layer.starts_with(GROUP_PREFIX)
    };
    let names = file.planes().filter_map(|plane| plane.name.strip_suffix(".R"));
    names.filter(|layer| is_light(layer)).map(str::to_owned).collect()
}

/// Reads what the denoiser needs of a file.
struct Reader<'a> {
    file: &'a ExrFile,
    path: &'a Path,
}

impl Reader<'_> {
    /// The numbers of a channel, all finite.
    fn plane(&self, channel: &str) -> Result<&[f32], DenoiseError> {
        let numbers = match find(self.file, channel).map(|plane| &plane.numbers) {
            Some(Numbers::Half(values) | Numbers::Float(values)) => values,
            _ => {
                return Err(DenoiseError::MissingLayer {
                    channel: channel.to_owned(),
                    path: self.path.to_owned(),
                });
            }
        };
        if let Some(i) = numbers.iter().position(|v| !v.is_finite()) {
            let window = self.file.parts[0].data;
            let width = window.width() as usize;
            return Err(DenoiseError::NotFinite {
                x: window.x0 + (i % width) as i32,
                y: window.y0 + (i / width) as i32,
                channel: channel.to_owned(),
                value: numbers[i],
                path: self.path.to_owned(),
            });
        }
        Ok(numbers)
    }

    fn color(&self, layer: &str, channels: [&str; 3]) -> Result<Color, DenoiseError> {
        let mut color = Color::default();
        for (plane, channel) in color.iter_mut().zip(channels) {
            *plane = self.plane(&format!("{layer}.{channel}"))?.to_vec();
        }
        Ok(color)
    }

    /// The sum of the channels of a layer.
    fn sum(&self, layer: &str, channels: [&str; 3]) -> Result<Vec<f32>, DenoiseError> {
        let [x, y, z] = self.color(layer, channels)?;
        Ok(x.iter().zip(y).zip(z).map(|((x, y), z)| x + y + z).collect())
    }

    /// The motion vectors, where the file has them.
    fn vectors(&self) -> Result<Option<Vectors>, DenoiseError> {
        let [backward, forward] = ["backward", "forward"];
        if [backward, forward]
            .iter()
            .any(|layer| find(self.file, &format!("{layer}.u")).is_none())
        {
            return Ok(None);
        }
        Ok(Some(Vectors {
            backward: self.color(backward, ["u", "v", "z"])?,
            forward: self.color(forward, ["u", "v", "z"])?,
        }))
    }

    fn number(&self, name: &str) -> Option<f32> {
        match self.file.attribute(name) {
            Some(Value::Float(number)) => Some(*number),
            _ => None,
        }
    }

    fn matrix(&self, name: &str) -> Option<[f32; 16]> {
        match self.file.attribute(name) {
            Some(Value::M44f(matrix)) => Some(*matrix),
            _ => None,
        }
    }
}

fn find<'a>(file: &'a ExrFile, channel: &str) -> Option<&'a FilePlane> {
    file.planes().find(|plane| plane.name == channel)
}

/// The frame in a file, with these layers of light beside the beauty.
pub(super) fn frame(file: &ExrFile, layers: &[String], path: &Path) -> Result<Frame, DenoiseError> {
    let reader = Reader { file, path };
    let part = &file.parts[0];
    let depth = reader.plane("depth_mean.Z")?;
    let variance = reader.plane("depth_variance.Z")?;
    // The variance of 1/z is that of z over z^4.
    let of_inverse = |(z, variance): (&f32, &f32)| variance / (z * z * z * z).max(f32::MIN_POSITIVE);
    let alpha = match find(file, "A") {
        Some(_) => reader.plane("A")?.to_vec(),
        None => vec![1.0; depth.len()],
    };
    let alpha_halves = [reader.plane("alpha_halves.A")?, reader.plane("alpha_halves.B")?];
    let alpha_halves = alpha_halves.map(<[f32]>::to_vec);
    let (alpha, alpha_halves, catcher_alpha) = match find(file, &format!("{COVERAGE}.A")) {
        None => (alpha, alpha_halves, None),
        Some(plane) => {
            let covered = reader.plane(&plane.name)?.to_vec();
            let catchers = CatcherAlpha {
                all: alpha,
                halves: alpha_halves,
            };
            (covered.clone(), [covered.clone(), covered], Some(catchers))
        }
    };
    let mut guides = Guides {
        albedo: reader.color("albedo", RGB)?,
        albedo_variance: reader.sum("albedo_variance", RGB)?,
        normal: reader.color("N_mean", XYZ)?,
        normal_variance: reader.sum("N_variance", XYZ)?,
        inverse_depth_variance: depth.iter().zip(variance).map(of_inverse).collect(),
        inverse_depth: depth.iter().map(|z| 1.0 / z.max(1e-10)).collect(),
        object: match find(file, "objectId.Y").map(|plane| &plane.numbers) {
            Some(Numbers::Uint(ids)) => Some(ids.clone()),
            _ => None,
        },
    };
    guides.divide_by_alpha(&alpha);
    let halves = [reader.color("beauty_a", RGB)?, reader.color("beauty_b", RGB)?];
    let mut light = Vec::new();
    for layer in layers {
        light.push(reader.color(layer, RGB)?);
    }
    let camera = reader.matrix("worldToCamera").map(|camera_from_world| CameraMatrices {
        camera_from_world,
        ndc_from_world: reader.matrix("worldToNDC"),
        lens: reader
            .number("aperture")
            .zip(reader.number("focus"))
            .map(|(f, at)| [f, at]),
    });
    let beauty = ["R", "G", "B"].map(|channel| reader.plane(channel));
    let [r, g, b] = beauty;
    let beauty = [r?, g?, b?];
    let mut frame = Frame {
        families: families(layers, &light, &beauty),
        size: [part.data.width(), part.data.height()].map(|v| v as usize),
        origin: [part.data.x0, part.data.y0],
        resolution: [part.display.width(), part.display.height()],
        specular: specular(layers, &light),
        alpha,
        alpha_halves,
        catcher_alpha,
        guides,
        scene: match file.attribute(SCENE) {
            Some(Value::String(scene)) => Some(scene.clone()),
            _ => None,
        },
        camera,
        vectors: reader.vectors()?,
        ..Frame::default()
    };
    frame.set_light(halves, light);
    Ok(frame)
}

/// The components, and the light groups, where the file has all of them: they sum to the beauty.
fn families(layers: &[String], light: &[Color], beauty: &[&[f32]; 3]) -> Vec<Vec<usize>> {
    const MOST: f64 = 0.01;
    let sums = |family: &Vec<usize>| {
        let (mut apart, mut all) = (0.0, 0.0);
        for (c, plane) in beauty.iter().enumerate() {
            for (i, beauty) in plane.iter().enumerate() {
                let sum: f32 = family.iter().map(|layer| light[*layer][c][i]).sum();
                apart += f64::from((sum - beauty).abs());
                all += f64::from(*beauty);
            }
        }
        !family.is_empty() && apart <= MOST * all
    };
    let family = |groups: bool| -> Vec<usize> {
        let names = layers.iter().enumerate();
        names
            .filter(|(_, name)| name.starts_with(GROUP_PREFIX) == groups)
            .map(|(i, _)| i)
            .collect()
    };
    [family(false), family(true)].into_iter().filter(sums).collect()
}

/// The part of the light of each pixel that mirrors and glass send, where the layers tell it.
fn specular(layers: &[String], light: &[Color]) -> Option<Vec<f32>> {
    const SPECULAR: [&str; 3] = ["specular_direct", "specular_indirect", "transmission"];
    const DIFFUSE: [&str; 3] = ["diffuse_direct", "diffuse_indirect", "emission"];
    let sum = |names: [&str; 3]| -> Option<Vec<f32>> {
        let mut sum = vec![0.0; light.first()?[0].len()];
        for name in names {
            let layer = layers.iter().position(|layer| layer == name)?;
            for plane in &light[layer] {
                sum.iter_mut().zip(plane).for_each(|(sum, v)| *sum += v);
            }
        }
        Some(sum)
    };
    let (specular, diffuse) = (sum(SPECULAR)?, sum(DIFFUSE)?);
    let part = |(specular, diffuse): (f32, f32)| {
        let all = specular + diffuse;
        if all > 0.0 {
            (specular / all).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    Some(specular.into_iter().zip(diffuse).map(part).collect())
}

/// Puts denoised light into the file that it came from, with the noisy picture and the error as layers of their own.
pub(super) fn put(file: &mut ExrFile, layers: &[String], denoised: &Denoised) {
    let mut beside: Vec<FilePlane> = Vec::new();
    for (c, channel) in RGB.into_iter().enumerate() {
        if let Some(plane) = find(file, channel) {
            let numbers = plane.numbers.clone();
            let named = |layer: &str, numbers| FilePlane {
                name: format!("{layer}.{channel}"),
                numbers,
            };
            if let Some(error) = &denoised.error {
                let error = match &numbers {
                    Numbers::Float(_) => Numbers::Float(error[c].clone()),
                    _ => Numbers::Half(error[c].clone()),
                };
                beside.push(named(ERROR, error));
            }
            beside.push(named(NOISY, numbers));
        }
        replace(file, channel, &denoised.beauty[c], &denoised.is_exact);
        for (layer, light) in layers.iter().zip(&denoised.light) {
            replace(file, &format!("{layer}.{channel}"), &light[c], &denoised.is_exact);
        }
    }
    if let Some(alpha) = &denoised.alpha {
        replace(file, "A", alpha, &vec![false; alpha.len()]);
    }
    if !file.is_multi {
        file.parts[0].planes.extend(beside);
        return;
    }
    for layer in [NOISY, ERROR] {
        let mut part = file.parts[0].clone();
        layer.clone_into(&mut part.name);
        let own = beside.iter().filter(|plane| plane.name.starts_with(layer));
        part.planes = own.cloned().collect();
        if !part.planes.is_empty() {
            file.parts.push(part);
        }
    }
}

/// Replaces the numbers of a channel, but for pixels without noise.
fn replace(file: &mut ExrFile, channel: &str, by: &[f32], is_exact: &[bool]) {
    let mut planes = file.parts.iter_mut().flat_map(|part| &mut part.planes);
    if let Some(FilePlane {
        numbers: Numbers::Half(values) | Numbers::Float(values),
        ..
    }) = planes.find(|plane| plane.name == channel)
    {
        for ((value, by), is_exact) in values.iter_mut().zip(by).zip(is_exact) {
            if !is_exact {
                *value = *by;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        film::Window,
        output::{BlockShape, Compression, FilePart},
    };

    /// A file of two pixels with these channels, all of whose numbers are 0.5.
    fn file(channels: &[String]) -> ExrFile {
        let window = Window::new(3, 7, 5, 8);
        let plane = |name: &String| FilePlane {
            name: name.clone(),
            numbers: Numbers::Float(vec![0.5; 2]),
        };
        ExrFile {
            is_multi: false,
            parts: vec![FilePart {
                name: String::new(),
                attributes: Vec::new(),
                compression: Compression::None,
                blocks: BlockShape::Lines,
                display: Window::full([16, 9]),
                data: window,
                planes: channels.iter().map(plane).collect(),
            }],
        }
    }

    fn channels() -> Vec<String> {
        let denoise = PASSES.iter().filter(|pass| pass.serves_denoisers());
        let named = denoise.flat_map(|pass| pass.channels.iter().map(|channel| format!("{}.{channel}", pass.name)));
        named.chain(RGB.map(str::to_owned)).collect()
    }

    fn read(file: &ExrFile) -> Result<Frame, DenoiseError> {
        frame(file, &[], Path::new("f.exr"))
    }

    #[test]
    fn the_channels_of_the_denoisers_passes_are_enough_and_each_is_needed() {
        assert!(read(&file(&channels())).is_ok());
        for missing in channels().iter().filter(|name| *name != "objectId.Y") {
            let rest: Vec<String> = channels().into_iter().filter(|name| name != missing).collect();
            let error = read(&file(&rest)).expect_err("a channel is missing").to_string();
            assert!(
                error.contains(missing.as_str()) && error.contains("--aovs denoise"),
                "{error}"
            );
        }
    }

    #[test]
    fn a_number_that_is_not_finite_is_named_with_its_pixel() {
        for value in [f32::NAN, f32::INFINITY] {
            let mut file = file(&channels());
            let mut planes = file.parts[0].planes.iter_mut();
            let plane = planes.find(|plane| plane.name == "beauty_b.G").expect("it is there");
            plane.numbers = Numbers::Float(vec![0.5, value]);
            let error = read(&file).expect_err("a number is not finite").to_string();
            assert_eq!(error, format!("pixel 4, 7 of beauty_b.G is {value}: f.exr"));
        }
    }
}
