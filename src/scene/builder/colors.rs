//! Conversion of all colours of a scene to its working space.
//!
//! Each kind converts its own colours; those of vertices are converted here.

use super::SceneBuilder;
use crate::{
    math::{Rgb, Vec4, WorkingSpace},
    texture::BitmapId,
};

impl SceneBuilder {
    /// Converts the colours of materials, textures, lights and vertices from Rec. 709 to a working space; the caller converts
    /// those of the background. `is_color` tells whether a bitmap holds colours or data.
    pub fn convert_colors(&mut self, space: WorkingSpace, is_color: impl Fn(BitmapId) -> bool) {
        if space == WorkingSpace::Rec709 {
            return;
        }
        for material in &mut self.materials {
            material.convert_colors(space);
        }
        for texture in &mut self.textures {
            texture.pattern.convert_colors(space, &is_color);
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
}

#[cfg(test)]
mod tests;
