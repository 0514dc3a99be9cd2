//! Errors of a scene's files, with the lines of the scene that name them.

use std::{fmt, path::Path};

use crate::{
    assets::AssetError,
    describe::{Diagnostics, FileKind, SceneDesc},
    math::sorting,
    value::{Problem, Span, Spanned, is_override, one_line},
};

/// The most characters of a message without a line of the scene.
const LONGEST_MESSAGE: usize = 1000;

/// Why a file of a scene was not loaded.
#[derive(Debug)]
pub(super) struct FileError {
    pub error: AssetError,
    /// The object that has it as its model, by its index in the description, where that is known.
    pub object: Option<usize>,
}

/// The errors of files that are no models of objects.
pub(super) fn file_errors(errors: Vec<AssetError>) -> Vec<FileError> {
    let plain = |error| FileError { error, object: None };
    errors.into_iter().map(plain).collect()
}

/// The files that were not loaded, in the order in which the scene names them.
#[derive(Debug)]
pub struct AssetErrors {
    errors: Vec<AssetError>,
    messages: Vec<String>,
    /// Whether a line of the scene is in the messages.
    have_excerpts: bool,
}

impl AssetErrors {
    /// The errors of the files of this scene, which are at `span` or where the scene names them. Those of files that
    /// only models name are without a line.
    pub(super) fn of_scene(errors: Vec<FileError>, desc: &SceneDesc, span: Option<&Span>) -> Self {
        // A model by itself stands for a text that is in no file, but for what flags set.
        let is_shown = |span: &Span| desc.source.kind == FileKind::Scene || is_override(span);
        let place = |error: &FileError| span.cloned().or_else(|| place(error, desc)).filter(is_shown);
        let mut placed: Vec<_> = errors.into_iter().map(|error| (place(&error), error.error)).collect();
        sorting::sort_by_key(&mut placed, |(span, _)| {
            span.as_ref().map_or(usize::MAX, |span| span.start)
        });
        let messages = |(span, error): &(Option<Span>, AssetError)| {
            let plain = error.messages();
            let Some(span) = span else {
                return plain
                    .iter()
                    .map(|text| one_line(text, LONGEST_MESSAGE).into_owned())
                    .collect();
            };
            let problem = |message| Problem {
                help: help(error).map(str::to_owned),
                ..Problem::at(span.clone(), message)
            };
            let problems = plain.into_iter().map(problem).collect();
            Diagnostics::new(&desc.source, problems).map_or_else(Vec::new, |found| found.messages())
        };
        Self {
            messages: placed.iter().flat_map(messages).collect(),
            have_excerpts: placed.iter().any(|(span, _)| span.is_some()),
            errors: placed.into_iter().map(|(_, error)| error).collect(),
        }
    }

    /// These errors after others.
    #[must_use]
    pub fn after(self, others: Option<Self>) -> Self {
        let Some(others) = others else { return self };
        Self {
            errors: others.errors.into_iter().chain(self.errors).collect(),
            messages: [others.messages, self.messages].concat(),
            have_excerpts: self.have_excerpts || others.have_excerpts,
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = &AssetError> {
        self.errors.iter()
    }

    /// A text for each problem.
    pub fn messages(&self) -> &[String] {
        &self.messages
    }

    /// Whether the messages show lines of the scene.
    pub fn have_excerpts(&self) -> bool {
        self.have_excerpts
    }
}

impl From<AssetError> for AssetErrors {
    fn from(error: AssetError) -> Self {
        Self {
            messages: error.messages(),
            have_excerpts: false,
            errors: vec![error],
        }
    }
}

impl fmt::Display for AssetErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.messages.join("\n"))
    }
}

/// A hint for the correction, where there is one.
fn help(error: &AssetError) -> Option<&'static str> {
    match error {
        AssetError::Subdivision { cause, .. } => cause.help(),
        _ => None,
    }
}

/// The place of the value that makes the error, or of the first one that names its file.
fn place(FileError { error, object }: &FileError, desc: &SceneDesc) -> Option<Span> {
    let mesh = object.and_then(|object| desc.objects[object].shape.get_ref().mesh());
    match (error, mesh) {
        (AssetError::Subdivision { cause, .. }, Some(mesh)) => {
            let height = mesh.displacement.as_ref().map(|given| given.height.span());
            let subdivide = mesh.subdivide.as_ref().map(Spanned::span);
            let (first, second) = match cause.is_of_displacement() {
                true => (height, subdivide),
                false => (subdivide, height),
            };
            first.or(second)
        }
        // The image of a displacement is not named by the mesh.
        (AssetError::Image(_), _) | (_, None) => named(error.path(), desc),
        (_, Some(mesh)) => Some(mesh.file.span()),
    }
}

/// The place of the first value that names this file.
fn named(path: &Path, desc: &SceneDesc) -> Option<Span> {
    let images = desc
        .textures
        .iter()
        .filter_map(|texture| Some(&texture.pattern.image()?.file));
    let meshes = desc
        .objects
        .iter()
        .filter_map(|object| Some(&object.shape.get_ref().mesh()?.file));
    let lights = desc.lights.iter().filter_map(|entry| Some(entry.light.ies()?.name));
    let folder = desc.folder();
    let mut files = images.chain(meshes).chain(lights);
    let found = files
        .find(|file| folder.join(file.get_ref()) == path)
        .map(Spanned::span);
    found.or_else(|| {
        let environment = desc.background.environment.as_ref()?;
        (desc.environment_file()? == path).then(|| environment.get_ref().file.span())
    })
}
