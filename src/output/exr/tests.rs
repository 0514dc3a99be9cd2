//! Files through another reader, the `exr` crate's, and numbers on their way to halves.

use std::io::Cursor;

use ::exr::prelude::{self as reader, AttributeValue, FlatSamples, ReadChannels as _, ReadLayers as _, Text};
use half::f16;
use proptest::prelude::*;

use super::*;
use crate::{
    math::hash,
    output::{BlockShape, Value},
};

const SHAPES: [BlockShape; 2] = [BlockShape::Lines, BlockShape::Tiles];

type Read = reader::Image<reader::Layers<reader::AnyChannels<FlatSamples>>>;

fn noise(n: usize, seed: u32) -> impl Iterator<Item = u32> {
    (0..n as u32).map(move |i| hash::pcg4d([i, seed, 0, 0])[0])
}

fn bytes(image: &Image) -> Vec<u8> {
    let mut out = Vec::new();
    let report = write(image, &mut out).unwrap();
    assert_eq!(report.bytes, out.len() as u64);
    out
}

fn read(bytes: &[u8]) -> Read {
    reader::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .pedantic()
        .from_buffered(Cursor::new(bytes))
        .unwrap()
}

/// Writes noise (or, if `smooth`, a ramp that compresses well) in every type and expects to read it back.
fn round_trip(display: Window, data: Window, compression: Compression, smooth: bool) {
    let n = data.area();
    let random: Vec<u32> = match smooth {
        true => (0..n as u32).map(|i| i / 7).collect(),
        false => noise(n, 1).collect(),
    };
    let floats: Vec<f32> = random.iter().map(|v| *v as f32 / 65536.0 - 32768.0).collect();
    let bits: Vec<f32> = random.iter().map(|v| f32::from_bits(*v)).collect();
    let interleaved: Vec<f32> = floats.iter().flat_map(|v| [0.0, *v, 0.0]).collect();
    let inner = ChannelData {
        values: &interleaved,
        first: 1,
        step: 3,
    };
    let channels = [
        Channel {
            name: "Z.half",
            samples: Samples::Half(inner),
        },
        Channel {
            name: "a.float",
            samples: Samples::Float(ChannelData::dense(&bits)),
        },
        Channel {
            name: "A.uint",
            samples: Samples::Uint(ChannelData::dense(&random)),
        },
    ];
    for blocks in SHAPES {
        let image = Image {
            display,
            data,
            channels: &channels,
            attributes: &[],
            compression,
            blocks,
        };
        let file = bytes(&image);
        let back = read(&file);
        let layer = &back.layer_data[0];
        let window = back.attributes.display_window;
        assert_eq!((window.position.0, window.position.1), (display.x0, display.y0));
        assert_eq!(
            (window.size.0, window.size.1),
            (display.width() as usize, display.height() as usize)
        );
        assert_eq!(
            (layer.size.0, layer.size.1),
            (data.width() as usize, data.height() as usize)
        );
        let position = layer.attributes.layer_position;
        assert_eq!((position.0, position.1), (data.x0, data.y0));
        let list = &layer.channel_data.list;
        let names: Vec<_> = list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, ["A.uint", "Z.half", "a.float"]);
        let [
            FlatSamples::U32(uints),
            FlatSamples::F16(halves),
            FlatSamples::F32(singles),
        ] = [0, 1, 2].map(|i| list[i].sample_data.clone())
        else {
            panic!("types differ");
        };
        assert_eq!(uints, random);
        assert_eq!(halves, floats.iter().map(|v| f16::from_f32(*v)).collect::<Vec<_>>());
        assert!(singles.iter().map(|v| v.to_bits()).eq(random.iter().copied()));
    }
}

