//! The logical lines of an OBJ or MTL file in any encoding: continuations are joined, comments removed.

use std::borrow::Cow;

/// Converts the text to an ASCII-compatible encoding: no byte order mark, UTF-16 to UTF-8, line ends to `\n`.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, [u8]> {
    let utf16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.chunks_exact(2).map(|b| unit([b[0], b[1]]));
        let text: String = char::decode_utf16(units)
            .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect();
        Cow::Owned(text.into_bytes())
    };
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        _ => Cow::Borrowed(bytes),
    };
    if text.contains(&b'\r') && !text.contains(&b'\n') {
        // Line ends of the classic Mac OS.
        return Cow::Owned(text.iter().map(|b| if *b == b'\r' { b'\n' } else { *b }).collect());
    }
    text
}

/// One statement.
pub(super) struct Line<'a> {
    /// The number of its first line in the file, from 1.
    pub number: usize,
    /// Without surrounding spaces and without a comment; never empty.
    pub text: Cow<'a, [u8]>,
}

/// All statements of a decoded text.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Self { rest: text, number: 0 }
    }

    /// The next line of the file, without its end.
    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|b| *b == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        Some(line.trim_ascii())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let mut text = Cow::Borrowed(self.physical()?);
            let number = self.number;
            while is_continued(&text) {
                let joined = text.to_mut();
                joined.pop();
                joined.push(b' ');
                joined.extend_from_slice(self.physical().unwrap_or_default());
            }
            let end = text.trim_ascii().len().min(uncommented(&text));
            let text = match text {
                Cow::Borrowed(t) => Cow::Borrowed(t[..end].trim_ascii_end()),
                Cow::Owned(t) => Cow::Owned(t[..end].trim_ascii().to_vec()),
            };
            if !text.is_empty() {
                return Some(Line { number, text });
            }
        }
    }
}

/// Whether a line continues in the next one. A backslash may also be the second byte of a letter in Shift-JIS.
fn is_continued(line: &[u8]) -> bool {
    let Some((b'\\', before)) = line.split_last() else {
        return false;
    };
    let is_letter = before.last().is_some_and(|b| *b >= 0x80) && str::from_utf8(before).is_err();
    !line.starts_with(b"#") && !is_letter
}

/// Returns the start of a comment: a `#` at the start or after a space, so that names may hold one.
fn uncommented(text: &[u8]) -> usize {
    let mut from = 0;
    while let Some(at) = text[from..].iter().position(|b| *b == b'#') {
        let at = from + at;
        if at == 0 || text[at - 1].is_ascii_whitespace() {
            return at;
        }
        from = at + 1;
    }
    text.len()
}

/// The words of a statement.
pub(super) fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty())
}

/// Returns the bytes after the keyword.
pub(super) fn argument(text: &[u8]) -> &[u8] {
    let keyword = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    text[keyword..].trim_ascii()
}

/// Returns a name as text. The encoding of names is unknown; bytes that are not UTF-8 are escaped, so that different names stay
/// different.
pub(super) fn name(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        for byte in chunk.invalid() {
            text.push_str(&format!("\\x{byte:02X}"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> Vec<(usize, String)> {
        let text = decode(text);
        let line = |l: Line<'_>| (l.number, String::from_utf8_lossy(&l.text).into_owned());
        Lines::new(&text).map(line).collect()
    }

    #[test]
    fn comments_continuations_and_marks_disappear() {
        let text = b"\xef\xbb\xbfv 1 2 3 # one\r\n\r\n  # \xff all \\\nf 1 \\\n 2 3\nusemtl a#b\n";
        let expected = [(1, "v 1 2 3"), (4, "f 1  2 3"), (6, "usemtl a#b")];
        assert_eq!(read(text), expected.map(|(n, l)| (n, l.to_owned())));
    }

    #[test]
    fn a_letter_of_shift_jis_that_ends_in_a_backslash_continues_nothing() {
        let text = b"newmtl \x83\\\nKd 1 0 0\n";
        let decoded = decode(text);
        let lines: Vec<_> = Lines::new(&decoded).map(|l| argument(&l.text).to_vec()).collect();
        assert_eq!(lines, [b"\x83\\".to_vec(), b"1 0 0".to_vec()]);
        assert_eq!(name(&lines[0]), r"\x83\");
        assert_eq!(name("Gr\u{fc}n".as_bytes()), "Gr\u{fc}n");
        // In UTF-8 no letter does.
        assert_eq!(read("f 1 \u{fc}\\\n2\n".as_bytes()).len(), 1);
    }

    #[test]
    fn old_macintosh_and_utf_16_files_are_read() {
        let expected = [(1, "v 1".to_owned()), (2, "v 2".to_owned())];
        assert_eq!(read(b"v 1\rv 2\r"), expected);
        let wide: Vec<u8> = "\u{feff}v 1\nv 2".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(read(&wide), expected);
        assert_eq!(read(b"f 1 2 \\"), [(1, "f 1 2".to_owned())]);
    }
}
