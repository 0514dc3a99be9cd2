//! Cameras.

use ::gltf::json::camera::Camera;

use crate::assets::model::ModelView;

/// Returns the view of a camera; `None` if its parameters are invalid.
pub(super) fn view(camera: &Camera) -> Option<ModelView> {
    let view = match (&camera.perspective, &camera.orthographic) {
        (Some(p), _) => ModelView::Perspective { fov: p.yfov.into() },
        (None, Some(o)) => ModelView::Orthographic {
            height: 2.0 * f64::from(o.ymag).abs(),
        },
        (None, None) => return None,
    };
    let sound = match view {
        ModelView::Perspective { fov } => fov > 0.0 && fov < std::f64::consts::PI,
        ModelView::Orthographic { height } => height > 0.0 && height.is_finite(),
    };
    sound.then_some(view)
}
