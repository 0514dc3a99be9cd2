//! Ranked coverage, the content of Cryptomatte layers: the mattes of a pixel with their coverage.
//!
//! The coverage of a matte is the sum of the weights of its samples over that of all samples, including misses. Lens, shutter
//! and partial opacity are part of it, because they are sampled. Cryptomatte has no negative coverage: samples with a negative
//! filter weight do not count, unless all samples of the pixel are negative.
//!
//! Source: Friedman and Jones, "Fully Automatic ID Mattes with Support for Motion Blur and Transparency", SIGGRAPH 2015
//! posters, doi:10.1145/2787626.2787629.

use super::state;

/// The default number of mattes per pixel.
pub const DEFAULT_RANKS: u32 = 6;

/// The weights of a set of samples.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct Weight {
    /// The sum of the positive weights.
    positive: f32,
    count: u32,
}

impl Weight {
    fn add(&mut self, weight: f32) {
        self.positive += weight.max(0.0);
        self.count += 1;
    }

    /// Adds the weights of later samples.
    fn append(&mut self, later: &Self) {
        self.positive += later.positive;
        self.count += later.count;
    }

    /// The share of `self` in the weights of a pixel.
    fn share(&self, total: &Self) -> f32 {
        if total.positive > 0.0 {
            self.positive / total.positive
        } else {
            self.count as f32 / total.count as f32
        }
    }
}

/// A matte of a pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Entry {
    id: u32,
    weight: Weight,
    /// The index of the pixel's next entry plus 1; 0 at the end.
    next: u32,
}

/// The mattes of the pixels of a tile, for several passes.
#[derive(Clone, Debug)]
pub(super) struct TileCoverage {
    passes: usize,
    totals: Vec<Weight>,
    /// The index of the first entry plus 1, for each pass of each pixel; 0 if it has none.
    heads: Vec<u32>,
    entries: Vec<Entry>,
}

impl TileCoverage {
    pub fn new(pixels: usize, passes: usize) -> Self {
        let pixels = if passes == 0 { 0 } else { pixels };
        Self {
            passes,
            totals: vec![Weight::default(); pixels],
            heads: vec![0; pixels * passes],
            entries: Vec::new(),
        }
    }

    /// Adds a sample's weight to a pixel's total.
    pub fn add_sample(&mut self, pixel: usize, weight: f32) {
        self.totals[pixel].add(weight);
    }

    /// Adds the same weight to the matte of the sample.
    pub fn add(&mut self, pixel: usize, pass: usize, id: u32, weight: f32) {
        self.weight_of(pixel, pass, id).add(weight);
    }

    /// Adds the sums of later samples.
    pub fn append(&mut self, later: &Self) {
        for (own, later) in self.totals.iter_mut().zip(&later.totals) {
            own.append(later);
        }
        for (slot, &head) in later.heads.iter().enumerate() {
            let mut at = head;
            while at > 0 {
                let entry = &later.entries[at as usize - 1];
                self.weight_of(slot / self.passes, slot % self.passes, entry.id)
                    .append(&entry.weight);
                at = entry.next;
            }
        }
    }

    /// The weight of a matte in a pixel of a pass, which is added if it is not there.
    fn weight_of(&mut self, pixel: usize, pass: usize, id: u32) -> &mut Weight {
        let head = &mut self.heads[pixel * self.passes + pass];
        let mut at = *head;
        while at > 0 && self.entries[at as usize - 1].id != id {
            at = self.entries[at as usize - 1].next;
        }
        if at == 0 {
            self.entries.push(Entry {
                id,
                weight: Weight::default(),
                next: *head,
            });
            *head = self.entries.len() as u32;
            at = *head;
        }
        &mut self.entries[at as usize - 1].weight
    }

    /// Appends its state.
    pub fn write_state(&self, out: &mut Vec<u8>) {
        let Self {
            passes: _,
            totals,
            heads,
            entries,
        } = self;
        state::put(out, totals);
        state::put(out, heads);
        state::put_counted(out, entries);
    }

    /// Reads its state from the start of `input`; `None` if that is invalid.
    pub fn read_state(&mut self, input: &mut &[u8]) -> Option<()> {
        state::take(input, &mut self.totals)?;
        state::take(input, &mut self.heads)?;
        self.entries = state::take_counted(input)?;
        // An entry refers to an older one, so chains end.
        let is_known = |at: &u32| *at as usize <= self.entries.len();
        let is_older = |(i, entry): (usize, &Entry)| entry.next as usize <= i;
        (self.heads.iter().all(is_known) && self.entries.iter().enumerate().all(is_older)).then_some(())
    }

    /// The mattes of a pass for all pixels: for each matte the bits of its id as a float, and its coverage. They are in descending
    /// order of coverage and ascending order of id; each pixel has `ranks`, filled up with zeros.
    pub fn resolve(&self, pass: usize, ranks: usize) -> Vec<f32> {
        let mut values = vec![0.0; self.totals.len() * 2 * ranks];
        let mut found: Vec<(u32, f32)> = Vec::new();
        for ((pixel, total), out) in self.totals.iter().enumerate().zip(values.chunks_exact_mut(2 * ranks)) {
            found.clear();
            let mut at = self.heads[pixel * self.passes + pass];
            while at > 0 {
                let entry = &self.entries[at as usize - 1];
                found.push((entry.id, entry.weight.share(total)));
                at = entry.next;
            }
            found.retain(|(_, coverage)| *coverage > 0.0);
            found.sort_unstable_by(|(a, x), (b, y)| y.total_cmp(x).then(a.cmp(b)));
            for ((id, coverage), rank) in found.iter().zip(out.chunks_exact_mut(2)) {
                rank.copy_from_slice(&[f32::from_bits(*id), *coverage]);
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mattes of a pixel with these samples of a matte (0 for none) and a weight.
    fn resolved(samples: &[(u32, f32)], ranks: usize) -> Vec<(u32, f32)> {
        let mut tile = TileCoverage::new(1, 1);
        for &(id, weight) in samples {
            tile.add_sample(0, weight);
            if id != 0 {
                tile.add(0, 0, id, weight);
            }
        }
        let values = tile.resolve(0, ranks);
        values.as_chunks().0.iter().map(|[id, c]| (id.to_bits(), *c)).collect()
    }

    #[test]
    fn coverage_is_a_share_of_all_samples_and_of_those_that_met_nothing() {
        let samples = [(7, 1.0), (9, 1.0), (0, 1.0), (9, 1.0)];
        assert_eq!(resolved(&samples, 3), [(9, 0.5), (7, 0.25), (0, 0.0)]);
    }

    #[test]
    fn equal_ones_stand_in_the_order_of_their_ids_and_only_the_first_ranks_are_kept() {
        let samples = [(9, 1.0), (3, 1.0), (5, 1.0), (3, 1.0)];
        assert_eq!(resolved(&samples, 2), [(3, 0.5), (5, 0.25)]);
    }

    #[test]
    fn negative_lobes_of_a_filter_have_no_part_unless_nothing_else_is_there() {
        assert_eq!(resolved(&[(1, 1.0), (2, -1.0), (1, 1.0)], 2), [(1, 1.0), (0, 0.0)]);
        assert_eq!(resolved(&[(2, -1.0), (0, -1.0)], 1), [(2, 0.5)]);
    }
}
