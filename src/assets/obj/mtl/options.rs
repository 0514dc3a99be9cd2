//! The options of a texture, and its file.

use crate::{
    math::Vec2,
    texture::{StTransform, image::Wrap},
    value::Channel,
};

/// The texture statement of a material.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// The name of its file, possibly with spaces.
    pub file: Vec<u8>,
    /// `-s` and `-o`.
    pub transform: StTransform,
    /// `-clamp on`.
    pub wrap: Wrap,
    /// `-mm`: the offset, which is added after the gain is applied, and the gain.
    pub base: f32,
    pub gain: f32,
    /// `-bm`.
    pub strength: f32,
    /// `-imfchan`; `None` if it names no channel, such as `l` for luminance.
    pub channel: Option<Channel>,
    /// Options that are not rendered.
    pub unsupported: Vec<&'static str>,
}

/// Parses a finite number.
pub(super) fn finite(word: &[u8]) -> Option<f32> {
    str::from_utf8(word).ok()?.parse::<f32>().ok().filter(|v| v.is_finite())
}

/// Splits off the first word of a text; `None` if there is only one.
fn split(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = text.iter().position(u8::is_ascii_whitespace)?;
    Some((&text[..end], text[end..].trim_ascii_start()))
}

/// Parses options such as `-s 1 1 1` and the file's name; `None` without one. The last word always belongs to the name.
pub(super) fn map_of(given: &[u8]) -> Option<Map> {
    let mut map = Map {
        file: Vec::new(),
        transform: StTransform::IDENTITY,
        wrap: Wrap::Repeat,
        base: 0.0,
        gain: 1.0,
        strength: 1.0,
        channel: None,
        unsupported: Vec::new(),
    };
    let (mut scale, mut offset) = (Vec2::ONE, Vec2::ZERO);
    let mut rest = given.trim_ascii();
    while let Some((option, after)) = split(rest) {
        let option = option.to_ascii_lowercase();
        match option.as_slice() {
            b"-s" => (scale, rest) = numbers(after, scale),
            b"-o" => (offset, rest) = numbers(after, offset),
            b"-t" => {
                map.unsupported.push("-t");
                (_, rest) = numbers(after, Vec2::ZERO);
            }
            b"-mm" => {
                let mut range = Vec2::new(map.base, map.gain);
                (range, rest) = two_numbers(after, range);
                (map.base, map.gain) = (range.x, range.y);
            }
            b"-blendu" | b"-blendv" | b"-boost" | b"-texres" | b"-clamp" | b"-bm" | b"-imfchan" | b"-type" | b"-cc"
            | b"-colorspace" => {
                let Some((value, after)) = split(after) else { break };
                map.set(&option, value);
                rest = after;
            }
            // The file's name, possibly with a leading dash.
            _ => break,
        }
    }
    map.file = rest.to_vec();
    if (scale, offset) != (Vec2::ONE, Vec2::ZERO) {
        map.transform = StTransform::new(offset, 0.0, scale);
    }
    (!map.file.is_empty()).then_some(map)
}

impl Map {
    fn set(&mut self, option: &[u8], value: &[u8]) {
        match option {
            b"-clamp" if value.eq_ignore_ascii_case(b"on") => self.wrap = Wrap::Clamp,
            b"-cc" if value.eq_ignore_ascii_case(b"on") => self.unsupported.push("-cc"),
            b"-bm" => self.strength = finite(value).unwrap_or(self.strength),
            b"-imfchan" => {
                self.channel = match value.to_ascii_lowercase().as_slice() {
                    b"r" => Some(Channel::R),
                    b"g" => Some(Channel::G),
                    b"b" => Some(Channel::B),
                    b"m" => Some(Channel::A),
                    _ => None,
                };
            }
            _ => {}
        }
    }
}

/// Parses up to three numbers and returns the first two; missing ones are those of `otherwise`.
fn numbers(text: &[u8], otherwise: Vec2) -> (Vec2, &[u8]) {
    let (mut found, mut rest) = (otherwise.to_array(), text);
    for i in 0..3 {
        let Some((value, after)) = split(rest).and_then(|(word, after)| Some((finite(word)?, after))) else {
            break;
        };
        if let Some(number) = found.get_mut(i) {
            *number = value;
        }
        rest = after;
    }
    (found.into(), rest)
}

fn two_numbers(text: &[u8], otherwise: Vec2) -> (Vec2, &[u8]) {
    let (mut found, mut rest) = (otherwise.to_array(), text);
    for number in &mut found {
        let Some((word, after)) = split(rest) else { break };
        *number = finite(word).unwrap_or(*number);
        rest = after;
    }
    (found.into(), rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_and_names_keep_their_spaces() {
        let read = |text: &str| map_of(text.as_bytes()).unwrap();
        let file = |text: &str| String::from_utf8(read(text).file).unwrap();
        assert_eq!(file("a b.png"), "a b.png");
        assert_eq!(file("-clamp on -bm 1 -mm 0 1 my file.png"), "my file.png");
        assert_eq!(file("-odd.png"), "-odd.png");
        assert_eq!(file("-s 2 3.png"), "3.png");
        assert_eq!(file("-s 4"), "4");
        let map = read("-S 4 2 1 -o 0.5 -clamp on -mm 0.1 0.5 -bm 0.3 -imfchan g a.png");
        assert_eq!(
            map.transform,
            StTransform::new(Vec2::new(0.5, 0.0), 0.0, Vec2::new(4.0, 2.0))
        );
        assert_eq!((map.wrap, map.base, map.gain), (Wrap::Clamp, 0.1, 0.5));
        assert_eq!((map.strength, map.channel), (0.3, Some(Channel::G)));
        assert_eq!(read("-cc on -t 1 1 1 a.png").unsupported, ["-cc", "-t"]);
        assert!(map_of(b"  ").is_none());
    }
}
