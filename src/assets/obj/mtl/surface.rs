//! The surface of a material, from its statements.
//!
//! Sources: Alias|Wavefront, "Advanced Visualizer Manual", appendix B1 (MTL); Exocortex, "Extending Wavefront MTL for
//! Physically-Based Rendering".

use std::f32::consts::TAU;

use super::{
    statements::{Number, Slot, Statements, Tint},
    textures::Textures,
};
use crate::{
    assets::{model::Treatment, obj::ObjError},
    bsdf::layered::Boundary,
    material::{HeightMap, Sidedness, principled::Principled},
    math::Rgb,
    texture::{Color, Scalar, TextureId, bitmap::ColorSpace},
    value::Channel,
};

/// The grey of surfaces without a material.
pub(super) const GRAY: f32 = 0.8;
/// An index of refraction with nearly total reflection at normal incidence.
const MIRROR_IOR: f32 = 1e4;
/// The default of `Ni`.
const IOR: f32 = 1.5;
/// The largest plausible index of refraction.
const MAX_IOR: f32 = 10.0;
/// The roughness without `Ns` and `Pr`.
const ROUGHNESS: f32 = 0.5;

/// Converts the statements of a material.
pub(super) struct Reader<'a, 'b> {
    pub material: &'a Statements,
    pub textures: Textures<'a, 'b>,
}

impl Reader<'_, '_> {
    /// The surface; matte if only its colour is given.
    ///
    /// # Errors
    /// A texture is outside of the model's folder.
    pub fn surface(&mut self, has_colors: bool) -> Result<Principled, ObjError> {
        let base_color = self.base_color(has_colors)?;
        let mut surface = Principled::matte(base_color);
        self.reflection(&mut surface)?;
        self.metal(&mut surface)?;
        self.layers(&mut surface)?;
        if let Some(emitted) = self.color(Slot::Ke, Tint::Ke, None)? {
            surface.emissive = emitted;
            // Faces of OBJ files are two-sided.
            surface.sidedness = Sidedness::Both;
        }
        self.transparency(&mut surface)?;
        self.relief(&mut surface)?;
        for name in &self.material.unsupported {
            self.textures.report(name, "material", Treatment::Without(""));
        }
        surface.reads_vertices = has_colors;
        Ok(surface)
    }

    /// A colour times a texture; `None` if there is neither. Exporters write black for a colour that a texture replaces.
    fn color(&mut self, slot: Slot, tint: Tint, otherwise: Option<Rgb>) -> Result<Option<Color>, ObjError> {
        let factor = self.material.tint(tint).or(otherwise);
        if let Some(map) = self.material.map(slot)
            && let Some(id) = self.textures.place(map, ColorSpace::Srgb)?
        {
            let factor = factor.filter(|c| !c.is_black()).unwrap_or(Rgb::WHITE);
            return Ok(Some(Color::Tinted(id, factor * map.gain)));
        }
        Ok(factor.filter(|c| !c.is_black()).map(Color::Constant))
    }

    /// `norm`, or else `bump`, which contains heights or, from some exporters, normals.
    fn relief(&mut self, surface: &mut Principled) -> Result<(), ObjError> {
        let bump = self.material.map(Slot::Bump);
        let normals = match (self.material.map(Slot::Norm), bump) {
            (Some(norm), bump) => {
                if bump.is_some() {
                    let how = Treatment::Without("the normal map beside it is shown");
                    self.textures.report("bump", "material", how);
                }
                Some(norm)
            }
            (None, Some(bump)) if self.textures.holds_normals(bump)? => Some(bump),
            _ => None,
        };
        if let Some(map) = normals {
            if let Some(id) = self.textures.place(map, ColorSpace::Raw)? {
                surface.normal = Some(Color::Texture(id));
                surface.normal_scale = map.strength;
            }
        } else if let Some(map) = bump
            && let Some(texture) = self.textures.place(map, ColorSpace::Raw)?
        {
            let (channel, scale) = (map.channel, map.strength * map.gain);
            surface.heights = Some(HeightMap {
                texture,
                channel,
                scale,
            });
        }
        Ok(())
    }

    fn base_color(&mut self, has_colors: bool) -> Result<Color, ObjError> {
        let plain = Rgb::gray(if has_colors { 1.0 } else { GRAY });
        let color = self.color(Slot::Kd, Tint::Kd, Some(plain))?;
        // A black `Kd` with a missing texture is only a placeholder.
        let black = match self.material.map(Slot::Kd) {
            Some(_) => plain,
            None => Rgb::BLACK,
        };
        Ok(color.unwrap_or(Color::Constant(black)))
    }

