//! Compilation: a description and the files it names become a [`Scene`], flat and immutable.
//!
//! Every problem that a pass finds is reported together: first what contradicts itself or is not defined, then the
//! files that are missing or broken.

use std::{collections::HashMap, sync::Arc};

use crate::{
    accel::{self, BuildOptions},
    assets::{AssetError, Store, model::ImageSource, store::ImageRequest},
    describe::{Diagnostics, MaterialEntry, SceneDesc},
    material::{Material, MaterialId},
    scene::{Background, LightGroups, Lights, Scene},
    texture::{BitmapId, Color, Texture, TextureId, Textures, image::ImageDesc, mipmap},
    value::{ColorSource, Problem, Spanned, did_you_mean},
};

mod background;
mod meshes;
pub mod model;
mod objects;
mod place;
mod sharing;

pub use sharing::Sharing;

/// Why a description became no scene.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("{0}")]
    Invalid(Diagnostics),
    #[error("{}", lines(.0))]
    Assets(Vec<AssetError>),
    #[error(transparent)]
    Build(#[from] accel::BuildError),
}

fn lines(errors: &[AssetError]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Compiles a scene and builds its acceleration structure, on the threads of the current rayon pool.
pub fn scene(desc: &SceneDesc, accel: impl Into<BuildOptions>) -> Result<Scene, Error> {
    scene_with(desc, accel, &Store::default())
}

/// Compiles a scene of which some models are loaded already.
pub fn scene_with(desc: &SceneDesc, accel: impl Into<BuildOptions>, store: &Store) -> Result<Scene, Error> {
    scene_sharing(desc, accel, store, Sharing::default())
}

/// The same with a say in which meshes are instances.
pub fn scene_sharing(
    desc: &SceneDesc,
    accel: impl Into<BuildOptions>,
    store: &Store,
    sharing: Sharing,
) -> Result<Scene, Error> {
    let mut compiler = Compiler {
        desc,
        materials: desc
            .materials
            .iter()
            .zip(0..)
            .map(|(m, i)| (m.name.get_ref().as_str(), i))
            .collect(),
        problems: Vec::new(),
    };
    let (wanted, textures) = compiler.textures();
    let materials = compiler.materials();
    let objects::Objects {
        geometry,
        objects,
        shape_objects,
        meshes: placed,
    } = compiler.objects();
    let lights = desc
        .lights
        .iter()
        .filter_map(|l| compiler.keep(l.light.compile()))
        .collect();
    let environment = compiler.environment();
    if let Some(diagnostics) = Diagnostics::new(&desc.source, compiler.problems) {
        return Err(Error::Invalid(diagnostics));
    }
    let mut parts = meshes::Parts {
        geometry,
        objects,
        meshes: Vec::new(),
        instances: Vec::new(),
        object_places: Vec::new(),
        materials,
        names: desc.materials.iter().map(|m| m.name.get_ref().clone()).collect(),
        textures,
        images: wanted,
    };
    // What is wrong with models and with images is reported together.
    let placed = parts.place(&placed, store, sharing);
    parts.images.extend(environment);
    let bitmaps = store.images(&parts.images);
    let mut bitmaps = match (placed, bitmaps) {
        (Ok(()), Ok(bitmaps)) => bitmaps,
        (placed, bitmaps) => {
            let errors = placed.err().into_iter().chain(bitmaps.err()).flatten();
            return Err(Error::Assets(errors.collect()));
        }
    };
    let textures = Textures {
        textures: &parts.textures,
        bitmaps: &bitmaps,
    };
    warn_of_the_bright(&parts.names, &parts.materials, &textures);
    mipmap::add_levels(&parts.textures, &mut bitmaps);
    let background = Background {
        sky: background::sky(&desc.background, &mut bitmaps),
        visible: desc.background.visible,
    };
    Ok(Scene {
        accel: accel::build(accel, Arc::new(parts.geometry))?,
        objects: parts.objects,
        meshes: parts.meshes,
        instances: parts.instances,
        object_places: parts.object_places,
        shape_objects,
        materials: parts.materials,
        textures: parts.textures,
        bitmaps,
        lights: Lights::default(),
        light_groups: LightGroups::default(),
        background,
        varying: Vec::new(),
    }
    .lit(lights))
}

/// Files to be loaded, each once for each way to read it, in the order of their [`BitmapId`]s.
type Wanted = Vec<ImageRequest>;

struct Compiler<'a> {
    desc: &'a SceneDesc,
    /// The numbers of materials by name.
    materials: HashMap<&'a str, u32>,
    problems: Vec<Problem>,
}

