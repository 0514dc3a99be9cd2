//! Models by themselves that are moved and scaled to a common size.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::{
    assets::model::{ModelCamera, ModelView},
    compile::objects::world_from_object,
    describe::SceneDesc,
    kind::named,
    math::{DAabb, DAffine3},
};

named! {
    /// The unit shape that a model by itself is scaled to. It is centred at the origin.
    pub enum Normalise: "shape" {
        /// A sphere of radius 1: the corners of the bounds lie on it.
        UnitSphere = "unit-sphere",
        /// A cube with edges of 1: the bounds have the length of an edge along their longest axis.
        UnitCube = "unit-cube",
    }
}

/// The map from the space of a model to the world: a point p of the model is at `scale * p + translate`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelPlace {
    pub scale: f64,
    pub translate: DVec3,
}

impl ModelPlace {
    /// The map that makes `bounds` fill this shape. Bounds without a size are moved only; `None` for those that are empty.
    pub fn new(shape: Normalise, bounds: &DAabb) -> Option<Self> {
        let size = match shape {
            Normalise::UnitSphere => bounds.half_diagonal(),
            Normalise::UnitCube => (bounds.max - bounds.min).max_element(),
        };
        let scale = if size > 0.0 { size.recip() } else { 1.0 };
        let translate = -scale * bounds.center();
        (bounds.is_finite() && scale.is_finite() && translate.is_finite()).then_some(Self { scale, translate })
    }

    /// Whether its numbers are beyond those of a scene file.
    pub fn is_too_large(&self) -> bool {
        let largest = self.scale.max(self.translate.abs().max_element());
        largest > f64::from(f32::MAX) || self.light_factor() > f64::from(f32::MAX)
    }

    /// The map of the description of a model by itself, with the digits that it keeps.
    pub fn of(desc: &SceneDesc) -> Option<Self> {
        let place = world_from_object(desc.objects.first()?).ok()?;
        Some(Self {
            scale: place.matrix3.x_axis.x,
            translate: place.translation,
        })
    }

    /// The table of the object in a scene file, without its head.
    pub fn toml(&self) -> String {
        let translate = self.translate.to_array();
        format!("scale = {:?}\ntranslate = {translate:?}\n", self.scale)
    }

    /// The factor of the intensities of lights that are as bright on the model as before.
    pub fn light_factor(&self) -> f64 {
        self.scale * self.scale
    }

    fn map(&self) -> DAffine3 {
        DAffine3 {
            matrix3: DMat3::from_diagonal(DVec3::splat(self.scale)),
            translation: self.translate,
        }
    }

    /// The bounds of what has these bounds in the space of the model.
    pub fn bounds(&self, bounds: &DAabb) -> DAabb {
        bounds.transformed(&self.map())
    }

    /// A camera of the model, in the world.
    pub fn camera(&self, camera: &ModelCamera) -> ModelCamera {
        let mut placed = camera.clone();
        placed.model_from_camera.translation = self.map().transform_point3(camera.model_from_camera.translation);
        if let ModelView::Orthographic { height } = &mut placed.view {
            *height *= self.scale;
        }
        placed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: DAabb = DAabb {
        min: DVec3::new(-3.0, 10.0, 0.25),
        max: DVec3::new(5.0, 12.0, 1.25),
    };

    #[test]
    fn bounds_fill_the_sphere_or_the_cube_around_the_origin() {
        let [sphere, cube] = [Normalise::UnitSphere, Normalise::UnitCube].map(|shape| {
            ModelPlace::new(shape, &BOUNDS)
                .expect("they have a size")
                .bounds(&BOUNDS)
        });
        for bounds in [sphere, cube] {
            assert!(bounds.center().length() < 1e-15, "{bounds:?}");
        }
        assert!((sphere.max.length() - 1.0).abs() < 1e-15);
        assert!(((cube.max - cube.min) - DVec3::new(1.0, 0.25, 0.125)).length() < 1e-15);
    }

    #[test]
    fn bounds_without_a_size_are_moved_and_empty_ones_are_left() {
        let point = DAabb {
            min: BOUNDS.max,
            max: BOUNDS.max,
        };
        let place = ModelPlace::new(Normalise::UnitSphere, &point).expect("a point");
        assert_eq!((place.scale, place.translate), (1.0, -BOUNDS.max));
        assert_eq!(ModelPlace::new(Normalise::UnitCube, &DAabb::EMPTY), None);
    }
}
