//! The patterns of a job's files.

use std::path::{Path, PathBuf};

use super::denoise_options;
use crate::{
    assets::{Files, MemoryBudget, model_formats::is_model},
    batch::{Request, TakenFrames, products::metadata::Sidecar},
    describe::{self, OneOrMany, SceneDesc},
    error::Error,
    output::{
        Contents, Exr, FilePattern, FilePatternError, Format,
        names::{EYE, SCENE, has_field, with_names},
    },
};

/// The patterns of a job's files.
pub(in crate::batch) struct Patterns {
    /// The patterns of rendered files.
    pub rendered: Vec<FilePattern>,
    /// The patterns of the files that the first one becomes; empty if the job does not denoise.
    pub denoised: Vec<FilePattern>,
    /// The format of the frames that the caller takes.
    taken: Option<&'static dyn Format>,
    /// The eye that the names of files beside the pictures have: that of stereo, unless all folders of pictures have it.
    pub eye: Option<&'static str>,
    /// A pattern with `{eye}`, where there is no eye.
    pub lacks_eye: Option<String>,
}

impl Patterns {
    /// The patterns that a scene names, or those of its own name.
    ///
    /// # Errors
    /// A pattern is invalid, or has an unsuitable format.
    pub fn new(desc: &SceneDesc, request: &Request) -> Result<Self, Error> {
        let texts = desc.output.files.as_ref();
        let texts = texts.map(|files| files.0.iter().map(|text| text.get_ref().clone()).collect());
        Self::of_texts((&desc.name(), texts, is_chosen(desc)), request)
    }

    /// The patterns of the scene of this name with these texts, if there are any, which an override or the scene's author names.
    fn of_texts(
        (scene, texts, is_chosen): (&str, Option<Vec<String>>, bool),
        request: &Request,
    ) -> Result<Self, Error> {
        // A picture of both eyes is that of none.
        let eye = request.stereo.filter(|_| request.second_eye.is_none());
        let eye = eye.map(|eye| eye.side().name());
        let texts = texts.filter(|_| is_chosen || !request.taken.are_any());
        let mut given = texts.iter().flatten().chain(request.png_data().map(|(_, text)| text));
        let lacks_eye = given.find(|text| eye.is_none() && has_field(text, EYE)).cloned();
        let folder = |text: &str| has_field(&text[..text.rfind(std::path::is_separator).unwrap_or(0)], EYE);
        let is_in_folders = texts
            .as_ref()
            .is_some_and(|texts| texts.iter().all(|text| folder(text)));
        let names: Vec<(&str, &str)> = [(SCENE, scene)].into_iter().chain(eye.map(|eye| (EYE, eye))).collect();
        let parse = |text: &String| FilePattern::parse(&with_names(text, &names));
        let rendered: Result<Vec<FilePattern>, FilePatternError> = match &texts {
            Some(texts) => texts.iter().map(parse).collect(),
            None if request.taken.are_any() => Ok(Vec::new()),
            None => {
                let name = eye.map_or_else(|| scene.to_owned(), |eye| format!("{scene}.{eye}"));
                ["exr", "png"]
                    .map(|ending| FilePattern::of_sequence(&name, ending))
                    .into_iter()
                    .collect()
            }
        };
        let mut patterns = Self {
            rendered: rendered.map_err(Error::Pattern)?,
            denoised: Vec::new(),
            eye: eye.filter(|_| !is_in_folders),
            lacks_eye,
            taken: match request.taken {
                TakenFrames::Files(format) => Some(format),
                TakenFrames::None | TakenFrames::Pictures => None,
            },
        };
        if request.denoise.is_some() {
            if patterns.rendered.is_empty() {
                let message = "--denoise reads the frames again: name files for them, too (-o f.####.exr)";
                return Err(Error::Usage(message.to_owned()));
            }
            let noisy = denoise_options::noisy(&patterns.rendered).map_err(Error::Pattern)?;
            patterns.denoised = std::mem::replace(&mut patterns.rendered, vec![noisy]);
        }
        for (format, text) in request.png_data() {
            let eye = patterns.eye.map_or_else(String::new, |eye| format!(".{eye}"));
            let beside = || format!("{}{}{eye}.####.png", patterns.folder(), format.file);
            let pattern = match text.is_empty() {
                true => FilePattern::parse(&beside()),
                false => parse(text),
            };
            let pattern = pattern.map_err(Error::Pattern)?;
            if pattern.format().name() != format.name() {
                let flag = format.flag;
                let message = format!("{flag}: expected a pattern that ends in .png, found `{text}`");
                return Err(Error::Usage(message));
            }
            patterns.rendered.push(pattern.with_format(format));
        }
        if let Some(folder) = request.sample_ranges.and_then(|ranges| ranges.folder()) {
            for pattern in &mut patterns.rendered {
                let format = pattern.format();
                *pattern = pattern.in_folder(&folder).map_err(Error::Pattern)?.with_format(format);
            }
        }
        let stands_beside = [
            (!request.metadata.is_empty(), "--metadata"),
            (request.policy.checkpoint.is_some(), "--checkpoint"),
            (request.policy.keep_sums, "--keep-sums"),
            (request.sample_ranges.is_some(), "--sample-range"),
        ];
        let mut needless = stands_beside.into_iter().filter(|(is_given, _)| *is_given);
        if let (true, Some((_, flag))) = (patterns.rendered.is_empty(), needless.next()) {
            let message =
                format!("{flag} writes files beside those of the frames: name files for them, too (-o f.####.exr)");
            return Err(Error::Usage(message));
        }
        Ok(patterns)
    }

