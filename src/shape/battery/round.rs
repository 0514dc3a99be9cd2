//! Hits and normals of round shapes against algebra.

use super::examples::{PLACES, Random, hits, placed, shape};
use crate::math::{DVec3, Ray, Vec3};

/// Checks the hit of a ray that is given in units of the shape's size, from its place: where, and
/// with which normal.
fn meets(text: &str, o: Vec3, d: Vec3, expected: Option<(f32, Vec3)>) {
    for (size, at) in PLACES {
        let shape = placed(text, size, at);
        let ray = Ray::new(o * size + at, d * size);
        let hit = shape.intersect(&ray);
        let Some((t, ng)) = expected else {
            assert_eq!(hit, None, "{text} of {size} at {at}");
            continue;
        };
        let hit = hit.unwrap_or_else(|| panic!("{text} of {size} at {at} is missed"));
        let rounding = 8.0 * f32::EPSILON * (1.0 + at.length() / size);
        assert!(
            (hit.t - t).abs() <= t * f32::EPSILON + rounding,
            "{text} of {size} at {at}: {}",
            hit.t
        );
        let s = shape.surface(&ray, &hit);
        assert!(
            (s.ng - ng).length() <= 1e-6 + 2.0 * rounding,
            "{text} of {size} at {at}: {}",
            s.ng
        );
        let off = (s.p - ray.at(t)).abs();
        let bound = s.p_error + ray.o.abs() * f32::EPSILON + (ray.d * t).abs() * (2.0 * f32::EPSILON);
        assert!(
            off.max_element() <= 4.0 * bound.max_element(),
            "{text} of {size} at {at}: {}",
            s.p
        );
    }
}

const SPHERE: &str = "sphere = { center = [$x, $y, $z], radius = $1 }";

#[test]
fn spheres_are_met_head_on_from_inside_and_not_behind() {
    meets(SPHERE, Vec3::X * 3.0, -Vec3::X, Some((2.0, Vec3::X)));
    meets(SPHERE, Vec3::X * 3.0, -Vec3::X * 0.5, Some((4.0, Vec3::X)));
    meets(SPHERE, Vec3::ZERO, Vec3::Z, Some((1.0, Vec3::Z)));
    meets(SPHERE, Vec3::Y * 0.5, -Vec3::Y, Some((1.5, -Vec3::Y)));
    meets(SPHERE, Vec3::X * 3.0, Vec3::X, None);
    meets(
        SPHERE,
        Vec3::new(0.6, 5.0, 0.0),
        -Vec3::Y,
        Some((4.2, Vec3::new(0.6, 0.8, 0.0))),
    );
}

#[test]
fn spheres_are_met_just_inside_their_outline_and_missed_just_outside() {
    let sphere = shape("sphere = { radius = 1 }");
    for distance in [2.0, 1e3, 1e5] {
        let beside = |x: f32| sphere.intersect(&Ray::new(Vec3::new(x, 0.0, distance), -Vec3::Z));
        assert_eq!(beside(1.0).map(|h| h.t), Some(distance));
        assert!(beside(1.0_f32.next_down()).is_some());
        assert_eq!(beside(1.0_f32.next_up()), None);
    }
}

#[test]
fn a_sphere_far_away_is_hit_where_algebra_says() {
    // The near root, from the digits that single precision would have lost.
    let sphere = shape("sphere = { radius = 1 }");
    let (o, d) = (DVec3::new(6e4, 8e4, 0.5), DVec3::new(-6.0, -8.0, 0.0));
    let ray = Ray::new(o.as_vec3(), d.as_vec3());
    let hit = sphere.intersect(&ray).unwrap();
    let expected = 1e4 - (1.0_f64 - 0.25).sqrt() / 10.0;
    assert_eq!(hit.t, expected as f32);
    let p = sphere.surface(&ray, &hit).p;
    assert!(
        (p.z - 0.5).abs() < 1e-6 && (p.x - 0.6 * 0.75_f32.sqrt()).abs() < 1e-6,
        "{p}"
    );
}

