//! Normalisation of an OBJ file for the parser: only numbers and faces, in runs of faces with the same properties.
//!
//! The parser ignores smoothing groups, reads only one `mtllib` name per line, and fails on mixed faces and on indices of more than
//! 64 bits. So this module keeps the names, and passes on `v`, `vt`, `vn` and `f` of known shape in numbered groups, one for each
//! [`Run`].

use std::collections::HashMap;

use super::{
    lines::{Lines, argument, name, words},
    positions, uvs,
};
use crate::{
    assets::{model::ModelNode, repair::is_not_finite},
    math::DVec3,
};

/// The common properties of the faces of a run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    /// The name of the material, if there is one.
    pub material: Option<Vec<u8>>,
    /// The object or group, an index into [`Normalized::nodes`].
    pub node: Option<usize>,
    /// 0 is flat.
    pub smoothing: u32,
    pub has_uvs: bool,
    pub has_normals: bool,
}

/// A normalised file.
pub(super) struct Normalized {
    pub text: Vec<u8>,
    pub runs: Vec<Run>,
    /// The arguments of all `mtllib` lines.
    pub libraries: Vec<Vec<u8>>,
    /// Objects, and groups within them, each once.
    pub nodes: Vec<ModelNode>,
    /// Whether a coordinate of a vertex may be far from 0.
    pub may_be_far: bool,
    /// Whether a texture coordinate may be far from 0.
    pub may_have_far_uvs: bool,
    /// Whether a vertex has a colour.
    pub has_colors: bool,
    /// The number of invalid normals, which became 0.
    pub bad_normals: usize,
    /// The number of statements of each row of [`SKIPPED`].
    pub skipped: [usize; SKIPPED.len()],
}

/// Statements with geometry that is not rendered, and what they are.
pub(super) const SKIPPED: [(&str, &str); 10] = [
    ("p", "points"),
    ("l", "lines"),
    ("curv", "free-form curves"),
    ("curv2", "free-form curves"),
    ("surf", "free-form surfaces"),
    ("bzp", "free-form surfaces"),
    ("bsp", "free-form surfaces"),
    ("cdc", "free-form curves"),
    ("call", "statements of other files"),
    ("csh", "commands"),
];

/// The treatment of vertices; by default they are not changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Treatment {
    /// Vertices become relative to it.
    pub origin: Option<DVec3>,
    /// Whether every vertex gets a colour, of channels that are NaN where it has none.
    pub keeps_colors: bool,
    /// Whether texture coordinates become their numbers, see [`uvs`].
    pub numbers_uvs: bool,
}

/// An error with its line.
#[derive(Debug, PartialEq)]
pub(super) struct Flaw {
    pub line: usize,
    pub cause: String,
}

/// The numbers of `v`, `vt` and `vn`.
pub(super) type Counts = [usize; 3];