#[test]
fn every_lossless_compression_and_type_reads_back() {
    for compression in Compression::ALL.into_iter().filter(|c| !c.is_lossy()) {
        for smooth in [true, false] {
            for (w, h) in [(1, 1), (7, 33), (33, 16), (130, 70), (1, 40), (255, 1)] {
                let window = Window::full([w, h]);
                round_trip(window, window, compression, smooth);
            }
            let crop = Window::sized([-5, -9], [21, 35]);
            round_trip(Window::full([64, 48]), crop, compression, smooth);
            let crop = Window::sized([60, 40], [3, 1]);
            round_trip(Window::full([64, 48]), crop, compression, smooth);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_window_reads_back(x in -99..99, y in -99..99, width in 1..70u32, height in 1..70u32, c in 0..5usize) {
        let data = Window::sized([x, y], [width, height]);
        let compression = Compression::ALL[c];
        prop_assert!(!compression.is_lossy());
        round_trip(Window::full([64, 48]), data, compression, width % 2 == 0);
    }
}

fn to_half(v: f32) -> (f16, WriteReport) {
    let values = [v];
    let channels = [Channel {
        name: "Y",
        samples: Samples::Half(ChannelData::dense(&values)),
    }];
    let window = Window::full([1, 1]);
    let image = Image {
        display: window,
        data: window,
        channels: &channels,
        attributes: &[],
        compression: Compression::None,
        blocks: BlockShape::Lines,
    };
    let mut out = Vec::new();
    let report = write(&image, &mut out).unwrap();
    (f16::from_le_bytes(out[out.len() - 2..].try_into().unwrap()), report)
}

#[test]
fn halves_are_rounded_to_the_nearest_and_ties_to_even() {
    let ulp = 2.0_f32.powi(-10);
    for (v, expected) in [
        (1.0 + 0.5 * ulp, 1.0),
        (1.0 + 1.5 * ulp, 1.0 + 2.0 * ulp),
        ((1.0 + 0.5 * ulp).next_up(), 1.0 + ulp),
        (-1.0 - 0.5 * ulp, -1.0),
        (2.0_f32.powi(-24), 2.0_f32.powi(-24)),
        (2.0_f32.powi(-25), 0.0),
        (2.0_f32.powi(-25).next_up(), 2.0_f32.powi(-24)),
        (2049.0, 2048.0),
        (2051.0, 2052.0),
        (65504.0, 65504.0),
    ] {
        let (half, report) = to_half(v);
        assert_eq!(half.to_f32(), expected, "{v}");
        assert_eq!((report.clamped, report.nans), (0, 0), "{v}");
    }
    assert!(to_half(-0.0).0.is_sign_negative());
}

#[test]
fn what_a_half_cannot_hold_is_clamped_and_counted() {
    for (v, expected) in [
        (65504.0_f32.next_up(), 65504.0),
        (1e30, 65504.0),
        (f32::INFINITY, 65504.0),
        (f32::NEG_INFINITY, -65504.0),
    ] {
        let (half, report) = to_half(v);
        assert_eq!((half.to_f32(), report.clamped, report.nans), (expected, 1, 0), "{v}");
    }
    for nan in [f32::NAN, -f32::NAN] {
        let (half, report) = to_half(nan);
        assert_eq!((half.to_bits(), report.clamped, report.nans), (0, 0, 1));
    }
}

#[test]
fn attributes_keep_their_types() {
    let matrix = std::array::from_fn(|i| i as f32);
    let attributes = [
        Attribute::new("owner", "Zoë"),
        Attribute::new("capDate", ""),
        Attribute::new("frame", -3),
        Attribute::new("near", 0.1_f32),
        Attribute::new("exact", 0.1_f64),
        Attribute::new("shift", Value::V2f([0.5, -0.5])),
        Attribute::new("worldToCamera", Value::M44f(matrix)),
        Attribute::new(
            "framesPerSecond",
            Value::Rational {
                numerator: 24000,
                denominator: 1001,
            },
        ),
        Attribute::new(
            "timeCode",
            Value::TimeCode {
                time: 0x0102_0304,
                user: 0x0506_0708,
            },
        ),
        Attribute::new("region", Value::Box2i(Window::sized([-1, -2], [3, 4]))),
        Attribute::new("views", Value::Strings(vec!["left".into(), "right".into()])),
    ];
    let channels = [Channel {
        name: "Y",
        samples: Samples::Uint(ChannelData::dense(&[1])),
    }];
    let window = Window::full([1, 1]);
    let image = Image {
        display: window,
        data: window,
        channels: &channels,
        attributes: &attributes,
        compression: Compression::Zip,
        blocks: BlockShape::Lines,
    };
    let back = read(&bytes(&image));
    let own = &back.layer_data[0].attributes;
    assert_eq!(
        own.owner,
        Some(Text::new_or_panic("Zo\u{c3}\u{ab}")),
        "UTF-8, which that reader takes for Latin-1"
    );
    assert_eq!(own.near_clip_plane, Some(0.1));
    assert_eq!(own.frames_per_second, Some((24000, 1001)));
    assert_eq!(own.world_to_camera, Some(matrix));
    assert_eq!(own.multi_view_names, None);
    let time = back.attributes.time_code.unwrap();
    assert_eq!((time.hours, time.minutes, time.seconds, time.frame), (1, 2, 3, 4));
    let other = |name: &str| {
        own.other
            .get(&Text::new_or_panic(name))
            .or_else(|| back.attributes.other.get(&Text::new_or_panic(name)))
    };
    assert_eq!(other("frame"), Some(&AttributeValue::I32(-3)));
    assert_eq!(other("exact"), Some(&AttributeValue::F64(0.1)));
    assert_eq!(
        other("shift"),
        Some(&AttributeValue::FloatVec2(reader::Vec2(0.5, -0.5)))
    );
    let region = reader::IntegerBounds::new((-1, -2), (3, 4));
    assert_eq!(other("region"), Some(&AttributeValue::IntegerBounds(region)));
    let views = ["left", "right"].map(Text::new_or_panic).to_vec();
    assert_eq!(other("views"), Some(&AttributeValue::TextVector(views)));
}

#[test]
fn the_order_that_things_are_given_in_does_not_show() {
    let values = [0.5, 0.25, 0.75, 1.0];
    let channel = |name, first| Channel {
        name,
        samples: Samples::Half(ChannelData {
            values: &values,
            first,
            step: 4,
        }),
    };
    let mut channels = [channel("R", 0), channel("G", 1), channel("B", 2), channel("A", 3)];
    let mut attributes = [Attribute::new("b", 1), Attribute::new("a", 2), Attribute::new("zz", 3)];
    let window = Window::full([1, 1]);
    let file = |channels: &[Channel], attributes: &[Attribute]| {
        bytes(&Image {
            display: window,
            data: window,
            channels,
            attributes,
            compression: Compression::Zips,
            blocks: BlockShape::Lines,
        })
    };
    let one = file(&channels, &attributes);
    channels.reverse();
    attributes.reverse();
    assert_eq!(one, file(&channels, &attributes));
}

#[test]
fn threads_do_not_show() {
    let window = Window::full([640, 99]);
    let values: Vec<u32> = noise(window.area(), 3).map(|v| v & 0xff).collect();
    let channels = [Channel {
        name: "Y",
        samples: Samples::Uint(ChannelData::dense(&values)),
    }];
    for compression in Compression::ALL {
        let image = Image {
            display: window,
            data: window,
            channels: &channels,
            attributes: &[],
            compression,
            blocks: BlockShape::Lines,
        };
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bytes(&image))
        };
        assert_eq!(with(1), with(7));
    }
}

