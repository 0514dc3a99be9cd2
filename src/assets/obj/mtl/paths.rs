//! Paths in OBJ and MTL files.

use std::{
    borrow::Cow,
    path::{Component, Path, PathBuf},
};

use crate::assets::{Files, obj::ObjError};

/// Refuses files outside of the folder of the model.
pub(super) fn check_inside(files: &Files, obj: &Path, file: &Path) -> Result<(), ObjError> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    match files.allows(folder, file) {
        true => Ok(()),
        false => Err(ObjError::Outside {
            file: file.to_owned(),
            path: obj.to_owned(),
        }),
    }
}

/// The files of a `mtllib` line: one whose name may contain spaces, or several.
pub(super) fn libraries(folder: &Path, line: &[u8]) -> Vec<PathBuf> {
    let whole = locate(folder, line);
    if whole.is_file() || !line.iter().any(u8::is_ascii_whitespace) {
        return vec![whole];
    }
    let mut files = Vec::new();
    let (mut start, mut last) = (0, 0);
    for word in line.split(u8::is_ascii_whitespace) {
        let end = last + word.len();
        // A word without the extension is part of a name with spaces.
        if word.to_ascii_lowercase().ends_with(b".mtl") || end == line.len() {
            files.push(locate(folder, line[start..end].trim_ascii()));
            start = end;
        }
        last = end + 1;
    }
    files
}

/// A file beside another: backslashes separate folders too, but before a space they make it part of the name; of a path of
/// another machine the last part counts.
pub(super) fn locate(folder: &Path, name: &[u8]) -> PathBuf {
    let name = name.trim_ascii();
    let name = name.strip_prefix(b"\"").unwrap_or(name);
    let name = name.strip_suffix(b"\"").unwrap_or(name);
    let mut slashed: Vec<u8> = Vec::with_capacity(name.len());
    for (i, byte) in name.iter().enumerate() {
        match byte {
            b'\\' if name.get(i + 1) == Some(&b' ') => {}
            b'\\' => slashed.push(b'/'),
            other => slashed.push(*other),
        }
    }
    // A backslash may be half of a letter.
    let name = match str::from_utf8(name) {
        Err(_) if folder.join(path_of(name)).is_file() => name,
        _ => slashed.as_slice(),
    };
    let path = path_of(name);
    let is_absolute = path.has_root() || name.get(1) == Some(&b':');
    match path.components().next_back() {
        Some(Component::Normal(last)) if is_absolute => folder.join(last),
        _ => folder.join(path),
    }
}

#[cfg(unix)]
fn path_of(name: &[u8]) -> Cow<'_, Path> {
    use std::os::unix::ffi::OsStrExt;
    Cow::Borrowed(Path::new(std::ffi::OsStr::from_bytes(name)))
}

#[cfg(not(unix))]
fn path_of(name: &[u8]) -> Cow<'_, Path> {
    Cow::Owned(PathBuf::from(String::from_utf8_lossy(name).into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_other_systems_are_found() {
        let at = |name: &str| locate(Path::new("m"), name.as_bytes());
        assert_eq!(at(r"textures\a.png"), Path::new("m/textures/a.png"));
        assert_eq!(at(r"C:\art\a.png"), Path::new("m/a.png"));
        assert_eq!(at("/home/art/a.png"), Path::new("m/a.png"));
        assert_eq!(at("\"a b.png\""), Path::new("m/a b.png"));
        assert_eq!(at(r"tex\my\ own\ a.png"), Path::new("m/tex/my own a.png"));
    }

    #[test]
    fn one_line_names_several_libraries() {
        let at = |line: &str| libraries(Path::new("nowhere"), line.as_bytes());
        let expected = ["a.mtl", "my own.MTL", "c"].map(|f| Path::new("nowhere").join(f));
        assert_eq!(at("a.mtl my own.MTL c"), expected);
        assert_eq!(at("a.mtl"), [Path::new("nowhere/a.mtl")]);
        assert_eq!(at(r"my\ own.mtl"), [Path::new("nowhere/my own.mtl")]);
    }
}