#[test]
fn poles_of_a_sphere_have_parameters_and_derivatives() {
    let sphere = shape("sphere = { radius = 2 }");
    for (from, v) in [(Vec3::Y, 1.0), (-Vec3::Y, 0.0)] {
        let ray = Ray::new(from * 5.0, -from);
        let s = sphere.surface(&ray, &sphere.intersect(&ray).unwrap());
        assert_eq!((s.p, s.ng, s.uv.y), (from * 2.0, from, v));
        assert_eq!((s.dpdu.normalize(), s.dpdv.normalize()), (Vec3::Z, -Vec3::X * from.y));
    }
    let ray = Ray::new(Vec3::Z * 5.0, -Vec3::Z);
    let s = sphere.surface(&ray, &sphere.intersect(&ray).unwrap());
    assert_eq!(s.uv.to_array(), [0.25, 0.5]);
}

const CYLINDER: &str = "cylinder = { base = [$x, $y, $z], radius = $1, height = $2 }";
const TUBE: &str = "cylinder = { base = [$x, $y, $z], radius = $1, height = $2, caps = false }";
const SKIN: &str = "cylinder = { base = [$x, $y, $z], radius = $1, height = $2, caps = false, outside_only = true }";

#[test]
fn walls_of_cylinders_are_met_from_outside_and_inside() {
    for text in [CYLINDER, TUBE] {
        meets(text, Vec3::new(4.0, 1.0, 0.0), -Vec3::X, Some((3.0, Vec3::X)));
        meets(text, Vec3::new(0.0, 1.0, 0.0), Vec3::Z, Some((1.0, Vec3::Z)));
        meets(
            text,
            Vec3::new(0.6, 1.0, -3.0),
            Vec3::Z,
            Some((2.2, Vec3::new(0.6, 0.0, -0.8))),
        );
        meets(text, Vec3::new(4.0, 2.5, 0.0), -Vec3::X, None);
        meets(text, Vec3::new(4.0, 1.0, 0.0), Vec3::X, None);
    }
    // Up through the wall at a slope: the wall is at x = 1, the height there 1.5.
    meets(
        CYLINDER,
        Vec3::new(4.0, 0.0, 0.0),
        Vec3::new(-2.0, 1.0, 0.0),
        Some((1.5, Vec3::X)),
    );
}

#[test]
fn cylinders_along_their_axis_show_their_caps_or_nothing() {
    for x in [0.0, 0.5, 1.0_f32.next_down()] {
        let above = Vec3::new(x, 5.0, 0.0);
        let below = Vec3::new(0.0, -1.0, x);
        if x < 0.9 {
            meets(CYLINDER, above, -Vec3::Y, Some((3.0, Vec3::Y)));
            meets(CYLINDER, below, Vec3::Y, Some((1.0, -Vec3::Y)));
            meets(CYLINDER, Vec3::new(x, 0.5, 0.0), Vec3::Y, Some((1.5, Vec3::Y)));
        }
        for text in [TUBE, SKIN] {
            meets(text, above, -Vec3::Y, None);
            meets(text, below, Vec3::Y, None);
        }
    }
    meets(CYLINDER, Vec3::new(1.5, 5.0, 0.0), -Vec3::Y, None);
}

#[test]
fn a_tube_is_open_at_its_ends() {
    // In through the top, down to the wall's inside at x = -1, height 1.
    let slope = Vec3::new(-1.0, -1.0, 0.0);
    meets(TUBE, Vec3::new(1.0, 3.0, 0.0), slope, Some((2.0, -Vec3::X)));
    meets(CYLINDER, Vec3::new(1.0, 3.0, 0.0), slope, Some((1.0, Vec3::Y)));
    meets(SKIN, Vec3::new(1.0, 3.0, 0.0), slope, None);
}

