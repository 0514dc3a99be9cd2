//! Samples with NaN or infinite values: they are left out of the film and counted, and the first pixels are reported.

/// Samples of a frame that were left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InvalidSamples {
    pub count: u64,
    /// Row and column of the first pixels, in the order of rows.
    first: Vec<[i32; 2]>,
}

impl InvalidSamples {
    /// The most pixels that are reported.
    pub const MAX_NAMED: usize = 4;

    /// Counts `samples` samples of `pixel` (column, row).
    #[cold]
    pub fn count_pixel(&mut self, [x, y]: [i32; 2], samples: u32) {
        self.count += u64::from(samples);
        self.name([y, x]);
    }

    /// Adds the counts of another tile. The order of the tiles does not matter.
    pub fn add(&mut self, other: &Self) {
        self.count += other.count;
        for at in &other.first {
            self.name(*at);
        }
    }

    fn name(&mut self, at: [i32; 2]) {
        if let Err(place) = self.first.binary_search(&at)
            && place < Self::MAX_NAMED
        {
            self.first.insert(place, at);
            self.first.truncate(Self::MAX_NAMED);
        }
    }

    /// Column and row of the first pixels, at most [`InvalidSamples::MAX_NAMED`].
    pub fn pixels(&self) -> impl Iterator<Item = [i32; 2]> + '_ {
        self.first.iter().map(|&[y, x]| [x, y])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_pixels_are_named_in_whatever_order_tiles_come() {
        let pixels = [[3, 9], [7, 1], [0, 2], [7, 1], [5, 1], [1, 30], [2, 2]];
        let tile = |range: &[[i32; 2]]| {
            let mut tile = InvalidSamples::default();
            range.iter().for_each(|&p| tile.count_pixel(p, 1));
            tile
        };
        let mut there = tile(&pixels[..3]);
        there.add(&tile(&pixels[3..]));
        let mut back = tile(&pixels[5..]);
        back.add(&tile(&pixels[..5]));
        assert_eq!(there, back);
        assert_eq!(there.count, 7);
        assert_eq!(there.pixels().collect::<Vec<_>>(), [[5, 1], [7, 1], [0, 2], [2, 2]]);
    }
}
