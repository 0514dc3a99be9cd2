//! Materials of OBJ files: of MTL the diffuse colour and its texture.

use std::{
    collections::{HashMap, HashSet},
    path::{Component, Path, PathBuf},
};

use super::{
    error::ObjError,
    lines::{Lines, argument, decode, words},
};
use crate::{
    assets::{
        Files,
        files::is_refused,
        model::{ImageSource, Model, ModelMaterial, ModelTexture},
    },
    material::principled::Principled,
    math::Rgb,
    texture::{Color, TextureId, image::Wrap},
    value::one_line,
};

/// The grey of what has no material.
const GRAY: f32 = 0.8;

/// The materials of all libraries of a file, read once each.
pub(super) struct Library<'a> {
    files: &'a Files,
    /// By name, with the library's folder. Of two with one name the later counts, as everywhere.
    materials: HashMap<String, (tobj::Material, PathBuf)>,
    /// The images that the model already has.
    images: HashMap<PathBuf, usize>,
}

impl<'a> Library<'a> {
    /// Reads the libraries that the lines after `mtllib` name. One that is missing or broken is a warning: the faces are
    /// grey without it.
    ///
    /// # Errors
    /// A library lies outside of the folder of the model, or is no regular file.
    pub fn load(obj: &Path, lines: &[String], files: &'a Files) -> Result<Self, ObjError> {
        let mut library = Self {
            files,
            materials: HashMap::new(),
            images: HashMap::new(),
        };
        let folder = obj.parent().unwrap_or(Path::new(""));
        let mut seen = HashSet::new();
        for path in lines.iter().flat_map(|line| candidates(folder, line)) {
            if seen.insert(path.clone()) {
                library.check_inside(obj, &path)?;
                library.add(obj, &path)?;
            }
        }
        Ok(library)
    }

    /// Refuses files outside of the folder of the model.
    fn check_inside(&self, obj: &Path, file: &Path) -> Result<(), ObjError> {
        let folder = obj.parent().unwrap_or(Path::new(""));
        match self.files.allows(folder, file) {
            true => Ok(()),
            false => Err(ObjError::Outside {
                file: file.to_owned(),
                path: obj.to_owned(),
            }),
        }
    }

    fn add(&mut self, obj: &Path, path: &Path) -> Result<(), ObjError> {
        let (obj, shown) = (obj.display(), path.display());
        let bytes = match self.files.read(path) {
            Ok(bytes) => bytes,
            Err(source) if is_refused(&source) => {
                let path = path.to_owned();
                return Err(ObjError::Read { source, path });
            }
            Err(e) => {
                tracing::warn!("{obj}: cannot read the material library, its surfaces are gray: {e}: {shown}");
                return Ok(());
            }
        };
        match tobj::load_mtl_buf(&mut &normalize(&decode(&bytes), path)[..]) {
            Ok((materials, _)) => {
                let folder = path.parent().unwrap_or(Path::new(""));
                let named = materials.into_iter().map(|m| (m.name.clone(), (m, folder.to_owned())));
                self.materials.extend(named);
            }
            Err(e) => tracing::warn!("{obj}: the material library is broken, its surfaces are gray: {e}: {shown}"),
        }
        Ok(())
    }

    /// Puts the material of that name into `model`, and its image; returns its number there.
    ///
    /// # Errors
    /// The image lies outside of the folder of the model.
    pub fn place(&mut self, name: Option<&str>, obj: &Path, model: &mut Model) -> Result<usize, ObjError> {
        let found = name.and_then(|name| self.materials.get(name));
        if let (Some(name), None, false) = (name, found, self.materials.is_empty()) {
            tracing::warn!(
                "{}: there is no material '{}', its surfaces are gray",
                obj.display(),
                one_line(name, 80)
            );
        }
        let mut base_color = Rgb::gray(GRAY);
        let mut base_texture = None;
        if let Some((material, folder)) = found {
            base_color = material.diffuse.map_or(base_color, Rgb::from_array);
            if let Some(texture) = &material.diffuse_texture {
                let (name, wrap) = file_and_wrap(texture);
                let file = locate(folder, &name);
                self.check_inside(obj, &file)?;
                let image = *self.images.entry(file).or_insert_with_key(|file| {
                    model.images.push(ImageSource::File(file.clone()));
                    model.images.len() - 1
                });
                model.textures.push(ModelTexture {
                    wrap: [wrap; 2],
                    ..ModelTexture::of_image(image)
                });
                base_texture = Some(TextureId(model.textures.len() as u32 - 1));
                // Exporters leave Kd black where a texture takes its place.
                if base_color.is_black() {
                    base_color = Rgb::WHITE;
                }
            }
        }
        model.materials.push(ModelMaterial {
            name: name.unwrap_or_default().to_owned(),
            surface: Principled::matte(match base_texture {
                Some(texture) => Color::Tinted(texture, base_color),
                None => Color::Constant(base_color),
            }),
        });
        Ok(model.materials.len() - 1)
    }
}

