//! The names of files that a system can write, and which of them are one file.

use std::{
    ffi::{OsStr, OsString},
    path::{Component, Path},
};

/// Names of devices of Windows, with any extension. `COM` and `LPT` have a digit behind them.
const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "conin$", "conout$"];
const NUMBERED_DEVICES: [&str; 2] = ["com", "lpt"];

/// The rules of a system for the names of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileNames {
    /// All names but those with `/` and the zero byte are allowed and different.
    Unix,
    /// Some names are reserved, some characters are not allowed, and case makes no difference.
    Windows,
}

impl FileNames {
    /// The rules of the system that the program runs on.
    pub const HERE: Self = if cfg!(windows) { Self::Windows } else { Self::Unix };

    /// The name in a form that is equal for all names of one file.
    pub fn comparable(self, name: &OsStr) -> OsString {
        match self {
            Self::Unix => name.to_owned(),
            Self::Windows => name.to_string_lossy().to_lowercase().into(),
        }
    }

    /// The reason why a file of this path cannot be written, by its name or that of a folder.
    pub fn fault(self, path: &Path) -> Option<String> {
        if self == Self::Unix {
            return None;
        }
        path.components().find_map(|component| match component {
            Component::Normal(name) => fault_on_windows(&name.to_string_lossy()),
            _ => None,
        })
    }
}

/// The reason why Windows does not allow the name of a file or a folder.
fn fault_on_windows(name: &str) -> Option<String> {
    let is_refused = |c: &char| c.is_ascii_control() && *c != '\u{7f}' || "<>:\"|?*".contains(*c);
    if let Some(c) = name.chars().find(is_refused) {
        return Some(format!("Windows does not allow the character {c:?} in a name"));
    }
    if name.ends_with(['.', ' ']) {
        return Some("Windows does not allow a name that ends with a dot or a space".to_owned());
    }
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_lowercase();
    let number = NUMBERED_DEVICES.iter().find_map(|device| stem.strip_prefix(device));
    let is_numbered = matches!(
        number,
        Some("1" | "2" | "3" | "4" | "5" | "6" | "7" | "8" | "9" | "¹" | "²" | "³")
    );
    (is_numbered || DEVICES.contains(&stem.as_str())).then(|| format!("the name {name} is reserved on Windows"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_windows_cannot_write_are_known() {
        let fault = |path: &str| FileNames::Windows.fault(Path::new(path));
        for (path, part) in [
            ("con.png", "the name con.png is reserved"),
            ("out/Aux.0001.exr", "the name Aux.0001.exr is reserved"),
            ("out/NUL/f.png", "the name NUL is reserved"),
            ("prn .png", "reserved"),
            ("CONOUT$.png", "reserved"),
            ("com1.png", "reserved"),
            ("LPT9.tar.png", "reserved"),
            ("out./f.png", "dot or a space"),
            ("out /f.png", "dot or a space"),
            ("f.png ", "dot or a space"),
            ("out/ab:c.png", "':'"),
            ("what?.png", "'?'"),
            ("a<b.png", "'<'"),
            ("a>b/f.png", "'>'"),
            ("a|b.png", "'|'"),
            ("*.png", "'*'"),
            ("a\"b.png", "'\"'"),
            ("a\tb.png", "'\\t'"),
        ] {
            let fault = fault(path).expect(path);
            assert!(fault.contains(part), "{fault}");
        }
        for path in [
            "f.0001.exr",
            "./out/../f.png",
            "console.png",
            "com.png",
            "com0.png",
            "com10.png",
            "lpt.1.png",
            ".hidden.png",
            "a b.c d.png",
            "f.con",
            "ünï漢🎬 #%{}'$.png",
        ] {
            assert_eq!(fault(path), None, "{path}");
        }
        assert_eq!(FileNames::Unix.fault(Path::new("con./a:b?.png ")), None);
    }

    #[test]
    fn names_of_windows_have_no_case() {
        let one = |rules: FileNames| rules.comparable("f.0001.exr".as_ref()) == rules.comparable("F.0001.EXR".as_ref());
        assert!(one(FileNames::Windows) && !one(FileNames::Unix));
    }

    #[cfg(windows)]
    #[test]
    fn the_letter_of_a_drive_is_no_part_of_a_name() {
        for path in [r"C:\out\f.png", "c:f.png", r"\\?\C:\out\f.png", r"\\server\share\f.png"] {
            assert_eq!(FileNames::HERE.fault(Path::new(path)), None, "{path}");
        }
    }
}
