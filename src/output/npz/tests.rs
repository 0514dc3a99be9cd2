//! Files by their bytes, and what becomes of broken ones.

use std::{io, path::PathBuf};

use super::*;
use crate::{
    film::{Film, FilmLayout, PassRequest, Window},
    output::{Coverage, FrameMetadata, NpzCompression, Shown, encode, sealed},
};

fn encodings() -> [Encoding; 2] {
    [NpzCompression::None, NpzCompression::Deflate].map(|npz| Encoding {
        npz,
        ..Encoding::default()
    })
}

/// A film whose numbers are all different bits, NaNs and both zeros among them.
fn film(passes: &[&str], window: Window) -> Film {
    let passes = PassRequest::parse_list(passes.iter().copied()).unwrap();
    let layout = FilmLayout::new(BEAUTY, &passes, &[]).unwrap().with_ranks(4);
    let mut film = Film::new([8, 6], window, &layout);
    for plane in 0..film.planes().len() {
        for y in window.y0..window.y1 {
            for x in window.x0..window.x1 {
                let (pixel, pixels) = (window.index(x, y), window.area());
                let step = film.planes()[plane].spec.step();
                let values = film.values_mut(plane);
                for layer in 0..values.len() / (pixels * step) {
                    for channel in 0..step {
                        let bits = 0x7fc0_0000_u32.wrapping_mul((x + y) as u32 % 3) + (y * 8 + x) as u32 * 64;
                        let bits = bits + (plane * 16 + layer * 4 + channel) as u32;
                        values[(layer * pixels + pixel) * step + channel] = f32::from_bits(bits);
                    }
                }
            }
        }
    }
    film
}

fn metadata() -> FrameMetadata {
    FrameMetadata::example(-3, vec![Attribute::new("fingerprint", "a window's")])
}

fn bytes(film: &Film, shown: Shown, encoding: Encoding) -> Vec<u8> {
    let image = FrameImage {
        film,
        shown,
        coverage: Coverage::Partial,
        metadata: &metadata(),
    };
    encode(&Npz, &image, encoding).unwrap().0
}

fn arrays(bytes: &[u8]) -> Vec<Array<'static>> {
    let mut archive = Archive::open(io::Cursor::new(bytes)).unwrap();
    let count = archive.members.len();
    let read = |i: usize| Array::parse(&archive.members[i].name.clone(), archive.read(i).unwrap()).unwrap();
    (0..count).map(read).collect()
}

fn bits(array: &Array) -> Vec<u32> {
    array
        .bytes
        .as_chunks()
        .0
        .iter()
        .map(|b| u32::from_le_bytes(*b))
        .collect()
}

const PASSES: [&str; 4] = ["depth", "objectId", "N", "CryptoObject"];

#[test]
fn every_bit_of_every_pass_is_in_an_array_of_its_shape() {
    let film = film(&PASSES, Window::new(1, 2, 6, 6));
    for encoding in encodings() {
        let arrays = arrays(&bytes(&film, Shown::All, encoding));
        let names: Vec<_> = arrays
            .iter()
            .map(|a| (a.name.as_str(), a.element, a.shape.as_slice()))
            .collect();
        assert_eq!(
            names[1..],
            [
                ("rgba", Element::F32, &[4, 5, 4][..]),
                ("depth", Element::F32, &[4, 5]),
                ("objectId", Element::U32, &[4, 5]),
                ("N", Element::F32, &[4, 5, 3]),
                ("CryptoObject", Element::U32, &[4, 5, 4]),
                ("CryptoObject_coverage", Element::F32, &[4, 5, 4]),
            ]
        );
        for (plane, array) in film.planes().iter().zip(&arrays[1..]).take(4) {
            let values: Vec<u32> = plane.values.iter().map(|v| v.to_bits()).collect();
            assert_eq!(bits(array), values, "{}", array.name);
        }
        let values = &film.planes()[4].values;
        let (ids, coverages) = (bits(&arrays[5]), bits(&arrays[6]));
        for (pixel, rank) in (0..20).flat_map(|pixel| (0..4).map(move |rank| (pixel, rank))) {
            let at = (rank / 2 * 20 + pixel) * 4 + rank % 2 * 2;
            let found = [ids[pixel * 4 + rank], coverages[pixel * 4 + rank]];
            assert_eq!(found, [values[at].to_bits(), values[at + 1].to_bits()]);
        }
    }
}

#[test]
fn a_shown_pass_is_alone_with_alpha() {
    let film = film(&["N"], Window::full([8, 6]));
    let arrays = arrays(&bytes(&film, Shown::Plane(1), Encoding::default()));
    let names: Vec<_> = arrays.iter().map(|a| a.name.as_str()).collect();
    assert_eq!(names, ["metadata", "N", "alpha"]);
    let alpha: Vec<u32> = film.beauty().iter().map(|pixel| pixel[3].to_bits()).collect();
    assert_eq!(bits(&arrays[2]), alpha);
}

