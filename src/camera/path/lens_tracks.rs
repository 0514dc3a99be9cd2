//! The curves of a lens along a camera path.

use crate::{
    camera::{
        LensOverrides,
        intrinsics::{COLUMNS, IntrinsicsOverrides},
        lens::{Aperture, FieldOfView, Sensor},
    },
    math::track::{Channel, Interp, Track},
};

/// A curve for each parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LensTracks {
    view: Track<FieldOfView>,
    sensor: Track<Sensor>,
    aperture: Track<Aperture>,
    focus_distance: Track<f64>,
    shift_x: Track<f64>,
    shift_y: Track<f64>,
    /// In the order of [`COLUMNS`].
    intrinsics: [Track<f64>; COLUMNS.len()],
}

impl LensTracks {
    /// The curves through lenses, each with its time and the interpolation up to the next.
    pub fn new(keys: &[(f64, LensOverrides, Interp)]) -> Self {
        Self {
            view: track(keys, |lens| lens.view),
            sensor: track(keys, |lens| lens.sensor),
            aperture: track(keys, |lens| lens.aperture),
            focus_distance: track(keys, |lens| lens.focus_distance),
            shift_x: track(keys, |lens| lens.shift_x),
            shift_y: track(keys, |lens| lens.shift_y),
            intrinsics: std::array::from_fn(|i| track(keys, |lens| lens.intrinsics.0[i])),
        }
    }

    pub fn at(&self, frame: f64) -> LensOverrides {
        LensOverrides {
            view: self.view.at(frame),
            sensor: self.sensor.at(frame),
            aperture: self.aperture.at(frame),
            focus_distance: self.focus_distance.at(frame),
            shift_x: self.shift_x.at(frame),
            shift_y: self.shift_y.at(frame),
            intrinsics: IntrinsicsOverrides(self.intrinsics.each_ref().map(|track| track.at(frame))),
        }
    }
}

fn track<T: Channel>(keys: &[(f64, LensOverrides, Interp)], value: impl Fn(&LensOverrides) -> Option<T>) -> Track<T> {
    Track::new(keys.iter().map(|(time, lens, interp)| (*time, value(lens), *interp)))
}
