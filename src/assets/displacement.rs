//! Heights of a texture, by which the vertices of a model are moved along its normals.

use std::{cmp::Ordering, hash, path::PathBuf};

use crate::{
    shape::mesh::Bits,
    texture::{Texture, bitmap::ColorSpace},
    value::Channel,
};

/// A texture of heights, by texture coordinates or by the place in the model. It is compared by its
/// text, which has all of its numbers.
#[derive(Clone, Debug)]
pub struct HeightTexture {
    /// Its bitmap is number 0.
    pub(super) texture: Texture,
    pub(super) channel: Channel,
    pub(super) image: Option<(PathBuf, ColorSpace)>,
    text: String,
}

impl HeightTexture {
    /// A texture whose bitmap, if it has one, is number 0, and is that of this file.
    pub fn new(texture: Texture, channel: Channel, image: Option<(PathBuf, ColorSpace)>) -> Self {
        Self {
            text: format!("{texture:?} {channel:?} {image:?}"),
            texture,
            channel,
            image,
        }
    }
}

impl PartialEq for HeightTexture {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl Eq for HeightTexture {}

impl PartialOrd for HeightTexture {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for HeightTexture {
    fn cmp(&self, other: &Self) -> Ordering {
        self.text.cmp(&other.text)
    }
}

impl hash::Hash for HeightTexture {
    fn hash<H: hash::Hasher>(&self, state: &mut H) {
        self.text.hash(state);
    }
}

/// The heights of a displacement.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Heights {
    Constant(Bits),
    Texture(Box<HeightTexture>),
}

/// A displacement of the vertices of a model along its normals: `scale` times the height less `midlevel`, in the space of the mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Displacement {
    pub heights: Heights,
    pub scale: Bits,
    pub midlevel: Bits,
}