#[test]
fn stored_numbers_begin_at_multiples_of_64_bytes() {
    let film = film(&PASSES, Window::full([8, 6]));
    let file = bytes(&film, Shown::All, Encoding::default());
    for plane in film.planes().iter().take(4) {
        let values: Vec<u8> = plane.values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let at = file.windows(values.len()).position(|part| part == values).unwrap();
        assert_eq!(at % 64, 0, "{}", plane.spec.name);
    }
}

fn put(home: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = home.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn a_cut_or_a_flipped_bit_is_found_and_never_a_panic() {
    let home = tempfile::tempdir().unwrap();
    let film = film(&["depth"], Window::new(1, 2, 3, 4));
    for encoding in encodings() {
        let whole = bytes(&film, Shown::All, encoding);
        let path = put(home.path(), "f.npz", &whole);
        let facts = Npz.inspect(&path).unwrap();
        assert_eq!((facts.frame(), facts.window), (Some(-3), Window::new(1, 2, 3, 4)));
        for length in (0..whole.len()).step_by(3) {
            assert!(
                Npz.inspect(&put(home.path(), "f.npz", &whole[..length])).is_none(),
                "{length}"
            );
        }
        for at in 0..whole.len() {
            let mut flipped = whole.clone();
            flipped[at] ^= 1 << (at % 8);
            assert!(Npz.inspect(&put(home.path(), "f.npz", &flipped)).is_none(), "{at}");
        }
    }
}

#[test]
fn a_file_of_another_program_is_whole_if_its_checksums_fit_and_has_no_version() {
    let home = tempfile::tempdir().unwrap();
    let mut file = Vec::new();
    let array = Array::new("depth", Element::F32, vec![2, 3], &[1.0; 6][..]);
    zip::write(&[array.into_member()], &[], NpzCompression::Deflate, &mut file).unwrap();
    let facts = Npz.inspect(&put(home.path(), "f.npz", &file)).unwrap();
    assert_eq!((facts.resolution, facts.version()), ([3, 2], None));
    let end = file.len() - 120;
    file[end] ^= 1;
    assert!(Npz.inspect(&put(home.path(), "f.npz", &file)).is_none());
}

#[test]
fn sizes_that_lie_take_no_memory() {
    let home = tempfile::tempdir().unwrap();
    let film = film(&[], Window::new(1, 2, 3, 4));
    let whole = bytes(&film, Shown::All, encodings()[1]);
    let directory = whole.windows(4).position(|part| part == b"PK\x01\x02").unwrap();
    for (at, name) in [(20, "packed"), (24, "unpacked"), (42, "offset")] {
        let mut lie = whole.clone();
        lie[directory + at..][..4].fill(0xff);
        assert!(Npz.inspect(&put(home.path(), "f.npz", &lie)).is_none(), "{name}");
    }
}

#[test]
fn crops_become_the_bytes_of_the_whole_picture() {
    let home = tempfile::tempdir().unwrap();
    let windows = [[0, 0, 3, 6], [3, 0, 8, 2], [3, 2, 8, 6]].map(|[x0, y0, x1, y1]| Window::new(x0, y0, x1, y1));
    let own = [Attribute::new("fingerprint", "a window's")];
    for encoding in encodings() {
        let crop = |(i, window): (usize, Window)| CropFile {
            path: put(
                home.path(),
                &i.to_string(),
                &bytes(&film(&PASSES, window), Shown::All, encoding),
            ),
            window,
        };
        let crops: Vec<CropFile> = windows.into_iter().enumerate().map(crop).collect();
        let whole = bytes(&film(&PASSES, Window::full([8, 6])), Shown::All, encoding);
        assert!(sealed(Npz.join(&crops, &own).unwrap()) == whole);
    }
}

#[test]
fn crops_with_an_array_without_bytes_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let window = Window::full([8, 6]);
    let own = arrays(&bytes(&film(&["depth"], window), Shown::All, Encoding::default()));
    for (element, shape) in [
        (Element::F32, vec![6, 8, 0]),
        (Element::F32, vec![6, 8, 0, usize::MAX, usize::MAX]),
        (Element::U32, vec![0]),
        (Element::Text(0), vec![6, 8]),
        (Element::Text(0), vec![6, 8, usize::MAX, usize::MAX]),
    ] {
        let empty = Array {
            name: "depth".to_owned(),
            element,
            shape: shape.clone(),
            bytes: (&[][..]).into(),
        };
        let mut file = Vec::new();
        write(vec![own[0].clone(), empty], NpzCompression::None, &mut file).unwrap();
        let path = put(home.path(), "f.npz", &file);
        assert!(Npz.facts(&path).is_some());
        let refused = Npz.join(&[CropFile { path, window }], &[]).unwrap_err().to_string();
        assert!(refused.contains("an array that is empty"), "{shape:?}: {refused}");
    }
}
