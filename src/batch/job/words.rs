//! Words in tables of values and among draws: names of things, and of files.

use std::path::Path;

use super::{Job, load_options};
use crate::{
    assets::{MemoryKind, store::ModelRequest},
    compile::{self, LoadOptions},
    describe::{Entity, MovingDesc, Values, Word},
    error::Error,
};

impl Job {
    /// Checks each word of the values, once the scene of the file is loaded: whether names are known and files are there.
    pub(super) fn check_words(&self) -> Result<(), Error> {
        self.with_words(|values, words| {
            let reader = MovingDesc::new(&self.desc, values);
            let mut desc = self.desc.clone();
            for word in words {
                if let Some(path) = &word.file {
                    self.check_file(word, path)?;
                // Values that do not fit together fail at their frame.
                } else if reader.put(&mut desc, word) {
                    compile::check_names(&desc, word.entity, &self.store)
                        .map_err(|message| Error::Invalid(reader.word_problem(word, message)))?;
                }
            }
            Ok(())
        })
    }

    /// Checks whether a file can be read. Placeholders may replace images.
    fn check_file(&self, word: &Word, path: &Path) -> Result<(), Error> {
        let is_image = matches!(word.entity, Entity::Texture(_) | Entity::Background);
        match self.store.files().read(path) {
            Err(cause) if !(is_image && self.store.has_placeholders()) => Err(Error::CellFile {
                origin: word.origin.clone(),
                cause,
                path: path.to_owned(),
            }),
            _ => Ok(()),
        }
    }

    /// Loads each file that values may name at any frame, and each variant of a model that they may choose, with the files that
    /// these name themselves, one after the other, and drops it. Call it after [`Job::load`], once the scene is dropped: the memory
    /// of the scene is counted as free.
    ///
    /// # Errors
    /// All those of these files, with the places that name them.
    pub fn check_named_files(&self) -> Result<(), Error> {
        self.with_words(|values, words| {
            let reader = MovingDesc::new(&self.desc, values);
            let time = self.plan.first_frame / self.plan.fps;
            let options = load_options(Some(values), self.plan.first_eye, time);
            let (mut known, mut found) = (Vec::new(), None);
            for word in words {
                match self.check_named_file((&reader, word), &options, &mut known) {
                    Err(compile::Error::Assets(errors)) => found = Some(errors.after(found)),
                    checked => checked?,
                }
            }
            match found {
                Some(errors) => Err(compile::Error::Assets(errors).into()),
                None => Ok(()),
            }
        })
    }

    fn check_named_file(
        &self,
        (reader, word): (&MovingDesc<'_>, &Word),
        options: &LoadOptions,
        known: &mut Vec<ModelRequest>,
    ) -> Result<(), compile::Error> {
        if word.file.is_none() && !word.is_of_shape {
            return Ok(());
        }
        let mut desc = self.desc.clone();
        let is_put = reader.put(&mut desc, word);
        let of_shape = || {
            let mesh = desc.objects[word.entity.object()?].shape.get_ref().mesh()?;
            Some(desc.folder().join(mesh.file.get_ref()))
        };
        let Some(path) = word.file.clone().or_else(of_shape).filter(|_| is_put) else {
            return Ok(());
        };
        desc.source = reader.source_of(word);
        self.store.forget_models();
        for kind in [MemoryKind::Images, MemoryKind::Shapes] {
            self.store.files().memory().release(kind);
        }
        match compile::check_file((&desc, &reader.span_of(word)), &path, &self.store, options, known) {
            // Another draw may choose among the alternatives in the file.
            Err(compile::Error::Assets(errors))
                if word.is_drawn_beside_others && errors.iter().all(|error| error.is_choice()) =>
            {
                Ok(())
            }
            checked => checked,
        }
    }

    /// Calls `with` with the values and their words, if there are any.
    fn with_words(&self, with: impl FnOnce(&Values, &[Word]) -> Result<(), Error>) -> Result<(), Error> {
        let Some(values) = self.plan.values.as_deref() else {
            return Ok(());
        };
        match &values.words(&self.desc)[..] {
            [] => Ok(()),
            words => with(values, words),
        }
    }
}
