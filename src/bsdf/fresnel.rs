//! Smooth boundaries between two clear media.

use crate::math::Vec3;

/// The part of unpolarised light that a smooth boundary reflects.
///
/// `cos_i` is the cosine of the incident angle, from 0 to 1; `eta` the transmitted over the
/// incident index of refraction. 1 where nothing passes (total reflection). Source: Born and Wolf,
/// "Principles of Optics", section 1.5.
pub fn dielectric(cos_i: f32, eta: f32) -> f32 {
    let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Whether a boundary reflects all light that arrives at the cosine `wo_z`; below 0 from behind, where the index of
/// refraction is `ior` times that in front.
pub fn is_total(wo_z: f32, ior: f32) -> bool {
    let eta = if wo_z < 0.0 { ior.recip() } else { ior };
    1.0 - wo_z * wo_z >= eta * eta
}

/// The part of unpolarised light that a metal of the complex index of refraction `eta + i k`
/// reflects, against vacuum.
///
/// `cos` is the cosine of the incident angle, from 0 to 1. Source: Born and Wolf, "Principles of
/// Optics", section 14.2.
#[inline(always)]
pub fn conductor(cos: f32, eta: f32, k: f32) -> f32 {
    let (cos2, sin2) = (cos * cos, (1.0 - cos * cos).max(0.0));
    let (eta2, k2) = (eta * eta, k * k);
    let t = eta2 - k2 - sin2;
    let length = (t * t + 4.0 * eta2 * k2).sqrt();
    let a = (0.5 * (length + t)).max(0.0).sqrt();
    let share = |sum: f32, twice: f32| (sum - twice) / (sum + twice);
    let perpendicular = share(length + cos2, 2.0 * a * cos);
    let parallel = perpendicular * share(cos2 * length + sin2 * sin2, 2.0 * a * cos * sin2);
    (0.5 * (perpendicular + parallel)).clamp(0.0, 1.0)
}

/// The weight by which Schlick's approximation interpolates from the reflectance at normal incidence
/// (0) to that at grazing incidence (1).
///
/// Source: Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", CGF 13(3), 1994,
/// doi:10.1111/1467-8659.1330233.
#[inline(always)]
pub fn schlick_term(cos: f32) -> f32 {
    let x = (1.0 - cos).clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// The direction in which light that arrives from `w` goes on behind the boundary; `None` under
/// total reflection.
///
/// `w` is unit and leaves the surface on the side of the unit normal `n`; `eta` is the transmitted
/// over the incident index. Snell's law.
pub fn refract(w: Vec3, n: Vec3, eta: f32) -> Option<Vec3> {
    let cos_i = n.dot(w);
    let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (eta * eta);
    if sin2_t >= 1.0 {
        return None;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    Some((-w / eta + n * (cos_i / eta - cos_t)).normalize())
}

/// The mirror image of `w` about the unit normal `n`.
#[inline(always)]
pub fn reflect(w: Vec3, n: Vec3) -> Vec3 {
    n * (2.0 * n.dot(w)) - w
}

/// `w` seen from the other side of the surface whose normal is z.
#[inline]
pub fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::trig;

    #[test]
    fn glass_reflects_four_percent_at_normal_incidence_from_either_side() {
        assert!((dielectric(1.0, 1.5) - 0.04).abs() < 1e-6);
        assert!((dielectric(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        assert!(dielectric(0.3, 1.0) < 1e-12);
    }

    #[test]
    fn all_light_is_reflected_at_grazing_incidence_and_beyond_the_critical_angle() {
        assert!((dielectric(0.0, 1.5) - 1.0).abs() < 1e-6);
        let critical_cos = (1.0_f32 - 1.0 / (1.5 * 1.5)).sqrt();
        assert_eq!(dielectric(critical_cos - 1e-4, 1.0 / 1.5), 1.0);
        assert!(dielectric(critical_cos + 1e-2, 1.0 / 1.5) < 1.0);
        assert_eq!(refract(Vec3::new(0.9, 0.435_889_9, 0.0), Vec3::Y, 1.0 / 1.5), None);
    }

    #[test]
    fn what_passes_one_way_passes_the_other_way() {
        for cos_i in [0.05_f32, 0.3, 0.7, 0.99] {
            let sin_i = (1.0 - cos_i * cos_i).sqrt();
            let w = Vec3::new(sin_i, cos_i, 0.0);
            let t = refract(w, Vec3::Y, 1.5).expect("into the denser medium");
            assert!((-t.x * 1.5 - sin_i).abs() < 1e-6, "Snell's law");
            let back = refract(t, Vec3::NEG_Y, 1.0 / 1.5).expect("out of it again");
            assert!((back - w).length() < 1e-5, "{back} {w}");
            let cos_t = trig::cos(trig::asin(sin_i / 1.5));
            assert!((dielectric(cos_i, 1.5) - dielectric(cos_t, 1.0 / 1.5)).abs() < 1e-5);
        }
    }

    #[test]
    fn a_mirror_keeps_the_angle() {
        let w = Vec3::new(0.6, 0.8, 0.0);
        assert_eq!(reflect(w, Vec3::Y), Vec3::new(-0.6, 0.8, 0.0));
    }
}
