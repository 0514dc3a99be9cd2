//! Run-length encodings of the pixels of an object.
//!
//! The lengths of runs of 0 and 1 by turns down the columns, each but the first two as the difference from the one but one before
//! it, in groups of 5 bits from the lowest with a sixth bit where more follow, as characters from `0` on.

/// The pixels of an object, as runs down the columns.
#[derive(Default)]
pub struct Runs {
    /// The first pixel of each run and the one after its last, counted down the columns.
    runs: Vec<[u32; 2]>,
    pub area: u32,
    /// The first and the last column and row.
    corners: Option<[[u32; 2]; 2]>,
}

impl Runs {
    /// Adds a pixel that comes after all others.
    pub fn add(&mut self, pixel: [u32; 2], height: u32) {
        let at = pixel[0] * height + pixel[1];
        match self.runs.last_mut() {
            Some([_, end]) if *end == at => *end += 1,
            _ => self.runs.push([at, at + 1]),
        }
        self.area += 1;
        let [first, last] = self.corners.get_or_insert([pixel; 2]);
        for axis in 0..2 {
            first[axis] = first[axis].min(pixel[axis]);
            last[axis] = last[axis].max(pixel[axis]);
        }
    }

    /// The first column and row, the width and the height.
    pub fn bounds(&self) -> [u32; 4] {
        let [[x0, y0], [x1, y1]] = self.corners.unwrap_or_default();
        [x0, y0, x1 + 1 - x0, y1 + 1 - y0]
    }

    /// The encoding in a picture of this size.
    pub fn counts(&self, [width, height]: [u32; 2]) -> String {
        let mut lengths = Vec::with_capacity(2 * self.runs.len() + 1);
        let mut end = 0;
        for [from, to] in &self.runs {
            lengths.extend([from - end, to - from]);
            end = *to;
        }
        if end < width * height {
            lengths.push(width * height - end);
        }
        let lengths: Vec<i64> = lengths.into_iter().map(i64::from).collect();
        let mut text = String::new();
        for (i, length) in lengths.iter().enumerate() {
            let mut rest = if i > 2 { length - lengths[i - 2] } else { *length };
            loop {
                let group = (rest & 0x1f) as u8;
                rest >>= 5;
                // The highest bit of the last group is the sign.
                let is_last = rest == if group & 0x10 == 0 { 0 } else { -1 };
                text.push(char::from(b'0' + (group | if is_last { 0 } else { 0x20 })));
                if is_last {
                    break;
                }
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(rows: &[&str]) -> (Runs, [u32; 2]) {
        let size = [rows[0].len() as u32, rows.len() as u32];
        let mut runs = Runs::default();
        for column in 0..size[0] {
            for row in 0..size[1] {
                if rows[row as usize].as_bytes()[column as usize] == b'#' {
                    runs.add([column, row], size[1]);
                }
            }
        }
        (runs, size)
    }

    /// The lengths that a text encodes.
    fn decoded(text: &str) -> Vec<i64> {
        let (mut lengths, mut bytes) = (Vec::<i64>::new(), text.bytes().peekable());
        while bytes.peek().is_some() {
            let (mut value, mut shift) = (0, 0);
            for byte in bytes.by_ref() {
                let group = i64::from(byte - b'0');
                value |= (group & 0x1f) << shift;
                shift += 5;
                if group & 0x20 == 0 {
                    if group & 0x10 != 0 {
                        value |= -1 << shift;
                    }
                    break;
                }
            }
            if lengths.len() > 2 {
                value += lengths[lengths.len() - 2];
            }
            lengths.push(value);
        }
        lengths
    }

    #[test]
    fn masks_are_runs_of_columns_with_their_box_and_area() {
        let (mask, size) = runs(&["....", ".##.", ".#.#"]);
        assert_eq!((mask.area, mask.bounds()), (4, [1, 1, 3, 2]));
        assert_eq!(decoded(&mask.counts(size)), [4, 2, 1, 1, 3, 1]);
        let (whole, size) = runs(&["##", "##"]);
        assert_eq!(
            (decoded(&whole.counts(size)), whole.bounds()),
            (vec![0, 4], [0, 0, 2, 2])
        );
        // As pycocotools encodes it.
        assert_eq!(whole.counts(size), "04");
    }

    #[test]
    fn long_and_shrinking_runs_come_back() {
        let mut mask = Runs::default();
        for at in (0..5000).chain([5001, 6000, 6001, 9000]) {
            mask.add([at / 100, at % 100], 100);
        }
        let lengths = [0, 5000, 1, 1, 998, 2, 2998, 1, 999];
        assert_eq!(decoded(&mask.counts([100, 100])), lengths);
    }
}
