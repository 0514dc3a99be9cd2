//! Files of every format, whole, cut short and forged.

use std::fs;

use ::image::ImageFormat as F;
use half::f16;

use super::*;
use crate::math::{Primaries, Rgb, WorkingSpace, hash};

const W: u32 = 37;
const H: u32 = 23;

/// A picture without symmetry, so that no row or column may change places.
fn pattern() -> DynamicImage {
    let value = |x: u32, y: u32, c: u32| hash::pcg4d([x, y, c, 0])[0] as u8;
    let pixel = |x, y| ::image::Rgb([value(x, y, 0), (x * 6) as u8, (y * 10) as u8]);
    DynamicImage::ImageRgb8(::image::RgbImage::from_fn(W, H, pixel))
}

fn file(picture: &DynamicImage, format: F) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    picture.write_to(&mut out, format).unwrap();
    out.into_inner()
}

fn decode(bytes: &[u8], name: &str) -> Result<Bitmap, ImageError> {
    encoded(bytes, name, ColorSpace::Srgb).decode(0, &MemoryBudget::default())
}

fn encoded(bytes: &[u8], name: &str, color_space: ColorSpace) -> EncodedImage {
    EncodedImage {
        bytes: bytes.into(),
        path: name.into(),
        color_space,
        alpha: AlphaUse::default(),
    }
}

fn load(path: &Path) -> Result<Bitmap, ImageError> {
    let request = ImageRequest::new(ImageSource::File(path.to_owned()), ColorSpace::Srgb);
    EncodedImage::read(&request, &Files::default())?.decode(0, &MemoryBudget::default())
}

