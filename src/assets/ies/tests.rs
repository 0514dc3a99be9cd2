//! IES files of all versions, and hostile ones.

use super::*;

/// A file of this version with these numbers.
fn file(version: &str, numbers: &str) -> String {
    format!("{version}\n[TEST] own\n[MANUFAC] nobody\nTILT=NONE\n{numbers}")
}

fn parse(bytes: &[u8]) -> Result<Measurement, Fault> {
    read(bytes).map(|(measurement, _)| measurement)
}

#[test]
fn numbers_after_the_intensities_are_told_with_their_line() {
    let text = file("IESNA:LM-63-2002", NUMBERS);
    let rest = |more: &str| {
        read(format!("{text}{more}").as_bytes())
            .expect("valid")
            .1
            .map(|fault| fault.line)
    };
    assert_eq!([rest(""), rest("\n the end"), rest("\u{1a}")], [None; 3]);
    assert_eq!([rest("7\n"), rest("\n\n 7 8 9")], [Some(11), Some(13)]);
}

#[test]
fn messages_of_extreme_numbers_are_short() {
    let huge = format!("1{}", "0".repeat(300));
    for (from, to) in [
        ("10 20", &huge),
        ("2 1 2 0", &huge),
        ("0 45 90", &format!("0 45 {huge}")),
        ("3 2 1", &format!("-{huge} 2 1")),
    ] {
        let Fault { cause, .. } = parse(file("IESNA:LM-63-2002", &NUMBERS.replace(from, to)).as_bytes()).unwrap_err();
        assert!(cause.len() < 100, "{cause}");
    }
    assert_eq!(parse(b"").unwrap_err().line, 1);
}

/// Three vertical and two horizontal angles.
const NUMBERS: &str = "1 1000 2 3 2 1 2 0 0 0\n0.5 1.1 36\n0 45 90\n0 90\n10 20 30\n40 50 0\n";

fn candela(text: &str) -> Vec<f32> {
    parse(text.as_bytes()).expect("a valid file").candela
}

#[test]
fn the_numbers_of_every_version_are_read() {
    let scaled = |factor: f32| [10.0, 20.0, 30.0, 40.0, 50.0, 0.0].map(|v: f32| v * factor).to_vec();
    let near = |found: Vec<f32>, expected: Vec<f32>| {
        found.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 1e-5 * b) && found.len() == expected.len()
    };
    // The twelfth number is a factor up to 1995, and the way in which the file was made since 2019.
    for version in ["IESNA91", "IESNA:LM-63-1995", "no version"] {
        assert!(near(candela(&file(version, NUMBERS)), scaled(1.1)), "{version}");
    }
    for version in ["IESNA:LM-63-2002", "IES:LM-63-2019"] {
        assert!(near(candela(&file(version, NUMBERS)), scaled(1.0)), "{version}");
    }
    let m = parse(file("IES:LM-63-2019", NUMBERS).as_bytes()).expect("valid");
    assert_eq!((m.photometry, m.symmetry), (Photometry::C, Symmetry::Quadrants));
    assert_eq!((m.vertical, m.horizontal), (vec![0.0, 45.0, 90.0], vec![0.0, 90.0]));
}

#[test]
fn commas_lines_and_odd_ends_part_numbers() {
    let plain = candela(&file("IESNA:LM-63-2002", NUMBERS));
    for (from, to) in [(" ", ","), (" ", "\n"), (" ", ", \t"), ("\n", "\r\n"), ("\n", "\r")] {
        let (head, numbers) = ("IESNA:LM-63-2002\nTILT=NONE\n", NUMBERS.replace(from, to));
        let text = format!("{head}{numbers}");
        let text = if from == "\n" {
            text.replace('\n', to).replace("\r\r", "\r")
        } else {
            text
        };
        assert_eq!(candela(&text), plain, "{text:?}");
    }
    // Names in another encoding, spaces at the tilt, and something behind the numbers.
    let mut bytes = b"IESNA:LM-63-2002\n[LUMINAIRE] L\xe4mpchen\n tilt = none \n".to_vec();
    bytes.extend_from_slice(NUMBERS.as_bytes());
    bytes.extend_from_slice(b"\x1a end");
    assert_eq!(parse(&bytes).expect("valid").candela, plain);
}

