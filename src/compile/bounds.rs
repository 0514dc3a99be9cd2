//! The bounds of a scene that is only described: no acceleration structure is built for them.

use super::{Error, LoadOptions, load::around_models, origin::shape_box};
use crate::{
    assets::Store,
    describe::{FileKind, ObjectDesc, SceneDesc},
    math::{DAabb, DVec3},
};

/// The bounds in world space, in m, of the bounded objects that the camera may see, in the poses of the time of `options`, and the
/// time at which the last animation ends, in s. The ground that is supplied with a model by itself does not count.
pub fn visible_bounds(desc: &SceneDesc, store: &Store, options: &LoadOptions) -> Result<(DAabb, Option<f64>), Error> {
    let origin = DVec3::ZERO;
    let options = LoadOptions {
        origin: Some(origin),
        ..options.clone()
    };
    let (compiled, loaded) = around_models(desc, store, &options)?;
    let loaded = loaded.map_err(|errors| Error::assets(errors, desc))?;
    let is_seen = |object: &ObjectDesc| object.visible && object.ray_visibility.camera;
    let counted = match desc.source.kind {
        FileKind::Scene => desc.objects.len(),
        FileKind::Model => 1,
    };
    let shapes = desc
        .objects
        .iter()
        .take(counted)
        .filter(|object| is_seen(object))
        .filter_map(shape_box);
    let (mut boxes, mut end) = (shapes.collect::<Vec<_>>(), None);
    for (placed, model) in compiled.placed.iter().zip(&loaded.models) {
        if is_seen(&desc.objects[placed.object.0 as usize]) {
            boxes.push(placed.place.world_box(origin, &model.bounds()));
        }
        let motion = model.motion.as_ref().filter(|motion| !motion.clips.is_empty());
        let speed = placed.playback.speed.abs();
        if let Some(motion) = motion.filter(|_| speed > 0.0) {
            let own = placed.playback.start + f64::from(motion.end()) / speed;
            end = Some(end.map_or(own, |end: f64| end.max(own)));
        }
    }
    let bounds = boxes.into_iter().filter(DAabb::is_finite);
    Ok((bounds.fold(DAabb::EMPTY, DAabb::union), end))
}
