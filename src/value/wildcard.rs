//! Names with wildcards.

/// Whether `name` is one that `pattern` means, in which `*` stands for any text and `?` for any character.
pub fn matches_wildcards(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut p, mut n) = (0, 0);
    // The place after the last star, and how much of the name that stands for the star has at least.
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p + 1, n));
                p += 1;
            }
            Some(c) if *c == '?' || *c == name[n] => (p, n) = (p + 1, n + 1),
            _ => {
                let Some((after, from)) = star else { return false };
                (p, n) = (after, from + 1);
                star = Some((after, from + 1));
            }
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_is_any_text_and_a_question_mark_any_character() {
        for (pattern, name) in [
            ("Wheel*", "Wheel"),
            ("Wheel*", "Wheel_L"),
            ("*_L", "Wheel_L_L"),
            ("*", ""),
            ("a?c", "abc"),
            ("*b*d", "abcbd"),
            ("Tür?", "Türe"),
        ] {
            assert!(matches_wildcards(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [
            ("Wheel", "Wheel_L"),
            ("wheel*", "Wheel_L"),
            ("a?c", "ac"),
            ("*_L", "Wheel_R"),
            ("", "a"),
        ] {
            assert!(!matches_wildcards(pattern, name), "{pattern} {name}");
        }
    }
}