/// The names of the three counts.
pub(super) const NAMES: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Normalises a decoded file.
pub(super) fn normalize(text: &[u8], treatment: Treatment) -> Result<Normalized, Flaw> {
    let mut out = Normalized {
        text: Vec::with_capacity(text.len() + 64),
        runs: Vec::new(),
        libraries: Vec::new(),
        nodes: Vec::new(),
        may_be_far: false,
        may_have_far_uvs: false,
        has_colors: false,
        bad_normals: 0,
        skipped: [0; SKIPPED.len()],
    };
    let mut nodes = Nodes::default();
    let mut counts = Counts::default();
    let mut run = Run {
        material: None,
        node: None,
        smoothing: 0,
        has_uvs: false,
        has_normals: false,
    };
    // A new name starts a new run, so that parts stay as the author made them.
    let mut is_new = true;
    for line in Lines::new(text) {
        let text: &[u8] = &line.text;
        let keyword = words(text).next().unwrap_or_default();
        match keyword {
            b"v" | b"V" => {
                counts[0] += 1;
                let has_more = match treatment.origin {
                    Some(origin) if positions::append_relative(text, origin, &mut out.text) => false,
                    _ => {
                        out.may_be_far |= words(text).skip(1).take(3).any(positions::may_be_far);
                        out.numbers(text, 3)
                    }
                };
                if has_more || treatment.keeps_colors {
                    out.color(text, treatment.keeps_colors);
                }
            }
            b"vt" | b"VT" => {
                counts[1] += 1;
                out.may_have_far_uvs |= words(text).skip(1).take(2).any(positions::may_be_far);
                if !(treatment.numbers_uvs && uvs::append_number(text, counts[1] - 1, &mut out.text)) {
                    out.numbers(text, 2);
                }
            }
            b"vn" | b"VN" => {
                counts[2] += 1;
                out.normal(text);
            }
            b"f" | b"F" => {
                let shape = check_face(text, counts).map_err(|cause| Flaw {
                    line: line.number,
                    cause,
                })?;
                if is_new || (run.has_uvs, run.has_normals) != (shape.has_uvs, shape.has_normals) {
                    (run.has_uvs, run.has_normals) = (shape.has_uvs, shape.has_normals);
                    out.text.extend_from_slice(format!("g {}\n", out.runs.len()).as_bytes());
                    out.runs.push(run.clone());
                    is_new = false;
                }
                out.face(text, &shape);
            }
            b"o" | b"O" => {
                is_new = true;
                run.node = nodes.object(argument(text), &mut out.nodes);
            }
            b"g" | b"G" => {
                is_new = true;
                run.node = nodes.group(argument(text), &mut out.nodes);
            }
            b"s" | b"S" => {
                let smoothing = smoothing(argument(text));
                is_new |= smoothing != run.smoothing;
                run.smoothing = smoothing;
            }
            _ if keyword.eq_ignore_ascii_case(b"usemtl") => {
                let material = Some(argument(text).to_vec());
                is_new |= material != run.material;
                run.material = material;
            }
            _ if keyword.eq_ignore_ascii_case(b"mtllib") => out.libraries.push(argument(text).to_vec()),
            _ => {
                let is_this = |(name, _): &(&str, &str)| name.as_bytes().eq_ignore_ascii_case(keyword);
                let known = SKIPPED.iter().position(is_this);
                known.into_iter().for_each(|at| out.skipped[at] += 1);
            }
        }
    }
    Ok(out)
}

/// The number of a smoothing group; `off`, 0 and invalid values are flat, `on` is a group.
fn smoothing(text: &[u8]) -> u32 {
    match str::from_utf8(text) {
        Ok("on") => 1,
        Ok(text) => text.parse().unwrap_or(0),
        Err(_) => 0,
    }
}

/// The objects and groups so far, by parent node and name.
#[derive(Default)]
struct Nodes {
    known: HashMap<(Option<usize>, Vec<u8>), usize>,
    object: Option<usize>,
}

impl Nodes {
    fn object(&mut self, given: &[u8], out: &mut Vec<ModelNode>) -> Option<usize> {
        self.object = self.node(None, given, out);
        self.object
    }

    /// A group of the current object; one without a name is the object.
    fn group(&mut self, given: &[u8], out: &mut Vec<ModelNode>) -> Option<usize> {
        self.node(self.object, given, out)
    }

    fn node(&mut self, parent: Option<usize>, given: &[u8], out: &mut Vec<ModelNode>) -> Option<usize> {
        if given.is_empty() {
            return parent;
        }
        let at = *self.known.entry((parent, given.to_vec())).or_insert_with(|| {
            let name = name(given);
            out.push(ModelNode { name, parent });
            out.len() - 1
        });
        Some(at)
    }
}

