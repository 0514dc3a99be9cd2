//! Sorting of lists that are short, or sorted once.
//!
//! All lists share one instance of a stable sort, of their indices. The sorts of slices are 6 kB of code for every type and order,
//! so they are for lists that are long or sorted often.

use std::cmp::Ordering;

/// Sorts a list. Equal values keep their order.
pub fn sort_by<T>(values: &mut [T], compare: impl Fn(&T, &T) -> Ordering) {
    let order = sorted(values.len(), &|a, b| compare(&values[a], &values[b]));
    for place in 0..order.len() {
        // Earlier places have given their old values away: to where their own came from.
        let mut from = order[place];
        while from < place {
            from = order[from];
        }
        values.swap(place, from);
    }
}

/// Sorts a list by a key of each value. Equal values keep their order.
pub fn sort_by_key<T, K: Ord>(values: &mut [T], key: impl Fn(&T) -> K) {
    sort_by(values, |a, b| key(a).cmp(&key(b)));
}

/// A map or set of these items. `collect` sorts the items of a B-tree first, which is 8 kB of code for every type.
pub fn ordered<T, C: Default + Extend<T>>(items: impl IntoIterator<Item = T>) -> C {
    let mut all = C::default();
    all.extend(items);
    all
}

/// The indices of a list in the order of its values.
fn sorted(count: usize, compare: &dyn Fn(usize, usize) -> Ordering) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| compare(*a, *b));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::pcg4d;

    #[test]
    fn every_list_is_sorted_as_the_standard_library_sorts_it() {
        for count in 0..200 {
            let mut values: Vec<(u32, u32)> = (0..count).map(|i| (pcg4d([i, count, 0, 0])[0] % 20, i)).collect();
            let mut expected = values.clone();
            expected.sort_by_key(|value| value.0);
            sort_by_key(&mut values, |value| value.0);
            assert_eq!(values, expected);
        }
    }
}
