//! IES files: the intensities of lamps over directions (ANSI/IES LM-63, the versions of 1986 to 2019).
//!
//! A file has lines of keywords up to the line `TILT=`, and then numbers, which spaces, commas and the ends of lines part. Text
//! that follows the last number is no error, and more numbers are a warning. The number of angles is compared with the size of the
//! file before there is memory for them.

use std::{
    io,
    path::{Path, PathBuf},
};

use super::{Files, MemoryKind, OverBudget, files::is_refused};
use crate::{
    light::profile::{Measurement, Photometry, Profile, Symmetry},
    value::one_line,
    warnings::WarningKind,
};

/// Why an IES file was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum IesError {
    #[error("cannot read IES file: {source}: {}", path.display())]
    Read { source: io::Error, path: PathBuf },
    #[error("broken IES file: line {line}: {cause}: {}", path.display())]
    Broken { cause: String, line: usize, path: PathBuf },
    #[error("{cause}: {}", path.display())]
    Memory { cause: OverBudget, path: PathBuf },
}

impl IesError {
    /// The file.
    pub fn path(&self) -> &Path {
        let (Self::Read { path, .. } | Self::Broken { path, .. } | Self::Memory { path, .. }) = self;
        path
    }

    /// Whether the file could not be read, rather than understood.
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Read { source, .. } if !is_refused(source))
    }
}

/// Loads the profile of the file at `path`.
///
/// # Errors
/// The file cannot be read, or breaks the rules of its format.
pub fn load(path: &Path, files: &Files) -> Result<Profile, IesError> {
    let own = || path.to_owned();
    let bytes = files
        .read(path)
        .map_err(|source| IesError::Read { source, path: own() })?;
    // A number takes two bytes at least, and is kept for four quadrants.
    let most = bytes.len() as u64 / 2 * 4 * size_of::<f32>() as u64;
    let memory = files.memory();
    memory
        .check(MemoryKind::Models, most)
        .map_err(|cause| IesError::Memory { cause, path: own() })?;
    let (measurement, rest) = read(&bytes).map_err(|Fault { cause, line }| IesError::Broken {
        cause,
        line,
        path: own(),
    })?;
    if let Some(Fault { cause, line }) = rest {
        let text = format!("line {line}: {cause}: {}", path.display());
        files
            .warnings()
            .add_topic(WarningKind::FAULT, "ies", path.display(), text);
    }
    Ok(Profile::new(&measurement))
}

/// The least step between angles, in degrees: angles mirrored about 360 degrees stay apart in single precision.
const MIN_STEP: f32 = 1e-3;

/// A fault of a file.
#[derive(Debug, PartialEq)]
struct Fault {
    cause: String,
    /// From 1.
    line: usize,
}

/// The numbers of a file, one after another.
struct Numbers<'a> {
    rest: &'a [u8],
    /// The line of the number that was read last.
    line: usize,
}

