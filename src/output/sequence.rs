//! Patterns of file names: `out/frame.####.exr`, `out/frame.%04d.exr` or `out/frame.$F4.exr`.
//!
//! | written | frame 7 | frame -7 | frame 12345 |
//! |---|---|---|---|
//! | `####`, `%04d`, `$F4` | `0007` | `-007` | `12345` |
//! | `#`, `%d`, `$F` | `7` | `-7` | `12345` |
//!
//! A sign takes one of the places, as in C's `printf`; more digits than places are all kept. The field is in the name of
//! the file: folders are taken literally. In the name `%%` is a `%`, `%#` a `#` and `%$` a `$`. The extension chooses the
//! format. Relative patterns are relative to the current folder.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    fs, io,
    path::{Component, Path, PathBuf},
};

use super::{FORMATS, Format, format};
use crate::value::{UnknownName, one_of};

/// More places than any frame number has.
pub(super) const MOST_PLACES: usize = 16;

/// A pattern of file names with the format that it asks for.
#[derive(Clone, Debug)]
pub struct FilePattern {
    text: String,
    before: String,
    /// The places of the frame's number, where the pattern has one.
    places: Option<usize>,
    after: String,
    format: &'static dyn Format,
}

impl FilePattern {
    /// Returns the pattern of a sequence in the current folder, whose files are called `name`, whatever characters it
    /// has, and a number.
    pub fn of_sequence(name: &str, extension: &str) -> Result<Self, FilePatternError> {
        let name = name.replace('%', "%%").replace('#', "%#").replace('$', "%$");
        Self::parse(&format!("{name}.####.{extension}"))
    }

    /// Reads a pattern.
    pub fn parse(text: &str) -> Result<Self, FilePatternError> {
        let folder = text.rfind(std::path::is_separator).map_or(0, |at| at + 1);
        let mut parts = [text[..folder].to_owned(), String::new()];
        let mut places = None;
        let mut rest = &text[folder..];
        while !rest.is_empty() {
            let (length, field) = part_at(rest);
            match field {
                Part::Field(_) if places.is_some() => {
                    return Err(FilePatternError::TwoFields {
                        pattern: text.to_owned(),
                    });
                }
                Part::Field(n) if n > MOST_PLACES => {
                    return Err(FilePatternError::TooManyPlaces {
                        pattern: text.to_owned(),
                    });
                }
                Part::Field(n) => places = Some(n),
                Part::Plain(c) => parts[usize::from(places.is_some())].push(c),
            }
            rest = &rest[length..];
        }
        let [before, after] = parts;
        if let (None, Some(field)) = (places, foreign_field(&before[folder..])) {
            return Err(FilePatternError::ForeignField {
                written: before[folder..].replace(field, "####"),
                field: field.to_owned(),
                pattern: text.to_owned(),
            });
        }
        let format = format_of(text, if places.is_some() { &after } else { &before }, places)?;
        Ok(Self {
            text: text.to_owned(),
            before,
            places,
            after,
            format,
        })
    }

    /// Whether it names one file for each frame, or one file.
    pub fn has_frame(&self) -> bool {
        self.places.is_some()
    }

    /// The file of this frame.
    pub fn path(&self, frame: i32) -> PathBuf {
        let Self { before, after, .. } = self;
        PathBuf::from(match self.places {
            Some(places) => format!("{before}{frame:0places$}{after}"),
            None => before.clone(),
        })
    }

    /// The number at the end of the name of one file, before its extension: 7 in `f.0007.exr`.
    pub fn number(&self) -> Option<i32> {
        let name = Path::new(&self.before).file_stem()?.to_str()?;
        let digits = name.trim_end_matches(|c: char| c.is_ascii_digit());
        // A sign stands alone: `shot-7` is shot 7.
        let sign = digits
            .strip_suffix('-')
            .filter(|rest| rest.is_empty() || rest.ends_with('.'));
        name[sign.map_or(digits.len(), str::len)..].parse().ok()
    }

    /// The pattern with a field of one form, to compare patterns by: two that write the same file of each frame are equal.
    pub fn comparable(&self) -> PathBuf {
        let field = "#".repeat(self.places.unwrap_or(0));
        plain(Path::new(&format!("{}{field}{}", self.before, self.after)))
    }

    /// The same names in a folder of this name, inside of their own.
    ///
    /// # Errors
    /// None where the folder's name has no number field.
    pub fn in_folder(&self, folder: &str) -> Result<Self, FilePatternError> {
        let (before, name) = self.text.split_at(self.folder().len());
        // Windows has two separators: the one that was written is kept.
        let separator = before.chars().next_back().unwrap_or(std::path::MAIN_SEPARATOR);
        Self::parse(&format!("{before}{folder}{separator}{name}"))
    }