/// Whether a word is a finite number that the parser reads.
fn is_number(word: &[u8]) -> bool {
    let is_plain = |b: &u8| matches!(b, b'0'..=b'9' | b'.' | b'-');
    let parses = || str::from_utf8(word).is_ok_and(|w| w.parse::<f32>().is_ok_and(f32::is_finite));
    word.iter().all(is_plain) || parses()
}

/// The indices that the corners of a face have.
struct FaceShape {
    has_uvs: bool,
    has_normals: bool,
    /// Whether corners have different kinds of indices.
    is_mixed: bool,
}

fn check_face(text: &[u8], counts: Counts) -> Result<FaceShape, String> {
    let (mut every, mut any) = ([true; 3], [false; 3]);
    for corner in words(text).skip(1) {
        let mut named = [false; 3];
        for (i, index) in corner.split(|b| *b == b'/').enumerate() {
            if i >= 3 {
                return Err(format!(
                    "a corner names at most three things: '{}'",
                    String::from_utf8_lossy(corner)
                ));
            }
            named[i] = !index.is_empty();
            if named[i] {
                check_index(index, i, counts[i])?;
            }
        }
        for i in 0..3 {
            every[i] &= named[i];
            any[i] |= named[i];
        }
    }
    if words(text).nth(1).is_none() {
        return Err("a face without corners".into());
    }
    let shape = FaceShape {
        has_uvs: every[1],
        has_normals: every[2],
        is_mixed: every[1] != any[1] || every[2] != any[2],
    };
    Ok(shape)
}

/// Refuses indices that the parser would misread. Indices beyond the end are checked later, when the end is known.
fn check_index(index: &[u8], which: usize, count: usize) -> Result<(), String> {
    if matches!(index[0], b'1'..=b'9') && index.len() <= 9 {
        return Ok(());
    }
    let text = String::from_utf8_lossy(index);
    let what = NAMES[which];
    match text.parse::<i64>() {
        Ok(0) => Err(format!("a face names {what} 0, but they count from 1")),
        Ok(i) if i < 0 && i.unsigned_abs() > count as u64 => {
            Err(format!("a face names {what} {i}, but there are only {count} before it"))
        }
        Ok(i) if i <= i64::from(u32::MAX) => Ok(()),
        Ok(i) => Err(format!("a face names {what} {i}, more than there can be")),
        Err(_) => Err(format!("expected the number of a {what}, found '{text}'")),
    }
}

impl Normalized {
    /// Copies the first `n` numbers of a statement, and adds a second number to one-dimensional texture coordinates. Returns
    /// whether there are more.
    fn numbers(&mut self, text: &[u8], n: usize) -> bool {
        let mut count = 0;
        let mut words = words(text);
        for word in words.by_ref().take(n + 1) {
            let start = self.text.len();
            // What the libraries of several languages write for it.
            let word = if is_not_finite(word) { b"nan" } else { word };
            self.text.extend_from_slice(word);
            if count == 0 {
                self.text[start..].make_ascii_lowercase();
            }
            self.text.push(b' ');
            count += 1;
        }
        if n == 2 && count == 2 {
            self.text.extend_from_slice(b"0 ");
        }
        self.text.push(b'\n');
        words.next().is_some()
    }

    /// Copies a normal, or writes 0 if it is invalid.
    fn normal(&mut self, text: &[u8]) {
        let is_plain = text[2..].iter().all(|b| b.is_ascii_digit() || b" \t.-".contains(b));
        if is_plain || words(text).skip(1).take(3).all(is_number) {
            self.numbers(text, 3);
        } else {
            self.bad_normals += 1;
            self.text.extend_from_slice(b"vn 0 0 0\n");
        }
    }

    /// Appends the colour of a vertex to its line; a channel that is not there is NaN, since the value of white is not known yet.
    fn color(&mut self, text: &[u8], keeps: bool) {
        let mut own = words(text).skip(4).take(3);
        let own = [own.next(), own.next(), own.next()];
        self.has_colors |= own[2].is_some();
        if !keeps {
            return;
        }
        self.text.pop();
        for channel in own {
            self.text.push(b' ');
            let channel = channel.filter(|c| own[2].is_some() && is_number(c));
            self.text.extend_from_slice(channel.unwrap_or(b"nan"));
        }
        self.text.push(b'\n');
    }