/// A number for a message: with an exponent where it would have hundreds of digits.
fn shown(number: f64) -> String {
    let magnitude = number.abs();
    if magnitude < 1e15 && (magnitude >= 1e-15 || magnitude == 0.0) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

/// Whether a byte parts numbers.
fn is_gap(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == b','
}

impl<'a> Numbers<'a> {
    fn fault(&self, cause: impl Into<String>) -> Fault {
        let (cause, line) = (cause.into(), self.line);
        Fault { cause, line }
    }

    /// Goes past the gap before the next number.
    fn skip_gap(&mut self) {
        while let [first, rest @ ..] = self.rest {
            if !is_gap(*first) {
                break;
            }
            self.line += usize::from(ends_line(*first, rest));
            self.rest = rest;
        }
    }

    /// The next number, which `what` names.
    fn next(&mut self, what: &str) -> Result<f64, Fault> {
        self.skip_gap();
        let end = self.rest.iter().position(|byte| is_gap(*byte));
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        if word.is_empty() {
            return Err(self.fault(format!("the file ends where {what} should follow")));
        }
        self.rest = rest;
        let number = str::from_utf8(word).ok().and_then(|word| word.parse::<f64>().ok());
        match number.filter(|number| number.is_finite()) {
            Some(number) => Ok(number),
            None => {
                let found = String::from_utf8_lossy(word);
                Err(self.fault(format!("expected {what}, found `{}`", one_line(&found, 40))))
            }
        }
    }

    /// The next number, a factor of at least 0.
    fn factor(&mut self, what: &str) -> Result<f64, Fault> {
        let factor = self.next(what)?;
        if factor < 0.0 {
            return Err(self.fault(format!("{what} is below 0: {}", shown(factor))));
        }
        Ok(factor)
    }

    /// The next number, a count from `least` on. There cannot be more than the bytes that are left.
    fn count(&mut self, what: &str, least: usize) -> Result<usize, Fault> {
        let number = self.next(what)?;
        if number.fract() != 0.0 || number < least as f64 {
            return Err(self.fault(format!(
                "{what} is {}, and should be a whole number from {least} on",
                shown(number)
            )));
        }
        if number > self.rest.len() as f64 {
            return Err(self.fault(format!("{what} is {}, more than the file has numbers", shown(number))));
        }
        Ok(number as usize)
    }

    /// The next angles, which must rise and lie between `low` and `high`.
    fn angles(&mut self, what: &str, count: usize, [low, high]: [f32; 2]) -> Result<Vec<f32>, Fault> {
        let mut angles: Vec<f32> = Vec::with_capacity(count);
        for _ in 0..count {
            let angle = self.next(&format!("a {what} angle"))? as f32;
            if !(low..=high).contains(&angle) {
                let message = format!(
                    "a {what} angle of {} degrees, expected {low} to {high}",
                    shown(f64::from(angle))
                );
                return Err(self.fault(message));
            }
            if let Some(last) = angles.last().filter(|last| angle - **last < MIN_STEP) {
                let lack = if angle <= *last {
                    "do not rise".to_string()
                } else {
                    format!("rise by less than {MIN_STEP} degrees")
                };
                return Err(self.fault(format!("{what} angles {lack}: {angle} follows {last}")));
            }
            angles.push(angle);
        }
        Ok(angles)
    }
}

/// Whether a line ends with `byte`, before `rest`.
fn ends_line(byte: u8, rest: &[u8]) -> bool {
    byte == b'\n' || (byte == b'\r' && rest.first() != Some(&b'\n'))
}

/// The first line, and the rest after it.
fn split_line(text: &[u8]) -> (&[u8], &[u8]) {
    let end = (0..text.len()).find(|i| ends_line(text[*i], &text[i + 1..]));
    let Some(end) = end else { return (text, &[]) };
    (&text[..end], &text[end + 1..])
}

/// Whether the twelfth number is a factor, as it was up to the version of 1995. Later it has other meanings.
fn has_lamp_factor(first_line: &[u8]) -> bool {
    let is_of = |version: &&[u8]| {
        first_line
            .windows(version.len())
            .any(|part| part.eq_ignore_ascii_case(version))
    };
    let later: [&[u8]; 2] = [b"LM-63-2", b"LM-63-02"];
    !later.iter().any(is_of)
}

/// The numbers after the line `TILT=`, and the line that it is.
fn after_tilt(bytes: &[u8]) -> Result<Numbers<'_>, Fault> {
    let (mut rest, mut line) = (bytes, 0);
    while !rest.is_empty() {
        let text;
        (text, rest) = split_line(rest);
        line += 1;
        let text = text.trim_ascii();
        let Some(value) = text
            .get(..4)
            .filter(|word| word.eq_ignore_ascii_case(b"TILT"))
            .and_then(|_| text[4..].trim_ascii_start().strip_prefix(b"="))
        else {
            continue;
        };
        let value = value.trim_ascii();
        if !value.eq_ignore_ascii_case(b"NONE") {
            let shown = String::from_utf8_lossy(value);
            let cause = format!(
                "only lamps without tilt are supported (TILT=NONE), found `{}`",
                one_line(&shown, 40)
            );
            return Err(Fault { cause, line });
        }
        return Ok(Numbers { rest, line: line + 1 });
    }
    let cause = "there is no line `TILT=`, so that this is no IES file".to_owned();
    let line = line.max(1);
    Err(Fault { cause, line })
}