#[test]
fn horizontal_angles_tell_the_symmetry() {
    let of = |photometry: u32, horizontal: &str| {
        let count = horizontal.split(' ').count();
        let values = "1 ".repeat(2 * count);
        let text = format!("1 -1 1 2 {count} {photometry} 2 0 0 0 1 1 0 0 90 {horizontal} {values}");
        parse(file("IES:LM-63-2019", &text).as_bytes())
            .map(|m| m.symmetry)
            .map_err(|fault| fault.cause)
    };
    assert_eq!(of(1, "0"), Ok(Symmetry::Axial));
    assert_eq!(of(1, "0 45 90"), Ok(Symmetry::Quadrants));
    assert_eq!(of(1, "0 180"), Ok(Symmetry::Mirrored));
    assert_eq!(of(1, "90 180 270"), Ok(Symmetry::Mirrored));
    assert_eq!(of(1, "0 120 360"), Ok(Symmetry::None));
    assert_eq!(of(1, "0 90 180 270"), Ok(Symmetry::Closed));
    assert_eq!(of(2, "0 45"), Ok(Symmetry::AboutZero));
    assert_eq!(of(3, "-90 0 90"), Ok(Symmetry::None));
    let message = of(1, "10 20").expect_err("refused");
    assert!(
        message.starts_with("horizontal angles go from 10 to 20 degrees"),
        "{message}"
    );
    assert!(of(2, "0").is_err());
}

#[test]
fn hostile_files_are_refused_with_their_line() {
    let refused = |text: &str| {
        let Fault { cause, line } = parse(text.as_bytes()).expect_err(text);
        format!("line {line}: {cause}")
    };
    let numbers = |numbers: &str| refused(&file("IES:LM-63-2019", numbers));
    assert_eq!(
        refused("P6 nothing\n"),
        "line 1: there is no line `TILT=`, so that this is no IES file"
    );
    assert_eq!(
        refused("IESNA91\nTILT=INCLUDE\n"),
        "line 2: only lamps without tilt are supported (TILT=NONE), found `INCLUDE`"
    );
    assert_eq!(
        numbers("1 1000 1 4000000000 3 1 2 0 0 0"),
        "line 5: the number of vertical angles is 4000000000, more than the file has numbers"
    );
    assert_eq!(
        numbers("1 1000 1\n2.5 3 1 2 0 0 0"),
        "line 6: the number of vertical angles is 2.5, and should be a whole number from 2 on"
    );
    assert_eq!(
        numbers("1 1000 1 2 1 7 2 0 0 0"),
        "line 5: the type of photometry is 7, and should be 1 (C), 2 (B) or 3 (A)"
    );
    assert_eq!(
        numbers("1 1000 -1 2 1 1 2 0 0 0"),
        "line 5: the candela multiplier is below 0: -1"
    );
    assert_eq!(
        numbers("1 1000 inf 2 1 1 2 0 0 0"),
        "line 5: expected the candela multiplier, found `inf`"
    );
    let start = "1 1000 1 3 1 1 2 0 0 0\n1 1 0\n";
    assert_eq!(
        numbers(&format!("{start}0 90 45\n0\n1 1 1")),
        "line 7: vertical angles do not rise: 45 follows 90"
    );
    assert_eq!(
        numbers(&format!("{start}0 45 45.0001\n0\n1 1 1")),
        "line 7: vertical angles rise by less than 0.001 degrees: 45.0001 follows 45"
    );
    assert_eq!(
        numbers(&format!("{start}0 90 200\n0\n1 1 1")),
        "line 7: a vertical angle of 200 degrees, expected 0 to 180"
    );
    assert_eq!(
        numbers(&format!("{start}0 45 90\n0\n1 nan 1")),
        "line 9: expected an intensity, found `nan`"
    );
    assert_eq!(
        numbers(&format!("{start}0 45 90\n0\n1 -2 1")),
        "line 9: an intensity is below 0: -2"
    );
    assert_eq!(
        numbers(&format!("{start}0 45 90\n0\n1 1")),
        "line 9: the file ends where an intensity should follow"
    );
    assert_eq!(
        numbers(&format!("{start}0 45 90\n0\n0 0 0")),
        "line 9: all intensities are 0"
    );
    assert_eq!(
        numbers(&format!("{start}0 45 90\n0\n1 1e39 1")),
        "line 9: an intensity of 1e39 cd is too large"
    );
    let many = "1 1000 1 30 30 1 2 0 0 0\n1 1 0\n";
    let angles: String = (0..30).map(|i| format!("{i} ")).collect();
    let circle: String = (0..29).map(|i| format!("{i} ")).collect();
    assert_eq!(
        numbers(&format!("{many}{angles}\n{circle}360\n1 1 1")),
        "line 8: 30 times 30 intensities are more than the file has numbers"
    );
}

#[test]
fn no_damaged_file_panics() {
    let whole = file("IESNA:LM-63-1995", NUMBERS);
    for end in 0..whole.len() {
        let _ = parse(&whole.as_bytes()[..end]);
    }
    for (i, with) in (0..whole.len()).flat_map(|i| b"\0-9e.\n,\xff".iter().map(move |b| (i, *b))) {
        let mut bytes = whole.clone().into_bytes();
        bytes[i] = with;
        if let Ok(measurement) = parse(&bytes) {
            let profile = Profile::new(&measurement);
            assert!(profile.power().is_finite());
        }
    }
}