#[test]
fn only_long_names_set_the_flag_of_long_names() {
    let window = Window::full([1, 1]);
    for (name, flags) in [("n".repeat(31), 2), ("n".repeat(32), 0x402), ("n".repeat(255), 0x402)] {
        let channels = [Channel {
            name: &name,
            samples: Samples::Uint(ChannelData::dense(&[1])),
        }];
        let image = Image {
            display: window,
            data: window,
            channels: &channels,
            attributes: &[],
            compression: Compression::None,
            blocks: BlockShape::Lines,
        };
        let file = bytes(&image);
        assert_eq!(u32::from_le_bytes(file[4..8].try_into().unwrap()), flags);
        assert_eq!(read(&file).layer_data[0].channel_data.list[0].name.to_string(), name);
    }
}

#[test]
fn what_the_format_cannot_hold_is_refused() {
    let one = Window::full([1, 1]);
    let y = Channel {
        name: "Y",
        samples: Samples::Uint(ChannelData::dense(&[1])),
    };
    let twice = [Attribute::new("a", 1), Attribute::new("a", 2)];
    let own = [Attribute::new("compression", 1)];
    let fit = Image {
        display: one,
        data: one,
        channels: &[y],
        attributes: &[],
        compression: Compression::Zips,
        blocks: BlockShape::Lines,
    };
    let refused = |image: &Image| match write(image, &mut Vec::new()) {
        Err(EncodeError::Unfit(reason)) => reason,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(&Image { channels: &[], ..fit }), "no channels");
    assert_eq!(
        refused(&Image {
            channels: &[y, y],
            ..fit
        }),
        "two channels 'Y'"
    );
    assert!(
        refused(&Image {
            channels: &[Channel { name: "", ..y }],
            ..fit
        })
        .starts_with("the name")
    );
    assert!(
        refused(&Image {
            channels: &[Channel { name: "a\0", ..y }],
            ..fit
        })
        .starts_with("the name")
    );
    assert!(
        refused(&Image {
            channels: &[Channel {
                name: &"n".repeat(256),
                ..y
            }],
            ..fit
        })
        .starts_with("the name")
    );
    assert!(
        refused(&Image {
            data: Window::full([2, 1]),
            ..fit
        })
        .contains("fewer numbers")
    );
    assert!(
        refused(&Image {
            data: Window::full([0, 1]),
            ..fit
        })
        .contains("window")
    );
    assert!(
        refused(&Image {
            data: Window::sized([i32::MAX - 1, 0], [1, 1]),
            ..fit
        })
        .contains("window")
    );
    assert_eq!(
        refused(&Image {
            attributes: &twice,
            ..fit
        }),
        "two attributes 'a'"
    );
    assert_eq!(
        refused(&Image {
            attributes: &own,
            ..fit
        }),
        "two attributes 'compression'"
    );
}

