//! The size of the pictures of a job, where its cameras tell it.

use crate::{
    assets::{
        Files,
        camera_path::{self, CameraPathError, PathProblem},
    },
    batch::Request,
    camera::Pose,
    describe::SceneDesc,
    error::Error,
    math::DVec3,
    value::{Count, Spanned},
};

/// The description with the size of the pictures for which the cameras of the camera path are calibrated,
/// unless the scene or a flag says one.
///
/// # Errors
/// The camera path is wrong, or its pictures have several sizes.
pub(in crate::batch) fn sized(mut desc: SceneDesc, request: &Request, inputs: &Files) -> Result<SceneDesc, Error> {
    let is_said = [&desc.render.width, &desc.render.height]
        .iter()
        .any(|side| !side.span().is_empty());
    let Some(file) = request.camera_path.as_ref().filter(|_| !is_said) else {
        return Ok(desc);
    };
    // Only the lenses count here.
    let options = request.path_options(Some(Pose::at(DVec3::ZERO)));
    let path = camera_path::load(file, None, &options, inputs)?;
    let mut sizes: Vec<[f64; 2]> = path.sizes().collect();
    sizes.dedup();
    match sizes[..] {
        [] => {}
        [size] => {
            let [width, height] = size.map(|n| Spanned::new(0..0, Count(n as u32)));
            (desc.render.width, desc.render.height) = (width, height);
        }
        [[w, h], [other_w, other_h], ..] => {
            let message = format!(
                "some pictures have {w}x{h} pixels and others {other_w}x{other_h}: choose one size (--resolution)"
            );
            return Err(CameraPathError::Invalid {
                path: file.clone(),
                problems: PathProblem::of_file(message).into(),
            }
            .into());
        }
    }
    Ok(desc)
}
