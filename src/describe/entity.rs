//! The tables of a scene file whose values have names.

use super::SceneDesc;

/// A table of a scene file, by its index in the lists of the [`SceneDesc`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Entity {
    Object(usize),
    Light(usize),
    Material(usize),
    Texture(usize),
    Background,
    Camera,
}

impl Entity {
    /// The index of an object.
    pub fn object(self) -> Option<usize> {
        match self {
            Self::Object(at) => Some(at),
            _ => None,
        }
    }

    /// The entity that has the key at `path`, and the steps from it to the key.
    pub(super) fn of_path<'p>(desc: &SceneDesc, path: &'p [&'p str]) -> Result<(Self, &'p [&'p str]), String> {
        let listed = |at: &str, count: usize| at.parse::<usize>().ok().filter(|at| *at < count);
        let missing = |what: &str, at: &str| format!("the scene has no {what} `{at}`");
        match path {
            ["background", inner @ ..] => Ok((Self::Background, inner)),
            ["camera", inner @ ..] if desc.camera.is_some() => Ok((Self::Camera, inner)),
            ["camera", ..] => Err("the scene has no [camera]".to_owned()),
            ["object", at, inner @ ..] => match listed(at, desc.objects.len()) {
                Some(at) => Ok((Self::Object(at), inner)),
                None => Err(missing("object", at)),
            },
            ["light", at, inner @ ..] => match listed(at, desc.lights.len()) {
                Some(at) => Ok((Self::Light(at), inner)),
                None => Err(missing("light", at)),
            },
            ["material", name, inner @ ..] => match desc.materials.iter().position(|m| m.name.get_ref() == name) {
                Some(at) => Ok((Self::Material(at), inner)),
                None => Err(missing("material", name)),
            },
            ["texture", name, inner @ ..] => match desc.textures.iter().position(|t| t.name.get_ref() == name) {
                Some(at) => Ok((Self::Texture(at), inner)),
                None => Err(missing("texture", name)),
            },
            [table @ ("render" | "output"), ..] => Err(format!("`{table}` holds for the whole job: use --set")),
            [table, ..] => Err(format!(
                "unknown table `{table}`: a value is named by object, light, material, texture, background or camera"
            )),
            [] => Err("a column has no name".to_owned()),
        }
    }
}
