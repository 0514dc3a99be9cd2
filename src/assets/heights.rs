//! The heights of a displacement at the vertices of a model.

use super::{
    Files, MemoryBudget,
    displacement::{Displacement, Heights},
    image::{EncodedImage, ImageError, ImageRequest},
    model::ImageSource,
};
use crate::{
    math::{DVec3, Vec2, Vec3},
    texture::{Bitmap, TextureId, TexturePoint, Textures},
};

/// A displacement with its picture.
#[derive(Debug)]
pub struct LoadedDisplacement<'a> {
    displacement: &'a Displacement,
    bitmaps: Vec<Bitmap>,
}

impl Displacement {
    /// Reads its picture.
    pub fn load(&self, files: &Files) -> Result<LoadedDisplacement<'_>, ImageError> {
        let mut bitmaps = Vec::new();
        if let Heights::Texture(heights) = &self.heights
            && let Some((path, space)) = &heights.image
        {
            let request = ImageRequest::new(ImageSource::File(path.clone()), *space);
            let image = EncodedImage::read(&request, files)?;
            // The picture is dropped afterwards, so its memory is only checked.
            image.check(files.memory())?;
            bitmaps.push(image.decode(0, &MemoryBudget::default())?);
        }
        Ok(LoadedDisplacement {
            displacement: self,
            bitmaps,
        })
    }
}

impl LoadedDisplacement<'_> {
    /// Whether it reads texture coordinates.
    pub fn reads_uvs(&self) -> bool {
        match &self.displacement.heights {
            Heights::Constant(_) => false,
            Heights::Texture(heights) => heights.texture.mapping.reads_uvs(),
        }
    }

    /// The distance by which a vertex at `p` in the space of the model moves, with these texture
    /// coordinates relative to `uv_origin`.
    pub fn at(&self, p: DVec3, uv: Vec2, uv_origin: Vec2) -> f64 {
        let Displacement {
            heights,
            scale,
            midlevel,
        } = self.displacement;
        let height = match heights {
            Heights::Constant(height) => height.get(),
            Heights::Texture(heights) => {
                let point = TexturePoint {
                    uv,
                    uv_origin,
                    ..TexturePoint::new(p.as_vec3(), Vec3::Y)
                };
                let textures = Textures {
                    textures: std::slice::from_ref(&heights.texture),
                    bitmaps: &self.bitmaps,
                };
                textures.channel(TextureId(0), heights.channel, &point)
            }
        };
        f64::from(scale.get()) * (f64::from(height) - f64::from(midlevel.get()))
    }
}
