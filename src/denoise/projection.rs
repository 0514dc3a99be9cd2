//! The way from the pixels of one camera to those of another.

use glam::{DMat3, DMat4, DVec3, DVec4};

use super::frame::{CameraMatrices, Frame};

/// The way from the pixels of one camera to those of another.
pub(super) struct Projection {
    own: View,
    other: View,
}

/// A camera with the size of its picture in pixels.
struct View {
    ndc: DMat4,
    depth: DVec4,
    size: [f64; 2],
}

/// A place in a picture, in pixels from its upper left corner, with the depth of what is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub x: f64,
    pub y: f64,
    pub depth: f64,
}

impl View {
    /// `None` where the camera has no matrices, such as that of a panorama.
    fn new(frame: &Frame) -> Option<Self> {
        // Files have matrices for row vectors by rows, which are those for column vectors by columns.
        let matrix = |m: [f32; 16]| DMat4::from_cols_array(&m.map(f64::from));
        let CameraMatrices {
            camera_from_world,
            ndc_from_world,
            lens: _,
        } = frame.camera?;
        Some(Self {
            ndc: matrix(ndc_from_world?),
            depth: matrix(camera_from_world).row(2),
            size: frame.resolution.map(f64::from),
        })
    }
}

impl Projection {
    /// `None` where a camera has no matrices, such as that of a panorama.
    pub fn new(own: &Frame, other: &Frame) -> Option<Self> {
        let (own, other) = (View::new(own)?, View::new(other)?);
        Some(Self { own, other })
    }

    /// The place in the other picture of what is at a place of the own one; `None` where it is behind the other camera.
    pub fn place(&self, Place { x, y, depth }: Place) -> Option<Place> {
        let View { ndc, depth: to_z, size } = &self.own;
        let (x, y) = (x / size[0], y / size[1]);
        // x = ndc_x . p / ndc_w . p and so on: three linear equations for p.
        let w = ndc.row(3);
        let rows = [ndc.row(0) - x * w, ndc.row(1) - y * w, *to_z - DVec4::W * depth];
        let m = DMat3::from_cols(rows[0].truncate(), rows[1].truncate(), rows[2].truncate()).transpose();
        let p = (m.inverse() * DVec3::new(-rows[0].w, -rows[1].w, -rows[2].w)).extend(1.0);
        let View { ndc, depth: to_z, size } = &self.other;
        let h = *ndc * p;
        let place = Place {
            x: h.x / h.w * size[0],
            y: h.y / h.w * size[1],
            depth: to_z.dot(p),
        };
        (h.w > 0.0 && place.depth > 0.0 && place.x.is_finite() && place.y.is_finite()).then_some(place)
    }
}