    fn face(&mut self, text: &[u8], shape: &FaceShape) {
        if !shape.is_mixed {
            self.text.push(b'f');
            self.text.extend_from_slice(&text[1..]);
            self.text.push(b'\n');
            return;
        }
        self.text.extend_from_slice(b"f");
        for corner in words(text).skip(1) {
            let mut parts = corner.split(|b| *b == b'/');
            let mut part = |keep: bool| parts.next().filter(|_| keep).unwrap_or_default();
            for (separator, part) in [
                (&b" "[..], part(true)),
                (b"/", part(shape.has_uvs)),
                (b"/", part(shape.has_normals)),
            ] {
                self.text.extend_from_slice(separator);
                self.text.extend_from_slice(part);
            }
        }
        self.text.push(b'\n');
    }
}

/// Finds the first statement with an invalid number or index, after an error.
pub(super) fn diagnose(text: &[u8]) -> Option<Flaw> {
    let which = |keyword: &[u8]| {
        [&b"v"[..], b"vt", b"vn"]
            .iter()
            .position(|k| k.eq_ignore_ascii_case(keyword))
    };
    let mut counts = Counts::default();
    for line in Lines::new(text) {
        if let Some(i) = which(words(&line.text).next().unwrap_or_default()) {
            counts[i] += 1;
        }
    }
    Lines::new(text).find_map(|line| {
        let mut parts = words(&line.text);
        let keyword = parts.next().unwrap_or_default();
        let cause = if keyword.eq_ignore_ascii_case(b"f") {
            parts.find_map(|corner| beyond_the_end(corner, counts))
        } else {
            let i = which(keyword)?;
            let least = if i == 1 { 1 } else { 3 };
            let numbers: Vec<_> = parts.take(3).collect();
            let bad = numbers.iter().map(|w| String::from_utf8_lossy(w)).find_map(|w| {
                // Numbers that are not finite are repaired later, and invalid normals are replaced.
                let is_broken = w.parse::<f32>().is_err() && !is_not_finite(w.as_bytes());
                (is_broken && (i != 2 || is_number(w.as_bytes()))).then(|| format!("expected a number, found '{w}'"))
            });
            let few = || (numbers.len() < least).then(|| format!("a {} has too few numbers", NAMES[i]));
            bad.or_else(few)
        };
        cause.map(|cause| Flaw {
            line: line.number,
            cause,
        })
    })
}

