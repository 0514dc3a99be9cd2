//! The formats of model files, and what to do with files of others.
//!
//! A format is one file with a type that implements [`ModelFormat`], and one row of [`FORMATS`].

use std::{fmt, path::Path};

use super::{gltf, gzip, model_format::ModelFormat, obj, ply, stl};
use crate::value::one_of;

/// All formats.
pub const FORMATS: &[&dyn ModelFormat] = &[&obj::Obj, &gltf::Gltf, &ply::Ply, &stl::Stl];

/// The format that the ending of a file's name tells.
pub fn of_path(path: &Path) -> Option<&'static dyn ModelFormat> {
    let is_packed = gzip::is_packed(path);
    let name = if is_packed { Path::new(path.file_stem()?) } else { path };
    let extension = ending(name)?;
    let mut formats = FORMATS.iter().copied();
    formats.find(|f| f.extensions().contains(&extension.as_str()) && (f.may_be_packed() || !is_packed))
}

/// Whether a file is a model, by its ending.
pub fn is_model(path: &Path) -> bool {
    of_path(path).is_some()
}

fn ending(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// The endings of all formats, packed ones last.
pub fn extensions() -> impl Iterator<Item = String> {
    let of = |format: &&dyn ModelFormat| format.extensions().iter();
    let packed = FORMATS.iter().filter(|format| format.may_be_packed());
    let plain = FORMATS.iter().flat_map(of).map(|e| (*e).to_owned());
    plain.chain(packed.flat_map(of).map(|e| format!("{e}.gz")))
}

/// The endings of files of other programs, and what a user does with such a file.
const FOREIGN: &[(&[&str], &str)] = &[
    (
        &["blend"],
        "Blender's own files are not read: export glTF (File > Export > glTF 2.0) and render the .glb",
    ),
    (
        &["fbx", "dae", "3ds", "lwo", "x3d", "wrl", "abc"],
        "open it in Blender or its own program and export glTF",
    ),
    (
        &["max", "ma", "mb", "c4d", "skp", "hip"],
        "the files of this program are not read: export glTF or OBJ from it",
    ),
    (
        &["usd", "usda", "usdc", "usdz"],
        "USD is not read: export glTF from the program that wrote it, or from Blender",
    ),
    (
        &["xml", "pbrt", "mtlx", "ass", "rib"],
        "scenes of other renderers are not read: name their PLY and OBJ meshes in a scene file (.toml)",
    ),
    (
        &["pov", "inc"],
        "scenes of POV-Ray are not read: write its shapes in a scene file (.toml), and export its meshes as OBJ",
    ),
    (
        &["step", "stp", "iges", "igs", "brep", "3dm"],
        "CAD surfaces are not read: export a mesh as STL or OBJ",
    ),
    (
        &["3mf", "off", "vtk"],
        "convert it to PLY or STL, for example with MeshLab",
    ),
    (
        &["las", "laz", "e57", "pcd", "pts", "xyz"],
        "convert the points to PLY, for example with CloudCompare",
    ),
    (
        &["splat", "ksplat", "spz"],
        "Gaussian splats are not rendered: export a mesh from the program that made them",
    ),
    (&["json", "yaml", "yml"], "scene files are TOML: see docs/scene"),
];

/// Returns what to do with a file of another program's format, by its ending.
pub fn advice(path: &Path) -> Option<&'static str> {
    let extension = ending(path)?;
    let known = FOREIGN
        .iter()
        .find(|(endings, _)| endings.contains(&extension.as_str()));
    known.map(|(_, advice)| *advice)
}

/// Why a file is of no known format: what to do instead, or the endings that are known.
pub(super) struct Unknown<'a>(pub &'a Path);

impl fmt::Display for Unknown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match advice(self.0) {
            Some(advice) => f.write_str(advice),
            None => {
                let known: Vec<String> = extensions().collect();
                write!(f, "expected {}", one_of(known.iter().map(String::as_str)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_ending_tells_the_format() {
        let is = |name: &str| is_model(Path::new(name));
        assert!(
            ["a.obj", "a.GLB", "b.c.PLY", "a.stl.gz", "a.obj.GZ"]
                .into_iter()
                .all(is)
        );
        assert!(!["a.glb.gz", "a.gz", "obj", "a.toml", "a.blend"].into_iter().any(is));
    }

    #[test]
    fn no_two_formats_have_one_ending_and_none_is_foreign() {
        let all: Vec<String> = extensions().collect();
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
        assert!(all.iter().all(|e| advice(Path::new(&format!("a.{e}"))).is_none()));
        let foreign: Vec<_> = FOREIGN.iter().flat_map(|(endings, _)| *endings).collect();
        assert_eq!(foreign.iter().collect::<BTreeSet<_>>().len(), foreign.len());
    }

    #[test]
    fn files_of_other_programs_come_with_advice() {
        let message = |name: &str| Unknown(Path::new(name)).to_string();
        assert!(message("a.blend").contains("export glTF"));
        assert!(message("a.pov").contains("scene file (.toml)"));
        assert!(message("a.USDZ").contains("USD is not read"));
        assert!(message("a.xyzzy").starts_with("expected one of `obj`"));
    }
}
