//! Runs of whole numbers, such as the triangles of each mesh, found by number.

/// The numbers from 0, cut into consecutive runs.
///
/// A look-up reads one entry of a guide, and searches the few runs that start before the next one. Source: Chen and Asau, "On
/// Generating Random Variates from an Empirical Distribution", AIIE Transactions 6(2), 1974.
#[derive(Clone, Debug, Default)]
pub struct Runs {
    /// The first number of each run, in ascending order; that of the first run is 0.
    starts: Vec<u32>,
    /// For each multiple of 2^`shift`, the number of runs that start there or before.
    guide: Vec<u32>,
    shift: u32,
    end: u32,
}

impl Runs {
    /// The runs that start at `starts` and end before `end`.
    pub fn new(starts: Vec<u32>, end: u32) -> Self {
        /// The entries of the guide for each run, at most.
        const ENTRIES: usize = 4;
        let mut shift = 0;
        while (end >> shift) as usize > ENTRIES * starts.len() {
            shift += 1;
        }
        let mut runs = 0;
        let guide = (0..=u64::from(end >> shift) + 1).map(|k| {
            while starts.get(runs).is_some_and(|start| u64::from(*start) <= k << shift) {
                runs += 1;
            }
            runs as u32
        });
        Self {
            guide: guide.collect(),
            starts,
            shift,
            end,
        }
    }

    /// The index of the run that holds `number`; the number of runs from the end of the last one on.
    #[inline]
    pub fn of(&self, number: u32) -> usize {
        if number >= self.end {
            return self.starts.len();
        }
        let k = (number >> self.shift) as usize;
        let (from, to) = (self.guide[k] as usize, self.guide[k + 1] as usize);
        from + self.starts[from..to].partition_point(|start| *start <= number) - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_run_of_each_number_is_the_last_that_starts_at_it_or_before() {
        let lengths: [&[u32]; 6] = [
            &[1],
            &[5],
            &[1; 9],
            &[7, 0, 0, 2],
            &[1000, 1, 1, 1, 3],
            &[1, 1, 2, 4000, 900, 1],
        ];
        for lengths in lengths {
            let starts: Vec<u32> = (0..lengths.len()).map(|i| lengths[..i].iter().sum()).collect();
            let end = lengths.iter().sum();
            let runs = Runs::new(starts.clone(), end);
            for number in 0..end {
                let expected = starts.partition_point(|start| *start <= number) - 1;
                assert_eq!(runs.of(number), expected, "{number} of {lengths:?}");
            }
            assert_eq!([end, u32::MAX].map(|number| runs.of(number)), [starts.len(); 2]);
        }
    }
}
