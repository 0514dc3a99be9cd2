//! The film: the pixels of the beauty and of all other passes.

pub mod accumulator;
pub mod coverage;
mod features;
pub mod layout;
mod motion;
pub mod noise;
mod pass_spec;
pub mod passes;
pub mod pixel_sum;
pub mod request;
mod state;
pub mod window;

pub use accumulator::{SampleRecord, TileAccumulator};
pub use layout::{FilmLayout, PlaneSpec};
pub use passes::{PassSpec, PixelType};
pub use request::PassRequest;
pub use window::Window;

/// The passes of one frame.
#[derive(Clone, Debug)]
pub struct Film {
    /// Columns and rows of the full picture.
    pub resolution: [u32; 2],
    /// The rendered part of the picture.
    pub window: Window,
    /// The samples of each pixel, except those that adaptive sampling stopped before.
    pub samples: u32,
    planes: Vec<Plane>,
}

/// The values of one pass.
#[derive(Clone, Debug)]
pub struct Plane {
    pub spec: PlaneSpec,
    /// [`PlaneSpec::width`] values for each pixel of the film's window, row by row from the top.
    pub values: Vec<f32>,
}

impl Film {
    /// A film filled with the background values of its passes.
    pub fn new(resolution: [u32; 2], window: Window, layout: &FilmLayout) -> Self {
        let plane = |spec: &PlaneSpec| Plane {
            spec: spec.clone(),
            values: vec![spec.pass.background; window.area() * spec.width()],
        };
        Self {
            resolution,
            window,
            samples: 0,
            planes: layout.planes().iter().map(plane).collect(),
        }
    }

    /// R, G, B, A of each pixel of the window, row by row from the top, premultiplied, scene-linear.
    pub fn beauty(&self) -> &[[f32; 4]] {
        bytemuck::cast_slice(&self.planes[0].values)
    }

    /// All planes, the beauty first.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// The values of the pass of this name.
    pub fn plane(&self, name: &str) -> Option<&Plane> {
        self.planes.iter().find(|plane| plane.spec.name == name)
    }

    /// The values of the plane with this index, to be changed.
    pub fn values_mut(&mut self, plane: usize) -> &mut [f32] {
        &mut self.planes[plane].values
    }

    /// Copies the pixels of `tile`, row by row from the top, to a plane; those outside of the film's window are left out.
    fn put<P: AsRef<[f32]>>(&mut self, plane: usize, tile: Window, mut pixels: impl Iterator<Item = P>) {
        let Plane { spec, values } = &mut self.planes[plane];
        let width = spec.width();
        let inner = tile.intersection(self.window);
        for y in tile.y0..tile.y1 {
            let mut pixels = pixels.by_ref().take(tile.width() as usize);
            if (inner.y0..inner.y1).contains(&y) {
                let row = &mut values[self.window.index(inner.x0, y) * width..];
                let row = row.chunks_exact_mut(width).take(inner.width() as usize);
                let own_pixels = pixels.by_ref().skip(inner.x0.abs_diff(tile.x0) as usize);
                for (own, pixel) in row.zip(own_pixels) {
                    own.copy_from_slice(pixel.as_ref());
                }
            }
            pixels.for_each(drop);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_land_where_they_belong() {
        let window = Window::new(10, 20, 14, 22);
        let mut film = Film::new([100, 100], window, &FilmLayout::default());
        film.put(0, Window::new(12, 21, 14, 22), [[1.0; 4], [2.0; 4]].into_iter());
        assert_eq!(film.beauty()[6], [1.0; 4]);
        assert_eq!(film.beauty()[7], [2.0; 4]);
        assert_eq!(film.beauty().iter().filter(|p| p[0] == 0.0).count(), 6);
        // Of a tile that reaches beyond the film, the pixels inside.
        let tile = Window::new(8, 18, 12, 22);
        film.put(0, tile, (0..16).map(|i| [i as f32; 4]));
        let reds: Vec<f32> = film.beauty().iter().map(|p| p[0]).collect();
        assert_eq!(reds, [10.0, 11.0, 0.0, 0.0, 14.0, 15.0, 1.0, 2.0]);
        film.put(0, Window::new(14, 20, 18, 22), (0..8).map(|_| [9.0; 4]));
        assert!(film.beauty().iter().all(|p| p[0] != 9.0));
    }

    #[test]
    fn a_film_begins_with_the_backgrounds_of_its_passes() {
        let passes = PassRequest::parse_list(["depth", "objectId"]).unwrap();
        let layout = FilmLayout::new(passes::BEAUTY, &passes, &[]).unwrap();
        let film = Film::new([2, 1], Window::full([2, 1]), &layout);
        assert_eq!(film.plane("depth").unwrap().values, [1e10; 2]);
        assert_eq!(film.plane("objectId").unwrap().values, [0.0; 2]);
        assert!(film.plane("N").is_none());
    }
}