    /// Its folder as it was written, with the separator at its end.
    pub fn folder(&self) -> &str {
        let end = self.text.rfind(std::path::is_separator).map_or(0, |at| at + 1);
        &self.text[..end]
    }

    /// The files of the sequence that are there, by their frames.
    ///
    /// # Errors
    /// The folder cannot be listed.
    pub fn existing(&self) -> io::Result<BTreeMap<i32, PathBuf>> {
        let mut files = BTreeMap::new();
        let example = self.path(0);
        let folder = example.parent().unwrap_or(Path::new(""));
        let prefix = &self.before[self.before.rfind(std::path::is_separator).map_or(0, |at| at + 1)..];
        let listed = if folder.as_os_str().is_empty() {
            Path::new(".")
        } else {
            folder
        };
        for entry in fs::read_dir(listed)? {
            let name = entry?.file_name();
            let number = name.to_str().and_then(|name| {
                let inner = name.strip_prefix(prefix)?.strip_suffix(&self.after)?;
                inner.parse::<i32>().ok()
            });
            let path = number.map(|number| (number, self.path(number)));
            files.extend(path.filter(|(_, path)| path.file_name() == Some(&name)));
        }
        Ok(files)
    }

    /// The same files in a format that no ending asks for.
    pub fn with_format(self, format: &'static dyn Format) -> Self {
        Self { format, ..self }
    }

    pub fn format(&self) -> &'static dyn Format {
        self.format
    }

    /// As it was written.
    pub fn as_str(&self) -> &str {
        &self.text
    }
}

/// The names of the files in a folder, in lower case since the system may not tell them apart; `None` if it cannot be listed.
pub fn names_in(folder: &Path) -> Option<HashSet<String>> {
    match fs::read_dir(folder) {
        Ok(entries) => entries
            .map(|entry| Some(entry.ok()?.file_name().to_string_lossy().to_lowercase()))
            .collect(),
        Err(error) => (error.kind() == io::ErrorKind::NotFound).then(HashSet::new),
    }
}

/// A field for the frame's number as other programs write it: `{frame}`, `{frame:04}`, `<frame>` or `@@@@`.
fn foreign_field(name: &str) -> Option<&str> {
    let between = |open: &str, close: char| {
        let start = name.find(open)?;
        let length = name[start..].find(close)?;
        Some(&name[start..=start + length])
    };
    let at_signs = || {
        let start = name.find("@@")?;
        let length = name[start..].find(|c| c != '@').unwrap_or(name.len() - start);
        Some(&name[start..start + length])
    };
    let braces = between("{frame", '}').or_else(|| between("{:", '}'));
    braces.or_else(|| between("<frame", '>')).or_else(at_signs)
}

/// Checks that every frame of every pattern has a file of its own.
pub fn check_distinct(patterns: &[FilePattern], frames: &[i32]) -> Result<(), FilePatternError> {
    let mut seen = HashMap::new();
    for pattern in patterns {
        if !pattern.has_frame() && frames.len() > 1 {
            return Err(FilePatternError::NoField {
                frames: frames.len(),
                pattern: pattern.text.clone(),
            });
        }
        if patterns.len() == 1 {
            // Different numbers are different names.
            break;
        }
        for &frame in frames {
            let path = pattern.path(frame);
            if let Some(other) = seen.insert(plain(&path), &pattern.text) {
                return Err(FilePatternError::Collision {
                    first: other.clone(),
                    second: pattern.text.clone(),
                    path,
                });
            }
        }
    }
    Ok(())
}

/// The path without the parts that change nothing.
fn plain(path: &Path) -> PathBuf {
    path.components().filter(|c| *c != Component::CurDir).collect()
}

/// A part of a file's name.
pub(super) enum Part {
    Plain(char),
    /// The frame's number, with this many places.
    Field(usize),
}

/// Returns the first part of `text`, which is not empty, and the number of bytes that it takes.
pub(super) fn part_at(text: &str) -> (usize, Part) {
    let digits = |from: usize| text[from..].bytes().take_while(u8::is_ascii_digit).count();
    // A number too large for `usize` is as wrong as any that is too large.
    let number = |from: usize, n: usize| match n {
        0 => 1,
        _ => text[from..from + n].parse().unwrap_or(usize::MAX),
    };
    let byte = |at: usize| text.as_bytes().get(at);
    let first = text.chars().next().unwrap_or_default();
    let plain = (first.len_utf8(), Part::Plain(first));
    match text.as_bytes() {
        [b'#', ..] => {
            let run = text.bytes().take_while(|b| *b == b'#').count();
            (run, Part::Field(run))
        }
        [b'%', literal @ (b'%' | b'#' | b'$'), ..] => (2, Part::Plain(char::from(*literal))),
        [b'%', after @ ..] => {
            let n = digits(1);
            // C pads with blanks unless there is a zero; nobody wants those in a file's name.
            let zero = n == 0 || after[0] == b'0';
            match byte(1 + n) {
                Some(b'd') if zero => (n + 2, Part::Field(number(1, n))),
                _ => plain,
            }
        }
        [b'$', b'F', ..] => {
            let n = digits(2);
            match byte(2 + n) {
                // Another variable, such as `$FPS`.
                Some(b) if n == 0 && (b.is_ascii_alphanumeric() || *b == b'_') => plain,
                _ => (2 + n, Part::Field(number(2, n))),
            }
        }
        _ => plain,
    }
}

