//! Origins for things that lie far from the world's.
//!
//! Single precision counts 5,600 km in steps of half a metre. So a scene and a mesh far from the world's origin are kept
//! around an origin of their own in single precision, and the place of that origin is known in double. The same holds for
//! texture coordinates, which may be those of a map.

use glam::{DVec2, DVec3, Vec2};

use super::DAabb;

/// Points with a coordinate of this, in m, are far. Below it single precision is exact to 0.03 mm.
pub const FAR: f64 = 1000.0;

/// The largest half diagonal of a box that has an origin of its own, relative to its distance.
const MAX_SIZE: f64 = 0.25;

/// Whether a point has a coordinate that single precision rounds too much.
pub fn is_far(p: DVec3) -> bool {
    p.abs().max_element() >= FAR
}

/// `p` in whole metres, as numbers that single precision holds exactly.
pub fn rounded(p: DVec3) -> DVec3 {
    p.round().as_vec3().as_dvec3()
}

/// The origin for what lies in a box: its rounded centre, if that is far and the box is small compared with its
/// distance. `None` where the world's origin does as well.
pub fn of_box(bounds: &DAabb) -> Option<DVec3> {
    if !bounds.is_finite() {
        return None;
    }
    let center = bounds.center();
    let gains = is_far(center) && bounds.half_diagonal() <= MAX_SIZE * center.length();
    gains.then(|| rounded(center))
}

/// The origin for texture coordinates: a whole number on each axis, below them if they are far from 0 and close together
/// compared with their distance, else 0. Coordinates that are not finite do not count.
pub fn of_uvs(uvs: impl Iterator<Item = DVec2>) -> Vec2 {
    let none = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let (least, most) = (uvs.filter(|uv| uv.is_finite())).fold(none, |(least, most), uv| (least.min(uv), most.max(uv)));
    let axis = |least: f64, most: f64| {
        let (center, half) = ((least + most) / 2.0, (most - least) / 2.0);
        let gains = center.abs() >= FAR && half <= MAX_SIZE * center.abs() && center.is_finite();
        if gains { least.floor() as f32 } else { 0.0 }
    };
    let origin = Vec2::new(axis(least.x, most.x), axis(least.y, most.y));
    if origin.is_finite() { origin } else { Vec2::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(center: DVec3, half: f64) -> Option<DVec3> {
        of_box(&DAabb::from_points([center - half, center + half]))
    }

    #[test]
    fn a_small_box_far_away_has_an_origin_in_whole_metres() {
        let center = DVec3::new(431_250.4, 100.7, 5_649_829.2);
        assert_eq!(around(center, 3.0), Some(DVec3::new(431_250.0, 101.0, 5_649_829.0)));
    }

    #[test]
    fn a_near_box_a_large_one_and_an_empty_one_have_none() {
        assert_eq!(around(DVec3::X * 999.0, 1.0), None);
        assert_eq!(around(DVec3::X * 5000.0, 1000.0), None);
        assert_eq!(of_box(&DAabb::EMPTY), None);
    }

    #[test]
    fn texture_coordinates_far_from_0_have_a_whole_origin_on_each_axis() {
        let of = |uvs: &[[f64; 2]]| of_uvs(uvs.iter().map(|uv| DVec2::from_array(*uv))).to_array();
        assert_eq!(of(&[[1e6 + 0.25, -5000.5], [1e6 + 7.0, -4998.0]]), [1e6, -5001.0]);
        assert_eq!(of(&[[1e6, 0.0], [1e6 + 1.0, 999.0], [f64::NAN, 5.0]]), [1e6, 0.0]);
        assert_eq!(of(&[[0.0, -2000.0], [1e6, 2000.0]]), [0.0, 0.0]);
        assert_eq!(of(&[]), [0.0, 0.0]);
        assert_eq!(of(&[[1e300, f64::INFINITY]]), [0.0, 0.0]);
    }

    #[test]
    fn origins_are_exact_in_single_precision_however_far_they_are() {
        let far = rounded(DVec3::new(149_597_870_701.3, -16_777_217.4, 0.4));
        assert_eq!(far.as_vec3().as_dvec3(), far);
    }
}
