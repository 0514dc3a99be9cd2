//! Pictures through the `png` crate's reader.

use super::*;
use crate::{
    film::{Film, FilmLayout, PassRequest, Window, passes::BEAUTY},
    output::{Attribute, DisplayTransform, FrameMetadata},
};

const RGBA: [[f32; 4]; 4] = [
    [0.18, 0.18, 0.18, 1.0],
    [0.09, 0.0, 0.5, 0.5],
    [0.0, 0.0, 0.0, 0.0],
    [f32::NAN, 9.0, -1.0, f32::NAN],
];

fn film() -> Film {
    let passes = PassRequest::parse_list(["N"]).unwrap();
    let layout = FilmLayout::new(BEAUTY, &passes, &[]).unwrap();
    let mut film = Film::new([640, 480], Window::sized([-1, 7], [2, 2]), &layout);
    film.values_mut(0).copy_from_slice(RGBA.as_flattened());
    film.values_mut(1)[..3].copy_from_slice(&[-1.0, 1.0, 0.0]);
    film
}

fn metadata() -> FrameMetadata {
    FrameMetadata::example(-3, Vec::new())
}

fn image<'a>(film: &'a Film, metadata: &'a FrameMetadata) -> FrameImage<'a> {
    FrameImage {
        film,
        shown: Shown::All,
        coverage: Coverage::Partial,
        metadata,
    }
}

fn bytes(frame: &FrameImage) -> (Vec<u8>, WriteReport) {
    let mut out = Vec::new();
    let report = Png.encode(frame, Encoding::default(), &mut out).unwrap();
    assert_eq!(report.bytes, out.len() as u64);
    (out, report)
}

fn read(bytes: &[u8]) -> (::png::Info<'static>, Vec<u8>) {
    let mut reader = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    reader.finish().unwrap();
    (reader.info().clone(), pixels)
}

#[test]
fn alpha_is_straight_and_light_is_divided_by_it() {
    let (film, metadata) = (film(), metadata());
    let (file, report) = bytes(&image(&film, &metadata));
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
    let (film, metadata) = (film(), metadata());
    let full = FrameImage {
        coverage: Coverage::Full,
        ..image(&film, &metadata)
    };
    let (info, pixels) = read(&bytes(&full).0);
    assert_eq!(info.color_type, ::png::ColorType::Rgb);
    assert_eq!(pixels[..6], [118, 118, 118, 85, 0, 188]);
}

#[test]
fn only_srgb_is_said_to_be_srgb() {
    for (view, intent) in [
        (DisplayTransform::Srgb, Some(::png::SrgbRenderingIntent::Perceptual)),
        (DisplayTransform::Raw, None),
    ] {
        let metadata = FrameMetadata { view, ..metadata() };
        let (info, _) = read(&bytes(&image(&film(), &metadata)).0);
        assert_eq!(info.srgb, intent);
    }
}

#[test]
fn texts_say_where_a_picture_comes_from() {
    let attributes = vec![
        Attribute::new("camera", "cam 1"),
        Attribute::new("title", "Zoë: равнина"),
        Attribute::new("n".repeat(80), "no keyword"),
        Attribute::new("lens", 35.5_f32),
    ];
    let metadata = FrameMetadata {
        attributes,
        ..metadata()
    };
    let (info, _) = read(&bytes(&image(&film(), &metadata)).0);
    let latin: Vec<_> = info
        .uncompressed_latin1_text
        .iter()
        .map(|t| (t.keyword.as_str(), t.text.as_str()))
        .collect();
    let software = concat!("batch-render ", env!("CARGO_PKG_VERSION"));
    let expected = [
        (seal::NAME, seal::PLACEHOLDER),
        ("Software", software),
        ("Frame", "-3"),
        ("Samples", "64"),
        ("Seed", "5"),
        ("Sampler", "sobol"),
        ("batch-render/window", "2x2-1+7 of 640x480"),
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
    let (film, metadata) = (film(), metadata());
    assert_eq!(bytes(&image(&film, &metadata)), bytes(&image(&film, &metadata)));
}

#[test]
fn a_pass_of_data_is_shown_its_own_way_and_not_divided_by_alpha() {
    let (film, metadata) = (film(), metadata());
    let shown = FrameImage {
        shown: Shown::Plane(1),
        ..image(&film, &metadata)
    };
    let (info, pixels) = read(&bytes(&shown).0);
    assert_eq!(
        (info.srgb, &pixels[..8]),
        (None, &[0, 255, 128, 255, 128, 128, 128, 128][..])
    );
    assert!(
        info.uncompressed_latin1_text
            .iter()
            .any(|t| t.keyword == "Pass" && t.text == "N")
    );
}

#[test]
fn a_file_is_whole_only_to_its_last_byte() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("f.png");
    let (mut file, _) = bytes(&image(&film(), &metadata()));
    std::fs::write(&path, &file).unwrap();
    assert!(Png.inspect(&path).is_none(), "it is not sealed yet");
    seal::seal(&mut file);
    for length in 0..file.len() {
        std::fs::write(&path, &file[..length]).unwrap();
        assert!(Png.inspect(&path).is_none(), "{length}");
    }
    std::fs::write(&path, &file).unwrap();
    assert!(Png.inspect(&path).is_some());
    assert!(Png.inspect(home.path()).is_none());
}
