//! Frames as files, by way of the formats' table.

use std::io::Cursor;

use ::exr::{
    meta::{MetaData, header::Header},
    prelude::{AttributeValue, Text},
};

use serde::{Deserialize, de::value::I64Deserializer};

use super::*;
use crate::film::{FilmLayout, PassRequest, Window, passes::BEAUTY};

fn film(passes: &[&str], size: [u32; 2]) -> Film {
    let passes = PassRequest::parse_list(passes.iter().copied()).unwrap();
    let layout = FilmLayout::new(BEAUTY, &passes, &[]).unwrap();
    let mut film = Film::new([640, 480], Window::sized([10, 20], size), &layout);
    let pixels = film.values_mut(0).as_chunks_mut().0;
    pixels.fill([0.5, f32::NAN, 1e6, 1.0]);
    film
}

fn metadata() -> FrameMetadata {
    FrameMetadata {
        fps: Some((24000, 1001)),
        ..FrameMetadata::example(7, Vec::new())
    }
}

fn image<'a>(film: &'a Film, metadata: &'a FrameMetadata) -> FrameImage<'a> {
    FrameImage {
        film,
        shown: Shown::All,
        coverage: Coverage::Full,
        metadata,
    }
}

fn header(frame: &FrameImage) -> Header {
    let mut out = Vec::new();
    exr::Exr.encode(frame, Encoding::default(), &mut out).unwrap();
    MetaData::read_from_buffered(Cursor::new(out), true).unwrap().headers[0].clone()
}

/// The header of a frame that says this.
fn header_of(metadata: &FrameMetadata) -> Header {
    header(&image(&film(&[], [3, 2]), metadata))
}

#[test]
fn every_format_writes_the_same_whole_file_twice() {
    let home = tempfile::tempdir().unwrap();
    for &format in FORMATS {
        let path = |name: &str| home.path().join(name).with_extension(format.name());
        let (a, b) = (path("a"), path("new folder/b"));
        let (film, metadata) = (film(&["depth"], [3, 2]), metadata());
        let frame = image(&film, &metadata);
        atomic::check(&b).unwrap();
        let report = write(&a, format, &frame, Encoding::default()).unwrap();
        assert_eq!(report, write(&b, format, &frame, Encoding::default()).unwrap());
        assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
        assert_eq!(std::fs::metadata(&a).unwrap().len(), report.bytes);
        // A file has the bytes of one that is sealed in memory.
        let in_memory = encode(format, &frame, Encoding::default()).unwrap();
        assert!((std::fs::read(&a).unwrap(), report) == in_memory);
        // Arrays keep what is no number.
        let nans = if format.name() == "npz" { 0 } else { 6 };
        assert!(report.nans == nans && format.inspect(&a).is_some());
        assert!(format.inspect(&home.path().join("absent")).is_none());
    }
}

#[test]
fn a_cut_or_a_changed_byte_is_found_in_every_format_and_is_never_a_panic() {
    let home = tempfile::tempdir().unwrap();
    let (film, metadata) = (film(&["objectId"], [3, 2]), metadata());
    for &format in FORMATS {
        let (whole, _) = encode(format, &image(&film, &metadata), Encoding::default()).unwrap();
        let path = home.path().join("f").with_extension(format.name());
        let is_whole = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            format.facts(&path);
            format.inspect(&path).is_some()
        };
        assert!(is_whole(&whole), "{}", format.name());
        let mut unseen = 0;
        for at in 0..whole.len() {
            assert!(!is_whole(&whole[..at]), "{}: {at} bytes", format.name());
            let mut changed = whole.clone();
            changed[at] ^= 1 << (at % 8);
            unseen += usize::from(is_whole(&changed));
        }
        // The checksum of the chunk that holds the seal of a PNG file.
        assert_eq!(unseen, if format.name() == "png" { 4 } else { 0 }, "{}", format.name());
    }
}

#[test]
fn a_whole_file_says_what_it_is() {
    let home = tempfile::tempdir().unwrap();
    let attributes = vec![
        Attribute::new("look", "soft"),
        Attribute::new("batch-render/clamp", 2.5),
        Attribute::new("note", "blass, gr\u{fc}n"),
        Attribute::new("long", "x".repeat(1 << 17)),
    ];
    let (film, metadata) = (
        film(&[], [3, 2]),
        FrameMetadata {
            attributes,
            ..metadata()
        },
    );
    for &format in FORMATS {
        let path = home.path().join("f").with_extension(format.name());
        write(&path, format, &image(&film, &metadata), Encoding::default()).unwrap();
        let facts = format.inspect(&path).unwrap();
        assert_eq!(facts.frame(), Some(7));
        assert_eq!(facts.version(), Some(env!("CARGO_PKG_VERSION")));
        assert_eq!(facts.attribute("note"), Some(&metadata.attributes[2].value));
        let text = |name| facts.attribute(name).map(ToString::to_string);
        assert_eq!(
            (text("look"), text("batch-render/clamp")),
            (Some("soft".into()), Some("2.5".into()))
        );
        assert!(text("long").is_none());
        assert_eq!((facts.resolution, facts.window), (film.resolution, film.window));
    }
}