/// The angles that the horizontal ones of a file stand for.
fn symmetry(photometry: Photometry, horizontal: &[f32]) -> Result<Symmetry, String> {
    let (first, last) = (horizontal[0], horizontal[horizontal.len() - 1]);
    let is_one = horizontal.len() == 1;
    match photometry {
        Photometry::C if is_one => Ok(Symmetry::Axial),
        Photometry::C => match (first, last) {
            (0.0, 90.0) => Ok(Symmetry::Quadrants),
            (0.0, 180.0) | (90.0, 270.0) => Ok(Symmetry::Mirrored),
            (0.0, 360.0) => Ok(Symmetry::None),
            (0.0, 180.0..360.0) => Ok(Symmetry::Closed),
            _ => Err(format!(
                "horizontal angles go from {first} to {last} degrees, expected 0 to 90, 180 or 360, or 90 to 270"
            )),
        },
        Photometry::A | Photometry::B if is_one => {
            Err("lamps of types A and B need several horizontal angles".to_owned())
        }
        Photometry::A | Photometry::B if first == 0.0 => Ok(Symmetry::AboutZero),
        Photometry::A | Photometry::B => Ok(Symmetry::None),
    }
}

/// The measurement of a file, and the fault of numbers that follow it.
fn read(bytes: &[u8]) -> Result<(Measurement, Option<Fault>), Fault> {
    let mut numbers = after_tilt(bytes)?;
    numbers.next("the number of lamps")?;
    numbers.next("the lumens of a lamp")?;
    let mut scale = numbers.factor("the candela multiplier")?;
    let verticals = numbers.count("the number of vertical angles", 2)?;
    let horizontals = numbers.count("the number of horizontal angles", 1)?;
    let photometry = match numbers.next("the type of photometry")? {
        1.0 => Photometry::C,
        2.0 => Photometry::B,
        3.0 => Photometry::A,
        other => {
            let other = shown(other);
            let cause = format!("the type of photometry is {other}, and should be 1 (C), 2 (B) or 3 (A)");
            return Err(numbers.fault(cause));
        }
    };
    numbers.next("the unit of lengths")?;
    for what in ["the width", "the length", "the height"] {
        numbers.next(what)?;
    }
    scale *= numbers.factor("the ballast factor")?;
    let twelfth = numbers.factor("the number after the ballast factor")?;
    if has_lamp_factor(split_line(bytes).0) {
        scale *= twelfth;
    }
    numbers.next("the input watts")?;
    let (vertical_range, horizontal_range) = match photometry {
        Photometry::C => ([0.0, 180.0], [0.0, 360.0]),
        Photometry::A | Photometry::B => ([-90.0, 90.0], [-90.0, 90.0]),
    };
    let vertical = numbers.angles("vertical", verticals, vertical_range)?;
    let horizontal = numbers.angles("horizontal", horizontals, horizontal_range)?;
    let symmetry = symmetry(photometry, &horizontal).map_err(|cause| numbers.fault(cause))?;
    let count = verticals.saturating_mul(horizontals);
    if count > numbers.rest.len() {
        let cause = format!("{verticals} times {horizontals} intensities are more than the file has numbers");
        return Err(numbers.fault(cause));
    }
    let (mut candela, mut largest) = (Vec::with_capacity(count), 0.0_f32);
    for _ in 0..count {
        let own = numbers.factor("an intensity")? * scale;
        // A sum of all of them is finite as well.
        if own * count as f64 > f64::from(f32::MAX) {
            return Err(numbers.fault(format!("an intensity of {own:e} cd is too large")));
        }
        largest = largest.max(own as f32);
        candela.push(own as f32);
    }
    if largest == 0.0 {
        return Err(numbers.fault("all intensities are 0"));
    }
    let more = numbers.next("the end of the file").is_ok();
    let rest = more.then(|| {
        numbers.fault(format!(
            "numbers after {verticals} times {horizontals} intensities are not read"
        ))
    });
    let measurement = Measurement {
        photometry,
        vertical,
        horizontal,
        symmetry,
        candela,
    };
    Ok((measurement, rest))
}

#[cfg(test)]
mod tests;
