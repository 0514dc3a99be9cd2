//! A canvas: the display values of a film while it renders.

use std::sync::{Mutex, MutexGuard};

use crate::{
    batch::Plan,
    film::{Film, PassSpec, Window},
    output::{
        Coverage, Shown,
        display::{PixelDisplay, quantize},
    },
    render::{self, TileResult},
    value::UnknownName,
};

/// The colour behind transparent pictures, also on the page.
const BACKDROP: f32 = 38.0;

/// The display values of a film while it renders.
pub struct Canvas {
    display: PixelDisplay,
    /// The shown plane.
    plane: usize,
    pass: &'static PassSpec,
    coverage: Coverage,
    pub size: [u32; 2],
    inner: Mutex<Inner>,
}

struct Inner {
    film: Film,
    rgb: Vec<u8>,
    /// The end of the round's samples, and the number of pixels that have them.
    round: u32,
    finished: usize,
}

/// The state of a canvas after a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The samples of each finished pixel.
    pub samples: u32,
    /// Whether all pixels have them.
    pub is_complete: bool,
}

impl Canvas {
    /// A canvas for films of these settings of `plan`, of a scene with these light groups.
    ///
    /// # Errors
    /// A pass shows a light group that the scene does not have.
    pub fn new(
        plan: &Plan,
        settings: &render::Settings,
        groups: &[String],
        coverage: Coverage,
    ) -> Result<Self, UnknownName> {
        let picture = render::picture_of(plan.picture.integrator.as_dyn());
        let layout = settings.film_layout(picture, groups)?;
        let plane = match plan.picture.shown {
            Shown::All => 0,
            Shown::Plane(plane) => plane,
        };
        let pass = layout.planes()[plane].pass;
        let film = Film::new(settings.resolution, settings.window, &layout);
        Ok(Self {
            display: PixelDisplay::new(
                pass.display,
                plan.picture.view,
                plan.picture.exposure,
                plan.picture.working_space,
            ),
            plane,
            pass,
            coverage,
            size: [settings.window.width(), settings.window.height()],
            inner: Mutex::new(Inner {
                rgb: vec![BACKDROP as u8; 3 * settings.window.area()],
                film,
                round: 0,
                finished: 0,
            }),
        })
    }

    /// Draws a tile.
    pub fn draw(&self, tile: &TileResult<'_>) -> Progress {
        let window = tile.tile();
        let mut inner = self.lock();
        let Inner {
            film,
            rgb,
            round,
            finished,
        } = &mut *inner;
        tile.resolve_into(film);
        self.show(film, window, rgb);
        if *round != tile.samples.end {
            (*round, *finished) = (tile.samples.end, 0);
        }
        *finished += window.area();
        Progress {
            samples: *round,
            is_complete: *finished == film.window.area(),
        }
    }

    /// Draws a whole film of the canvas's settings.
    pub fn draw_film(&self, film: &Film) {
        self.show(film, film.window, &mut self.lock().rgb);
    }

    /// Fills the canvas with a picture of a lower resolution.
    pub fn fill(&self, rgb: &[u8], [width, height]: [u32; 2]) {
        let [own_width, own_height] = self.size;
        let mut inner = self.lock();
        for (y, row) in inner.rgb.chunks_exact_mut(3 * own_width as usize).enumerate() {
            let from = (y * height as usize / own_height as usize) * width as usize;
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let i = 3 * (from + x * width as usize / own_width as usize);
                pixel.copy_from_slice(&rgb[i..i + 3]);
            }
        }
    }

    /// R, G and B of each pixel, row by row.
    pub fn rgb(&self) -> Vec<u8> {
        self.lock().rgb.clone()
    }

    fn show(&self, film: &Film, window: Window, rgb: &mut [u8]) {
        let plane = &film.planes()[self.plane];
        for y in window.y0..window.y1 {
            let start = film.window.index(window.x0, y);
            for i in start..start + window.width() as usize {
                let values = plane.pixel(i);
                let channels: [f32; 3] = std::array::from_fn(|c| values.get(c).copied().unwrap_or(0.0));
                let pixel = match self.coverage {
                    Coverage::Full => self.display.rgb8(channels),
                    Coverage::Partial => self.over_backdrop(channels, film.beauty()[i][3]),
                };
                rgb[3 * i..][..3].copy_from_slice(&pixel);
            }
        }
    }

    /// The display values of a pixel with straight alpha, over the backdrop.
    fn over_backdrop(&self, channels: [f32; 3], alpha: f32) -> [u8; 3] {
        let straight = match self.pass.is_light() && alpha > 0.0 {
            true => channels.map(|v| v / alpha),
            false => channels,
        };
        let over = |v: u8| (f32::from(v) * alpha + BACKDROP * (1.0 - alpha)) / 255.0;
        self.display.rgb8(straight).map(|v| quantize(over(v)))
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().expect("no thread panics while it draws")
    }
}
