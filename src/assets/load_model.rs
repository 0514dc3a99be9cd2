//! The loading of a model file by its format.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use super::{
    AssetError, Files, edited,
    model::{AnimationChoice, LightUnits, Model, ModelChoice},
    model_formats,
    subdivision::subdivide,
};

/// A model file, and what of it is shown.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ModelRequest {
    pub path: PathBuf,
    pub choice: ModelChoice,
}

impl From<&Path> for ModelRequest {
    fn from(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            choice: ModelChoice::default(),
        }
    }
}

/// Loads a model, and subdivides it where its choice says so.
pub(super) fn load_model(request: &ModelRequest, files: &Files) -> Result<Model, AssetError> {
    let ModelRequest { path, choice } = request;
    let path = path.clone();
    let Some(format) = model_formats::of_path(&path) else {
        return Err(AssetError::UnknownModel { path });
    };
    if choice.scene.is_some() && !format.has_choices() {
        return Err(AssetError::NoScenes { path });
    }
    if choice.variant.is_some() && !format.has_choices() {
        return Err(AssetError::NoVariants { path });
    }
    if choice.light_units != LightUnits::Auto && !format.has_choices() {
        return Err(AssetError::NoLights { path });
    }
    if matches!(&choice.animation, Some(AnimationChoice::Named(names)) if !names.is_empty()) && !format.has_choices() {
        return Err(AssetError::NoAnimations { path });
    }
    let mut model = format.load(&path, choice, files).map_err(AssetError::Model)?;
    if let Some(how) = &choice.subdivision {
        let displacement = choice
            .displacement
            .as_ref()
            .map(|given| given.load(files))
            .transpose()?;
        subdivide(
            &mut model,
            how,
            displacement.as_ref(),
            format.joins_groups(),
            files.memory(),
        )
        .map_err(|cause| AssetError::Subdivision {
            cause: Box::new(cause),
            path,
        })?;
    }
    if !format.has_choices() && !choice.edited.is_empty() {
        model.motion = Some(Arc::new(edited::motion(&model, &choice.edited)));
    }
    Ok(model)
}
