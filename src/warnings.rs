//! Warnings as values: what a user should know of a job that is rendered all the same.
//!
//! [`Warnings`] collects them from all threads. Its list does not depend on the order in which files were loaded. A program
//! prints [`Warnings::take_lines`], one line for each kind, and writes [`Warnings::list`] where it tells all.

use std::{
    collections::{BTreeMap, btree_map::Entry},
    fmt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use serde::{Serialize, Serializer};

use crate::value::one_line;

/// The most warnings of one kind that are kept: those that come first in the list.
const MAX_OF_A_KIND: usize = 1000;

/// The number of other subjects that a line names.
const NAMED: usize = 3;

/// The subject of a warning. Its name is a part of the interface: see docs/interface.md.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct WarningKind(&'static str);

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident = $name:literal;)*) => {
        impl WarningKind {
            $($(#[$doc])* pub const $kind: Self = Self($name);)*

            /// All kinds.
            pub const ALL: &[Self] = &[$(Self::$kind),*];
        }
    };
}

kinds! {
    /// A model uses a feature that is not rendered.
    FEATURE = "feature";
    /// A model or an IES file breaks the rules of its format.
    FAULT = "fault";
    /// A model has several cameras or material variants, of which nothing chooses one.
    CHOICE = "choice";
    /// A model has nothing to see.
    EMPTY_MODEL = "empty-model";
    /// Parts of a model were left out or replaced because their numbers are broken.
    BROKEN_ELEMENTS = "broken-elements";
    /// Triangles or emitters without area were left out.
    NO_AREA = "no-area";
    /// A file that another file names is missing or cannot be read.
    MISSING_FILE = "missing-file";
    /// A material library has no such material.
    MISSING_MATERIAL = "missing-material";
    /// A statement of a material library is not understood, or is read as another.
    STATEMENT = "statement";
    /// Numbers of an image were replaced.
    IMAGE_NUMBERS = "image-numbers";
    /// Images are shown at a lower resolution to fit into memory.
    TEXTURE_MEMORY = "texture-memory";
    /// The opacity of a material is 0 everywhere.
    INVISIBLE = "invisible";
    /// More than half of a picture is black, or of what is lit in it clipped.
    PICTURE = "picture";
    /// The model of a lens has no rays for a part of the picture.
    EMPTY_PART = "empty-part";
    /// Numbers are too large for their files.
    SATURATED = "saturated";
    /// A material reflects more light than it receives.
    ENERGY_GAIN = "energy-gain";
    /// A setting has no effect.
    UNUSED_SETTING = "unused-setting";
    /// Another job writes the same files.
    BUSY = "busy";
    /// A checkpoint was not used or not written.
    CHECKPOINT = "checkpoint";
    /// A frame has fewer samples than asked for.
    TIME_LIMIT = "time-limit";
    /// A frame was written before it was finished, as asked by a signal.
    PARTIAL_FRAME = "partial-frame";
    /// Keys of a camera path were not saved.
    UNSAVED_KEYS = "unsaved-keys";
    /// A file of the whole sequence is damaged, and the frames of other jobs in it are lost.
    LOST_FRAMES = "lost-frames";
    /// Categories of one `coco.json` are named after different things.
    MIXED_LABELS = "mixed-labels";
    /// A file could not be written at the first attempt.
    RETRY = "retry";
}

impl WarningKind {
    pub fn name(self) -> &'static str {
        self.0
    }
}

impl Serialize for WarningKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0)
    }
}

/// One warning. Warnings are ordered by kind, topic, subject and text.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Warning {
    pub kind: WarningKind,
    /// The text that tells warnings of one kind apart that do not belong into one line, such as the
    /// name of a feature; may be empty.
    #[serde(skip)]
    pub topic: String,
    /// The file, the object or the frame.
    pub subject: String,
    /// The whole message, which names the subject.
    pub text: String,
}

/// Collects the warnings of a job. A clone is the same collection.
#[derive(Clone, Default)]
pub struct Warnings {
    collected: Arc<Mutex<Collected>>,
}

#[derive(Default)]
struct Collected {
    /// Whether each was told.
    all: BTreeMap<Warning, bool>,
    counts: BTreeMap<WarningKind, usize>,
}

impl Collected {
    fn insert(&mut self, warning: Warning, is_told: bool) {
        let kind = warning.kind;
        let Entry::Vacant(place) = self.all.entry(warning) else {
            return;
        };
        place.insert(is_told);
        let count = self.counts.entry(kind).or_default();
        *count += 1;
        if *count > MAX_OF_A_KIND {
            *count -= 1;
            let last = self.all.keys().rev().find(|known| known.kind == kind).cloned();
            last.and_then(|last| self.all.remove(&last));
        }
    }
}

