//! Blocks of rays against single rays.

use super::examples::{Random, all};
use crate::{
    math::{Plain, Ray, Vec3, block::LANES},
    shape::{Attempt, RayBlock},
};

#[test]
fn blocks_give_the_bits_of_single_rays() {
    for e in all() {
        let mut random = Random(8);
        let mut unknown = 0;
        for round in 0..2000 {
            let distance = [0.3, 2.0, 50.0, 1e5][round % 4];
            let numbers = e.shape.block_numbers();
            let mut block = RayBlock::EMPTY;
            let rays: [Ray; LANES] = std::array::from_fn(|lane| {
                let mut ray = e.ray(&mut random, distance);
                match round % 16 {
                    13 => ray.d[lane % 3] = [0.0, -0.0][lane / 4 % 2],
                    14 => ray.d = Vec3::AXES[lane % 3] * [1.0, -2.0][lane / 4 % 2],
                    15 => ray.tmin = [0.1, 1.0, f32::NAN, f32::MIN][lane % 4],
                    _ => {}
                }
                ray
            });
            for (lane, ray) in rays.iter().enumerate() {
                block.set(lane, ray, &numbers);
            }
            e.shape.attempt_block(Plain, &mut block);
            for (lane, ray) in rays.iter().enumerate() {
                let bits = |t: f32, u: f32, v: f32| [t.to_bits(), u.to_bits(), v.to_bits()];
                let found = match block.answer[lane] {
                    Attempt::MISSES => None,
                    Attempt::MEETS => Some(bits(block.t[lane], block.u[lane], block.v[lane])),
                    _ => {
                        unknown += 1;
                        continue;
                    }
                };
                let expected = e.shape.intersect(ray).map(|hit| bits(hit.t, hit.u, hit.v));
                assert_eq!(found, expected, "{}: {ray:?}", e.text);
            }
        }
        assert!(
            unknown == 0 || matches!(e.name, "plane" | "quad"),
            "{}: {unknown} unknown",
            e.text
        );
    }
}
