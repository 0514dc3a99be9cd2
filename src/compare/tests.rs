use super::*;
use crate::{assets::image::PictureWindow, math::Rgb};

const SIZE: [u32; 2] = [96, 64];

/// A picture of waves and a bright spot, `shift` pixels to the right.
fn picture(is_light: bool, shift: u32) -> Picture {
    let [width, height] = SIZE;
    let pixel = |i: u32| {
        let (x, y) = (i % width + shift, i / width);
        let wave = |n: u32| ((x * n + y * (n + 2)) % 37) as f32 / 36.0;
        let spot = if is_light && x / 8 == 6 && y / 8 == 3 {
            40.0
        } else {
            1.0
        };
        Rgb::new(wave(3), wave(5) * 0.75, wave(1) * 0.5).map(|v| v * spot)
    };
    Picture {
        size: SIZE,
        window: PictureWindow {
            first: [0; 2],
            display: SIZE,
        },
        is_light,
        data: None,
        pixels: (0..width * height).map(pixel).collect(),
        alpha: Vec::new(),
        not_finite: 0,
    }
}

fn compared(reference: &Picture, test: &Picture) -> Measures {
    Comparison::new(reference, test, 0.0).expect("comparable").measures
}

/// The figures are those of flip-evaluator 1.7 for the same pictures.
#[test]
fn flip_is_that_of_its_authors() {
    for (is_light, expected) in [(false, 0.456_181), (true, 0.432_423)] {
        let [reference, test] = [0, 3].map(|shift| picture(is_light, shift));
        let flip = compared(&reference, &test).flip;
        assert!((flip - expected).abs() < 1e-5, "{flip} instead of {expected}");
    }
}

#[test]
fn equal_pictures_differ_by_nothing() {
    for is_light in [false, true] {
        let picture = picture(is_light, 0);
        let Measures {
            flip,
            rmse,
            relmse,
            pixels,
            largest,
            alpha_rmse,
        } = compared(&picture, &picture);
        assert_eq!([flip, rmse, relmse, pixels, largest, alpha_rmse], [0.0; 6]);
    }
}

#[test]
fn measures_are_their_formulas() {
    let reference = picture(true, 0);
    let mut test = reference.clone();
    test.pixels[5].g += 2.0;
    test.alpha = vec![1.0; reference.pixels.len()];
    test.alpha[7] = 0.5;
    let measures = compared(&reference, &test);
    let pixels = f64::from(SIZE[0] * SIZE[1]);
    let g = f64::from(reference.pixels[5].g);
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6 * b, "{a} instead of {b}");
    close(measures.rmse, (4.0 / (3.0 * pixels)).sqrt());
    close(measures.relmse, 4.0 / (g * g + 0.01) / (3.0 * pixels));
    close(measures.pixels, 2.0 / pixels);
    close(measures.largest, 2.0);
    close(measures.alpha_rmse, (0.25 / pixels).sqrt());
}

#[test]
fn pictures_of_other_sizes_and_ranges_are_refused() {
    let light = picture(true, 0);
    let mut narrow = light.clone();
    narrow.size = [SIZE[1], SIZE[0]];
    assert!(matches!(
        Comparison::new(&light, &narrow, 0.0),
        Err(CompareError::Window { .. })
    ));
    narrow.window.display = narrow.size;
    assert!(matches!(
        Comparison::new(&light, &narrow, 0.0),
        Err(CompareError::Size { .. })
    ));
    assert!(matches!(
        Comparison::new(&light, &picture(false, 0), 0.0),
        Err(CompareError::Range)
    ));
}

/// Writes a gray PNG file of 16 bits, with these texts.
fn numbers(path: &Path, values: [u16; 4], texts: &[(&str, &str)]) {
    let file = std::fs::File::create(path).expect("a file");
    let mut encoder = png::Encoder::new(file, 2, 2);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    for (key, text) in texts {
        let added = encoder.add_text_chunk((*key).to_owned(), (*text).to_owned());
        added.expect("a text");
    }
    let mut writer = encoder.write_header().expect("a header");
    let bytes: Vec<u8> = values.into_iter().flat_map(u16::to_be_bytes).collect();
    writer.write_image_data(&bytes).expect("pixels");
}

#[test]
fn data_of_16_bits_are_compared_as_numbers_and_ids_exactly() {
    let folder = tempfile::tempdir().expect("a folder");
    let [a, b] = ["a.png", "b.png"].map(|name| folder.path().join(name));
    let compared = |limit| compare(&a, &b, limit, &Files::default()).map(|found| found.measures);
    let [ids, depth, normals] = ["objectId", "depth", "N"].map(|pass| [("Pass", pass), ("Unit", "a unit")]);
    for (texts, limit, pixels) in [
        (&ids[..], 5.0, 0.5),
        (&depth, 0.5, 0.5),
        (&depth, 1.0, 0.0),
        (&[], 0.5, 0.5),
    ] {
        numbers(&a, [1, 1, 0, 65535], texts);
        numbers(&b, [2, 1, 1, 65535], texts);
        let found = compared(limit).expect("comparable");
        assert_eq!(
            (found.largest, found.pixels, found.flip),
            (1.0, pixels, pixels),
            "{texts:?}"
        );
    }
    numbers(&a, [1, 32768, 65535, 32768], &normals);
    numbers(&b, [65535, 32768, 65535, 32768], &normals);
    assert_eq!(compared(0.0).expect("comparable").largest, 2.0);
    numbers(&a, [1; 4], &depth);
    assert!(matches!(compared(0.0), Err(CompareError::Data { .. })));
}
