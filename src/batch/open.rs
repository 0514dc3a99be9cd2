//! The file that somebody wants rendered, whatever it is.

use std::path::Path;

use super::Request;
use crate::{
    assets::{Store, store::is_model},
    compile,
    describe::{self, RenderDesc, SceneDesc},
    error::Error,
};

/// The scene of a file: a scene file as it stands, or a model with all that it lacks. Models stay in `store`.
pub fn open(path: &Path, request: &Request, store: &Store) -> Result<SceneDesc, Error> {
    if !is_model(path) {
        return Ok(describe::load(path, |p| store.files().read(p))?);
    }
    let default = RenderDesc::default();
    let [width, height] = request
        .resolution
        .unwrap_or([default.width.get_ref().0, default.height.get_ref().0]);
    let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
    compile::default_scene::describe(path, aspect, store).map_err(|e| compile::Error::Assets(vec![e]).into())
}