impl Compiler<'_> {
    /// What was compiled, or a problem more.
    fn keep<T>(&mut self, result: Result<T, Problem>) -> Option<T> {
        result.map_err(|problem| self.problems.push(problem)).ok()
    }

    fn textures(&mut self) -> (Wanted, Vec<Texture>) {
        let mut wanted = Wanted::new();
        let folder = self.desc.folder();
        let mut textures = Vec::new();
        for entry in &self.desc.textures {
            let found = std::cell::RefCell::new(&mut wanted);
            let find = |image: &ImageDesc| {
                let file = ImageSource::File(folder.join(image.file.get_ref()));
                let key = (file, image.color_space);
                let mut wanted = found.borrow_mut();
                let at = wanted.iter().position(|w| *w == key).unwrap_or_else(|| {
                    wanted.push(key);
                    wanted.len() - 1
                });
                Ok(BitmapId(at as u32))
            };
            let pattern = entry.pattern.compile(&find);
            let mapping = entry.mapping.compile();
            if let (Some(pattern), Some(mapping)) = (self.keep(pattern), self.keep(mapping)) {
                textures.push(Texture {
                    mapping,
                    transform: entry.transform.compile(),
                    pattern,
                });
            }
        }
        (wanted, textures)
    }

    fn materials(&mut self) -> Vec<Material> {
        let desc = self.desc;
        let names: HashMap<&str, u32> = desc
            .textures
            .iter()
            .zip(0..)
            .map(|(t, i)| (t.name.get_ref().as_str(), i))
            .collect();
        let find = |source: &Spanned<ColorSource>| match source.get_ref() {
            ColorSource::Constant(color) => Ok(Color::Constant(*color)),
            ColorSource::Texture(name) => match names.get(name.as_str()) {
                Some(id) => Ok(Color::Texture(TextureId(*id))),
                None => Err(undefined(
                    "texture",
                    name,
                    source.span(),
                    desc.textures.iter().map(|t| &t.name),
                )),
            },
        };
        let compile = |entry: &MaterialEntry| {
            let name = &entry.name;
            entry.material.compile(&find).map_err(|problem| {
                // A kind that has no better place for its problem means the whole material.
                let span = problem.span.clone().or_else(|| Some(name.span()));
                Problem { span, ..problem }
            })
        };
        let compiled: Vec<_> = desc.materials.iter().map(compile).collect();
        compiled.into_iter().filter_map(|m| self.keep(m)).collect()
    }

    fn material_id(&self, name: &Spanned<String>) -> Result<MaterialId, Problem> {
        match self.materials.get(name.get_ref().as_str()) {
            Some(&at) => Ok(MaterialId(at)),
            None => Err(undefined(
                "material",
                name.get_ref(),
                name.span(),
                self.desc.materials.iter().map(|m| &m.name),
            )),
        }
    }
}

/// Says which materials send back more light than arrives.
fn warn_of_the_bright(names: &[String], materials: &[Material], textures: &Textures<'_>) {
    for (name, material) in names.iter().zip(materials) {
        let brightest = material.brightest(textures);
        if brightest > 1.0 {
            tracing::warn!("material `{name}` sends back more light than arrives, {brightest} of it");
        }
    }
}

fn undefined<'a>(
    what: &str,
    name: &str,
    span: std::ops::Range<usize>,
    known: impl Iterator<Item = &'a Spanned<String>>,
) -> Problem {
    let problem = Problem::at(span, format!("there is no {what} `{name}`"));
    match did_you_mean(name, known.map(|n| n.get_ref().as_str())) {
        Some(near) => problem.with_help(format!("did you mean `{near}`?")),
        None => problem.with_help(format!("define it: [{what}.{name}]")),
    }
}
