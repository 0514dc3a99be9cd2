//! Small pictures of frames over black, as they look on a display.

use batch_render::output::FrameImage;

/// The picture of a frame, scaled down to at most so many columns. It is at most four times as high as that.
pub fn small_picture(image: &FrameImage<'_>, columns: u32) -> image::RgbImage {
    let (window, plane) = (image.film.window, image.picture());
    let (width, height) = (window.width(), window.height());
    let display = image.display();
    let w = columns.min(width);
    let h = (w * height).div_ceil(width.max(1)).clamp(1, 4 * columns);
    image::RgbImage::from_fn(w, h, |x, y| {
        // The mean of a few places within the pixel.
        const SIDE: u32 = 3;
        let mut sum = [0.0; 3];
        for place in 0..SIDE * SIDE {
            let along = |i: u32, k: u32, to: u32, from: u32| {
                let at = (f64::from(i) + (f64::from(k) + 0.5) / f64::from(SIDE)) / f64::from(to);
                ((at * f64::from(from)) as u32).min(from - 1) as usize
            };
            let (column, row) = (along(x, place % SIDE, w, width), along(y, place / SIDE, h, height));
            let pixel = plane.pixel(row * width as usize + column);
            for (sum, value) in sum.iter_mut().zip(pixel) {
                *sum += value / (SIDE * SIDE) as f32;
            }
        }
        image::Rgb(display.rgb8(sum))
    })
}
