//! Rectangles of pixels.

/// Columns `x0..x1` and rows `y0..y1` of a picture, from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    pub x0: u32,
    pub y0: u32,
    pub x1: u32,
    pub y1: u32,
}

impl Window {
    pub const fn new(x0: u32, y0: u32, x1: u32, y1: u32) -> Self {
        Self { x0, y0, x1, y1 }
    }

    /// The whole of a picture.
    pub const fn full([width, height]: [u32; 2]) -> Self {
        Self::new(0, 0, width, height)
    }

    pub const fn width(&self) -> u32 {
        self.x1 - self.x0
    }

    pub const fn height(&self) -> u32 {
        self.y1 - self.y0
    }

    /// How many pixels it has.
    pub const fn area(&self) -> usize {
        self.width() as usize * self.height() as usize
    }

    /// Squares of `side` pixels that cover it, row by row, smaller at its right and lower edge.
    pub fn tiles(self, side: u32) -> impl ExactSizeIterator<Item = Self> + Clone {
        let columns = self.width().div_ceil(side);
        let rows = self.height().div_ceil(side);
        (0..(columns * rows) as usize).map(move |i| {
            let x0 = self.x0 + i as u32 % columns * side;
            let y0 = self.y0 + i as u32 / columns * side;
            Self::new(x0, y0, (x0 + side).min(self.x1), (y0 + side).min(self.y1))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        let window = Window::new(3, 5, 20, 18);
        let mut seen = vec![0; 400];
        for t in window.tiles(8) {
            for y in t.y0..t.y1 {
                for x in t.x0..t.x1 {
                    seen[(y * 20 + x) as usize] += 1;
                }
            }
        }
        for (i, n) in seen.iter().enumerate() {
            let inside = i % 20 >= 3 && (5..18).contains(&(i / 20));
            assert_eq!(*n, i32::from(inside));
        }
    }
}
