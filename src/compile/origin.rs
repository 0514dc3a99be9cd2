//! The choice of a scene's origin.
//!
//! The positions of a compiled scene are in single precision, relative to an origin in double precision. It is the first of these
//! that applies, in whole metres:
//!
//! 1. the centre of the bounds of all bounded objects, if it is far from the world's origin ([`FAR`](crate::math::origin::FAR))
//!    and the bounds are small compared with that distance;
//! 2. the camera's first position, if it is far and an object is near it compared with that distance;
//! 3. the world's origin.
//!
//! The choice depends on the scene and the whole camera path, never on the rendered frames, so chunks of a job have the same
//! bits.

use crate::{
    describe::{ObjectDesc, SceneDesc},
    math::{DAabb, DAffine3, DVec3, origin},
};

/// The largest distance between the eye and a near object, relative to the distance of the eye from the world's origin.
const NEAR: f64 = 0.125;

/// The choice of a scene's origin, from the bounds of its objects and the camera.
pub(super) struct SceneOrigin {
    /// The bounds of the bounded objects, in world space.
    boxes: Vec<DAabb>,
    eye: Option<DVec3>,
}

impl SceneOrigin {
    /// Takes the shapes of a scene into account. `eye` is the first position of the camera; `None` for that of the scene's own.
    pub fn new(desc: &SceneDesc, eye: Option<DVec3>) -> Self {
        let own_eye = || Some(desc.camera.as_ref()?.get_ref().compile().ok()?.pose.eye());
        Self {
            boxes: desc.objects.iter().filter_map(shape_box).collect(),
            eye: eye.or_else(own_eye),
        }
    }

    /// Takes the bounds of models into account.
    pub fn add(&mut self, boxes: impl Iterator<Item = DAabb>) {
        self.boxes.extend(boxes.filter(DAabb::is_finite));
    }

    pub fn choose(&self) -> DVec3 {
        let all = self.boxes.iter().copied().fold(DAabb::EMPTY, DAabb::union);
        let near_eye = |eye: &DVec3| {
            let reach = NEAR * eye.length();
            origin::is_far(*eye) && self.boxes.iter().any(|b| b.distance(*eye) <= reach)
        };
        let around_eye = || self.eye.filter(near_eye).map(origin::rounded);
        origin::of_box(&all).or_else(around_eye).unwrap_or_default()
    }
}

/// The bounds of a shape in world space; `None` if it is unbounded or invalid. The compiler reports its errors.
pub(super) fn shape_box(object: &ObjectDesc) -> Option<DAabb> {
    let shape = object.shape.get_ref();
    let anchor = shape.anchor()?;
    let around_anchor = shape.compile(anchor).ok()?.bounds();
    let own = DAabb::from(around_anchor).transformed(&DAffine3::from_translation(anchor));
    let placed = match &object.transform {
        Some(given) => own.transformed(&given.get_ref().compile(given.span()).ok()?),
        None => own,
    };
    Some(placed).filter(DAabb::is_finite)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(boxes: &[(f64, f64)], eye: f64) -> f64 {
        let along = |&(from, to): &(f64, f64)| DAabb::from_points([DVec3::X * from, DVec3::X * to]);
        let scene = SceneOrigin {
            boxes: boxes.iter().map(along).collect(),
            eye: Some(DVec3::X * eye),
        };
        scene.choose().x
    }

    #[test]
    fn scenes_near_the_origin_and_around_it_are_compiled_around_it() {
        assert_eq!(origin(&[(-5.0, 5.0)], 9.5), 0.0);
        assert_eq!(origin(&[(900.0, 901.0)], 950.0), 0.0);
        assert_eq!(origin(&[(-5.0, 5.0)], 20_000.0), 0.0);
        assert_eq!(origin(&[], 20_000.0), 0.0);
    }

    #[test]
    fn small_scenes_far_away_are_compiled_around_their_centres_and_large_ones_around_the_eye() {
        assert_eq!(origin(&[(5000.0, 5001.0), (5002.0, 5003.4)], 4000.3), 5002.0);
        assert_eq!(origin(&[(5000.0, 5001.0), (-9000.0, 9000.0)], 4000.3), 4000.0);
    }
}
