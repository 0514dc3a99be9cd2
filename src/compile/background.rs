//! The background: a colour, a gradient, an environment map from a file, or a sky.

use super::compiler::Compiler;
use crate::{
    assets::{image::AlphaUse, model::ImageSource, store::ImageRequest},
    describe::BackgroundDesc,
    light::{
        Light,
        environment::{Environment, EnvironmentDesc},
        sky::Sky,
    },
    math::{DMat3, Rgb, WorkingSpace, transform},
    scene::{Background, BackgroundRadiance},
    texture::{Bitmap, bitmap::ColorSpace},
    value::Problem,
    warnings::{WarningKind, Warnings},
};

impl Compiler<'_> {
    /// The image of the background's environment map.
    pub(super) fn environment(&mut self) -> Option<ImageRequest> {
        let background = &self.desc.background;
        let given = [
            ("color", background.color.as_ref().map(|_| 0..0)),
            ("environment", background.environment.as_ref().map(|own| own.span())),
            ("sky", background.sky.as_ref().map(|own| own.span())),
            ("gradient", background.gradient.as_ref().map(|own| own.span())),
        ];
        let mut given = given.into_iter().filter_map(|(name, span)| Some((name, span?)));
        if let (Some((first, _)), Some((second, span))) = (given.next(), given.next()) {
            let message = format!("`{first}` and `{second}` are both given");
            self.problems.push(Problem::at(span, message));
        }
        let file = self.desc.environment_file()?;
        // What alpha covers does not shine the more.
        Some(ImageRequest {
            alpha: AlphaUse::Unused,
            ..ImageRequest::new(ImageSource::File(file), ColorSpace::Srgb)
        })
    }
}

/// The light of a background.
pub(super) struct BackgroundLight {
    pub radiance: BackgroundRadiance,
    /// The sun of a sky. It is the last of the lights.
    pub sun: Option<Light>,
}

/// The sky of a background, if it is one.
///
/// # Errors
/// A value of it is wrong.
pub(super) fn sky(desc: &BackgroundDesc) -> Result<Option<Sky>, Problem> {
    let given = desc.sky.as_ref();
    given.map(|sky| sky.get_ref().compile(sky.span())).transpose()
}

/// The rotation of an environment map to the world.
fn rotation(environment: &EnvironmentDesc) -> DMat3 {
    environment.rotate.map_or(DMat3::IDENTITY, |r| transform::rotation(r.0))
}

/// The light of an environment map with the rotation of this background.
pub(super) fn rotated(radiance: &BackgroundRadiance, desc: &BackgroundDesc) -> BackgroundRadiance {
    let given = desc.environment.as_ref();
    radiance.rotated(given.map_or(DMat3::IDENTITY, |given| rotation(given.get_ref())))
}

/// The background with this light, in a working space.
pub(super) fn with_radiance(
    desc: &BackgroundDesc,
    radiance: BackgroundRadiance,
    working_space: WorkingSpace,
) -> Background {
    Background {
        radiance,
        visible: desc.visible,
        backdrop: desc.backdrop.map(|color| working_space.from_rec709(color.0)),
    }
}

/// The background in a working space; `picture` is the image of its environment map.
pub(super) fn light(
    desc: &BackgroundDesc,
    (sky, picture): (Option<&Sky>, Option<&Bitmap>),
    working_space: WorkingSpace,
    warnings: &Warnings,
) -> BackgroundLight {
    let Some(sky) = sky else {
        return BackgroundLight {
            radiance: radiance(desc, picture, working_space, warnings),
            sun: None,
        };
    };
    let (environment, sun) = sky.bake(working_space);
    BackgroundLight {
        radiance: BackgroundRadiance::environment(environment),
        sun: Some(sun.with_camera().into_light()),
    }
}

fn radiance(
    desc: &BackgroundDesc,
    picture: Option<&Bitmap>,
    working_space: WorkingSpace,
    warnings: &Warnings,
) -> BackgroundRadiance {
    if let Some(gradient) = &desc.gradient {
        return BackgroundRadiance::Gradient(gradient.get_ref().compile(working_space));
    }
    let (Some(environment_desc), Some(picture)) = (&desc.environment, picture) else {
        let color = desc.color.map_or(Rgb::BLACK, |c| c.0);
        return BackgroundRadiance::Color(working_space.from_rec709(color));
    };
    let environment_desc = environment_desc.get_ref();
    let rotation = rotation(environment_desc);
    let environment = Environment::new(picture, working_space, environment_desc.intensity.0, rotation);
    let file = environment_desc.file.get_ref();
    if environment.clamped > 0 {
        let count = environment.clamped;
        let texels = if count == 1 { "texel" } else { "texels" };
        let text = format!("{count} {texels} below 0 became 0: {file}");
        warnings.add_topic(WarningKind::IMAGE_NUMBERS, "below 0", file, text);
    }
    BackgroundRadiance::environment(environment)
}
