//! The textures of a principled material.

use super::Principled;
use crate::{
    material::MaterialKind,
    math::Rgb,
    texture::{Color, Scalar, TextureId, TexturePoint, Textures},
};

impl Principled {
    /// A diffuse surface without any shine.
    pub fn matte(base_color: Color) -> Self {
        Self {
            base_color,
            roughness: Scalar::Constant(1.0),
            specular: Scalar::Constant(0.0),
            ..Self::default()
        }
    }

    /// The colour of a surface that [`Principled::matte`] makes; `None` of any other.
    pub fn matte_color(&self) -> Option<Color> {
        let Self {
            metallic: Scalar::Constant(0.0),
            specular: Scalar::Constant(0.0),
            transmission: Scalar::Constant(0.0),
            diffuse_transmission: Scalar::Constant(0.0),
            clearcoat: Scalar::Constant(0.0),
            normal: None,
            heights: None,
            reads_vertices: false,
            ..
        } = self
        else {
            return None;
        };
        let black = |c: &Color| matches!(c, Color::Constant(c) if c.is_black());
        let is_plain = black(&self.sheen_color) && self.emission().is_none() && self.is_opaque();
        is_plain.then_some(self.base_color)
    }

    pub(super) fn base_color(&self, textures: &Textures<'_>, at: &TexturePoint) -> Rgb {
        let color = textures.color(&self.base_color, at);
        if self.reads_vertices {
            color * at.vertex.color
        } else {
            color
        }
    }

    /// The same material with every texture replaced by the one that `find` returns for it.
    pub fn map_textures(mut self, find: impl Fn(TextureId) -> TextureId) -> Self {
        let (colors, scalars) = self.sources_mut();
        for color in colors {
            match color {
                Color::Constant(_) => {}
                Color::Texture(id) | Color::Tinted(id, _) => *id = find(*id),
            }
        }
        for scalar in scalars {
            match scalar {
                Scalar::Constant(_) => {}
                Scalar::Texture(id, ..) | Scalar::Inverted(id, ..) => *id = find(*id),
            }
        }
        let coat = self.clearcoat_normal.as_mut().map(|map| &mut map.color);
        let maps = [self.normal.as_mut(), coat, self.anisotropy_direction.as_mut()];
        for map in maps.into_iter().flatten() {
            if let Color::Texture(id) | Color::Tinted(id, _) = map {
                *id = find(*id);
            }
        }
        if let Some(heights) = &mut self.heights {
            heights.texture = find(heights.texture);
        }
        self
    }

    /// The maps of normals and directions.
    pub fn maps(&self) -> impl Iterator<Item = &Color> {
        let coat = self.clearcoat_normal.as_ref().map(|map| &map.color);
        let maps = [self.normal.as_ref(), coat, self.anisotropy_direction.as_ref()];
        maps.into_iter().flatten()
    }

    /// All colours and numbers but the maps.
    pub(super) fn sources(&self) -> ([&Color; 5], [&Scalar; 12]) {
        let colors = [
            &self.base_color,
            &self.specular_color,
            &self.sheen_color,
            &self.diffuse_transmission_color,
            &self.emissive,
        ];
        let scalars = [
            &self.metallic,
            &self.roughness,
            &self.specular,
            &self.transmission,
            &self.diffuse_transmission,
            &self.clearcoat,
            &self.clearcoat_roughness,
            &self.sheen_roughness,
            &self.iridescence,
            &self.iridescence_place,
            &self.anisotropy,
            &self.opacity,
        ];
        (colors, scalars)
    }

    pub(super) fn sources_mut(&mut self) -> ([&mut Color; 5], [&mut Scalar; 12]) {
        let colors = [
            &mut self.base_color,
            &mut self.specular_color,
            &mut self.sheen_color,
            &mut self.diffuse_transmission_color,
            &mut self.emissive,
        ];
        let scalars = [
            &mut self.metallic,
            &mut self.roughness,
            &mut self.specular,
            &mut self.transmission,
            &mut self.diffuse_transmission,
            &mut self.clearcoat,
            &mut self.clearcoat_roughness,
            &mut self.sheen_roughness,
            &mut self.iridescence,
            &mut self.iridescence_place,
            &mut self.anisotropy,
            &mut self.opacity,
        ];
        (colors, scalars)
    }
}