    /// The formats of the rendered frames.
    pub fn formats(&self) -> Vec<&'static dyn Format> {
        self.rendered
            .iter()
            .map(FilePattern::format)
            .chain(self.taken)
            .collect()
    }

    /// Whether other files than EXR files hold passes.
    pub fn has_arrays(&self) -> bool {
        let formats = self.all().map(FilePattern::format).chain(self.taken);
        let mut data = formats.filter(|format| format.contents() == Contents::Data);
        data.any(|format| format.name() != Exr.name())
    }

    /// All patterns, those of final files first.
    pub fn all(&self) -> impl Iterator<Item = &FilePattern> {
        self.denoised.iter().chain(&self.rendered)
    }

    /// The folder of the first of the final files, with its separator.
    fn folder(&self) -> &str {
        self.all().next().map(FilePattern::folder).unwrap_or_default()
    }

    /// The pattern of the final pictures: files for displays, else the first.
    pub fn picture(&self) -> Option<&FilePattern> {
        let files = if self.denoised.is_empty() {
            &self.rendered
        } else {
            &self.denoised
        };
        let shown = files
            .iter()
            .find(|pattern| pattern.format().contents() == Contents::Picture);
        shown.or(files.first())
    }
}

/// Whether an override names the files, and not the scene's author.
pub(in crate::batch) fn is_chosen(desc: &SceneDesc) -> bool {
    desc.output.files.as_ref().is_some_and(OneOrMany::is_override)
}

/// The names of the files of a job, without the numbers of its frames, as far as they are known before models are loaded: patterns,
/// and the files beside the pictures. `chosen` are the patterns of the caller, if any. `None` where the scene cannot be read.
///
/// A scene that is not read yet has no frames, which a plan has: these names find out what all its
/// frames have in common with other jobs.
pub fn named_files(path: &Path, chosen: &[String], request: &Request) -> Option<Vec<PathBuf>> {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let patterns = match is_model(path) {
        true => {
            let texts = (!chosen.is_empty()).then(|| chosen.to_vec());
            Patterns::of_texts((&stem?, texts, !chosen.is_empty()), request)
        }
        false => {
            let files = Files::new(request.allow_outside, MemoryBudget::new(request.max_memory));
            let desc = describe::load(path, &request.overrides, |path| files.read(path));
            Patterns::new(&desc.ok()?, request)
        }
    };
    let patterns = patterns.ok()?;
    let picture = patterns.picture().map(|pattern| pattern.path(0));
    let beside = Sidecar::with_sources(&request.metadata).into_iter();
    let beside = beside.filter_map(|sidecar| Some(sidecar.path(picture.as_deref()?, patterns.eye)));
    let files = patterns.all().map(FilePattern::comparable);
    Some(files.chain(beside).collect())
}