/// The format that the end of a pattern names: `end` is what follows the frame's number, or all of it.
fn format_of(text: &str, end: &str, places: Option<usize>) -> Result<&'static dyn Format, FilePatternError> {
    let name = end.rsplit(std::path::is_separator).next().unwrap_or_default();
    let number_is_in_name = places.is_some() && name.len() == end.len();
    let extension = match name.rsplit_once('.') {
        Some((stem, extension)) if !extension.is_empty() && (!stem.is_empty() || number_is_in_name) => extension,
        _ => {
            return Err(FilePatternError::NoExtension {
                pattern: text.to_owned(),
            });
        }
    };
    format(extension).ok_or_else(|| FilePatternError::UnknownFormat {
        name: UnknownName::new("format", extension, names()),
        pattern: text.to_owned(),
    })
}

/// An error in the file patterns of a job.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FilePatternError {
    #[error("more than one field for the frame's number (write %# for a plain #, %$ for $ and %% for %): {pattern}")]
    TwoFields { pattern: String },
    #[error("the frame's number is written as ####, not as {field}, as in {written}: {pattern}")]
    ForeignField {
        field: String,
        written: String,
        pattern: String,
    },
    #[error("more than {MOST_PLACES} places for the frame's number: {pattern}")]
    TooManyPlaces { pattern: String },
    #[error("no extension to tell the format by (expected {}): {pattern}", one_of(names()))]
    NoExtension { pattern: String },
    #[error("{name}: {pattern}")]
    UnknownFormat { name: UnknownName, pattern: String },
    #[error("{frames} frames but no field for the frame's number in the file's name, as in name.####.exr: {pattern}")]
    NoField { frames: usize, pattern: String },
    #[error("{first} and {second} write the same file: {}", path.display())]
    Collision {
        first: String,
        second: String,
        path: PathBuf,
    },
}