#[test]
fn an_image_that_does_not_fit_is_an_error_with_the_path_last() {
    let home = tempfile::tempdir().unwrap();
    for &format in FORMATS {
        let path = home.path().join("f").with_extension(format.name());
        let (empty, metadata) = (film(&[], [0, 2]), metadata());
        let error = write(&path, format, &image(&empty, &metadata), Encoding::default()).unwrap_err();
        assert!(matches!(error, OutputError::Encode { .. }));
        assert!(error.to_string().ends_with(&path.display().to_string()), "{error}");
        assert!(!path.exists());
    }
}

#[test]
fn an_exr_says_what_it_is_in_typed_attributes() {
    let header = header_of(&metadata());
    let own = &header.own_attributes;
    let other = |name: &str| {
        let name = Text::new_or_panic(name);
        own.other
            .get(&name)
            .or_else(|| header.shared_attributes.other.get(&name))
            .cloned()
    };
    let text = |s: &str| Some(AttributeValue::Text(Text::new_or_panic(s)));
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(
        own.software_name,
        Some(Text::new_or_panic(format!("batch-render {version}")))
    );
    assert_eq!(other("batch-render/version"), text(version));
    assert_eq!(other("batch-render/frame"), Some(AttributeValue::I32(7)));
    assert_eq!(other("batch-render/samples"), Some(AttributeValue::I32(64)));
    assert_eq!(other("batch-render/seed"), Some(AttributeValue::I32(5)));
    assert_eq!(other("batch-render/sampler"), text("sobol"));
    assert_eq!(other("imageCounter"), Some(AttributeValue::I32(7)));
    assert_eq!(own.frames_per_second, Some((24000, 1001)));
    assert_eq!(other("colorInteropID"), text("lin_rec709_scene"));
    let primaries = header.shared_attributes.chromaticities.unwrap();
    assert_eq!((primaries.red.0, primaries.white.1), (0.64, 0.329));
}

#[test]
fn display_values_are_not_said_to_be_light() {
    let header = header_of(&FrameMetadata {
        view: DisplayTransform::Raw,
        attributes: vec![Attribute::new("comments", "take 2")],
        ..metadata()
    });
    assert_eq!(header.shared_attributes.chromaticities, None);
    assert!(
        !header
            .own_attributes
            .other
            .contains_key(&Text::new_or_panic("colorInteropID"))
    );
    let comments = header.own_attributes.comments.unwrap().to_string();
    assert_eq!(
        comments,
        "take 2\nthe numbers are display values, not scene-linear light"
    );
}

#[test]
fn what_the_job_says_replaces_what_the_renderer_would() {
    let header = header_of(&FrameMetadata {
        attributes: vec![Attribute::new("software", "another"), Attribute::new("owner", "me")],
        ..metadata()
    });
    assert_eq!(header.own_attributes.software_name, Some(Text::new_or_panic("another")));
    assert_eq!(header.own_attributes.owner, Some(Text::new_or_panic("me")));
}

#[test]
fn passes_stand_beside_the_beauty_with_their_types() {
    let film = film(&["depth", "objectId", "N"], [3, 2]);
    let channels = |shown| {
        let metadata = metadata();
        let header = header(&FrameImage {
            shown,
            ..image(&film, &metadata)
        });
        let channels = header.channels.list.into_iter();
        channels
            .map(|c| (c.name.to_string(), c.sample_type))
            .collect::<Vec<_>>()
    };
    use ::exr::meta::attribute::SampleType::{F16, F32, U32};
    let all = [
        ("A", F16),
        ("B", F16),
        ("G", F16),
        ("N.X", F16),
        ("N.Y", F16),
        ("N.Z", F16),
        ("R", F16),
        ("depth.Z", F32),
        ("objectId.Y", U32),
    ];
    let named = |list: &[(&str, _)]| list.iter().map(|(n, t)| ((*n).to_owned(), *t)).collect::<Vec<_>>();
    assert_eq!(channels(Shown::All), named(&all));
    assert_eq!(channels(Shown::Plane(1)), named(&[("A", F16), ("depth.Z", F32)]));
}

#[test]
fn tables_of_jpeg_files_are_those_of_the_independent_jpeg_group() {
    let (film, metadata) = (film(&[], [16, 16]), metadata());
    let file = |encoding| {
        encode(&jpg::Jpg, &image(&film, &metadata), encoding)
            .expect("it fits")
            .0
    };
    let usual = file(Encoding::default());
    // A table is a segment of 67 bytes; its first number is the step of means.
    let is_table = |bytes: &&[u8]| bytes[..4] == [0xff, 0xdb, 0, 67];
    for quality in 1..=100 {
        let read = JpegQuality::deserialize(I64Deserializer::<serde::de::value::Error>::new(quality));
        let encoding = Encoding {
            jpeg: read.expect("a quality"),
            ..Encoding::default()
        };
        let file = file(encoding);
        let steps = file.windows(6).filter(is_table).map(|bytes| i64::from(bytes[5]));
        let scale = if quality < 50 {
            5000 / quality
        } else {
            200 - 2 * quality
        };
        let expected = [16, 17].map(|step| ((step * scale + 50) / 100).clamp(1, 255));
        assert_eq!(steps.collect::<Vec<_>>(), expected, "{quality}");
        assert_eq!(file == usual, quality == 95);
    }
}
