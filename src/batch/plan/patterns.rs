//! The patterns of a job's files.

use super::denoise_options;
use crate::{
    batch::{Request, TakenFrames},
    describe::{OneOrMany, SceneDesc},
    error::Error,
    output::{Contents, Exr, FilePattern, FilePatternError, Format},
};

/// The patterns of a job's files.
pub(in crate::batch) struct Patterns {
    /// The patterns of rendered files.
    pub rendered: Vec<FilePattern>,
    /// The patterns of the files that the first one becomes; empty if the job does not denoise.
    pub denoised: Vec<FilePattern>,
    /// The format of the frames that the caller takes.
    taken: Option<&'static dyn Format>,
}

impl Patterns {
    /// The patterns that a scene names, or those of its own name.
    ///
    /// # Errors
    /// A pattern is invalid, or has an unsuitable format.
    pub fn new(desc: &SceneDesc, request: &Request) -> Result<Self, Error> {
        let mut patterns = Self {
            rendered: match request.taken.are_any() && !is_chosen(desc) {
                true => Vec::new(),
                false => pictures(desc).map_err(Error::Pattern)?,
            },
            denoised: Vec::new(),
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
            let beside = || format!("{}{}.####.png", patterns.folder(), format.file);
            let pattern = match text.is_empty() {
                true => FilePattern::parse(&beside()),
                false => FilePattern::parse(text),
            };
            let pattern = pattern.map_err(Error::Pattern)?;
            if pattern.format().name() != format.name() {
                let flag = format.flag;
                let message = format!("{flag}: expected a pattern that ends in .png, found `{text}`");
                return Err(Error::Usage(message));
            }
            patterns.rendered.push(pattern.with_format(format));
        }
        let stands_beside = [
            (!request.metadata.is_empty(), "--metadata"),
            (request.policy.checkpoint.is_some(), "--checkpoint"),
            (request.policy.keep_sums, "--keep-sums"),
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

fn pictures(desc: &SceneDesc) -> Result<Vec<FilePattern>, FilePatternError> {
    if let Some(files) = &desc.output.files {
        return files.0.iter().map(|text| FilePattern::parse(text.get_ref())).collect();
    }
    let name = desc.name();
    ["exr", "png"]
        .into_iter()
        .map(|e| FilePattern::of_sequence(&name, e))
        .collect()
}
