//! What lies behind everything: a colour, or a picture from a file.

use super::Compiler;
use crate::{
    assets::{model::ImageSource, store::ImageRequest},
    describe::BackgroundDesc,
    light::environment::Environment,
    math::{DMat3, Rgb, transform::axis_rotation},
    scene::Sky,
    texture::{Bitmap, bitmap::ColorSpace},
    value::Problem,
};

impl Compiler<'_> {
    /// The picture that the background wants.
    pub(super) fn environment(&mut self) -> Option<ImageRequest> {
        let background = &self.desc.background;
        let environment = background.environment.as_ref()?;
        if background.color.is_some() {
            let message = "`color` and `environment` are both given";
            self.problems.push(Problem::at(environment.span(), message));
        }
        let file = self.desc.folder().join(environment.get_ref().file.get_ref());
        Some((ImageSource::File(file), ColorSpace::Srgb))
    }
}

/// The background, which takes the last of `bitmaps` if it wanted one.
pub(super) fn sky(desc: &BackgroundDesc, bitmaps: &mut Vec<Bitmap>) -> Sky {
    let Some(said) = &desc.environment else {
        return Sky::Color(desc.color.map_or(Rgb::BLACK, |c| c.0));
    };
    let said = said.get_ref();
    let picture = bitmaps.pop().expect("the picture was the last that was loaded");
    let rotation = said.rotate.map_or(DMat3::IDENTITY, |r| {
        let r = r.0.as_dvec3();
        axis_rotation(2, r.z) * axis_rotation(1, r.y) * axis_rotation(0, r.x)
    });
    let environment = Environment::new(&picture, said.intensity.0, rotation);
    let file = said.file.get_ref();
    if picture.repaired > 0 {
        let count = picture.repaired;
        let are = if count == 1 {
            "number that is"
        } else {
            "numbers that are"
        };
        tracing::warn!("{count} {are} not finite became 0 or 65504: {file}");
    }
    if environment.clamped > 0 {
        let count = environment.clamped;
        let texels = if count == 1 { "texel" } else { "texels" };
        tracing::warn!("{count} {texels} below 0 became 0: {file}");
    }
    Sky::environment(environment)
}
