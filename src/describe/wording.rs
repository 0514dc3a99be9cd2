//! The wording of messages of parsers: in terms of scene files, and without names of types.

/// Values as parsers call them, and as scene files do.
const VALUES: &[(&str, &str)] = &[
    ("string ", "the text "),
    ("integer ", ""),
    ("floating point ", ""),
    ("boolean ", ""),
    ("sequence", "a list"),
    ("map", "a table"),
];

/// A message of a parser as a scene file's: "expected a number, found the text "big"".
pub(super) fn in_words_of_the_file(message: &str) -> String {
    let told = ["invalid type: ", "invalid value: ", "invalid length "];
    let rest = told.iter().find_map(|kind| message.strip_prefix(kind));
    let Some((found, expected)) = rest.and_then(|rest| rest.rsplit_once(", expected ")) else {
        return message.to_owned();
    };
    // A struct here is a table there.
    let expected = match expected {
        "a sequence" => "a list",
        "a map" => "a table",
        "i64" | "u64" | "i32" | "u32" | "usize" => "a whole number",
        "f64" | "f32" => "a number",
        expected if expected.starts_with("struct ") => "a table",
        expected => expected,
    };
    let value = VALUES
        .iter()
        .find_map(|(theirs, own)| Some((own, found.strip_prefix(theirs)?)));
    let found = match value {
        Some((own, value)) => format!("{own}{value}"),
        None if message.starts_with("invalid length") => match found {
            "1" => "1 element".to_owned(),
            count => format!("{count} elements"),
        },
        None => found.to_owned(),
    };
    format!("expected {expected}, found {found}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_expected_stands_before_what_was_found() {
        for (parsers, ours) in [
            (
                "invalid type: string \"big\", expected a number",
                "expected a number, found the text \"big\"",
            ),
            (
                "invalid type: integer `1`, expected a name or a table",
                "expected a name or a table, found `1`",
            ),
            (
                "invalid type: sequence, expected struct Sky",
                "expected a table, found a list",
            ),
            (
                "invalid length 2, expected an array of length 3",
                "expected an array of length 3, found 2 elements",
            ),
            (
                "invalid value: string \"a, b\", expected a colour",
                "expected a colour, found the text \"a, b\"",
            ),
            (
                "invalid type: string \"a\", expected a sequence",
                "expected a list, found the text \"a\"",
            ),
            (
                "invalid type: floating point `1.5`, expected i64",
                "expected a whole number, found `1.5`",
            ),
            ("missing field `eye`", "missing field `eye`"),
        ] {
            assert_eq!(in_words_of_the_file(parsers), ours);
        }
    }
}
