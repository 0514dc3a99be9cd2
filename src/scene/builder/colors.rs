//! Conversion of all colours of a scene to its working space.
//!
//! Each kind converts its own colours; those of vertices are converted here.

use super::SceneBuilder;
use crate::{
    material::Material,
    math::{ColorConversion, Primaries, Rgb, Vec4, WorkingSpace},
    texture::BitmapId,
};

impl SceneBuilder {
    /// Converts the colours of materials, textures, lights and vertices to a working space: those of bitmaps from
    /// their own primaries, all others from Rec. 709. The caller converts those of the background. `is_color` tells
    /// whether a bitmap holds colours or data.
    pub fn convert_colors(&mut self, space: WorkingSpace, is_color: impl Fn(BitmapId) -> bool) {
        self.convert_textures(space, is_color);
        if space == WorkingSpace::Rec709 {
            return;
        }
        for material in &mut self.materials {
            material.convert_colors(space);
        }
        for light in &mut self.lights {
            light.convert_colors(space);
        }
        let vertices = self.meshes.iter_mut().flat_map(|mesh| &mut mesh.colors);
        for color in vertices.chain(&mut self.shape_colors) {
            let [r, g, b, opacity] = color.to_array();
            let [r, g, b] = space.from_rec709(Rgb::new(r, g, b)).to_array();
            *color = Vec4::new(r, g, b, opacity);
        }
    }

    /// Converts the textures; data are not converted, see [`Texture::colors`](crate::texture::Texture::colors).
    fn convert_textures(&mut self, space: WorkingSpace, is_color: impl Fn(BitmapId) -> bool) {
        for texture in &mut self.textures {
            let Some(id) = texture.pattern.bitmap() else {
                texture.colors = ColorConversion::new(Primaries::default(), space);
                continue;
            };
            let bitmap = &self.bitmaps[id.0 as usize];
            if is_color(id) {
                texture.colors = ColorConversion::new(bitmap.primaries, space);
                texture.rec709 = ColorConversion::new(bitmap.primaries, WorkingSpace::Rec709);
            }
            if bitmap.negative > 0 {
                texture.colors = texture.colors.clamped();
                texture.rec709 = texture.rec709.clamped();
            }
        }
    }

    /// The bitmaps whose alpha is the opacity of a material.
    pub fn opacity_bitmaps(&self) -> Vec<BitmapId> {
        let textures = self.materials.iter().filter_map(Material::opacity_texture);
        textures
            .filter_map(|id| self.textures[id.0 as usize].pattern.bitmap())
            .collect()
    }
}

#[cfg(test)]
mod tests;