    /// A channel of a texture times `factor` and the texture's gain.
    fn channel(&mut self, slot: Slot, channel: Channel, factor: f32) -> Result<Option<Scalar>, ObjError> {
        let Some(map) = self.material.map(slot) else {
            return Ok(None);
        };
        let id = self.textures.place(map, ColorSpace::Raw)?;
        let channel = map.channel.unwrap_or(channel);
        Ok(id.map(|id| Scalar::Texture(id, channel, factor * map.gain)))
    }

    /// A texture, or else a number from 0 to 1. The number is ignored if there is a texture, because exporters do not set it then.
    fn unit(&mut self, slot: Slot, number: Number) -> Result<Option<Scalar>, ObjError> {
        let value = self.material.number(number);
        let map = self.channel(slot, Channel::R, 1.0)?;
        Ok(map.or(value.map(|v| Scalar::Constant(v.clamp(0.0, 1.0)))))
    }

    fn illum(&self) -> Option<i32> {
        self.material.number(Number::Illum).map(|v| v as i32)
    }

    /// `Ni` if it is above 1: exporters also write 1 for reflecting surfaces.
    fn ior(&self) -> Option<f32> {
        let ior = self.material.number(Number::Ni)?;
        (ior > 1.0).then_some(ior.min(MAX_IOR))
    }

    /// `Ks` and `Ns`, unless `illum` is 0 or 1.
    fn reflection(&mut self, surface: &mut Principled) -> Result<(), ObjError> {
        if matches!(self.illum(), Some(0 | 1)) {
            return Ok(());
        }
        let Some(color) = self.color(Slot::Ks, Tint::Ks, None)? else {
            return Ok(());
        };
        surface.specular = Scalar::Constant(1.0);
        surface.specular_color = match color {
            Color::Constant(c) => Color::Constant(c.map(|v| v.min(1.0))),
            texture => texture,
        };
        surface.roughness = self.shininess()?;
        surface.ior = match (self.illum(), self.ior()) {
            (Some(3 | 8), _) | (Some(5), None) => MIRROR_IOR,
            (_, ior) => ior.unwrap_or(IOR),
        };
        Ok(())
    }

    /// The roughness of a Phong exponent.
    ///
    /// Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007, section 5.2,
    /// doi:10.2312/EGWR/EGSR07/195-206: alpha^2 = 2 / (Ns + 2).
    fn shininess(&mut self) -> Result<Scalar, ObjError> {
        let of = |ns: f32| (2.0 / (ns.max(0.0) + 2.0)).sqrt().sqrt();
        let roughness = self.material.number(Number::Ns).map_or(ROUGHNESS, of);
        let Some(Scalar::Texture(id, channel, gloss)) = self.channel(Slot::Ns, Channel::R, 1.0 - roughness)? else {
            return Ok(Scalar::Constant(roughness));
        };
        let how = Treatment::InPart("exponents between 0 and Ns are approximate");
        self.textures.report("map_Ns", "material", how);
        Ok(Scalar::Inverted(id, channel, gloss))
    }

    /// `Pr` and `Pm`, in place of `Ks`.
    fn metal(&mut self, surface: &mut Principled) -> Result<(), ObjError> {
        let (roughness, metallic) = (self.unit(Slot::Pr, Number::Pr)?, self.unit(Slot::Pm, Number::Pm)?);
        if roughness.is_none() && metallic.is_none() {
            return Ok(());
        }
        if let Some(metallic) = metallic {
            surface.metallic = metallic;
        }
        surface.roughness = match roughness {
            Some(roughness) => roughness,
            None if self.material.number(Number::Ns).is_some() => self.shininess()?,
            None => Scalar::Constant(ROUGHNESS),
        };
        surface.specular = Scalar::Constant(1.0);
        surface.specular_color = Color::Constant(Rgb::WHITE);
        surface.ior = self.ior().unwrap_or(IOR);
        Ok(())
    }

