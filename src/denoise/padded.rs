//! Planes with a margin, so that windows around pixels need no care at the edges.

/// A plane of numbers with a margin of copies of the nearest pixels.
pub(super) struct Padded {
    values: Vec<f32>,
    stride: usize,
    margin: usize,
}

impl Padded {
    pub fn new(plane: &[f32], [width, height]: [usize; 2], margin: usize) -> Self {
        let stride = width + 2 * margin;
        let mut values = Vec::with_capacity(stride * (height + 2 * margin));
        for y in 0..height + 2 * margin {
            let row = &plane[y.saturating_sub(margin).min(height - 1) * width..][..width];
            values.extend(std::iter::repeat_n(row[0], margin));
            values.extend(row);
            values.extend(std::iter::repeat_n(row[width - 1], margin));
        }
        Self { values, stride, margin }
    }

    /// The plane with a margin of 0.
    pub fn within(plane: &[f32], [width, height]: [usize; 2], margin: usize) -> Self {
        let stride = width + 2 * margin;
        let mut values = vec![0.0; stride * (height + 2 * margin)];
        let rows = values.chunks_exact_mut(stride).skip(margin);
        for (row, values) in rows.zip(plane.chunks_exact(width)) {
            row[margin..margin + width].copy_from_slice(values);
        }
        Self { values, stride, margin }
    }

    /// The `length` pixels of row `y` from column `x` on; both may lie in the margin.
    #[inline(always)]
    pub fn row(&self, x: isize, y: isize, length: usize) -> &[f32] {
        let margin = self.margin as isize;
        let at = (y + margin) as usize * self.stride + (x + margin) as usize;
        &self.values[at..at + length]
    }
}
