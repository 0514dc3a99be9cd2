//! Two films in one: the pictures of two eyes.

use super::{Film, Plane, Window};
use crate::camera::stereo::EyeLayout;

impl Film {
    /// The film of two pictures of the same size and passes, neither of them a part of a larger one; this one is the first.
    pub fn beside(&self, second: &Self, layout: EyeLayout) -> Self {
        let [x, y] = layout.factors();
        let resolution = [self.resolution[0] * x, self.resolution[1] * y];
        let planes = self.planes.iter().zip(&second.planes).map(|(first, second)| {
            // Lines, or layers, of the one follow those of the other.
            let pixels = match layout {
                EyeLayout::SideBySide => self.window.width() as usize,
                EyeLayout::TopBottom => self.window.area(),
            };
            let run = pixels * first.spec.step();
            let mut values = Vec::with_capacity(2 * first.values.len());
            for (one, other) in first.values.chunks(run).zip(second.values.chunks(run)) {
                values.extend_from_slice(one);
                values.extend_from_slice(other);
            }
            Plane {
                spec: first.spec.clone(),
                values,
            }
        });
        Self {
            resolution,
            window: Window::full(resolution),
            samples: self.samples.min(second.samples),
            planes: planes.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{FilmLayout, PassRequest, passes::BEAUTY};

    #[test]
    fn each_half_has_the_values_of_its_film_in_every_plane_and_layer() {
        let passes = PassRequest::parse_list(["depth", "CryptoObject"]).expect("passes");
        let layout = FilmLayout::new(BEAUTY, &passes, &[]).expect("a layout");
        let size = [3, 2];
        let film = |from: f32| {
            let mut film = Film::new(size, Window::full(size), &layout);
            for plane in 0..film.planes().len() {
                let values = film.values_mut(plane).iter_mut();
                values.zip(0_u16..).for_each(|(to, i)| *to = from + f32::from(i));
            }
            film
        };
        let films = [film(0.0), film(1000.0)];
        for layout in EyeLayout::ALL {
            let whole = films[0].beside(&films[1], layout);
            let [x, y] = layout.factors();
            assert_eq!((whole.resolution, whole.window.area()), ([3 * x, 2 * y], 12));
            for (at, film) in films.iter().enumerate() {
                for (own, plane) in film.planes().iter().zip(whole.planes()) {
                    let step = own.spec.step();
                    for layer in 0..own.spec.width() / step {
                        for pixel in 0..6 {
                            let [column, row] = [pixel % 3, pixel / 3];
                            let [left, top] = match layout {
                                EyeLayout::SideBySide => [3 * at, 0],
                                EyeLayout::TopBottom => [0, 2 * at],
                            };
                            let place = (row + top) * 3 * x as usize + column + left;
                            let values = |plane: &Plane, at: usize| plane.values[at * step..][..step].to_vec();
                            assert_eq!(values(own, layer * 6 + pixel), values(plane, layer * 12 + place));
                        }
                    }
                }
            }
        }
    }
}
