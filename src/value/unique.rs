//! Unique names of things that a file names as it likes.

use std::collections::HashMap;

/// The name by which each thing goes: its own, or its number from 0 if that is empty. A name that an earlier
/// one has gets `#2`, `#3` and so on.
pub fn unique_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    // The number of times that a name was given so far.
    let mut taken: HashMap<String, usize> = HashMap::new();
    let mut unique = Vec::new();
    for (number, own) in names.into_iter().enumerate() {
        let own = match own {
            "" => number.to_string(),
            own => own.to_owned(),
        };
        let mut name = own.clone();
        while taken.contains_key(&name) {
            let count = taken.entry(own.clone()).or_default();
            *count += 1;
            name = format!("{own}#{count}");
        }
        taken.insert(name.clone(), 1);
        unique.push(name);
    }
    unique
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_things_without_one_go_by_their_number() {
        assert_eq!(
            unique_names(["a", "", "a", "a#2", "a", "1", ""]),
            ["a", "1", "a#2", "a#2#2", "a#3", "1#2", "6"]
        );
    }

    #[test]
    fn many_equal_names_take_linear_time() {
        let names = unique_names(std::iter::repeat_n("x", 100_000));
        assert_eq!(names.last().map(String::as_str), Some("x#100000"));
    }
}