#[test]
fn a_wall_from_outside_only_counts_where_rays_enter() {
    for (text, x) in [(SKIN, 1.0), (CONE_SKIN, 0.5)] {
        let out = if text == SKIN { Vec3::X } else { SLANT };
        meets(text, Vec3::new(4.0, 1.0, 0.0), -Vec3::X, Some((4.0 - x, out)));
        meets(text, Vec3::new(0.0, 1.0, 0.0), -Vec3::X, None);
        meets(text, Vec3::new(0.0, 1.0, 0.0), Vec3::X, None);
        let seen = placed(text, 1.0, Vec3::ZERO);
        assert_eq!(hits(&seen, &Ray::new(Vec3::new(4.0, 1.0, 0.0), -Vec3::X)).len(), 1);
    }
    // Past the near wall, above it, to the inside of the far one.
    meets(SKIN, Vec3::new(2.0, 3.0, 0.0), Vec3::new(-1.0, -0.75, 0.0), None);
    meets(
        TUBE,
        Vec3::new(2.0, 3.0, 0.0),
        Vec3::new(-1.0, -0.75, 0.0),
        Some((3.0, -Vec3::X)),
    );
}

#[test]
fn a_cylinder_a_hundred_thousand_radii_away_is_hit_where_algebra_says() {
    let tube = shape("cylinder = { base = [0, -1, 0], radius = 1, height = 2 }");
    let ray = Ray::new(Vec3::new(0.5, 6e4, 8e4), Vec3::new(0.0, -6.0, -8.0));
    let hit = tube.intersect(&ray).unwrap();
    // The wall is at z = sqrt(3)/2, the height there 3/4 of it.
    let z = 0.75_f64.sqrt();
    assert_eq!(hit.t, ((8e4 - z) / 8.0) as f32);
    let s = tube.surface(&ray, &hit);
    assert!((s.p.y - (0.75 * z) as f32).abs() < 1e-6, "{}", s.p);
    assert!((s.ng - Vec3::new(0.5, 0.0, z as f32)).length() < 1e-6);
}

const CONE: &str = "cone = { base = [$x, $y, $z], radius = $1, height = $2 }";
const FUNNEL: &str = "cone = { base = [$x, $y, $z], radius = $1, height = $2, caps = false }";
const CONE_SKIN: &str = "cone = { base = [$x, $y, $z], radius = $1, height = $2, caps = false, outside_only = true }";
/// The wall's normal on the side of +x: (2, 1) / sqrt(5).
const SLANT: Vec3 = Vec3::new(0.894_427_2, 0.447_213_6, 0.0);

fn turned(n: Vec3) -> Vec3 {
    Vec3::new(-n.x, n.y, n.z)
}

#[test]
fn walls_of_cones_are_met_from_outside_and_inside() {
    for text in [CONE, FUNNEL] {
        meets(text, Vec3::new(4.0, 1.0, 0.0), -Vec3::X, Some((3.5, SLANT)));
        meets(text, Vec3::new(0.0, 1.0, 0.0), Vec3::X, Some((0.5, SLANT)));
        meets(text, Vec3::new(0.0, 0.5, 0.0), -Vec3::X, Some((0.75, turned(SLANT))));
        meets(text, Vec3::new(0.5, 5.0, 0.0), -Vec3::Y, Some((4.0, SLANT)));
        meets(text, Vec3::new(4.0, 2.5, 0.0), -Vec3::X, None);
        // The mirrored cone above the apex is not there.
        meets(text, Vec3::new(0.0, 3.0, 0.0), Vec3::X, None);
        meets(text, Vec3::new(0.0, 3.0, 0.0), Vec3::Y, None);
    }
    meets(CONE, Vec3::new(0.5, -1.0, 0.0), Vec3::Y, Some((1.0, -Vec3::Y)));
    meets(FUNNEL, Vec3::new(0.5, -1.0, 0.0), Vec3::Y, Some((2.0, SLANT)));
    meets(CONE_SKIN, Vec3::new(0.5, -1.0, 0.0), Vec3::Y, None);
}