fn beyond_the_end(corner: &[u8], counts: Counts) -> Option<String> {
    corner.split(|b| *b == b'/').enumerate().find_map(|(i, index)| {
        let text = String::from_utf8_lossy(index);
        match text.parse::<i64>() {
            Ok(n) if n > counts[i] as i64 => Some(format!(
                "a face names {} {n}, but there are only {}",
                NAMES[i], counts[i]
            )),
            Err(_) if i == 0 || !index.is_empty() => {
                Some(format!("expected the number of a {}, found '{text}'", NAMES[i]))
            }
            _ => None,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(text: &str) -> (String, Vec<Run>) {
        let n = normalize(text.as_bytes(), Treatment::default()).unwrap();
        (String::from_utf8(n.text).unwrap(), n.runs)
    }

    #[test]
    fn runs_part_where_material_smoothing_or_the_shape_of_faces_changes() {
        let (text, runs) =
            normal("s 2\nf 1/1 2/2 3/3\nusemtl a\nf 1/1 2/2 3/3\nf 1 2/2 3\ns off\ng x\nf 1//1 2//1 3//1\n");
        let expected = "g 0\nf 1/1 2/2 3/3\ng 1\nf 1/1 2/2 3/3\ng 2\nf 1// 2// 3//\ng 3\nf 1//1 2//1 3//1\n";
        assert_eq!(text, expected);
        let smoothing: Vec<_> = runs.iter().map(|r| r.smoothing).collect();
        assert_eq!(smoothing, [2, 2, 2, 0]);
        assert_eq!(runs[1].material.as_deref(), Some(&b"a"[..]));
        assert!(runs[3].has_normals && !runs[3].has_uvs);
    }

    #[test]
    fn colors_weights_and_short_texture_coordinates_are_made_regular() {
        let (text, _) = normal("v 1 2 3 0.5 0.5 0.5\nv 1 2 3 1\nvt 0.5\nVT 1 2 3\n");
        assert_eq!(text, "v 1 2 3 \nv 1 2 3 \nvt 0.5 0 \nvt 1 2 \n");
        let keeps_colors = Treatment {
            keeps_colors: true,
            ..Treatment::default()
        };
        let colored = normalize(b"v 1 2 3 0.5 0.5 x\nv 1 2 3 1\nv 1 2 3\n", keeps_colors).unwrap();
        let expected = "v 1 2 3  0.5 0.5 nan\nv 1 2 3  nan nan nan\nv 1 2 3  nan nan nan\n";
        assert_eq!(String::from_utf8(colored.text).unwrap(), expected);
        assert!(colored.has_colors);
    }

    #[test]
    fn normals_that_are_no_numbers_are_zero_and_counted() {
        let n = normalize(
            b"vn nan 0 1\nvn -1.#IND 0 1\nvn 1e99 0 0\nvn 0 1e0 0\n",
            Treatment::default(),
        )
        .unwrap();
        let text = "vn 0 0 0\nvn 0 0 0\nvn 0 0 0\nvn 0 1e0 0 \n";
        assert_eq!((n.bad_normals, String::from_utf8(n.text).unwrap().as_str()), (3, text));
    }

    #[test]
    fn objects_and_groups_become_nodes_once_each() {
        let (_, runs) =
            normal("f 1 1 1\no a\nf 1 1 1\ng x\nf 1 1 1\no b\ng x\nf 1 1 1\no a\ng x\nf 1 1 1\ng\nf 1 1 1\n");
        let nodes: Vec<_> = runs.iter().map(|r| r.node).collect();
        assert_eq!(nodes, [None, Some(0), Some(1), Some(3), Some(1), Some(0)]);
    }

    #[test]
    fn wrong_indices_are_named_with_their_line() {
        let flaw = |text: &str| {
            normalize(text.as_bytes(), Treatment::default())
                .map(|_| ())
                .unwrap_err()
        };
        assert_eq!(
            flaw("v 0 0 0\nf 1 0 1").cause,
            "a face names vertex 0, but they count from 1"
        );
        let few = flaw("v 0 0 0\nf -1 -2 1");
        assert_eq!(
            (few.line, few.cause.as_str()),
            (2, "a face names vertex -2, but there are only 1 before it")
        );
        assert!(flaw("f 99999999999 1 1").cause.contains("more than there can be"));
        let beyond = diagnose(b"v 0 0 0\nf 1 1 1\nf 1/5 1 1").unwrap();
        assert_eq!(
            (beyond.line, beyond.cause.as_str()),
            (3, "a face names texture coordinate 5, but there are only 0")
        );
        assert_eq!(diagnose(b"v 0 x 0").unwrap().cause, "expected a number, found 'x'");
        assert!(diagnose(b"v 0 -nan(ind) 0").is_none());
        // An invalid normal is replaced and no error.
        assert!(diagnose(b"vn nan 0 1").is_none());
        assert!(diagnose(b"vn 1.2.3 0 1").unwrap().cause.contains("1.2.3"));
        assert_eq!(diagnose(b"v 0 1").unwrap().cause, "a vertex has too few numbers");
    }
}
