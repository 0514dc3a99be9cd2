//! Textures of a scene file.

use std::{cell::RefCell, collections::HashMap};

use super::{
    compiler::{Compiler, undefined},
    nesting::Nesting,
};
use crate::{
    assets::{model::ImageSource, store::ImageRequest},
    describe::{SceneDesc, TextureEntry},
    math::{DVec3, Rgb},
    texture::{BitmapId, Color, FindSources, Texture, TextureId, image::ImageDesc},
    value::{ColorSource, Problem, Spanned},
};

/// Look-ups of textures, itself among them, that one look-up makes at most.
const MOST_LOOKUPS: u64 = 1000;

impl Compiler<'_> {
    pub(super) fn textures(&mut self) {
        let folder = self.desc.folder();
        let names = TextureNames::new(self.desc);
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
            let find = FindSources {
                bitmap: &bitmap,
                color: &|source| names.color(source),
            };
            match compile(entry, &find, self.origin) {
                Ok(texture) => {
                    self.scene.texture(texture);
                }
                Err(problems) => self.problems.extend(problems),
            }
        }
        if self.problems.is_empty() {
            self.problems.extend(self.tangled());
        }
    }

    /// The problem of the first texture that contains itself, or that looks up too many others.
    fn tangled(&self) -> Option<Problem> {
        let textures = self.scene.textures().textures;
        let mut nesting = Nesting::new(textures.len(), |id: usize| {
            textures[id].sources().map(|source| source.0 as usize)
        });
        (0..textures.len()).find_map(|id| {
            let message = match nesting.of(id) {
                Ok(sources) if sources.lookups <= MOST_LOOKUPS => return None,
                Ok(_) => format!("a look-up in this texture makes more than {MOST_LOOKUPS} look-ups in others"),
                Err(tangle) => tangle.message("texture", |id| self.desc.textures[id].name.get_ref()),
            };
            Some(Problem::at(self.desc.textures[id].name.span(), message))
        })
    }
}

/// Compiles a texture for a scene around `origin`.
pub(super) fn compile(entry: &TextureEntry, find: &FindSources<'_>, origin: DVec3) -> Result<Texture, Vec<Problem>> {
    let mut problems = Vec::new();
    let mut keep = |problem| problems.push(problem);
    let pattern = entry.pattern.compile(find).map_err(&mut keep).ok();
    let warp = entry.warp.as_ref().map(|warp| warp.compile(find)).transpose();
    let warp = warp.map_err(&mut keep).ok();
    let mapping = entry.mapping.compile(origin).map_err(&mut keep).ok();
    if let Some(key) = entry.placed_by.first()
        && !entry.pattern.has_coordinates()
    {
        let (key, kind, span) = (key.get_ref(), entry.pattern.name(), key.span());
        let problem = Problem::at(
            span,
            format!("`{kind}` has no coordinates of its own, and takes no `{key}`"),
        );
        keep(problem.with_help(format!("give `{key}` to the textures that it is made of")));
    }
    match (pattern, warp, mapping) {
        (Some(pattern), Some(warp), Some(mapping)) if problems.is_empty() => Ok(Texture {
            transform: entry.transform.compile(),
            warp,
            factor: entry.factor.map_or(Rgb::WHITE, |factor| factor.0),
            ..Texture::new(mapping, pattern)
        }),
        _ => Err(problems),
    }
}

/// The textures of a scene file by name.
pub(super) struct TextureNames<'a> {
    textures: &'a [TextureEntry],
    ids: HashMap<&'a str, u32>,
}

impl<'a> TextureNames<'a> {
    pub fn new(desc: &'a SceneDesc) -> Self {
        let names = desc.textures.iter().map(|entry| entry.name.get_ref().as_str());
        Self {
            textures: &desc.textures,
            ids: names.zip(0..).collect(),
        }
    }

    /// The texture of a name, which is at `span`.
    pub fn entry(&self, name: &str, span: std::ops::Range<usize>) -> Result<(TextureId, &'a TextureEntry), Problem> {
        match self.ids.get(name) {
            Some(&id) => Ok((TextureId(id), &self.textures[id as usize])),
            None => {
                let known = self.textures.iter().map(|entry| &entry.name);
                Err(undefined("texture", name, span, known))
            }
        }
    }

    /// The colour of a source.
    pub fn color(&self, source: &Spanned<ColorSource>) -> Result<Color, Problem> {
        let texture = |name: &str| self.entry(name, source.span()).map(|(id, _)| id);
        Ok(match source.get_ref() {
            ColorSource::Constant(color) => Color::Constant(*color),
            ColorSource::Texture(name) => Color::Texture(texture(name)?),
            ColorSource::Tinted { texture: name, tint } => Color::Tinted(texture(name)?, *tint),
        })
    }

    /// The colour of a source that holds directions along the tangents of a surface.
    pub fn directions(&self, source: &Spanned<ColorSource>) -> Result<Color, Problem> {
        if let ColorSource::Texture(name) | ColorSource::Tinted { texture: name, .. } = source.get_ref() {
            let (_, entry) = self.entry(name, source.span())?;
            let (flaw, help) = if !entry.pattern.has_coordinates() {
                (
                    "is made of other textures, and directions have tangents of their own in each",
                    "name a texture with coordinates of its own, or give the material a `bump` of heights",
                )
            } else if entry.mapping.has_sides() {
                (
                    "is mapped from three sides, and directions have tangents of their own on each",
                    "map it by `uv` or `planar`, or give the material a `bump` of heights",
                )
            } else {
                return self.color(source);
            };
            return Err(Problem::at(source.span(), format!("`{name}` {flaw}")).with_help(help));
        }
        self.color(source)
    }
}