#[test]
fn a_cone_along_its_axis_shows_its_apex_or_its_cap() {
    for (size, at) in PLACES {
        let cone = placed(CONE, size, at);
        let t = |o: Vec3, d: Vec3| cone.intersect(&Ray::new(o * size + at, d * size)).map(|h| h.t);
        let rounding = 8.0 * f32::EPSILON * (1.0 + at.length() / size);
        let near = |t: Option<f32>, to: f32| t.is_some_and(|t| (t - to).abs() <= rounding * to.max(1.0));
        assert!(near(t(Vec3::Y * 6.0, -Vec3::Y), 4.0));
        assert!(near(t(Vec3::Y * -3.0, Vec3::Y), 3.0));
        assert!(near(t(Vec3::Y, Vec3::Y), 1.0));
        assert!(near(t(Vec3::Y, -Vec3::Y), 1.0));
    }
}

#[test]
fn rays_through_the_apex_meet_the_cone_there_and_have_a_normal() {
    let mut random = Random(41);
    for text in [CONE, FUNNEL, CONE_SKIN] {
        let cone = placed(text, 1.0, Vec3::ZERO);
        let (mut steep, mut met) = (0, 0);
        for _ in 0..2000 {
            let d = random.direction();
            let d = Vec3::new(d.x, -d.y.abs(), d.z);
            let ray = Ray::new(Vec3::Y * 2.0 - d * 4.0, d);
            let first = cone.intersect(&ray);
            if let Some(hit) = first {
                let s = cone.surface(&ray, &hit);
                assert!((s.ng.length() - 1.0).abs() < 1e-6 && s.p.is_finite() && s.dpdu.length() > 0.0);
            }
            // Inside the cone's own angle the apex is where the ray goes in.
            if text != FUNNEL && Vec3::new(d.x, 0.0, d.z).length() < 0.45 * -d.y {
                steep += 1;
                met += usize::from(first.is_some_and(|hit| (hit.t - 4.0).abs() < 1e-5));
            }
        }
        assert!(text == FUNNEL || steep > 100, "{steep}");
        assert_eq!(met, steep, "{text}");
    }
}

#[test]
fn rays_exactly_through_the_apex_meet_it() {
    // All numbers are exact but the parameter of the apex, 7/3.
    let cone = shape("cone = { radius = 0.9, height = 2 }");
    let mut random = Random(45);
    let mut steep = 0;
    for _ in 0..3000 {
        let step = (random.direction() * 341.0).round() / 1024.0;
        let narrow = [1.0, 2.0_f32.powi(-20), 2.0_f32.powi(-30)][steep % 3];
        let step = Vec3::new(step.x * narrow, -step.y.abs(), step.z * narrow);
        if Vec3::new(step.x, 0.0, step.z).length() >= 0.449 * -step.y {
            continue;
        }
        steep += 1;
        let ray = Ray::new(Vec3::Y * 2.0 - step * 7.0, step * 3.0);
        let hit = cone.intersect(&ray).unwrap_or_else(|| panic!("{ray:?}"));
        assert!((hit.t - 7.0 / 3.0).abs() <= f32::EPSILON * 2.0, "{ray:?}");
    }
    assert!(steep > 200);
}

