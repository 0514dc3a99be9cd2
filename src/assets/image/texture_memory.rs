//! The memory limit of all images together.

/// The number of halvings of each image so that all take at most `limit` bytes. The largest is halved first, until they fit or
/// none can be halved.
pub fn halvings(bytes: &[u64], limit: u64) -> Vec<u32> {
    let mut left = bytes.to_vec();
    let mut halvings = vec![0; bytes.len()];
    let mut sum = bytes.iter().fold(0_u64, |sum, b| sum.saturating_add(*b));
    while sum > limit {
        let largest = left.iter().copied().max().unwrap_or(0);
        // A single texel of floats cannot be halved.
        if largest <= 16 {
            break;
        }
        for (left, halvings) in left.iter_mut().zip(&mut halvings).filter(|(left, _)| **left == largest) {
            *left /= 4;
            *halvings += 1;
        }
        sum = left.iter().fold(0, |sum, b| sum.saturating_add(*b));
    }
    halvings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_images_are_halved_until_all_fit() {
        assert_eq!(halvings(&[100, 400, 400], 900), [0, 0, 0]);
        assert_eq!(halvings(&[100, 400, 400], 899), [0, 1, 1]);
        assert_eq!(halvings(&[100, 400, 400], 299), [1, 2, 2]);
        assert_eq!(halvings(&[1 << 40], 1 << 20), [10]);
        assert_eq!(halvings(&[64, 0], 0), [1, 0]);
        assert!(halvings(&[], 0).is_empty());
    }
}
