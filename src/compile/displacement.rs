//! Compilation of displacements.

use std::cell::RefCell;

use super::{
    compiler::Compiler,
    textures::{self, TextureNames},
};
use crate::{
    assets::displacement::{Displacement, HeightTexture, Heights},
    math::DVec3,
    shape::mesh::{Bits, DisplacementDesc, MeshDesc},
    texture::{BitmapId, Color, FindSources, image::ImageDesc},
    value::{Channel, ColorSource, Problem, ScalarSource, Spanned},
};

impl Compiler<'_> {
    /// The displacement of a mesh, if it has one; `None` if it is wrong.
    pub(super) fn displacement_of(&mut self, mesh: &MeshDesc) -> Option<Option<Displacement>> {
        let Some(desc) = &mesh.displacement else {
            return Some(None);
        };
        let DisplacementDesc {
            height,
            scale,
            midlevel,
        } = desc;
        let heights = match height.get_ref() {
            ScalarSource::Constant(height) => Ok(Heights::Constant(Bits::new(*height))),
            ScalarSource::Texture { name, channel } => self.height_texture(height, name, channel.unwrap_or(Channel::R)),
        };
        match heights {
            Ok(heights) => Some(Some(Displacement {
                heights,
                scale: Bits::new(scale.0),
                midlevel: Bits::new(midlevel.0),
            })),
            Err(problems) => {
                self.problems.extend(problems);
                None
            }
        }
    }

    fn height_texture(
        &self,
        source: &Spanned<ScalarSource>,
        name: &str,
        channel: Channel,
    ) -> Result<Heights, Vec<Problem>> {
        let entry = TextureNames::new(self.desc).entry(name, source.span());
        let (_, entry) = entry.map_err(|problem| vec![problem])?;
        if !entry.mapping.lies_on_mesh() {
            let message = format!("the texture `{name}` does not lie on the mesh, as a displacement needs it");
            let help = "its `mapping` may be `uv`, `object` or `planar`";
            return Err(vec![Problem::at(source.span(), message).with_help(help)]);
        }
        let image = RefCell::new(None);
        let find = |desc: &ImageDesc| {
            *image.borrow_mut() = Some((self.desc.folder().join(desc.file.get_ref()), desc.color_space));
            Ok(BitmapId(0))
        };
        let color = |color: &Spanned<ColorSource>| match color.get_ref() {
            ColorSource::Constant(color) => Ok(Color::Constant(*color)),
            ColorSource::Texture(_) | ColorSource::Tinted { .. } => {
                let message = format!("`{name}` reads other textures, and a displacement reads a texture alone");
                Err(Problem::at(source.span(), message))
            }
        };
        let find = FindSources {
            bitmap: &find,
            color: &color,
        };
        let texture = textures::compile(entry, &find, DVec3::ZERO)?;
        let image = image.into_inner();
        let heights = HeightTexture::new(texture.prepared(), channel, image);
        Ok(Heights::Texture(Box::new(heights)))
    }
}
