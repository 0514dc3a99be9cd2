use proptest::prelude::*;

use super::*;

fn track<T: Channel>(keys: &[(f64, T)], interp: Interp) -> Track<T> {
    Track::new(keys.iter().map(|(frame, value)| (*frame, Some(*value), interp)))
}

fn at<T: Channel>(track: &Track<T>, frame: f64) -> T {
    track.at(frame).expect("a key")
}

#[test]
fn two_keys_make_a_straight_line_at_an_even_rate() {
    for interp in [Interp::Smooth, Interp::Linear] {
        let t = track(&[(10.0, DVec3::ZERO), (20.0, DVec3::new(5.0, 10.0, 0.0))], interp);
        assert!((at(&t, 13.0) - DVec3::new(1.5, 3.0, 0.0)).length() < 1e-12);
    }
}

#[test]
fn even_keys_on_a_line_make_an_even_motion() {
    let keys: Vec<_> = (0..6).map(|i| (f64::from(i) * 4.0, DVec3::X * f64::from(i))).collect();
    let t = track(&keys, Interp::Smooth);
    for i in 0..=200 {
        let frame = f64::from(i) * 0.1;
        assert!((at(&t, frame).x - frame / 4.0).abs() < 1e-12);
    }
}

#[test]
fn a_held_key_lasts_until_the_next_and_is_a_cut_for_its_neighbours() {
    let keys = [
        (0.0, 0.0, Interp::Smooth),
        (1.0, 1.0, Interp::Step),
        (2.0, 50.0, Interp::Smooth),
        (3.0, 51.0, Interp::Smooth),
    ];
    let t = Track::new(keys.map(|(frame, x, interp)| (frame, Some(DVec3::X * x), interp)));
    assert_eq!(at(&t, 1.999).x, 1.0);
    assert_eq!(at(&t, 2.0).x, 50.0);
    assert!((at(&t, 2.5).x - 50.5).abs() < 1e-12);
    assert!((at(&t, 0.5).x - 0.5).abs() < 1e-12);
}

#[test]
fn a_camera_rests_between_equal_keys_and_leaves_gently() {
    let t = track(
        &[
            (0.0, DVec3::ZERO),
            (1.0, DVec3::ONE),
            (2.0, DVec3::ONE),
            (3.0, DVec3::ZERO),
        ],
        Interp::Smooth,
    );
    assert_eq!(at(&t, 1.3), DVec3::ONE);
    let speed = |frame: f64| at(&t, frame).distance(at(&t, frame + 1e-6)) / 1e-6;
    assert!(speed(2.0) < 1e-4 && speed(2.5) > 1.0);
}

#[test]
fn velocity_has_no_jump_at_uneven_keys() {
    let keys = [
        (0.0, DVec3::ZERO),
        (3.0, DVec3::new(1.0, 2.0, 0.0)),
        (4.0, DVec3::new(4.0, 2.0, 1.0)),
        (11.0, DVec3::new(5.0, -1.0, 0.0)),
    ];
    let t = track(&keys, Interp::Smooth);
    let e = 1e-6;
    for key in [3.0, 4.0] {
        let left = (at(&t, key) - at(&t, key - e)) / e;
        let right = (at(&t, key + e) - at(&t, key)) / e;
        assert!((left - right).length() < 1e-4, "{left} {right}");
    }
}

/// The recursive evaluation of Barry and Goldman, of the points at four knots.
fn barry_goldman(keys: &[(f64, DVec3); 4], s: f64) -> DVec3 {
    let mut level = keys.map(|(_, p)| p);
    // Which knots the weights of a level run between: one more apart on each, but the last is of
    // the middle two again.
    for (n, apart) in [(3, 1), (2, 2), (1, 1)] {
        let offset = usize::from(n == 1);
        for i in 0..n {
            let (a, b) = (keys[i + offset].0, keys[i + offset + apart].0);
            level[i] = level[i] * ((b - s) / (b - a)) + level[i + 1] * ((s - a) / (b - a));
        }
    }
    level[0]
}