fn lossless() -> [(F, &'static str); 4] {
    [
        (F::Png, "a.png"),
        (F::Bmp, "a.bmp"),
        (F::Tga, "a.tga"),
        (F::WebP, "a.webp"),
    ]
}

#[test]
fn lossless_formats_keep_every_byte_with_the_top_row_first() {
    let picture = pattern();
    for (format, name) in lossless() {
        let image = decode(&file(&picture, format), name).unwrap();
        assert_eq!((image.width, image.height, image.channels), (W, H, 3), "{name}");
        assert_eq!(image.storage, Storage::Srgb8(picture.as_bytes().to_vec()), "{name}");
    }
}

#[test]
fn the_content_decides_the_format() {
    let bytes = file(&pattern(), F::Png);
    assert!(decode(&bytes, "really.jpg").is_ok());
    assert!(decode(&bytes, "no extension").is_ok());
    let error = decode(b"solid teapot", "teapot.stl").unwrap_err();
    assert!(matches!(error, ImageError::Unknown { .. }));
    assert!(matches!(decode(b"", "a.xyz"), Err(ImageError::Unknown { .. })));
}

#[test]
fn color_space_applies_to_colours_and_not_to_alpha() {
    let pixel = ::image::Rgba([188, 0, 255, 128]);
    let picture = DynamicImage::ImageRgba8(::image::RgbaImage::from_pixel(1, 1, pixel));
    for bits in [8, 16] {
        let picture = match bits {
            8 => picture.clone(),
            _ => DynamicImage::ImageRgba16(picture.to_rgba16()),
        };
        let bytes = file(&picture, F::Png);
        let load = |space| {
            let image = encoded(&bytes, "a.png", space);
            image.decode(0, &MemoryBudget::default()).unwrap()
        };
        let (srgb, raw) = (load(ColorSpace::Srgb), load(ColorSpace::Raw));
        assert!((srgb.rgb(0, 0).r - 0.502_886_5).abs() < 1e-6);
        assert!((raw.rgb(0, 0).r - 188.0 / 255.0).abs() < 1e-6);
        for image in [srgb, raw] {
            assert_eq!((image.rgb(0, 0).g, image.rgb(0, 0).b), (0.0, 1.0));
            assert!((image.alpha(0, 0) - 128.0 / 255.0).abs() < 1e-6);
            assert!(image.has_alpha());
        }
    }
}

#[test]
fn a_picture_takes_the_memory_that_its_header_tells() {
    let colors = pattern();
    let pictures = [
        colors.clone(),
        DynamicImage::ImageRgb16(colors.to_rgb16()),
        DynamicImage::ImageLuma16(colors.to_luma16()),
        DynamicImage::ImageLumaA8(colors.to_luma_alpha8()),
    ];
    let exr = exr_file(W, H, 1.0);
    let files = pictures.iter().map(|p| file(p, F::Png)).chain([exr]);
    for (i, bytes) in files.enumerate() {
        let image = encoded(&bytes, "picture", ColorSpace::Raw);
        let told = image.memory(0);
        for halvings in [0, 1, 3] {
            let memory = MemoryBudget::default();
            let bitmap = image.decode(halvings, &memory).unwrap();
            assert_eq!([bitmap.width, bitmap.height], [W >> halvings, H >> halvings]);
            let taken: u64 = memory.taken().into_iter().map(|(_, bytes)| bytes).sum();
            assert!(
                taken.abs_diff(told >> (2 * halvings)) <= 1,
                "{i}, {halvings}: {taken} of {told}"
            );
            let (texels, channels) = (u64::from(bitmap.width * bitmap.height), bitmap.channels as u64);
            let size = match &bitmap.storage {
                Storage::Srgb8(_) | Storage::Linear8(_) => 1,
                Storage::Srgb16(_) | Storage::Linear16(_) | Storage::Unit(_) => 2,
                Storage::Float(_) => 4,
            };
            // A third as many numbers in levels, of two bytes or more.
            let own = texels * channels;
            let needed = own * size + own / 4 * size.max(2);
            assert!(needed <= taken, "{i}: {channels} channels of {size} bytes");
        }
    }
    assert_eq!(encoded(b"nothing", "a.png", ColorSpace::Raw).memory(0), 0);
}

#[test]
fn gray_stays_one_channel_of_bytes() {
    let picture = pattern().to_luma8();
    let image = decode(&file(&DynamicImage::ImageLuma8(picture), F::Png), "a.png").unwrap();
    assert_eq!(image.channels, 1);
    let texel = image.rgb(3, 4);
    assert!(texel.r == texel.g && texel.g == texel.b);
    assert_eq!(image.alpha(3, 4), 1.0);
}

#[test]
fn a_file_cut_short_is_an_error() {
    let mut files: Vec<_> = lossless().map(|(f, name)| (file(&pattern(), f), name)).to_vec();
    files.push((file(&pattern(), F::Jpeg), "a.jpg"));
    files.push((file(&DynamicImage::ImageRgb32F(pattern().to_rgb32f()), F::Hdr), "a.hdr"));
    files.push((exr_file(W, H, 1.0), "a.exr"));
    for (bytes, name) in files {
        assert!(decode(&bytes, name).is_ok(), "{name}");
        for percent in [3, 10, 30, 60, 90, 97] {
            let cut = &bytes[..bytes.len() * percent / 100];
            let error = decode(cut, name).expect_err(name);
            assert!(!error.is_missing());
            assert!(error.to_string().ends_with(name), "{error}");
        }
    }
}

#[test]
fn a_missing_file_is_told_from_a_broken_one() {
    let home = tempfile::tempdir().unwrap();
    for (path, is_missing) in [(home.path().join("absent.png"), true), (home.path().to_owned(), false)] {
        let error = load(&path).unwrap_err();
        assert_eq!(error.is_missing(), is_missing, "{error}");
    }
    let path = home.path().join("a.png");
    fs::write(&path, b"\x89PNG\r\n\x1a\n and no more").unwrap();
    assert!(!load(&path).unwrap_err().is_missing());
}

#[test]
fn absurd_sizes_are_refused() {
    let mut bmp = file(&pattern(), F::Bmp);
    let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n".to_vec();
    hdr.extend([0; 99]);
    bmp[18..22].copy_from_slice(&i32::MAX.to_le_bytes());
    for (bytes, name) in [(bmp, "a.bmp"), (hdr, "a.hdr")] {
        assert!(decode(&bytes, name).is_err(), "{name}");
    }
    assert!(matches!(check_size([0, 1], 0), Err(ImageProblem::Size { .. })));
    assert!(matches!(
        check_size([1, MAX_BYTES + 1], 0),
        Err(ImageProblem::Size { .. })
    ));
    assert!(matches!(
        check_size([1, 1], MAX_BYTES + 1),
        Err(ImageProblem::Size { .. })
    ));
}

#[test]
fn an_image_without_pixels_is_an_error_that_says_so() {
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 5\n";
    let mut tga = file(&pattern(), F::Tga);
    tga[12..14].copy_from_slice(&[0, 0]);
    let mut bmp = file(&pattern(), F::Bmp);
    bmp[18..22].copy_from_slice(&[0; 4]);
    for (bytes, name) in [(&hdr[..], "a.hdr"), (&tga, "a.tga"), (&bmp, "a.bmp")] {
        let error = decode(bytes, name).unwrap_err().to_string();
        assert!(error.ends_with(name), "{error}");
    }
    let error = check_size([0, 5], 0).unwrap_err().at(Path::new("a.png"));
    assert_eq!(error.to_string(), "the image has no pixels, its size is 0 x 5: a.png");
}

/// RGB of halves with ZIP.
fn exr_file(w: u32, h: u32, first: f32) -> Vec<u8> {
    use ::exr::prelude::{Encoding, Image as Exr, Layer, LayerAttributes, SpecificChannels, WritableImage};
    let pixel = move |p: ::exr::math::Vec2<usize>| {
        let red = if p.0 == 0 && p.1 == 0 { first } else { p.0 as f32 };
        (f16::from_f32(red), f16::from_f32(p.1 as f32), f16::from_f32(0.25))
    };
    let channels = SpecificChannels::rgb(pixel);
    let size = (w as usize, h as usize);
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
    let mut out = Cursor::new(Vec::new());
    Exr::from_layer(layer).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}

#[test]
fn exr_is_linear_and_its_top_row_is_first() {
    let image = decode(&exr_file(W, H, 1.0), "a.exr").unwrap();
    assert_eq!(
        (image.width, image.height, image.channels, image.repaired),
        (W, H, 3, 0)
    );
    assert_eq!(image.rgb(5, 2), Rgb::new(5.0, 2.0, 0.25));
}

#[test]
fn colours_of_an_exr_are_parted_from_their_alpha_once() {
    use ::exr::prelude::{Image as Exr, SpecificChannels, WritableImage};
    let channels = SpecificChannels::rgba(|p: ::exr::math::Vec2<usize>| match p.0 {
        0 => (0.25f32, 0.125f32, 0.5f32, 0.5f32),
        1 => (3.0, 2.0, 1.0, 0.0),
        _ => (0.5, -0.5, 1.0, 1.0),
    });
    let mut out = Cursor::new(Vec::new());
    Exr::from_channels((3, 1), channels)
        .write()
        .to_buffered(&mut out)
        .unwrap();
    let bytes = out.into_inner();
    let read = |color_space, alpha| {
        let image = EncodedImage {
            alpha,
            ..encoded(&bytes, "a.exr", color_space)
        };
        image.decode(0, &MemoryBudget::default()).unwrap()
    };
    let parted = read(ColorSpace::Srgb, AlphaUse::Opacity);
    assert_eq!(parted.rgb(0, 0), Rgb::new(0.5, 0.25, 1.0));
    assert_eq!((parted.alpha(0, 0), parted.weighs_by_alpha), (0.5, true));
    // What glows without covering stays.
    assert_eq!(parted.rgb(1, 0), Rgb::new(3.0, 2.0, 1.0));
    assert_eq!((parted.rgb(2, 0).g, parted.negative), (-0.5, 1));
    for (space, alpha) in [
        (ColorSpace::Raw, AlphaUse::Straight),
        (ColorSpace::Srgb, AlphaUse::Unused),
    ] {
        assert_eq!(read(space, alpha).rgb(0, 0), Rgb::new(0.25, 0.125, 0.5));
    }
}

#[test]
fn the_primaries_of_an_exr_are_those_that_it_names() {
    use ::exr::{
        meta::attribute::{AttributeValue, Chromaticities, Text},
        prelude::{Image as Exr, SpecificChannels, Vec2, WritableImage},
    };
    let read = |id: Option<&str>, numbers: Option<[f32; 8]>| {
        let channels = SpecificChannels::rgb(|_| (0.5f32, 0.5f32, 0.5f32));
        let mut image = Exr::from_channels((1, 1), channels);
        let text = |id: &str| AttributeValue::Text(Text::from(id));
        let id = id.map(|id| (Text::from("colorInteropID"), text(id)));
        image.layer_data.attributes.other.extend(id);
        image.attributes.chromaticities = numbers.map(|[a, b, c, d, e, f, g, h]| Chromaticities {
            red: Vec2(a, b),
            green: Vec2(c, d),
            blue: Vec2(e, f),
            white: Vec2(g, h),
        });
        let mut out = Cursor::new(Vec::new());
        image.write().to_buffered(&mut out).unwrap();
        decode(&out.into_inner(), "a.exr").unwrap().primaries
    };
    let ap1 = WorkingSpace::AcesCg.chromaticities();
    assert_eq!(read(None, None), Primaries::default());
    assert_eq!(read(None, Some(ap1)), Primaries(ap1));
    assert_eq!(read(Some("lin_ap1_scene"), None), Primaries(ap1));
    assert_eq!(read(Some("lin_rec709_scene"), Some(ap1)), Primaries::default());
    assert_eq!(read(Some("unknown"), Some(ap1)), Primaries(ap1));
    assert_eq!(read(Some("lin_rec2020_scene"), None).0[..2], [0.708, 0.292]);
}

#[test]
fn texels_that_are_not_finite_are_repaired_and_counted() {
    for (v, repaired) in [(f32::NAN, 0.0), (f32::INFINITY, 65504.0), (f32::NEG_INFINITY, -65504.0)] {
        let image = decode(&exr_file(3, 2, v), "a.exr").unwrap();
        assert_eq!((image.rgb(0, 0).r, image.repaired), (repaired, 1));
    }
}

#[test]
fn a_forged_exr_header_is_refused_before_memory_is_asked_for() {
    let mut bytes = exr_file(W, H, 1.0);
    let at = bytes.windows(10).position(|w| w == b"dataWindow").unwrap() + 10 + 1 + 5 + 1 + 4;
    for (x, y) in [
        (60_000, 60_000),
        (16_000, 16_000),
        (i32::MAX - 2, i32::MAX - 2),
        (36, 16_000_000),
        (1 << 20, 22),
    ] {
        bytes[at + 8..at + 12].copy_from_slice(&i32::to_le_bytes(x));
        bytes[at + 12..at + 16].copy_from_slice(&i32::to_le_bytes(y));
        let error = decode(&bytes, "sky.exr").unwrap_err();
        assert!(!error.is_missing(), "{x} {y}: {error}");
    }
}

#[test]
fn an_exr_shows_its_display_window_black_where_it_has_no_data() {
    use ::exr::{
        math::Vec2,
        meta::attribute::IntegerBounds,
        prelude::{Encoding, Image as Exr, ImageAttributes, Layer, LayerAttributes, SpecificChannels, WritableImage},
    };
    let red = |(x, y): (i32, i32), size: (usize, usize)| {
        let channels = SpecificChannels::rgb(|p: Vec2<usize>| (1.0 + p.0 as f32, 1.0 + p.1 as f32, 0.0_f32));
        let attributes = LayerAttributes::default().with_position(Vec2(x, y));
        let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels);
        let window = IntegerBounds::new(Vec2(2, -1), Vec2(4, 3));
        let mut out = Cursor::new(Vec::new());
        let image = Exr::new(ImageAttributes::new(window), layer);
        image.write().to_buffered(&mut out).unwrap();
        let picture = decode(&out.into_inner(), "a.exr").unwrap();
        assert_eq!((picture.width, picture.height), (4, 3));
        let row = |y: u32| (0..4).map(|x| picture.rgb(x, y).r).collect::<Vec<_>>();
        [row(0), row(1), row(2)]
    };
    // The lower two rows; more than is displayed on all sides; beside what is displayed.
    assert_eq!(
        red((2, 0), (4, 2)),
        [[0.0; 4], [1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0]]
    );
    assert_eq!(red((1, -2), (6, 5)), [[2.0, 3.0, 4.0, 5.0]; 3]);
    assert_eq!(red((90, 90), (4, 3)), [[0.0; 4]; 3]);
}

#[test]
fn a_picture_beyond_the_memory_of_the_job_is_refused_before_it_is_decoded() {
    let files = [
        (file(&pattern(), ImageFormat::Png), "a.png"),
        (exr_file(W, H, 1.0), "a.exr"),
    ];
    for (bytes, name) in files {
        let load = |budget| {
            let image = encoded(&bytes, name, ColorSpace::Srgb);
            image.decode(0, &MemoryBudget::new(Some(budget)))
        };
        let error = load(u64::from(W * H)).unwrap_err();
        assert!(
            matches!(error, ImageError::Memory { .. }) && error.to_string().ends_with(name),
            "{error}"
        );
        assert!(load(1 << 20).is_ok());
    }
}