#[test]
fn a_file_is_whole_only_to_its_last_byte() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("f.exr");
    let window = Window::sized([-3, -2], [9, 18]);
    let values: Vec<u32> = noise(window.area(), 5).collect();
    let channels = [Channel {
        name: "Y",
        samples: Samples::Uint(ChannelData::dense(&values)),
    }];
    let shapes = |compression| SHAPES.map(|blocks| (compression, blocks));
    for (compression, blocks) in Compression::ALL.into_iter().flat_map(shapes) {
        let image = Image {
            display: window,
            data: window,
            channels: &channels,
            attributes: &[],
            compression,
            blocks,
        };
        let file = bytes(&image);
        for length in (0..file.len()).step_by(7).chain([file.len() - 1]) {
            std::fs::write(&path, &file[..length]).unwrap();
            assert!(Exr.inspect(&path).is_none(), "{length} of {}", file.len());
        }
        std::fs::write(&path, &file).unwrap();
        assert!(Exr.inspect(&path).is_some());
        let mut unfilled = file.clone();
        let table = 8 + header::encode(&image, &channels, None).unwrap().len();
        unfilled[table..table + 8].fill(0);
        std::fs::write(&path, &unfilled).unwrap();
        assert!(Exr.inspect(&path).is_none(), "an empty place in the table of blocks");
    }
    assert!(Exr.inspect(&home.path().join("absent.exr")).is_none());
    assert!(Exr.inspect(home.path()).is_none());
}
