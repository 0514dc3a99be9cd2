//! Textures of a scene file.

use std::cell::RefCell;

use super::compiler::{Compiler, undefined};
use crate::{
    assets::{model::ImageSource, store::ImageRequest},
    describe::{SceneDesc, TextureEntry},
    math::Rgb,
    texture::{BitmapId, Color, FindSources, Texture, TextureId, image::ImageDesc},
    value::{ColorSource, Problem, Spanned},
};

/// Look-ups of textures, itself among them, that one look-up makes at most.
const MOST_LOOKUPS: u64 = 1000;

impl Compiler<'_> {
    pub(super) fn textures(&mut self) {
        let folder = self.desc.folder();
        for entry in &self.desc.textures {
            let images = RefCell::new(&mut self.images);
            let bitmap = |image: &ImageDesc| {
                let file = ImageSource::File(folder.join(image.file.get_ref()));
                let request = ImageRequest::new(file, image.color_space);
                let mut images = images.borrow_mut();
                let at = images.iter().position(|i| *i == request).unwrap_or_else(|| {
                    images.push(request);
                    images.len() - 1
                });
                Ok(BitmapId(at as u32))
            };
            let desc = self.desc;
            let find = FindSources {
                bitmap: &bitmap,
                color: &|source| color(desc, source),
            };
            let pattern = entry.pattern.compile(&find);
            let warp = entry.warp.as_ref().map(|warp| warp.compile(&find)).transpose();
            let mapping = entry.mapping.compile(self.origin);
            let (pattern, warp, mapping) = (self.record(pattern), self.record(warp), self.record(mapping));
            if let (Some(pattern), Some(warp), Some(mapping)) = (pattern, warp, mapping) {
                self.scene.texture(Texture {
                    transform: entry.transform.compile(),
                    warp,
                    factor: entry.factor.map_or(Rgb::WHITE, |factor| factor.0),
                    ..Texture::new(mapping, pattern)
                });
            }
        }
        if self.problems.is_empty() {
            self.problems.extend(self.circle());
        }
    }

    /// The problem of the first texture that contains itself, or that looks up too many others.
    fn circle(&self) -> Option<Problem> {
        let textures = self.scene.textures().textures;
        let mut lookups = vec![Lookups::Unknown; textures.len()];
        let wrong = (0..textures.len()).find_map(|id| match count(textures, id, &mut lookups) {
            Some(n) if n <= MOST_LOOKUPS => None,
            Some(_) => Some((
                id,
                format!("a look-up in this texture makes more than {MOST_LOOKUPS} look-ups in others"),
            )),
            None => Some((id, "this texture contains itself".to_owned())),
        });
        let (id, message) = wrong?;
        Some(Problem::at(self.desc.textures[id].name.span(), message))
    }
}

/// The number of look-ups that one in a texture makes.
#[derive(Clone, Copy)]
enum Lookups {
    Unknown,
    /// The look-ups of its sources are being counted.
    Counting,
    Known(u64),
}

/// Counts the look-ups of a texture; `None` where it contains itself.
fn count(textures: &[Texture], id: usize, lookups: &mut [Lookups]) -> Option<u64> {
    match lookups[id] {
        Lookups::Known(n) => return Some(n),
        Lookups::Counting => return None,
        Lookups::Unknown => lookups[id] = Lookups::Counting,
    }
    let mut sum: u64 = 1;
    for source in textures[id].sources() {
        sum = sum.saturating_add(count(textures, source.0 as usize, lookups)?);
    }
    lookups[id] = Lookups::Known(sum);
    Some(sum)
}

/// The colour of a source of the scene file.
pub(super) fn color(desc: &SceneDesc, source: &Spanned<ColorSource>) -> Result<Color, Problem> {
    let texture = |name: &str| {
        let is_it = |entry: &TextureEntry| entry.name.get_ref() == name;
        match desc.textures.iter().position(is_it) {
            Some(id) => Ok(TextureId(id as u32)),
            None => {
                let known = desc.textures.iter().map(|t| &t.name);
                Err(undefined("texture", name, source.span(), known))
            }
        }
    };
    Ok(match source.get_ref() {
        ColorSource::Constant(color) => Color::Constant(*color),
        ColorSource::Texture(name) => Color::Texture(texture(name)?),
        ColorSource::Tinted { texture: name, tint } => Color::Tinted(texture(name)?, *tint),
    })
}
