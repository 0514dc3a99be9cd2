//! Lists of a fixed length.

use std::{fmt, marker::PhantomData};

use serde::{Deserialize, Deserializer, de};

/// A list of `N` values, neither more nor fewer. An array of serde takes no notice of what a list has beyond its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct List<T, const N: usize>(pub [T; N]);

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for List<T, N> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct ListVisitor<T, const N: usize>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>, const N: usize> de::Visitor<'de> for ListVisitor<T, N> {
            type Value = List<T, N>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "an array of length {N}")
            }
            fn visit_seq<A: de::SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut values = Vec::with_capacity(N);
                while values.len() < N
                    && let Some(value) = seq.next_element()?
                {
                    values.push(value);
                }
                let mut count = values.len();
                while seq.next_element::<de::IgnoredAny>()?.is_some() {
                    count += 1;
                }
                match <[T; N]>::try_from(values) {
                    Ok(values) if count == N => Ok(List(values)),
                    _ => Err(de::Error::invalid_length(count, &self)),
                }
            }
        }
        d.deserialize_seq(ListVisitor(PhantomData))
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tests::read, List};

    #[test]
    fn a_list_has_its_length() {
        assert_eq!(read::<List<f64, 2>>("v = [1.0, 2.0]"), Ok(List([1.0, 2.0])));
        for (text, found) in [("v = [1.0]", 1), ("v = [1.0, 2.0, 3.0, 4.0]", 4)] {
            let message = format!("invalid length {found}, expected an array of length 2");
            assert_eq!(read::<List<f64, 2>>(text), Err(message));
        }
    }
}
