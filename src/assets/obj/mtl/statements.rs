//! The statements of an MTL file.

use std::path::Path;

use super::options::{Map, finite, map_of};
use crate::{
    assets::obj::lines::{Lines, argument, words},
    math::Rgb,
    warnings::{WarningKind, Warnings},
};

/// A colour of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tint {
    Kd,
    Ks,
    Ke,
    Tf,
}

/// A number of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Ns,
    Ni,
    D,
    Tr,
    Illum,
    Pr,
    Pm,
    Ps,
    Pc,
    Pcr,
    Aniso,
    Anisor,
}

/// A texture of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    Kd,
    Ks,
    Ns,
    Ke,
    D,
    Tr,
    Pr,
    Pm,
    Ps,
    Pc,
    Pcr,
    Bump,
    Norm,
}

/// The keywords in lower case, and what each sets.
const TINTS: [(&str, Tint); 4] = [("kd", Tint::Kd), ("ks", Tint::Ks), ("ke", Tint::Ke), ("tf", Tint::Tf)];

const NUMBERS: [(&str, Number); 12] = [
    ("ns", Number::Ns),
    ("ni", Number::Ni),
    ("d", Number::D),
    ("tr", Number::Tr),
    ("illum", Number::Illum),
    ("pr", Number::Pr),
    ("pm", Number::Pm),
    ("ps", Number::Ps),
    ("pc", Number::Pc),
    ("pcr", Number::Pcr),
    ("aniso", Number::Aniso),
    ("anisor", Number::Anisor),
];

const MAPS: [(&str, Slot); 15] = [
    ("map_kd", Slot::Kd),
    ("map_ks", Slot::Ks),
    ("map_ns", Slot::Ns),
    ("map_ke", Slot::Ke),
    ("map_d", Slot::D),
    ("map_tr", Slot::Tr),
    ("map_pr", Slot::Pr),
    ("map_pm", Slot::Pm),
    ("map_ps", Slot::Ps),
    ("map_pc", Slot::Pc),
    ("map_pcr", Slot::Pcr),
    ("bump", Slot::Bump),
    ("map_bump", Slot::Bump),
    ("norm", Slot::Norm),
    ("map_norm", Slot::Norm),
];

/// Statements that change the picture but are not rendered, with the names under which they are reported.
const UNSUPPORTED: [(&str, &str); 9] = [
    ("disp", "disp"),
    ("map_disp", "disp"),
    ("decal", "decal"),
    ("map_decal", "decal"),
    ("refl", "refl"),
    ("map_refl", "refl"),
    ("map_rma", "map_RMA"),
    ("map_orm", "map_ORM"),
    ("map_ps_roughness", "map_Ps_roughness"),
];

fn find<T: Copy>(table: &[(&str, T)], keyword: &str) -> Option<T> {
    table.iter().find(|(name, _)| *name == keyword).map(|(_, value)| *value)
}

/// The statements of a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Statements {
    tints: [Option<Rgb>; TINTS.len()],
    numbers: [Option<f32>; NUMBERS.len()],
    maps: [Option<Map>; Slot::Norm as usize + 1],
    /// The names of statements that are not rendered, each once.
    pub unsupported: Vec<&'static str>,
}

impl Statements {
    /// A colour, finite and not negative.
    pub fn tint(&self, tint: Tint) -> Option<Rgb> {
        self.tints[tint as usize]
    }

    /// A finite number.
    pub fn number(&self, number: Number) -> Option<f32> {
        self.numbers[number as usize]
    }

    /// Removes a number.
    pub fn forget(&mut self, number: Number) {
        self.numbers[number as usize] = None;
    }

    pub fn map(&self, slot: Slot) -> Option<&Map> {
        self.maps[slot as usize].as_ref()
    }

    fn unsupported(&mut self, name: &'static str) {
        if !self.unsupported.contains(&name) {
            self.unsupported.push(name);
        }
    }

