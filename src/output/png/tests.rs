//! Pictures through the `png` crate's reader.

use super::*;
use crate::{
    film::view::View,
    output::{Attribute, Window},
};

const RGBA: [[f32; 4]; 4] = [
    [0.18, 0.18, 0.18, 1.0],
    [0.09, 0.0, 0.5, 0.5],
    [0.0, 0.0, 0.0, 0.0],
    [f32::NAN, 9.0, -1.0, f32::NAN],
];

fn frame() -> FrameImage<'static> {
    FrameImage {
        resolution: [640, 480],
        window: Window {
            x: -1,
            y: 7,
            width: 2,
            height: 2,
        },
        rgba: &RGBA,
        coverage: Coverage::Partial,
        layers: &[],
        layer_attributes: &[],
        frame: -3,
        samples: 64,
        seed: 5,
        sampler: "sobol",
        view: View::Srgb,
        exposure: 0.0,
        fps: None,
        metadata: &[],
    }
}

fn bytes(frame: &FrameImage) -> (Vec<u8>, WriteReport) {
    let mut out = Vec::new();
    let report = Png.encode(frame, Encoding::default(), &mut out).unwrap();
    assert_eq!(report.bytes, out.len() as u64);
    (out, report)
}

fn read(bytes: &[u8]) -> (::png::Info<'static>, Vec<u8>) {
    let mut reader = ::png::Decoder::new(io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    reader.finish().unwrap();
    (reader.info().clone(), pixels)
}

#[test]
fn alpha_is_straight_and_light_is_divided_by_it() {
    let (file, report) = bytes(&frame());
    let (info, pixels) = read(&file);
    assert_eq!(
        (info.width, info.height, info.color_type),
        (2, 2, ::png::ColorType::Rgba)
    );
    assert_eq!(pixels[..4], [118, 118, 118, 255]);
    assert_eq!(pixels[4..8], [118, 0, 255, 128]);
    assert_eq!(pixels[8..12], [0; 4]);
    assert_eq!(pixels[12..], [0, 255, 0, 0]);
    assert_eq!((report.nans, report.clamped), (2, 0));
}

#[test]
fn a_visible_background_leaves_alpha_out() {
    let (info, pixels) = read(
        &bytes(&FrameImage {
            coverage: Coverage::Full,
            ..frame()
        })
        .0,
    );
    assert_eq!(info.color_type, ::png::ColorType::Rgb);
    assert_eq!(pixels[..6], [118, 118, 118, 85, 0, 188]);
}

#[test]
fn only_srgb_is_said_to_be_srgb() {
    for (view, intent) in [
        (View::Srgb, Some(::png::SrgbRenderingIntent::Perceptual)),
        (View::Raw, None),
    ] {
        let (info, _) = read(&bytes(&FrameImage { view, ..frame() }).0);
        assert_eq!(info.srgb, intent);
    }
}

#[test]
fn texts_say_where_a_picture_comes_from() {
    let metadata = [
        Attribute::new("camera", "cam 1"),
        Attribute::new("title", "Zoë: равнина"),
        Attribute::new("n".repeat(80), "no keyword"),
        Attribute::new("lens", 35.5_f32),
    ];
    let (info, _) = read(
        &bytes(&FrameImage {
            metadata: &metadata,
            ..frame()
        })
        .0,
    );
    let latin: Vec<_> = info
        .uncompressed_latin1_text
        .iter()
        .map(|t| (t.keyword.as_str(), t.text.as_str()))
        .collect();
    let software = concat!("batch-render ", env!("CARGO_PKG_VERSION"));
    let expected = [
        ("Software", software),
        ("Frame", "-3"),
        ("Samples", "64"),
        ("Seed", "5"),
        ("Sampler", "sobol"),
        ("View", "srgb"),
        ("Exposure", "0"),
        ("camera", "cam 1"),
        ("lens", "35.5"),
    ];
    assert_eq!(latin, expected);
    assert_eq!(info.utf8_text[0].keyword, "title");
    assert_eq!(info.utf8_text[0].get_text().unwrap(), "Zoë: равнина");
}

#[test]
fn the_same_picture_gives_the_same_bytes() {
    assert_eq!(bytes(&frame()), bytes(&frame()));
}

#[test]
fn too_few_pixels_are_refused() {
    let short = FrameImage {
        rgba: &RGBA[..3],
        ..frame()
    };
    let result = Png.encode(&short, Encoding::default(), &mut Vec::new());
    assert!(matches!(result, Err(EncodeError::Unfit(_))));
}

#[test]
fn a_file_is_whole_only_to_its_last_byte() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("f.png");
    let (file, _) = bytes(&frame());
    for length in 0..file.len() {
        std::fs::write(&path, &file[..length]).unwrap();
        assert!(Png.inspect(&path).is_none(), "{length}");
    }
    std::fs::write(&path, &file).unwrap();
    assert!(Png.inspect(&path).is_some());
    assert!(Png.inspect(home.path()).is_none());
}
