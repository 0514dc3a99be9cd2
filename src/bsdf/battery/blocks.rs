//! Blocks of BSDFs give the bits of single ones.

use super::{
    super::{
        block::BsdfBlock,
        conductor::ConductorBlock,
        diffuse::OrenNayarBlock,
        folded::{FoldBlock, Folded},
        layered::LayerBlock,
    },
    *,
};
use crate::math::{
    Sample2D,
    block::{LANES, get, get_rgb, set},
};

fn bits(color: Rgb) -> [u32; 3] {
    color.to_array().map(f32::to_bits)
}

/// Compares blocks of the kind `B` with single surfaces, folded at `plane` if there is one, and returns the names of the examples
/// that they hold.
fn compare<B: BsdfBlock>(plane: Option<Vec3>) -> Vec<String> {
    let mut folds = FoldBlock::EMPTY;
    (0..LANES / 2).for_each(|lane| folds.set(lane, plane));
    let mut held = Vec::new();
    for Example { name, bsdf, .. } in examples() {
        let Some(single) = B::kind(&bsdf) else { continue };
        let views: [_; LANES / 2] = std::array::from_fn(|lane| {
            let cos = [0.9, 0.4, 0.05, 1.0][lane % 4];
            direction(cos, 3.0 * cos + (lane / 4) as f32)
        });
        let mut block = B::EMPTY;
        // The other half of the lanes is of no surface.
        if !(0..LANES / 2).all(|lane| block.set(lane, single)) {
            continue;
        }
        (0..LANES / 2).for_each(|lane| block.set_view(lane, views[lane]));
        held.push(name.clone());
        block.prepare();
        for i in 0..400 {
            let mut wi = [[0.0; LANES]; 3];
            for lane in 0..LANES / 2 {
                let (uc, u) = numbers(LANES as u32 * i + lane as u32);
                set(&mut wi, lane, direction(2.0 * u.x - 1.0, 9.0 * uc));
            }
            let mut eval = block.eval(&wi);
            folds.add(&mut eval, &wi, &block.eval(&folds.mirrored(&wi)));
            let drawn: [_; LANES] = std::array::from_fn(|lane| numbers(LANES as u32 * (1000 + i) + lane as u32));
            let mut sampled = block.sample(&drawn.map(|(uc, _)| uc), &drawn.map(|(_, u)| Sample2D::from(u)));
            let images = folds.mirrored(&sampled.wi);
            folds.fold(&mut sampled, &images, &block.eval(&images).pdf);
            for lane in 0..LANES / 2 {
                let wo = views[lane];
                let folded = plane.map(|plane| Folded { bsdf: single, plane });
                let alone = match &folded {
                    Some(folded) => folded.eval(wo, get(&wi, lane)),
                    None => single.eval(wo, get(&wi, lane)),
                };
                assert_eq!(bits(get_rgb(&eval.diffuse, lane)), bits(alone.diffuse), "{name} {wo}");
                assert_eq!(bits(get_rgb(&eval.glossy, lane)), bits(alone.glossy), "{name} {wo}");
                assert_eq!(eval.pdf[lane].to_bits(), alone.pdf.to_bits(), "{name} {wo}");

                let (uc, u) = drawn[lane];
                let alone = match &folded {
                    Some(folded) => folded.sample(wo, uc, u.into()),
                    None => single.sample(wo, uc, u.into()),
                };
                let Some(alone) = alone else {
                    assert!(sampled.pdf[lane] <= 0.0 || sampled.pdf[lane].is_nan(), "{name} {wo}");
                    continue;
                };
                assert_eq!(get(&sampled.wi, lane), alone.wi, "{name} {wo}");
                assert_eq!(bits(get_rgb(&sampled.weight, lane)), bits(alone.weight), "{name} {wo}");
                assert_eq!(
                    bits(get_rgb(&sampled.diffuse, lane)),
                    bits(alone.diffuse),
                    "{name} {wo}"
                );
                assert_eq!(Some(sampled.pdf[lane]), alone.pdf, "{name} {wo}");
                assert_eq!(
                    sampled.is_diffuse[lane] != 0,
                    alone.lobe == Lobe::Diffuse,
                    "{name} {wo}"
                );
            }
        }
    }
    held
}

#[test]
fn blocks_evaluate_and_sample_as_one_by_one() {
    let planes = [None, Some(direction(0.95, 1.0)), Some(direction(0.4, 4.0))];
    let held = planes.map(|plane| {
        [
            compare::<LayerBlock>(plane),
            compare::<ConductorBlock>(plane),
            compare::<OrenNayarBlock>(plane),
        ]
        .concat()
    });
    let [held, ..] = held;
    for kind in [
        "plastic",
        "dense plastic",
        "metal",
        "coated metal",
        "coated plastic",
        "conductor",
        "gold",
        "oren-nayar",
        "oren-nayar rose",
    ] {
        assert!(held.contains(&format!("{kind} 0.35")), "{kind} is not held: {held:?}");
    }
}
