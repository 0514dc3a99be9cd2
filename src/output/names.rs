//! Names in patterns of files: `{scene}` and `{eye}`.

use super::sequence::{MOST_PLACES, Part, part_at};

/// Stands for the name of the scene.
pub const SCENE: &str = "{scene}";

/// Stands for the name of an eye, `left` or `right`.
pub const EYE: &str = "{eye}";

/// The message about `{eye}` in the name of a file where no picture is that of one eye.
pub const NO_EYE: &str = "{eye} is the eye of --stereo, which is missing, or puts both eyes into one picture";

/// The fields. In double braces, as `{{eye}}`, they stand for themselves in a pattern.
const FIELDS: [&str; 2] = [SCENE, EYE];

/// Puts names into a pattern of files, as `("{scene}", "car#1")`. A name is taken literally: in the name of the file,
/// its characters are written so that none belongs to a field for the frame's number, and fields in it are not
/// replaced. A name may have folders.
pub fn with_names(pattern: &str, names: &[(&str, &str)]) -> String {
    let mut pieces = pieces(pattern, names);
    for piece in &mut pieces {
        if let Piece::Escaped(field) = piece {
            *piece = Piece::Name(&field[1..field.len() - 1]);
        }
    }
    joined(&pieces)
}

/// Does the same for the name of the scene alone, and leaves the rest to [`with_names`].
pub fn with_scene_name(pattern: &str, scene: &str) -> String {
    let scene = FIELDS.iter().fold(scene.to_owned(), |name, field| {
        name.replace(field, &format!("{{{field}}}"))
    });
    joined(&pieces(pattern, &[(SCENE, &scene)]))
}

/// Whether a pattern has this field.
pub fn has_field(pattern: &str, field: &str) -> bool {
    let pieces = pieces(pattern, &[(field, "")]);
    pieces.iter().any(|piece| matches!(piece, Piece::Name(_)))
}

/// Puts names into a text that has no fields for the frame's number.
pub fn with_plain_names(text: &str, names: &[(&str, &str)]) -> String {
    let mut out = text.to_owned();
    let mut from = 0;
    while let Some((at, (field, name))) = first_of(&out[from..], names) {
        out.replace_range(from + at..from + at + field.len(), name);
        from += at + name.len();
    }
    out
}

/// The first field with a name in a text, and where it is.
fn first_of<'a, 'n>(text: &str, names: &'a [(&'a str, &'n str)]) -> Option<(usize, (&'a str, &'n str))> {
    let found = names.iter().filter_map(|own| Some((text.find(own.0)?, *own)));
    found.min_by_key(|(at, _)| *at)
}