fn names() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().map(|f| f.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(pattern: &str, frame: i32) -> String {
        let path = FilePattern::parse(pattern).unwrap().path(frame);
        path.into_os_string().into_string().unwrap()
    }

    #[test]
    fn fields_of_other_programs_are_refused_with_the_own_one() {
        for field in ["{frame}", "{frame:04}", "{:04d}", "<frame>", "@@@@"] {
            let pattern = format!("{{frame}}/f.{field}.png");
            let message = FilePattern::parse(&pattern).unwrap_err().to_string();
            assert!(message.contains("as in f.####.png"), "{message}");
        }
        for fine in [
            "{frame}/f.####.png",
            "f.{frame}.##.png",
            "{frame/f.png",
            "a@b.png",
            "{x}.png",
        ] {
            assert!(FilePattern::parse(fine).is_ok(), "{fine}");
        }
    }

    #[test]
    fn files_of_a_sequence_are_found_also_by_names_that_begin_with_a_dot_or_the_number() {
        let home = tempfile::tempdir().unwrap();
        for name in [".0002.exr", "0003.exr", "a.0004.exr", ".a.0005.exr"] {
            fs::write(home.path().join(name), "").unwrap();
        }
        for (name, frame) in [(".####.exr", 2), ("####.exr", 3), ("a.####.exr", 4), (".a.####.exr", 5)] {
            let pattern = home.path().join(name).into_os_string().into_string().unwrap();
            let found = FilePattern::parse(&pattern).unwrap().existing().unwrap();
            assert_eq!(found.into_keys().collect::<Vec<_>>(), [frame], "{name}");
        }
    }

    #[test]
    fn three_notations_mean_the_same() {
        for (frame, number) in [
            (7, "0007"),
            (-7, "-007"),
            (12345, "12345"),
            (-12345, "-12345"),
            (0, "0000"),
        ] {
            for pattern in ["out/f.####.exr", "out/f.%04d.exr", "out/f.$F4.exr"] {
                assert_eq!(file(pattern, frame), format!("out/f.{number}.exr"));
            }
        }
        for (frame, number) in [(7, "7"), (-7, "-7"), (i32::MIN, "-2147483648")] {
            for pattern in ["f#.png", "f%d.png", "f$F.png", "f%01d.png", "f$F1.png"] {
                assert_eq!(file(pattern, frame), format!("f{number}.png"));
            }
        }
    }

    #[test]
    fn everything_else_is_kept() {
        assert_eq!(file("/a b/ü$FPS%s_100%%.%02d.EXR", 3), "/a b/ü$FPS%s_100%.03.EXR");
        assert_eq!(file("%%d/Take #2/$F/f.#.exr", 3), "%%d/Take #2/$F/f.3.exr");
        assert_eq!(file("Take #2/final.exr", 3), "Take #2/final.exr");
        let shot = FilePattern::of_sequence("shot #3 at 100% $F", "exr").unwrap();
        assert_eq!(shot.path(7), PathBuf::from("shot #3 at 100% $F.0007.exr"));
        assert_eq!(file("100%#_%$F_%%d.%02d.exr", 3), "100#_$F_%d.03.exr");
        assert_eq!(file("#.exr", 3), "3.exr");
        assert_eq!(file("%4d.exr", 3), "%4d.exr");
        assert!(!FilePattern::parse("single.exr").unwrap().has_frame());
        assert_eq!(file("single.exr", 3), "single.exr");
    }

    #[test]
    fn the_number_of_one_file_is_at_the_end_of_its_name() {
        let names = [
            ("n/f.0007.exr", Some(7)),
            ("shot2-12.exr", Some(12)),
            ("f.-03.exr", Some(-3)),
            ("-3.exr", Some(-3)),
            ("f.exr", None),
            ("take 2/f2b.exr", None),
            ("f.99999999999.exr", None),
        ];
        for (name, number) in names {
            assert_eq!(FilePattern::parse(name).unwrap().number(), number, "{name}");
        }
    }

    #[test]
    fn the_extension_chooses_the_format() {
        for (pattern, name) in [("a.exr", "exr"), ("a.b.#.PNG", "png"), ("a.exr/####.png", "png")] {
            assert_eq!(FilePattern::parse(pattern).unwrap().format().name(), name);
        }
    }

    #[test]
    fn messages_say_what_to_do() {
        for (pattern, message) in [
            (
                "a.##.$F.exr",
                "more than one field for the frame's number (write %# for a plain #, %$ for $ and %% for %): a.##.$F.exr",
            ),
            ("a.%099d.exr", "more than 16 places for the frame's number: a.%099d.exr"),
            (
                "a.$F99999999999999999999.exr",
                "more than 16 places for the frame's number: a.$F99999999999999999999.exr",
            ),
            (
                "out/####",
                "no extension to tell the format by (expected one of `exr`, `jpg`, `npz`, `png`): out/####",
            ),
            (
                "out.exr/",
                "no extension to tell the format by (expected one of `exr`, `jpg`, `npz`, `png`): out.exr/",
            ),
            (
                ".exr",
                "no extension to tell the format by (expected one of `exr`, `jpg`, `npz`, `png`): .exr",
            ),
            (
                "",
                "no extension to tell the format by (expected one of `exr`, `jpg`, `npz`, `png`): ",
            ),
            ("a.#.ext", "unknown format `ext` (did you mean `exr`?): a.#.ext"),
            (
                "a.#.tiff",
                "unknown format `tiff` (expected one of `exr`, `jpg`, `npz`, `png`): a.#.tiff",
            ),
        ] {
            assert_eq!(FilePattern::parse(pattern).unwrap_err().to_string(), message);
        }
    }

    #[test]
    fn two_patterns_never_share_a_file() {
        let check = |patterns: &[&str], frames: &[i32]| {
            let patterns: Vec<_> = patterns.iter().map(|p| FilePattern::parse(p).unwrap()).collect();
            check_distinct(&patterns, frames).map_err(|e| e.to_string())
        };
        assert_eq!(check(&["a.####.exr", "a.####.png"], &[1, 2, 10000]), Ok(()));
        assert_eq!(check(&["a.exr", "a.png"], &[1]), Ok(()));
        assert_eq!(
            check(&["a.##.exr", "./a.$F.exr"], &[1, 10]),
            Err("a.##.exr and ./a.$F.exr write the same file: ./a.10.exr".to_owned())
        );
        assert_eq!(check(&["a.##.exr", "./a.$F.exr"], &[1, 9]), Ok(()));
        assert_eq!(
            check(&["a.exr"], &[1, 2]),
            Err(
                "2 frames but no field for the frame's number in the file's name, as in name.####.exr: a.exr"
                    .to_owned()
            )
        );
    }
}