    /// Parses a statement; `None` if its value is invalid. Unknown statements are ignored.
    fn read(&mut self, keyword: &str, text: &[u8]) -> Option<()> {
        if let Some(tint) = find(&TINTS, keyword) {
            self.tints[tint as usize] = Some(color(text)?);
        } else if let Some(number) = find(&NUMBERS, keyword) {
            if number == Number::D && words(text).nth(1) == Some(b"-halo") {
                self.unsupported("d -halo");
            }
            self.numbers[number as usize] = Some(words(text).skip(1).find_map(finite)?);
        } else if let Some(slot) = find(&MAPS, keyword) {
            if let Some(map) = map_of(argument(text)) {
                self.maps[slot as usize] = Some(map);
            }
        } else if let Some(name) = find(&UNSUPPORTED, keyword) {
            self.unsupported(name);
        }
        Some(())
    }
}

/// Parses the named materials of a decoded file. Statements before the first `newmtl` are ignored.
pub(super) fn read(text: &[u8], path: &Path, warnings: &Warnings) -> Vec<(Vec<u8>, Statements)> {
    let mut materials: Vec<(Vec<u8>, Statements)> = Vec::new();
    for line in Lines::new(text) {
        let keyword = words(&line.text).next().unwrap_or_default().to_ascii_lowercase();
        if keyword == b"newmtl" {
            materials.push((argument(&line.text).to_vec(), Statements::default()));
            continue;
        }
        let (Some((_, material)), Ok(keyword)) = (materials.last_mut(), str::from_utf8(&keyword)) else {
            continue;
        };
        if material.read(keyword, &line.text).is_none() {
            let (number, path) = (line.number, path.display());
            let text = format!("line {number}: this `{keyword}` is not understood: {path}");
            warnings.add(WarningKind::STATEMENT, path, text);
        }
    }
    materials
}

/// One number for all channels, or three.
fn color(text: &[u8]) -> Option<Rgb> {
    let numbers: Option<Vec<f32>> = words(text).skip(1).map(finite).collect();
    match numbers?[..] {
        [gray] => Some(Rgb::gray(gray.max(0.0))),
        [r, g, b, ..] => Some(Rgb::new(r, g, b).max(Rgb::BLACK)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_statements_change_nothing() {
        let text = b"Kd 1 1 1\nnewmtl\nKd 0.5\nnewmtl a b\nKd 1 x 0\nmap_Kd\nKd 0.1 -0.2 0.3 1\nKd spectral f.rfl\nillum\nNs nan\n";
        let read = read(text, Path::new("a.mtl"), &Warnings::default());
        let names: Vec<_> = read.iter().map(|(name, _)| name.as_slice()).collect();
        assert_eq!(names, [&b""[..], b"a b"]);
        assert_eq!(read[0].1.tint(Tint::Kd), Some(Rgb::gray(0.5)));
        assert_eq!(read[1].1.tint(Tint::Kd), Some(Rgb::new(0.1, 0.0, 0.3)));
        assert!(read[1].1.map(Slot::Kd).is_none());
        assert!(read[1].1.number(Number::Illum).is_none() && read[1].1.number(Number::Ns).is_none());
    }

    #[test]
    fn keywords_are_read_in_any_case() {
        let text = b"NEWMTL a\nkd 1\nMAP_KD x.png\nmap_Bump y.png\nBUMP z.png\nd -halo 0.5\nTR 0.2\n";
        let material = &read(text, Path::new("a.mtl"), &Warnings::default())[0].1;
        assert_eq!(material.tint(Tint::Kd), Some(Rgb::WHITE));
        assert_eq!(material.map(Slot::Kd).map(|m| m.file.as_slice()), Some(&b"x.png"[..]));
        assert_eq!(material.unsupported, ["d -halo"]);
        assert_eq!(
            (material.number(Number::D), material.number(Number::Tr)),
            (Some(0.5), Some(0.2))
        );
    }
}
