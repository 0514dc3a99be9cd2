//! Conversion of all colours of a scene to its working space.
//!
//! Reflectances, radiances and tints are converted as they are, absorption by the light that is left where the strongest channel
//! has lost all but 1/e of it, measured metals by their reflectances at normal incidence and at 82 degrees. Numbers that are
//! no colours stay: roughness, indices of refraction, thin films.

use super::SceneBuilder;
use crate::{
    light::Light,
    material::{Material, metal::MetalColor},
    math::{Rgb, Vec4, WorkingSpace, exponential},
    texture::{BitmapId, Color, Pattern},
};

impl SceneBuilder {
    /// Converts the colours of materials, textures, lights and vertices from Rec. 709 to a working space; those of the background
    /// are the caller's. `is_color` tells whether a bitmap holds colours, and not data.
    pub fn convert_colors(&mut self, space: WorkingSpace, is_color: impl Fn(BitmapId) -> bool) {
        if space == WorkingSpace::Rec709 {
            return;
        }
        let convert = |color: &mut Rgb| *color = space.from_rec709(*color);
        for material in &mut self.materials {
            convert_material(material, space);
        }
        for texture in &mut self.textures {
            match &mut texture.pattern {
                Pattern::Constant(constant) => convert(&mut constant.color),
                Pattern::Checker(checker) => checker.colors.iter_mut().for_each(convert),
                Pattern::Stripes(stripes) => stripes.colors.iter_mut().for_each(convert),
                Pattern::Image(image) if is_color(image.bitmap) => image.working_space = space,
                Pattern::Image(_) => {}
            }
        }
        for light in &mut self.lights {
            match light {
                Light::Point(light) => convert(&mut light.intensity),
                Light::Spot(light) => convert(&mut light.intensity),
                Light::Sun(light) => convert(&mut light.irradiance),
            }
        }
        let vertices = self.meshes.iter_mut().flat_map(|mesh| &mut mesh.colors);
        for color in vertices.chain(&mut self.shape_colors) {
            let [r, g, b, opacity] = color.to_array();
            let [r, g, b] = space.from_rec709(Rgb::new(r, g, b)).to_array();
            *color = Vec4::new(r, g, b, opacity);
        }
    }
}

fn convert_material(material: &mut Material, space: WorkingSpace) {
    let convert = |color: &mut Rgb| *color = space.from_rec709(*color);
    let convert_color = |color: &mut Color| match color {
        Color::Constant(color) | Color::Tinted(_, color) => convert(color),
        Color::Texture(_) => {}
    };
    match material {
        Material::Phong(phong) => {
            convert_color(&mut phong.color);
            [&mut phong.specular, &mut phong.reflect, &mut phong.transmit]
                .into_iter()
                .for_each(convert);
        }
        Material::Matte(matte) => convert_color(&mut matte.albedo),
        Material::Mirror(mirror) => convert(&mut mirror.reflectance),
        Material::Emitter(emitter) => convert_color(&mut emitter.radiance),
        Material::Glass(glass) => {
            convert(&mut glass.reflectance);
            convert(&mut glass.transmittance);
            glass.absorption = converted_absorption(glass.absorption, space);
        }
        Material::Metal(metal) => match &mut metal.color {
            MetalColor::Measured(reflectance) => *reflectance = reflectance.converted(|c| space.from_rec709(c)),
            MetalColor::Colored { color, edge } => {
                convert_color(color);
                convert(edge);
            }
        },
        Material::Principled(principled) => {
            for color in [
                &mut principled.base_color,
                &mut principled.specular_color,
                &mut principled.diffuse_transmission_color,
                &mut principled.sheen_color,
                &mut principled.emissive,
            ] {
                convert_color(color);
            }
            principled.absorption = converted_absorption(principled.absorption, space);
        }
    }
}

/// The absorption coefficient, in m^-1, that colours white light in the same way.
fn converted_absorption(absorption: Rgb, space: WorkingSpace) -> Rgb {
    let strongest = absorption.max_component();
    if strongest <= 0.0 || !strongest.is_finite() {
        return absorption;
    }
    let distance = strongest.recip();
    let left = absorption.map(|a| exponential::exp(-a * distance));
    space
        .from_rec709(left)
        .map(|left| (-exponential::ln(left) / distance).max(0.0))
}