    /// Sheen, clear coat and anisotropy.
    fn layers(&mut self, surface: &mut Principled) -> Result<(), ObjError> {
        if let Some(coat) = self.unit(Slot::Pc, Number::Pc)? {
            surface.clearcoat = coat;
        }
        if let Some(roughness) = self.unit(Slot::Pcr, Number::Pcr)? {
            surface.clearcoat_roughness = roughness;
        }
        let sheen = self.material.number(Number::Ps).map_or(0.0, |s| s.clamp(0.0, 1.0));
        let texture = match self.material.map(Slot::Ps) {
            Some(map) => self.textures.place(map, ColorSpace::Srgb)?.map(|id| (id, map.gain)),
            None => None,
        };
        surface.sheen_color = match texture {
            Some((id, gain)) => Color::Tinted(id, Rgb::gray(gain)),
            None => Color::Constant(Rgb::gray(sheen)),
        };
        if texture.is_some() || sheen > 0.0 {
            surface.sheen_roughness = Scalar::Constant(ROUGHNESS);
        }
        let stretch = self.material.number(Number::Aniso).unwrap_or(0.0).clamp(-1.0, 1.0);
        if stretch != 0.0 {
            let turns = self.material.number(Number::Anisor).unwrap_or(0.0);
            let turns = if stretch < 0.0 { turns + 0.25 } else { turns };
            surface.anisotropy = Scalar::Constant(stretch.abs());
            surface.anisotropy_rotation = turns * TAU;
        }
        Ok(())
    }

    /// `d`, or else 1 - `Tr`.
    fn dissolve(&self) -> f32 {
        let d = self.material.number(Number::D);
        let tr = || self.material.number(Number::Tr).map(|tr| 1.0 - tr);
        d.or_else(tr).unwrap_or(1.0).clamp(0.0, 1.0)
    }

    fn transparency(&mut self, surface: &mut Principled) -> Result<(), ObjError> {
        let dissolve = self.dissolve();
        let is_glass = self.glass(dissolve, surface);
        let factor = if is_glass { 1.0 } else { dissolve };
        let opacity = match self.dissolve_texture(Slot::D)? {
            Some((id, channel, gain)) => Some(Scalar::Texture(id, channel, factor * gain)),
            None => self
                .dissolve_texture(Slot::Tr)?
                .map(|(id, channel, gain)| Scalar::Inverted(id, channel, gain)),
        };
        surface.opacity = opacity.unwrap_or(Scalar::Constant(factor));
        Ok(())
    }

    /// The texture of the opacity, its channel (alpha if the picture has one) and gain.
    fn dissolve_texture(&mut self, slot: Slot) -> Result<Option<(TextureId, Channel, f32)>, ObjError> {
        let Some(map) = self.material.map(slot) else {
            return Ok(None);
        };
        let channel = match map.channel {
            Some(channel) => channel,
            None if self.textures.has_alpha(map)? => Channel::A,
            None => Channel::R,
        };
        // Alpha is the same in both colour spaces, so the picture of the base colour can be shared.
        let space = match channel {
            Channel::A => ColorSpace::Srgb,
            _ => ColorSpace::Raw,
        };
        let id = self.textures.place(map, space)?;
        Ok(id.map(|id| (id, channel, map.gain)))
    }

    /// Makes the surface glass if `illum` says so and another statement makes it transparent; returns whether it did. Exporters
    /// also write `illum 4` and `Tf 1 1 1` for opaque surfaces.
    fn glass(&self, dissolve: f32, surface: &mut Principled) -> bool {
        let boundary = match self.illum() {
            Some(6 | 7) => Boundary::Solid,
            Some(4 | 9) => Boundary::ThinWalled,
            _ => return false,
        };
        let filter = self.material.tint(Tint::Tf);
        let is_colored = filter.is_some_and(|c| c != Rgb::WHITE);
        let is_clear = dissolve < 1.0 || self.ior().is_some() || is_colored;
        if !is_clear || filter.is_some_and(Rgb::is_black) {
            return false;
        }
        let has_base = !matches!(surface.base_color, Color::Constant(c) if c.is_black());
        let clear = if has_base && dissolve < 1.0 {
            1.0 - dissolve
        } else {
            1.0
        };
        surface.transmission = Scalar::Constant(clear);
        if clear == 1.0 {
            let own = if has_base {
                surface.base_color
            } else {
                Color::Constant(Rgb::WHITE)
            };
            surface.base_color = filter.map_or(own, |c| Color::Constant(c.map(|v| v.min(1.0))));
        }
        surface.boundary = boundary;
        surface.ior = match self.material.number(Number::Ni) {
            Some(ni) => ni.clamp(1.0, MAX_IOR),
            None => IOR,
        };
        if surface.specular == Scalar::Constant(0.0) {
            surface.specular = Scalar::Constant(1.0);
        }
        if self.material.number(Number::Pr).is_none() && self.material.map(Slot::Pr).is_none() {
            // MTL refracts sharply, whatever the roughness of highlights.
            surface.roughness = Scalar::Constant(0.0);
        }
        true
    }
}
