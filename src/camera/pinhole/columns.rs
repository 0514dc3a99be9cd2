//! The lens of a pinhole by the intrinsics of a camera path.
//!
//! Numbers that a path leaves out are those of the scene's camera, if that is a pinhole. A path with `fx`
//! makes a pinhole of any other camera.

use super::{Distortion, PinholeLens};
use crate::camera::{
    Lens, ViewDistortion,
    intrinsics::{COLUMNS, IntrinsicsColumn, IntrinsicsOverrides, Part},
};

impl IntrinsicsOverrides {
    /// Those by which any pinhole becomes `lens`, so that no skew and no coefficient of another one stays; `None` where a
    /// coefficient of its distortion has no column.
    pub fn of(lens: &PinholeLens) -> Option<Self> {
        let distortion = lens.distortion.of_data_sets()?;
        let value = |column: &IntrinsicsColumn| match (column.part, &distortion) {
            (Part::Focal(axis), _) => Some(lens.focal[axis]),
            (Part::Center(axis), _) => lens.center[axis],
            (Part::Skew, _) => Some(lens.skew),
            (Part::Size(axis), _) => lens.size.map(|size| size[axis]),
            (Part::OpenCv(i), ViewDistortion::OpenCv(all)) => Some(all[i]),
            (Part::OpenCv(_), ViewDistortion::None) => Some(0.0),
            (Part::KannalaBrandt(i), ViewDistortion::OpenCvFisheye(all)) => Some(all[i]),
            (Part::OpenCv(_) | Part::KannalaBrandt(_), _) => None,
        };
        Some(Self(COLUMNS.each_ref().map(value)))
    }

    /// The lens that these make alone; `None` without a focal length.
    pub fn lens(&self) -> Option<PinholeLens> {
        let focal = self.part(Part::Focal(0))?;
        let plain = PinholeLens {
            focal: [focal; 2],
            center: [None; 2],
            skew: 0.0,
            size: None,
            distortion: Distortion::None,
        };
        Some(self.apply(&plain))
    }

    /// The lens of which these replace numbers: `lens`, or a pinhole if that has no use for a focal length in pixels.
    pub fn base(&self, lens: &Lens) -> Lens {
        match (lens, self.lens()) {
            (Lens::Pinhole(_), _) | (_, None) => *lens,
            (_, Some(own)) => own.into(),
        }
    }

    /// A lens with its numbers replaced. Without `fy`, the ratio of the focal lengths stays.
    pub(super) fn apply(&self, lens: &PinholeLens) -> PinholeLens {
        let ratio = lens.focal[1] / lens.focal[0];
        let mut changed = *lens;
        let mut distortion = None;
        let (mut opencv, mut fisheye) = ([0.0; 12], [0.0; 4]);
        match lens.distortion.of_data_sets() {
            Some(ViewDistortion::OpenCv(all)) => opencv = all,
            Some(ViewDistortion::OpenCvFisheye(all)) => fisheye = all,
            Some(ViewDistortion::None) | None => {}
        }
        for (column, v) in self.given() {
            match column.part {
                Part::Focal(0) => changed.focal = [v, v * ratio],
                Part::Focal(axis) => changed.focal[axis] = v,
                Part::Center(axis) => changed.center[axis] = Some(v),
                Part::Skew => changed.skew = v,
                Part::Size(axis) => changed.size.get_or_insert([v; 2])[axis] = v,
                Part::OpenCv(i) => {
                    opencv[i] = v;
                    distortion = Some(ViewDistortion::OpenCv(opencv));
                }
                Part::KannalaBrandt(i) => {
                    fisheye[i] = v;
                    distortion = Some(ViewDistortion::OpenCvFisheye(fisheye));
                }
            }
        }
        changed.distortion = distortion.map_or(lens.distortion, Distortion::from);
        changed
    }
}
