//! Properties of light trees.

use super::LightTree;
use crate::{
    light::{LightBounds, OrientationCone, Sidedness},
    math::{
        Aabb, Plain, Vec3,
        hash::{pcg4d, unit_f32},
    },
};

fn random(seed: u32, i: u32) -> [f32; 4] {
    pcg4d([seed, i, 3, 9]).map(unit_f32)
}

fn direction(seed: u32, i: u32) -> Vec3 {
    let [x, y, z, _] = random(seed, i);
    (Vec3::new(x, y, z) - 0.5).normalize_or(Vec3::Y)
}

fn place(seed: u32, i: u32) -> Vec3 {
    let [x, y, z, _] = random(seed, i);
    (Vec3::new(x, y, z) - 0.5) * 10.0
}

/// Small surfaces that face any way, some of them both ways, and points.
fn lights(count: u32) -> Vec<LightBounds> {
    (0..count)
        .map(|i| {
            let [size, power, kind, _] = random(1, i);
            let p = place(2, i);
            let sidedness = if kind < 0.2 { Sidedness::Both } else { Sidedness::Front };
            LightBounds {
                bounds: Aabb::from_points([p, p + Vec3::splat(size * 0.3)]),
                directions: if kind > 0.8 {
                    OrientationCone::ALL
                } else {
                    OrientationCone::flat(direction(3, i), sidedness)
                },
                power: power * power + 0.01,
            }
        })
        .collect()
}

fn tree(lights: &[LightBounds]) -> LightTree {
    LightTree::build(lights.iter().copied())
}

/// A place and a normal.
fn receiver(i: u32) -> (Vec3, Vec3) {
    (
        place(4, i),
        if i.is_multiple_of(4) {
            Vec3::ZERO
        } else {
            direction(5, i)
        },
    )
}

/// Returns whether a small light can illuminate `p` on a surface with normal `n`, by its own
/// directions alone.
fn shines(light: &LightBounds, p: Vec3, n: Vec3) -> bool {
    let wi = (light.bounds.center() - p).normalize();
    let out = -light.directions.axis.dot(wi);
    let leaves = match (light.directions == OrientationCone::ALL, light.directions.sidedness) {
        (true, _) => true,
        (false, Sidedness::Both) => out != 0.0,
        (false, Sidedness::Front) => out > 0.0,
    };
    leaves && (n == Vec3::ZERO || n.dot(wi) > 0.0)
}

#[test]
fn probabilities_add_up_to_one_less_what_falls_on_groups_that_do_not_matter() {
    for count in [1, 2, 3, 17, 300] {
        let lights = lights(count);
        let tree = tree(&lights);
        for r in 0..50 {
            let (p, n) = receiver(r);
            let sum: f64 = (0..count).map(|l| tree.pmf(p, n, l)).sum();
            let draws = 20_000;
            let none = (0..draws)
                .filter(|i| {
                    tree.choose(Plain, p, n, (f64::from(*i) + 0.5) / f64::from(draws))
                        .is_none()
                })
                .count();
            let expected = 1.0 - none as f64 / f64::from(draws);
            let tolerance = if none == 0 {
                1e-9
            } else {
                f64::from(count) / f64::from(draws)
            };
            assert!((sum - expected).abs() <= tolerance, "{count}: {sum} is not {expected}");
        }
    }
}

#[test]
fn lights_are_chosen_as_often_as_their_probability_says() {
    let lights = lights(40);
    let tree = tree(&lights);
    for r in 0..8 {
        let (p, n) = receiver(r);
        let draws = 20_000;
        let mut counts = [0_u32; 40];
        for i in 0..draws {
            if let Some((light, pmf)) = tree.choose(Plain, p, n, (f64::from(i) + 0.5) / f64::from(draws)) {
                counts[light as usize] += 1;
                assert_eq!(pmf, tree.pmf(p, n, light), "the walk and its way back");
            }
        }
        for (light, count) in (0..).zip(counts) {
            let expected = tree.pmf(p, n, light) * f64::from(draws);
            assert!(
                (f64::from(count) - expected).abs() <= 2.0,
                "{light}: {count} is not {expected}"
            );
        }
    }
}

#[test]
fn a_light_that_shines_on_a_place_always_has_a_chance() {
    let lights = lights(500);
    let tree = tree(&lights);
    for r in 0..200 {
        let (p, n) = receiver(r);
        for (i, light) in (0..).zip(&lights) {
            if shines(light, p, n) {
                assert!(tree.pmf(p, n, i) > 0.0, "{i} from {p} {n}: {light:?}");
            }
        }
    }
}

#[test]
fn unions_hold_the_directions_of_both() {
    for i in 0..2000 {
        let cone = |seed: u32| {
            let [o, e, both, _] = random(seed, i);
            OrientationCone {
                axis: direction(seed + 1, i),
                cos_o: 1.0 - 2.0 * o * o,
                cos_e: 0.5 - e,
                sidedness: if both < 0.3 { Sidedness::Both } else { Sidedness::Front },
            }
        };
        let (a, b) = (cone(10), cone(20));
        let all = a.union(&b);
        assert!((all.axis.length() - 1.0).abs() < 1e-5);
        for (k, part) in [a, b].into_iter().enumerate() {
            // A normal at the rim of the part.
            let (s, c) = ((1.0 - part.cos_o * part.cos_o).max(0.0).sqrt(), part.cos_o);
            for around in 0..8 {
                let side = direction(30, 8 * i + around).cross(part.axis).normalize_or(Vec3::X);
                let n = part.axis * c + side * s;
                let cos = all.axis.dot(n);
                let cos = if all.sidedness == Sidedness::Both {
                    cos.abs()
                } else {
                    cos
                };
                assert!(cos >= all.cos_o - 2e-3, "{i} {k}: {cos} {a:?} {b:?} {all:?}");
            }
            assert!(all.cos_e <= part.cos_e);
        }
    }
}

#[test]
fn lights_without_power_are_left_out() {
    let mut lights = lights(5);
    for i in [0, 3] {
        lights[i].power = 0.0;
    }
    let tree = tree(&lights);
    let (p, n) = (Vec3::splat(9.0), Vec3::ZERO);
    assert_eq!((tree.pmf(p, n, 0), tree.pmf(p, n, 3)), (0.0, 0.0));
    assert!(tree.pmf(p, n, 1) > 0.0 || tree.pmf(p, n, 2) > 0.0 || tree.pmf(p, n, 4) > 0.0);
    let empty = LightTree::build(std::iter::empty());
    assert!(empty.choose(Plain, p, n, 0.5).is_none() && empty.importance(p, n) == 0.0);
}

#[test]
fn many_lights_in_one_place_make_a_tree_that_is_not_deep() {
    let one = lights(1)[0];
    let tree = tree(&vec![one; 5000]);
    let sum: f64 = (0..5000).map(|l| tree.pmf(Vec3::splat(20.0), Vec3::ZERO, l)).sum();
    assert!((sum - 1.0).abs() < 1e-6, "{sum}");
    assert!((tree.pmf(Vec3::splat(20.0), Vec3::ZERO, 77) - 1.0 / 5000.0).abs() < 1e-4);
}

#[test]
fn the_tree_is_the_same_on_any_number_of_threads() {
    let lights = lights(6000);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        format!("{:?}", pool.install(|| tree(&lights)))
    };
    assert!(build(1) == build(3));
}
