//! Text out of input files, made safe to be shown.

use std::borrow::Cow;

/// Returns the text with control characters, and characters that change the direction of writing or are invisible, as
/// escapes such as `\u{1b}`. Line breaks stay.
pub fn visible(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c != '\n' && is_hidden(c))
}

/// Returns the text as one line of about `most` characters; of a longer one the middle is left out.
pub fn one_line(text: &str, most: usize) -> Cow<'_, str> {
    if text.chars().nth(most).is_none() {
        return escaped(text, is_hidden);
    }
    let tail = most / 4;
    let place = |(at, _): (usize, char)| at;
    let head_end = text.char_indices().nth(most - tail).map_or(text.len(), place);
    let tail_start = text.char_indices().rev().nth(tail.saturating_sub(1)).map_or(0, place);
    let (head, tail) = (&text[..head_end], &text[tail_start..]);
    Cow::Owned(format!("{}…{}", escaped(head, is_hidden), escaped(tail, is_hidden)))
}

fn escaped(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if is_escaped(c) {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

/// Whether a character does anything but show itself: control characters, and the format characters of "Unicode
/// Technical Report 36, Unicode Security Considerations", section 3.6.
fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{ad}'
                | '\u{61c}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{feff}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_and_bidirectional_characters_are_shown_as_escapes() {
        assert_eq!(visible("a\x1b[31m\u{202e}b\nü 漢"), "a\\u{1b}[31m\\u{202e}b\nü 漢");
        assert_eq!(one_line("a\nwrote b\r\t", 80), "a\\nwrote b\\r\\t");
        assert!(matches!(visible("plain"), Cow::Borrowed(_)));
    }

    #[test]
    fn long_text_is_cut_between_characters() {
        assert_eq!(one_line("äöü", 3), "äöü");
        assert_eq!(one_line("äöüßabcdé", 8), "äöüßab…dé");
    }
}