#[test]
fn the_curve_is_barry_and_goldmans_where_times_are_its_knots() {
    let points = [
        DVec3::ZERO,
        DVec3::new(1.0, 3.0, 0.0),
        DVec3::new(7.0, 2.0, 1.0),
        DVec3::new(8.0, -4.0, 0.0),
    ];
    let mut s = 0.0;
    let mut before = points[0];
    let keys = points.map(|p| {
        s += before.distance(p).sqrt();
        before = p;
        (s, p)
    });
    let t = track(&keys, Interp::Smooth);
    for i in 0..=20 {
        let s = keys[1].0 + (keys[2].0 - keys[1].0) * f64::from(i) / 20.0;
        assert!((at(&t, s) - barry_goldman(&keys, s)).length() < 1e-12);
    }
}

#[test]
fn slerp_goes_the_shorter_way_at_an_even_rate() {
    let about_y = |degrees: f64| {
        let (s, c) = libm::sincos(degrees.to_radians() * 0.5);
        DQuat::from_xyzw(0.0, s, 0.0, c)
    };
    for u in [0.0, 0.25, 0.5, 1.0] {
        // From 350 to 10 degrees over 0, whatever the signs.
        let want = about_y(-10.0 + 20.0 * u);
        for (a, b) in [(about_y(350.0), about_y(10.0)), (about_y(-10.0), -about_y(10.0))] {
            assert!(slerp(a, b, u).dot(want).abs() > 1.0 - 1e-15);
        }
    }
    assert!((slerp(about_y(5.0), about_y(5.0 + 1e-10), 0.5).length() - 1.0).abs() < 1e-15);
}

fn rising(n: std::ops::Range<usize>) -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((0.01_f64..50.0, -100.0_f64..100.0), n).prop_map(|steps| {
        let mut frame = -20.0;
        let next = |(step, value)| {
            frame += step;
            (frame, value)
        };
        steps.into_iter().map(next).collect()
    })
}

proptest! {
    #[test]
    fn curves_are_their_keys_bit_for_bit(keys in rising(1..8), y in -5.0..5.0) {
        for interp in [Interp::Smooth, Interp::Linear, Interp::Step] {
            let points: Vec<_> = keys.iter().map(|(t, v)| (*t, DVec3::new(*v, y * v, v * v))).collect();
            let (points_track, numbers) = (track(&points, interp), track(&keys, interp));
            for (key, point) in keys.iter().zip(&points) {
                prop_assert_eq!(at(&numbers, key.0), key.1);
                prop_assert_eq!(at(&points_track, point.0), point.1);
            }
        }
    }

    #[test]
    fn through_keys_on_a_line_nothing_overshoots(keys in rising(2..8), u in 0.0..1.0) {
        let along = DVec3::new(0.36, 0.48, -0.8);
        let points: Vec<_> = keys.iter().map(|(t, v)| (*t, along * *v)).collect();
        let (points, numbers) = (track(&points, Interp::Smooth), track(&keys, Interp::Smooth));
        for pair in keys.windows(2) {
            let [(t1, v1), (t2, v2)] = pair else { unreachable!("pairs") };
            let frame = t1 + (t2 - t1) * u;
            let inside = v1.min(*v2) - 1e-9..=v1.max(*v2) + 1e-9;
            let p = at(&points, frame);
            prop_assert!(inside.contains(&p.dot(along)), "{} not in {:?}", p.dot(along), inside);
            prop_assert!((p - along * p.dot(along)).length() < 1e-9);
            prop_assert!(inside.contains(&at(&numbers, frame)));
        }
    }

    #[test]
    fn slerp_never_turns_by_more_than_the_whole_arc(a in [-1.0_f64..1.0, -1.0..1.0, -1.0..1.0, 0.1..1.0], b in [-1.0_f64..1.0, -1.0..1.0, -1.0..1.0, 0.1..1.0], u in 0.0..1.0) {
        let unit = |[x, y, z, w]: [f64; 4]| { let q = DQuat::from_xyzw(x, y, z, w); q / q.length() };
        let (a, b) = (unit(a), unit(b));
        let angle = |p: DQuat, q: DQuat| 2.0 * libm::acos(p.dot(q).abs().min(1.0));
        let whole = angle(a, b);
        prop_assert!((angle(a, slerp(a, b, u)) - u * whole).abs() < 1e-6);
        prop_assert!((angle(slerp(a, b, u), b) - (1.0 - u) * whole).abs() < 1e-6);
    }
}