#[test]
fn points_are_off_the_surface_by_no_more_than_their_error() {
    // How far a point is from the endless surface, given its distance from the axis, or from the
    // centre, and its height.
    type Distance = fn(f64, f64, f64) -> f64;
    const R: f64 = 0.5;
    const H: f64 = 1.5;
    let axis = Vec3::new(1.0, -1.0, 2.0);
    let at = DVec3::new(20.0, -30.0, 10.0);
    let around = "base = [20, -30, 10], axis = [1, -1, 2], radius = 0.5, height = 1.5, caps = false";
    let sphere: Distance = |_, _, from_center| from_center - R;
    let tube: Distance = |rho, _, _| rho - R;
    let funnel: Distance = |rho, z, _| (rho * H - (H - z) * R) / (R * R + H * H).sqrt();
    let plane: Distance = |_, z, _| z;
    for (text, distance) in [
        ("sphere = { center = [20, -30, 10], radius = 0.5 }".to_owned(), sphere),
        (format!("cylinder = {{ {around} }}"), tube),
        (format!("cone = {{ {around} }}"), funnel),
        (
            "disk = { center = [20, -30, 10], normal = [1, -1, 2], radius = 0.5 }".to_owned(),
            plane,
        ),
        (
            "plane = { point = [20, -30, 10], normal = [1, -1, 2] }".to_owned(),
            plane,
        ),
    ] {
        let (shape, w) = (shape(&text), axis.normalize().as_dvec3().normalize());
        let mut random = Random(46);
        let (mut count, mut largest) = (0, 0.0_f64);
        for i in 0..20_000 {
            let target = at.as_vec3() + random.direction();
            let o = target + random.direction() * [0.3, 3.0, 1e5][i % 3];
            for (ray, hit) in hits(&shape, &Ray::new(o, target - o)) {
                let s = shape.surface(&ray, &hit);
                let q = s.p.as_dvec3() - at;
                let z = q.dot(w);
                let off = distance((q - w * z).length(), z, q.length()).abs();
                let bound = f64::from(s.ng.abs().dot(s.p_error));
                assert!(off <= bound, "{text}: {off} > {bound} at {s:?}");
                (count, largest) = (count + 1, largest.max(off / bound));
            }
        }
        // Not too generous either.
        assert!(count > 1000 && largest > 0.2, "{text}: {largest} of {count}");
    }
}

#[test]
fn rays_parallel_to_the_wall_of_a_cone_meet_it_once() {
    // The wall's own direction on the side of +x is (1, -2): the quadratic has no square.
    let along = Vec3::new(1.0, -2.0, 0.0);
    // It goes in through the side of -x, where 2 (x + 1) = y, and out through the base.
    meets(CONE, Vec3::new(-2.0, 4.0, 0.0), along, Some((1.5, turned(SLANT))));
    meets(FUNNEL, Vec3::new(-2.0, 4.0, 0.0), along, Some((1.5, turned(SLANT))));
    meets(CONE, Vec3::new(0.0, 1.0, 0.0), along, Some((0.5, -Vec3::Y)));
    meets(FUNNEL, Vec3::new(0.0, 1.0, 0.0), along, None);
    meets(FUNNEL, Vec3::new(0.0, 1.0, 0.0), -along, Some((0.25, turned(SLANT))));
    meets(CONE, Vec3::new(3.0, 1.0, 0.0), along, None);
}

#[test]
fn a_cone_a_hundred_thousand_radii_away_is_hit_where_algebra_says() {
    let cone = shape("cone = { base = [0, 0, 0], radius = 1, height = 2 }");
    let ray = Ray::new(Vec3::new(1e5, 1.0, 0.25), -Vec3::X);
    let hit = cone.intersect(&ray).unwrap();
    let x = (0.25_f64 - 0.0625).sqrt();
    assert_eq!(hit.t, (1e5 - x) as f32);
    let s = cone.surface(&ray, &hit);
    assert!((s.p - Vec3::new(x as f32, 1.0, 0.25)).length() < 1e-6, "{}", s.p);
    let e = Vec3::new(x as f32, 0.0, 0.25) * 2.0;
    assert!((s.ng - (e * SLANT.x + Vec3::Y * SLANT.y)).length() < 1e-6);
}

#[test]
fn disks_end_at_their_rim() {
    let disk = shape("disk = { center = [0, 1, 0], radius = 2 }");
    let at = |x: f32| {
        let ray = Ray::new(Vec3::new(x, -4.0, 0.0), Vec3::Y);
        let hit = disk.intersect(&ray)?;
        Some((hit.t, disk.surface(&ray, &hit)))
    };
    let (t, s) = at(1.0).unwrap();
    assert_eq!((t, s.ng, s.uv.to_array()), (5.0, Vec3::Y, [0.0, 0.5]));
    assert!(at(2.0).is_some() && at(2.0_f32.next_up()).is_none());
    let (_, center) = at(0.0).unwrap();
    assert!(center.uv.y == 0.0 && center.dpdu.length() > 0.0);
}
