//! Samples that came out as NaN or infinite: they never reach the film, but are counted and named.

/// Samples of a frame that were left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    pub count: u64,
    /// Row and column of the first pixels among theirs, from the top and each row from the left.
    first: Vec<[u32; 2]>,
}

impl Dropped {
    /// So many pixels are named.
    pub const NAMED: usize = 4;

    /// Notes a sample of `pixel` (column, row).
    #[cold]
    pub fn note(&mut self, [x, y]: [u32; 2]) {
        self.count += 1;
        self.name([y, x]);
    }

    /// Adds what another part of the frame left out. The order of the parts does not matter.
    pub fn add(&mut self, other: &Self) {
        self.count += other.count;
        for at in &other.first {
            self.name(*at);
        }
    }

    fn name(&mut self, at: [u32; 2]) {
        if let Err(place) = self.first.binary_search(&at)
            && place < Self::NAMED
        {
            self.first.insert(place, at);
            self.first.truncate(Self::NAMED);
        }
    }

    /// Column and row of the first pixels, at most [`Dropped::NAMED`].
    pub fn pixels(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.first.iter().map(|&[y, x]| [x, y])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_pixels_are_named_in_whatever_order_parts_come() {
        let pixels = [[3, 9], [7, 1], [0, 2], [7, 1], [5, 1], [1, 30], [2, 2]];
        let part = |range: &[[u32; 2]]| {
            let mut part = Dropped::default();
            range.iter().for_each(|&p| part.note(p));
            part
        };
        let mut there = part(&pixels[..3]);
        there.add(&part(&pixels[3..]));
        let mut back = part(&pixels[5..]);
        back.add(&part(&pixels[..5]));
        assert_eq!(there, back);
        assert_eq!(there.count, 7);
        assert_eq!(there.pixels().collect::<Vec<_>>(), [[5, 1], [7, 1], [0, 2], [2, 2]]);
    }
}
