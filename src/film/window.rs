//! Rectangles of pixels.

/// Columns `x0..x1` and rows `y0..y1` of a picture; the origin is its top left pixel, x runs to the right, y down. Overscan
/// has negative coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    pub x0: i32,
    pub y0: i32,
    pub x1: i32,
    pub y1: i32,
}

impl Window {
    pub const fn new(x0: i32, y0: i32, x1: i32, y1: i32) -> Self {
        Self { x0, y0, x1, y1 }
    }

    /// The window with this top left pixel and this many columns and rows.
    pub const fn sized([x0, y0]: [i32; 2], [width, height]: [u32; 2]) -> Self {
        Self::new(
            x0,
            y0,
            x0.wrapping_add_unsigned(width),
            y0.wrapping_add_unsigned(height),
        )
    }

    /// The window of a whole picture, which has fewer than 2^31 columns and rows.
    pub const fn full([width, height]: [u32; 2]) -> Self {
        Self::new(0, 0, width as i32, height as i32)
    }

    pub const fn width(&self) -> u32 {
        self.x1.abs_diff(self.x0)
    }

    pub const fn height(&self) -> u32 {
        self.y1.abs_diff(self.y0)
    }

    /// The number of its pixels.
    pub const fn area(&self) -> usize {
        self.width() as usize * self.height() as usize
    }

    /// The index of a pixel inside, counted by rows from the top left.
    pub const fn index(&self, x: i32, y: i32) -> usize {
        y.abs_diff(self.y0) as usize * self.width() as usize + x.abs_diff(self.x0) as usize
    }

    /// The pixel with this index.
    pub const fn place(&self, index: usize) -> [i32; 2] {
        let width = self.width();
        let (column, row) = (index as u32 % width, index as u32 / width);
        [self.x0 + column as i32, self.y0 + row as i32]
    }

    /// The intersection; possibly empty.
    pub fn intersection(self, other: Self) -> Self {
        let (x0, y0) = (self.x0.max(other.x0), self.y0.max(other.y0));
        let (x1, y1) = (self.x1.min(other.x1), self.y1.min(other.y1));
        Self::new(x0, y0, x1.max(x0), y1.max(y0))
    }

    /// Squares of `side` pixels that cover it, row by row, smaller at its right and lower edge.
    pub fn tiles(self, side: u32) -> impl ExactSizeIterator<Item = Self> + Clone {
        let columns = self.width().div_ceil(side);
        let rows = self.height().div_ceil(side);
        (0..(columns * rows) as usize).map(move |i| {
            let x0 = self.x0 + (i as u32 % columns * side) as i32;
            let y0 = self.y0 + (i as u32 / columns * side) as i32;
            let side = side as i32;
            Self::new(x0, y0, (x0 + side).min(self.x1), (y0 + side).min(self.y1))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for window in [Window::new(3, 5, 20, 18), Window::new(-7, -3, 10, 10)] {
            let mut count = vec![0; window.area()];
            for t in window.tiles(8) {
                for y in t.y0..t.y1 {
                    for x in t.x0..t.x1 {
                        count[window.index(x, y)] += 1;
                    }
                }
            }
            assert!(count.iter().all(|n| *n == 1));
        }
    }
}