/// The file of a `mtllib` line, whose name may hold spaces, or its several files.
fn candidates(folder: &Path, line: &str) -> Vec<PathBuf> {
    let whole = locate(folder, line);
    if whole.is_file() || !line.contains(char::is_whitespace) {
        return vec![whole];
    }
    line.split_whitespace().map(|name| locate(folder, name)).collect()
}

/// A file beside another: backslashes separate folders too, and of a path of another machine its last part counts.
fn locate(folder: &Path, name: &str) -> PathBuf {
    let name = name.trim_matches('"').replace('\\', "/");
    let path = Path::new(&name);
    let is_absolute = path.has_root() || name.as_bytes().get(1) == Some(&b':');
    let relative = match path.components().next_back() {
        Some(Component::Normal(last)) if is_absolute => Path::new(last),
        _ => path,
    };
    folder.join(relative)
}

/// The statements that are used, in the one form that the parser does not stumble over.
fn normalize(text: &[u8], path: &Path) -> Vec<u8> {
    let mut out = Vec::new();
    for line in Lines::new(text) {
        match words(&line.text).next().unwrap_or_default() {
            b"newmtl" => {
                let name = argument(&line.text);
                let name = if name.is_empty() { "unnamed" } else { &name };
                out.extend_from_slice(format!("newmtl {name}\n").as_bytes());
            }
            b"Kd" => match color(&line.text) {
                Some([r, g, b]) => out.extend_from_slice(format!("Kd {r} {g} {b}\n").as_bytes()),
                None => tracing::warn!("line {}: this Kd is not understood: {}", line.number, path.display()),
            },
            b"map_Kd" | b"map_kd" => {
                let given = argument(&line.text);
                if !given.is_empty() {
                    out.extend_from_slice(format!("map_Kd {given}\n").as_bytes());
                }
            }
            _ => {}
        }
    }
    out
}

/// One number for all channels, or three.
fn color(text: &[u8]) -> Option<[f32; 3]> {
    let number = |w: &[u8]| str::from_utf8(w).ok()?.parse::<f32>().ok().filter(|v| v.is_finite());
    let numbers: Option<Vec<f32>> = words(text).skip(1).map(number).collect();
    match numbers?[..] {
        [gray] => Some([gray.max(0.0); 3]),
        [r, g, b, ..] => Some([r, g, b].map(|v| v.max(0.0))),
        _ => None,
    }
}

/// The file's name, which may hold spaces, after options such as `-s 1 1 1`, of which only `-clamp` is used.
fn file_and_wrap(given: &str) -> (String, Wrap) {
    let split = |text: &'_ str| -> Option<(usize, usize)> {
        let end = text.find(char::is_whitespace)?;
        Some((end, end + text[end..].len() - text[end..].trim_start().len()))
    };
    let (mut rest, mut wrap) = (given.trim(), Wrap::Repeat);
    while let Some((end, next)) = split(rest) {
        let option = &rest[..end];
        let (least, most) = match option {
            "-s" | "-o" | "-t" => (0, 3),
            "-mm" => (2, 2),
            "-blendu" | "-blendv" | "-boost" | "-texres" | "-clamp" | "-bm" | "-imfchan" | "-type" | "-cc" => (1, 1),
            // A file's name, perhaps one that begins with a dash.
            _ => break,
        };
        rest = &rest[next..];
        for i in 0..most {
            let Some((end, next)) = split(rest) else { break };
            let value = &rest[..end];
            if i >= least && value.parse::<f32>().is_err() {
                break;
            }
            if (option, value) == ("-clamp", "on") {
                wrap = Wrap::Clamp;
            }
            rest = &rest[next..];
        }
    }
    (rest.to_owned(), wrap)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_options_are_passed_over_and_names_keep_their_spaces() {
        let read = |text: &str| file_and_wrap(text);
        assert_eq!(read("a b.png"), ("a b.png".into(), Wrap::Repeat));
        assert_eq!(read("-s 1 1 1 -o 0.5 a.png"), ("a.png".into(), Wrap::Repeat));
        assert_eq!(
            read("-clamp on -bm 1 -mm 0 1 my file.png"),
            ("my file.png".into(), Wrap::Clamp)
        );
        assert_eq!(read("-odd.png"), ("-odd.png".into(), Wrap::Repeat));
    }

    #[test]
    fn broken_statements_never_reach_the_parser() {
        let text = b"newmtl\nKd 0.5\nnewmtl a b\nKd 1 x 0\nmap_Kd\nKd 0.1 -0.2 0.3 1\nKd spectral f.rfl\nillum\n";
        let out = String::from_utf8(normalize(text, Path::new("a.mtl"))).unwrap();
        assert_eq!(out, "newmtl unnamed\nKd 0.5 0.5 0.5\nnewmtl a b\nKd 0.1 0 0.3\n");
        assert!(tobj::load_mtl_buf(&mut out.as_bytes()).is_ok());
    }

    #[test]
    fn paths_of_other_systems_are_found() {
        let at = |name| locate(Path::new("m"), name);
        assert_eq!(at(r"textures\a.png"), Path::new("m/textures/a.png"));
        assert_eq!(at(r"C:\art\a.png"), Path::new("m/a.png"));
        assert_eq!(at("/home/art/a.png"), Path::new("m/a.png"));
    }
}