/// A part of a pattern.
#[derive(Clone, Copy)]
enum Piece<'a> {
    /// As it was written.
    Written(&'a str),
    /// What is taken literally.
    Name(&'a str),
    /// A field in double braces, with these.
    Escaped(&'a str),
}

fn pieces<'a>(text: &'a str, names: &[(&str, &'a str)]) -> Vec<Piece<'a>> {
    let (mut pieces, mut start, mut at) = (Vec::new(), 0, 0);
    while at < text.len() {
        let rest = &text[at..];
        let escaped = FIELDS.into_iter().find(|field| {
            let inner = rest.strip_prefix('{').and_then(|rest| rest.strip_prefix(field));
            inner.is_some_and(|after| after.starts_with('}'))
        });
        let name = names.iter().find(|(field, _)| rest.starts_with(field));
        let (length, piece) = match (escaped, name) {
            (Some(field), _) => (field.len() + 2, Piece::Escaped(&rest[..field.len() + 2])),
            (None, Some((field, name))) => (field.len(), Piece::Name(name)),
            (None, None) => {
                at += rest.chars().next().map_or(1, char::len_utf8);
                continue;
            }
        };
        pieces.extend([Piece::Written(&text[start..at]), piece]);
        at += length;
        start = at;
    }
    pieces.push(Piece::Written(&text[start..]));
    pieces
}

/// The pattern of these pieces.
fn joined(pieces: &[Piece]) -> String {
    let text = |piece: &Piece<'_>| match *piece {
        Piece::Written(text) | Piece::Name(text) | Piece::Escaped(text) => text.to_owned(),
    };
    let plain: String = pieces.iter().map(text).collect();
    let folder = plain.rfind(std::path::is_separator).map_or(0, |at| at + 1);
    let mut out = plain[..folder].to_owned();
    let mut at = 0;
    for piece in pieces {
        let own = text(piece);
        let skipped = folder.saturating_sub(at).min(own.len());
        at += own.len();
        match piece {
            Piece::Name(_) => own[skipped..].chars().for_each(|c| push_plain(&mut out, c)),
            Piece::Written(_) | Piece::Escaped(_) => push_fields(&mut out, &own[skipped..]),
        }
    }
    out
}

/// Adds a part of a file's name with its fields, in a form that what follows cannot change.
fn push_fields(out: &mut String, mut text: &str) {
    while !text.is_empty() {
        let (length, part) = part_at(text);
        match part {
            Part::Plain(c) => push_plain(out, c),
            Part::Field(places) if places <= MOST_PLACES => out.extend(std::iter::repeat_n('#', places)),
            Part::Field(_) => out.push_str(&text[..length]),
        }
        text = &text[length..];
    }
}

fn push_plain(out: &mut String, c: char) {
    if matches!(c, '%' | '#' | '$') {
        out.push('%');
    }
    out.push(c);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::FilePattern;

    fn file(pattern: &str, scene: &str, frame: i32) -> String {
        let names = [(SCENE, scene), (EYE, "left")];
        let texts = [
            with_names(pattern, &names),
            with_names(&with_scene_name(pattern, scene), &names),
        ];
        let [at_once, in_steps] = texts.map(|text| FilePattern::parse(&text).unwrap().path(frame));
        assert_eq!(at_once, in_steps);
        at_once.into_os_string().into_string().unwrap()
    }

    #[test]
    fn names_are_literal_whatever_characters_they_have() {
        for name in [
            "car#", "car#2", "car$F2", "a%03db", "50%%x", "%", "{eye}", "{scene}", "%#", "4d", "F4", "$",
        ] {
            assert_eq!(file("o/{scene}.png", name, 1), format!("o/{name}.png"));
            assert_eq!(file("o/{scene}.##.png", name, 1), format!("o/{name}.01.png"));
            assert_eq!(file("{scene}/{scene}#.png", name, 7), format!("{name}/{name}7.png"));
            let folders = format!("x#1/{name}/{name}");
            assert_eq!(
                file("a#/{scene}_{eye}.%04d.png", &folders, 7),
                format!("a#/{folders}_left.0007.png")
            );
        }
        // Characters before a name do not become a field with it.
        for (pattern, name, expected) in [
            ("%0{scene}.png", "4d", "%04d.png"),
            ("${scene}.png", "F4", "$F4.png"),
            ("$F{scene}.png", "4", "74.png"),
            ("#{scene}.png", "#", "7#.png"),
            ("%{scene}.png", "#", "%#.png"),
            ("%{scene}.png", "%", "%%.png"),
            (
                "{{eye}}{{scene}}/{{scene}}#.{eye}.png",
                "a",
                "{eye}{scene}/{scene}7.left.png",
            ),
        ] {
            assert_eq!(file(pattern, name, 7), expected, "{pattern}");
        }
    }

    #[test]
    fn patterns_without_names_mean_what_they_did() {
        for pattern in [
            "f.####.exr",
            "f%04d.exr",
            "f.$F4.exr",
            "100%%.%#.$FPS.#.exr",
            "Take #2/f.exr",
        ] {
            let path = |text: &str| FilePattern::parse(text).unwrap().path(12);
            assert_eq!(path(&with_names(pattern, &[(EYE, "left")])), path(pattern));
        }
        let wrong = with_names("{eye}.%099d.exr", &[(EYE, "left")]);
        assert!(FilePattern::parse(&wrong).is_err(), "{wrong}");
        assert_eq!(
            with_plain_names("{eye}#{x}{scene}", &[(EYE, "left"), (SCENE, "{eye}%")]),
            "left#{x}{eye}%"
        );
    }
}
