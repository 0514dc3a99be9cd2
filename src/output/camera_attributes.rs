//! The attributes of a frame's camera, as OpenEXR names and defines them.
//!
//! They are those of the camera as the shutter opens. Matrices take row vectors: a point of the world is a row before the matrix.
//! Source: ImfStandardAttributes.h of OpenEXR.

use glam::DMat4;

use super::{Attribute, Value};
use crate::camera::{FilmSize, FrameCamera};

/// The depth that stands for infinity, in m.
const FARTHEST: f32 = 1e10;

/// The attributes of a camera for a picture of this size, at this rate in frames per second, if it is known.
pub fn camera_attributes(camera: &FrameCamera, film: FilmSize, fps: Option<(i32, u32)>) -> Vec<Attribute> {
    let first = camera.camera(0.0);
    let matrices = first.matrices(film);
    // Row-major for row vectors is the same order as column-major for column vectors.
    let matrix = |m: DMat4| Value::M44f(m.to_cols_array().map(|v| v as f32));
    let mut list = vec![
        Attribute::new("worldToCamera", matrix(matrices.camera_from_world)),
        // There are no clipping planes.
        Attribute::new("near", 0.0_f32),
        Attribute::new("far", FARTHEST),
    ];
    list.extend(matrices.ndc_from_world.map(|m| Attribute::new("worldToNDC", matrix(m))));
    if let Some(lens) = first.lens_facts() {
        list.push(Attribute::new("pinholeFocalLength", lens.focal_length as f32));
        if let Some(depth_of_field) = lens.depth_of_field {
            list.push(Attribute::new("aperture", depth_of_field.fstop as f32));
            list.push(Attribute::new("focus", depth_of_field.focus_distance as f32));
        }
    }
    let exposure = camera.exposure();
    if exposure > 0.0 {
        list.push(Attribute::new("shutterAngle", (360.0 * exposure) as f32));
        if let Some((numerator, denominator)) = fps {
            let seconds = exposure * f64::from(denominator) / f64::from(numerator);
            list.push(Attribute::new("expTime", seconds as f32));
        }
    }
    list
}
