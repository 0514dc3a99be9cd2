//! The film: the pixels of the beauty and of all other passes.

pub mod accumulator;
mod accumulator_layout;
mod beside;
mod catchers;
pub mod coverage;
mod features;
pub mod layout;
mod motion;
pub mod noise;
mod pass_spec;
pub mod passes;
pub mod pixel_sum;
pub mod request;
mod sample_record;
mod state;
pub mod window;

pub use accumulator::TileAccumulator;
pub use accumulator_layout::AccumulatorLayout;
pub use layout::{FilmLayout, PlaneSpec};
pub use passes::{PassSpec, PixelType};
pub use request::PassRequest;
pub use sample_record::SampleRecord;
pub use window::Window;

use bytemuck::cast_slice;

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
    /// For each pixel of the film's window, row by row from the top, [`PlaneSpec::step`] values; of passes of mattes first the
    /// first layer of all pixels, then the second and so on.
    pub values: Vec<f32>,
}

impl Plane {
    /// The values of a pixel, of passes of mattes those of the first layer.
    pub fn pixel(&self, index: usize) -> &[f32] {
        let step = self.spec.step();
        &self.values[index * step..][..step]
    }
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
        cast_slice(&self.planes[0].values)
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

    /// Copies the pixels of `tile`, row by row from the top, to a plane; those outside of the film's window are left out. Values
    /// that are there already are not written: the system gives a page of zeros memory at the first write to it, so layers of
    /// mattes that few pixels have, and passes that a scene does not use, take none.
    fn put<P: AsRef<[f32]>>(&mut self, plane: usize, tile: Window, mut pixels: impl Iterator<Item = P>) {
        let Plane { spec, values } = &mut self.planes[plane];
        let (step, layers) = (spec.step(), spec.width() / spec.step());
        let layer = values.len() / layers;
        let inner = tile.intersection(self.window);
        for y in tile.y0..tile.y1 {
            let mut pixels = pixels.by_ref().take(tile.width() as usize);
            if (inner.y0..inner.y1).contains(&y) {
                let first = self.window.index(inner.x0, y);
                let own_pixels = pixels.by_ref().skip(inner.x0.abs_diff(tile.x0) as usize);
                for (i, pixel) in (first..first + inner.width() as usize).zip(own_pixels) {
                    for (k, part) in pixel.as_ref().chunks_exact(step).enumerate() {
                        let own = &mut values[k * layer + i * step..][..step];
                        if cast_slice::<f32, u32>(own) != cast_slice::<f32, u32>(part) {
                            own.copy_from_slice(part);
                        }
                    }
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
    fn mattes_of_a_pixel_lie_in_layers_and_every_bit_is_kept() {
        let passes = PassRequest::parse_list(["CryptoObject", "N"]).unwrap();
        let layout = FilmLayout::new(passes::BEAUTY, &passes, &[]).unwrap().with_ranks(4);
        let mut film = Film::new([2, 1], Window::full([2, 1]), &layout);
        let pixels = [0.0, 8.0].map(|first: f32| std::array::from_fn::<f32, 8, _>(|i| first + i as f32));
        film.put(1, Window::full([2, 1]), pixels.into_iter());
        let values = &film.planes()[1].values;
        assert_eq!(values[..8], [0.0, 1.0, 2.0, 3.0, 8.0, 9.0, 10.0, 11.0]);
        assert_eq!(values[8..], [4.0, 5.0, 6.0, 7.0, 12.0, 13.0, 14.0, 15.0]);
        assert_eq!(film.planes()[1].pixel(1), [8.0, 9.0, 10.0, 11.0]);
        // A negative zero is equal to the background, and another number.
        film.put(2, Window::full([2, 1]), [[-0.0; 3], [1.0; 3]].into_iter());
        assert!(film.planes()[2].values[0].is_sign_negative());
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