impl Warnings {
    /// Adds a warning; one that is there already is not added again.
    pub fn add(&self, kind: WarningKind, subject: impl fmt::Display, text: impl Into<String>) {
        self.insert(kind, String::new(), subject.to_string(), text.into(), false);
    }

    /// Adds a warning that shares its line only with those of the same `topic`.
    pub fn add_topic(
        &self,
        kind: WarningKind,
        topic: impl Into<String>,
        subject: impl fmt::Display,
        text: impl Into<String>,
    ) {
        self.insert(kind, topic.into(), subject.to_string(), text.into(), false);
    }

    /// Adds a warning and logs it at once: whoever watches the job must know now.
    pub fn add_live(&self, kind: WarningKind, subject: impl fmt::Display, text: impl Into<String>) {
        let text = text.into();
        tracing::warn!("{text}");
        self.insert(kind, String::new(), subject.to_string(), text, true);
    }

    fn insert(&self, kind: WarningKind, topic: String, subject: String, text: String, is_told: bool) {
        let warning = Warning {
            kind,
            topic,
            subject,
            text,
        };
        self.lock().insert(warning, is_told);
    }

    /// All warnings so far, in order.
    pub fn list(&self) -> Vec<Warning> {
        self.lock().all.keys().cloned().collect()
    }

    /// One line for each kind and topic.
    pub fn lines(&self) -> Vec<String> {
        lines(self.lock().all.keys())
    }

    /// One line for each kind and topic of the warnings that were not taken before and not logged.
    pub fn take_lines(&self) -> Vec<String> {
        let all = &mut self.lock().all;
        let new = lines(all.iter().filter(|(_, is_told)| !**is_told).map(|(warning, _)| warning));
        all.values_mut().for_each(|is_told| *is_told = true);
        new
    }

    fn lock(&self) -> MutexGuard<'_, Collected> {
        self.collected.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl fmt::Debug for Warnings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.list()).finish()
    }
}

/// The first of each kind and topic, and the number and the first subjects of the others.
fn lines<'a>(warnings: impl Iterator<Item = &'a Warning>) -> Vec<String> {
    let all: Vec<&Warning> = warnings.collect();
    let groups = all.chunk_by(|a, b| (a.kind, &a.topic) == (b.kind, &b.topic));
    groups
        .map(|group| {
            let (first, others) = (group[0], &group[1..]);
            if others.is_empty() {
                return first.text.clone();
            }
            let mut subjects: Vec<&str> = others.iter().map(|w| w.subject.as_str()).collect();
            subjects.dedup();
            subjects.retain(|subject| *subject != first.subject);
            let named: Vec<_> = subjects.iter().take(NAMED).map(|s| one_line(s, 80)).collect();
            let rest = if subjects.len() > NAMED { ", ..." } else { "" };
            let of = if named.is_empty() { "" } else { ": " };
            let count = others.len();
            format!(
                "{} (and {count} more like this{of}{}{rest})",
                first.text,
                named.join(", ")
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_one_line_with_a_count_and_the_first_names() {
        let warnings = Warnings::default();
        for name in ["e", "b", "d", "a", "c", "a"] {
            warnings.add(WarningKind::NO_AREA, name, format!("flat: {name}"));
        }
        warnings.add_topic(WarningKind::FEATURE, "fog", "x", "x: no fog");
        warnings.add_topic(WarningKind::FEATURE, "rain", "x", "x: no rain");
        let expected = [
            "x: no fog",
            "x: no rain",
            "flat: a (and 4 more like this: b, c, d, ...)",
        ];
        assert_eq!(warnings.lines(), expected);
        assert_eq!(warnings.take_lines(), expected);
        warnings.add(WarningKind::NO_AREA, "f", "flat: f");
        assert_eq!(warnings.take_lines(), ["flat: f"]);
        assert_eq!(warnings.list().len(), 8);
    }

    #[test]
    fn the_list_does_not_depend_on_the_order_and_is_bounded() {
        let [up, down] = [Warnings::default(), Warnings::default()];
        let add = |to: &Warnings, i: usize| to.add(WarningKind::STATEMENT, format!("{i:05}"), "odd");
        (0..1500).for_each(|i| add(&up, i));
        (0..1500).rev().for_each(|i| add(&down, i));
        assert_eq!(up.list(), down.list());
        assert_eq!(up.list().len(), MAX_OF_A_KIND);
    }

    #[test]
    fn a_warning_that_was_logged_is_not_told_again() {
        let warnings = Warnings::default();
        warnings.add_live(WarningKind::BUSY, "f", "another job writes f");
        assert!(warnings.take_lines().is_empty());
        assert_eq!(warnings.clone().list()[0].subject, "f");
    }

    #[test]
    fn names_of_kinds_are_different() {
        let mut names: Vec<_> = WarningKind::ALL.iter().map(|kind| kind.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), WarningKind::ALL.len());
    }
}
