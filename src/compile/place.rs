//! The transforms of objects in a scene whose origin may be far from the world's.

use crate::math::{DAabb, DAffine3, DVec3, Transform, origin::is_far};

/// The transform of an object relative to the origin of the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectPlace {
    /// In double precision.
    scene_from_object: DAffine3,
    /// The same in single precision; `None` if the object is in world space.
    pub transform: Option<Transform>,
}

impl ObjectPlace {
    /// An object without a transform.
    pub fn in_world(origin: DVec3) -> Self {
        Self {
            scene_from_object: DAffine3::from_translation(DVec3::ZERO - origin),
            transform: None,
        }
    }

    /// An object with a transform, in a scene with this origin; `None` if the transform has no inverse.
    pub fn new(world_from_object: DAffine3, origin: DVec3) -> Option<Self> {
        if Transform::new(world_from_object)?.is_identity() {
            return Some(Self::in_world(origin));
        }
        Self::moved(world_from_object, origin)
    }

    /// An object whose transform counts even where it changes nothing; `None` if it has no inverse.
    pub fn moved(world_from_object: DAffine3, origin: DVec3) -> Option<Self> {
        let scene_from_object = DAffine3 {
            translation: world_from_object.translation - origin,
            ..world_from_object
        };
        Some(Self {
            scene_from_object,
            transform: Some(Transform::new(scene_from_object)?),
        })
    }

    /// The bounds in world space of bounds in the object's own space.
    pub fn world_box(&self, origin: DVec3, own: &DAabb) -> DAabb {
        let world_from_scene = DAffine3::from_translation(origin);
        own.transformed(&(world_from_scene * self.scene_from_object))
    }

    /// The transform from a space within the object. It is exact far from the object's own origin; near that it follows the
    /// object's transform in single precision.
    pub fn of(&self, object_from_space: &DAffine3) -> DAffine3 {
        let rounded = self.transform.map_or(self.scene_from_object, |t| t.widened());
        let scene_from_space = rounded * *object_from_space;
        let far = object_from_space.translation;
        if is_far(far) {
            DAffine3 {
                translation: self.scene_from_object.transform_point3(far),
                ..scene_from_space
            }
        } else {
            scene_from_space
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::transform::from_parts;

    #[test]
    fn a_model_that_is_brought_back_from_the_coordinates_of_a_map_keeps_its_millimetres() {
        let back = from_parts(DVec3::new(-431_250.371, 0.0, 0.0), DVec3::ZERO, DVec3::ONE);
        let place = ObjectPlace::new(back, DVec3::ZERO).expect("an inverse");
        let mesh = DAffine3::from_translation(DVec3::X * 431_251.0);
        assert!((place.of(&mesh).translation - DVec3::X * 0.629).length() < 1e-9);
    }

    #[test]
    fn turning_a_model_far_away_turns_its_place_in_double_precision() {
        let turn = from_parts(DVec3::ZERO, DVec3::Y * 30.0, DVec3::ONE);
        let origin = DVec3::new(4e6, 0.0, 3e6);
        let place = ObjectPlace::new(turn, origin).expect("an inverse");
        let p = DVec3::new(1e6, 0.0, 5e6);
        let found = place.of(&DAffine3::from_translation(p)).translation;
        assert!((origin + found - turn.transform_point3(p)).length() < 1e-8);
        assert_eq!(
            ObjectPlace::new(DAffine3::IDENTITY, origin)
                .expect("in the world")
                .transform,
            None
        );
    }
}
