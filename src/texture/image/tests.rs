//! Pictures near and far.

use super::*;
use crate::{
    math::{Vec3, hash},
    texture::{Mapping, Pattern, SharedFootprint, StTransform, Texture, TexturePoint, mipmap},
};

fn quarter() -> Vec<Bitmap> {
    // Top row 0 1, bottom row 2 3.
    vec![Bitmap::from_floats([2, 2], 1, vec![0.0, 1.0, 2.0, 3.0])]
}

fn pattern(filter: TextureFilter, wrap: Wrap) -> ImagePattern {
    ImagePattern {
        bitmap: BitmapId(0),
        filter,
        wrap: [wrap; 2],
    }
}

/// Random texels, with levels.
fn random(width: u32, height: u32) -> Vec<Bitmap> {
    let value = |i: u32| hash::unit_f32(hash::mix32(i + 7));
    let mut bitmap = Bitmap::from_floats([width, height], 3, (0..width * height * 3).map(value).collect());
    mipmap::build(&mut bitmap);
    vec![bitmap]
}

/// A bound on the colours between two corners.
fn bound(pattern: &ImagePattern, bitmaps: &[Bitmap], corners: [Vec2; 2]) -> Rgb {
    let textures = Textures { textures: &[], bitmaps };
    pattern.max_within(&textures, corners)
}

/// Axes of a round footprint that is so many texels wide.
fn round(texels: f32, width: u32, height: u32) -> [Vec2; 2] {
    [Vec2::X * texels / width as f32, Vec2::Y * texels / height as f32]
}

impl ImagePattern {
    /// The mean over the ellipse around `st` whose axes, from end to end, are `axes`.
    fn mean_over(&self, bitmaps: &[Bitmap], st: Vec2, axes: [Vec2; 2]) -> Rgb {
        let bitmap = &bitmaps[self.bitmap.0 as usize];
        let size = Vec2::new(bitmap.width as f32, bitmap.height as f32);
        self.mean(bitmap, st, Footprint::with_level(axes, size))
    }
}

#[test]
fn nearest_takes_the_texel_that_holds_the_point_and_t_runs_upwards() {
    let p = pattern(TextureFilter::Nearest, Wrap::Black);
    let at = |s, t| p.eval(&quarter(), Vec2::new(s, t)).r;
    assert_eq!(
        [at(0.1, 0.1), at(0.9, 0.1), at(0.1, 0.9), at(0.9, 0.9)],
        [2.0, 3.0, 0.0, 1.0]
    );
    assert_eq!([at(-0.1, 0.1), at(1.0, 0.1)], [0.0, 0.0]);
}

#[test]
fn linear_meets_the_texels_at_their_centres_and_their_mean_between() {
    let p = pattern(TextureFilter::Linear, Wrap::Clamp);
    let at = |s, t| p.eval(&quarter(), Vec2::new(s, t)).r;
    assert_eq!(at(0.25, 0.25), 2.0);
    assert_eq!(at(0.5, 0.5), 1.5);
    assert_eq!(at(0.0, 0.0), 2.0);
}

#[test]
fn wrap_modes_continue_the_row_as_named() {
    let row = |w: Wrap| (-3..5).map(|i| w.texel(i, 2)).collect::<Vec<_>>();
    let some = |v: [u32; 8]| v.map(Some).to_vec();
    assert_eq!(row(Wrap::Repeat), some([1, 0, 1, 0, 1, 0, 1, 0]));
    assert_eq!(row(Wrap::Clamp), some([0, 0, 0, 0, 1, 1, 1, 1]));
    assert_eq!(row(Wrap::Mirror), some([1, 1, 0, 0, 1, 1, 0, 0]));
    assert_eq!(row(Wrap::Black)[..4], [None, None, None, Some(0)]);
}

#[test]
fn wrap_modes_hold_at_every_level() {
    let bitmaps = random(16, 8);
    for level in 0..5 {
        let axes = round((1 << level) as f32, 16, 8);
        let at = |wrap, st| pattern(TextureFilter::Trilinear, wrap).mean_over(&bitmaps, st, axes);
        let st = Vec2::new(0.3, 0.6);
        let near = |a: Rgb, b: Rgb| (a - b).map(f32::abs).max_component() < 1e-5;
        assert!(near(at(Wrap::Repeat, st), at(Wrap::Repeat, st + Vec2::new(3.0, -2.0))));
        assert!(near(at(Wrap::Mirror, st), at(Wrap::Mirror, -st)));
        let outside = Vec2::new(-9.0, 0.6);
        assert!(near(at(Wrap::Clamp, outside), at(Wrap::Clamp, Vec2::new(-5.0, 0.6))));
        assert_eq!(at(Wrap::Black, outside), Rgb::BLACK);
    }
}

#[test]
fn magnified_a_picture_has_the_bits_of_linear() {
    let bitmaps = random(16, 8);
    let (linear, trilinear) = (
        pattern(TextureFilter::Linear, Wrap::Repeat),
        pattern(TextureFilter::Trilinear, Wrap::Repeat),
    );
    for i in 0..1000 {
        let st = Vec2::new(i as f32 * 0.0137 - 3.0, i as f32 * 0.0071);
        let texels = 0.001 * i as f32;
        assert_eq!(
            trilinear.mean_over(&bitmaps, st, round(texels, 16, 8)),
            linear.eval(&bitmaps, st)
        );
    }
}

#[test]
fn a_footprint_of_twice_the_width_is_one_level_up() {
    let size = Vec2::new(512.0, 128.0);
    for texels in [1.0, 1.7, 40.0, 333.0] {
        let level = |texels| Footprint::of(round(texels, 512, 128), size, MAX_PROBES).level();
        assert!((level(2.0 * texels) - level(texels) - 1.0).abs() < 1e-5, "{texels}");
    }
    assert_eq!(Footprint::of(round(0.3, 512, 128), size, MAX_PROBES).level(), 0.0);
}

#[test]
fn a_long_footprint_is_taken_apart_and_a_very_long_one_blurred() {
    let size = Vec2::splat(256.0);
    let of = |long: f32, short: f32| Footprint::of([Vec2::X * long / 256.0, Vec2::Y * short / 256.0], size, MAX_PROBES);
    assert_eq!((of(4.0, 4.0).probes, of(4.0, 4.0).level()), (1, 2.0));
    assert_eq!((of(16.0, 4.0).probes, of(16.0, 4.0).level()), (4, 2.0));
    assert_eq!((of(64.0, 1.0).probes, of(64.0, 1.0).level()), (8, 3.0));
}

#[test]
fn a_footprint_as_wide_as_the_picture_sees_its_mean() {
    let bitmaps = random(32, 32);
    let p = pattern(TextureFilter::Trilinear, Wrap::Repeat);
    let last = bitmaps[0].levels.last().unwrap().rgb(0, 0);
    for texels in [32.0, 1e4, f32::INFINITY] {
        let there = p.mean_over(&bitmaps, Vec2::new(0.2, 0.9), round(texels, 32, 32));
        assert!((there - last).map(f32::abs).max_component() < 1e-6, "{texels}");
    }
}

/// The mean of a picture over `texels` columns and rows from a corner on, counted from the bottom left, by its texels.
fn mean_of_texels(p: &ImagePattern, bitmap: &Bitmap, [i, j]: [i64; 2], texels: [i64; 2]) -> Rgb {
    let (w, h) = (i64::from(bitmap.width), i64::from(bitmap.height));
    let mut sum = Rgb::BLACK;
    for (x, y) in (i..i + texels[0]).flat_map(|x| (j..j + texels[1]).map(move |y| (x, y))) {
        if let (Some(x), Some(y)) = (p.wrap[0].texel(x, w), p.wrap[1].texel(y, h)) {
            sum += bitmap.texel_from_bottom(x, y);
        }
    }
    sum / (texels[0] * texels[1]) as f32
}

#[test]
fn a_footprint_over_an_edge_is_the_mean_of_the_texels_as_the_picture_continues() {
    let bitmaps = random(32, 32);
    let side = 16;
    for wrap in [Wrap::Clamp, Wrap::Black] {
        let p = pattern(TextureFilter::Trilinear, wrap);
        // Over edges, over corners, and beyond both.
        for corner in [
            [-8, 8],
            [24, 16],
            [0, -8],
            [16, 24],
            [-8, -8],
            [24, 24],
            [-64, 8],
            [90, -40],
            [8, 900],
        ] {
            let middle = corner.map(|i| (i + side / 2) as f32 / 32.0);
            let found = p.mean_over(&bitmaps, Vec2::from_array(middle), round(side as f32, 32, 32));
            let expected = mean_of_texels(&p, &bitmaps[0], corner, [side; 2]);
            let error = (found - expected).map(f32::abs).max_component();
            assert!(error < 1e-5, "{wrap:?} {corner:?}: {found:?} is not {expected:?}");
        }
    }
}

#[test]
fn beyond_the_picture_a_footprint_of_any_size_sees_the_edge() {
    let bitmaps = random(32, 16);
    let p = pattern(TextureFilter::Trilinear, Wrap::Clamp);
    for texels in [3.0, 40.0, 1000.0, 1e9] {
        let axes = round(texels, 32, 16);
        let away = 2.0 * texels;
        let corner = p.mean_over(&bitmaps, Vec2::new(away, -away), axes);
        assert_eq!(corner, bitmaps[0].texel_from_bottom(31, 0), "{texels}");
        let black = pattern(TextureFilter::Trilinear, Wrap::Black);
        assert_eq!(black.mean_over(&bitmaps, Vec2::new(away, 0.5), axes), Rgb::BLACK);
    }
    // Along the edge it sees all of it, and the rest of it the corners.
    let found = p.mean_over(&bitmaps, Vec2::new(70.0, 0.5), round(64.0, 32, 16));
    let expected = mean_of_texels(&p, &bitmaps[0], [2000, -24], [1, 64]);
    assert!((found - expected).map(f32::abs).max_component() < 1e-5);
    let quarters = p.mean_over(&bitmaps, Vec2::splat(0.5), round(f32::INFINITY, 32, 16));
    let corners = [[0, 0], [31, 0], [0, 15], [31, 15]].map(|[i, j]| bitmaps[0].texel_from_bottom(i, j));
    let expected = corners.into_iter().fold(Rgb::BLACK, |sum, c| sum + c) / 4.0;
    assert!((quarters - expected).map(f32::abs).max_component() < 1e-5);
}

#[test]
fn where_a_footprint_touches_an_edge_the_mean_has_no_step() {
    let bitmaps = random(32, 32);
    for wrap in [Wrap::Clamp, Wrap::Black] {
        let p = pattern(TextureFilter::Trilinear, wrap);
        for texels in [1.0, 1.3, 5.0, 11.0] {
            let half = 0.5 * texels / 32.0;
            for edge in [-half, half, 1.0 - half, 1.0 + half] {
                let at = |s: f32| p.mean_over(&bitmaps, Vec2::new(s, 0.4), round(texels, 32, 32));
                let step = at(edge + 1e-5) - at(edge - 1e-5);
                assert!(step.map(f32::abs).max_component() < 1e-3, "{wrap:?} {texels} {edge}");
            }
        }
    }
}

#[test]
fn a_constant_picture_is_constant_under_any_footprint() {
    let mut bitmap = Bitmap::from_floats([24, 10], 1, vec![0.625; 240]);
    mipmap::build(&mut bitmap);
    let bitmaps = [bitmap];
    let p = pattern(TextureFilter::Trilinear, Wrap::Mirror);
    for i in 0..200 {
        let axes = [Vec2::new(0.01 * i as f32, 0.3), Vec2::new(0.2, -0.003 * i as f32)];
        let there = p.mean_over(&bitmaps, Vec2::new(0.1 * i as f32, 0.7), axes);
        assert!((there.r - 0.625).abs() < 1e-6, "{i}: {}", there.r);
    }
}

#[test]
fn what_is_not_finite_is_black() {
    let bitmaps = random(4, 4);
    for filter in [TextureFilter::Trilinear, TextureFilter::Linear, TextureFilter::Nearest] {
        let p = pattern(filter, Wrap::Repeat);
        for st in [Vec2::new(f32::NAN, 0.0), Vec2::new(0.0, f32::INFINITY)] {
            assert_eq!(p.eval(&bitmaps, st), Rgb::BLACK);
            assert_eq!(p.mean_over(&bitmaps, st, round(3.0, 4, 4)), Rgb::BLACK);
        }
        let far = p.eval(&bitmaps, Vec2::splat(1e30));
        assert!(far.is_finite());
    }
}

#[test]
fn no_value_within_a_rectangle_is_above_its_bound() {
    let bitmaps = random(7, 5);
    for (k, wrap) in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror, Wrap::Black]
        .into_iter()
        .enumerate()
    {
        for filter in [TextureFilter::Nearest, TextureFilter::Linear] {
            let p = pattern(filter, wrap);
            for i in 0..200 {
                let [x, y, w, h] = hash::pcg4d([i, k as u32, 5, 9]).map(hash::unit_f32);
                let low = Vec2::new(x, y) * 4.0 - 2.0;
                let size = Vec2::new(w, h) * 0.4;
                let bound = bound(&p, &bitmaps, [low, low + size]);
                for j in 0..20 {
                    let [u, v, ..] = hash::pcg4d([i, j, 3, 1]).map(hash::unit_f32);
                    let value = p.eval(&bitmaps, low + size * Vec2::new(u, v));
                    assert!(
                        (value - bound).max_component() < 1e-6,
                        "{wrap:?} {filter:?} {value:?} {bound:?}"
                    );
                }
            }
        }
    }
    let p = pattern(TextureFilter::Linear, Wrap::Clamp);
    let of_one_texel = bound(&p, &quarter(), [Vec2::splat(0.01), Vec2::splat(0.02)]);
    assert_eq!(of_one_texel, Rgb::gray(2.0));
}

#[test]
fn where_a_corner_is_no_number_the_bound_is_that_of_the_whole() {
    let bitmaps = random(7, 5);
    let p = pattern(TextureFilter::Linear, Wrap::Clamp);
    for k in 0..4 {
        let mut numbers = [0.1, 0.1, 0.2, 0.2];
        numbers[k] = f32::NAN;
        let corners = [Vec2::from_slice(&numbers[..2]), Vec2::from_slice(&numbers[2..])];
        assert_eq!(bound(&p, &bitmaps, corners), bitmaps[0].max_value());
    }
}

#[test]
fn footprints_that_pictures_share_are_those_of_each_alone() {
    let bitmaps = [random(32, 16), random(32, 16), random(16, 16)].concat();
    let texture = |bitmap, transform| {
        let pattern = ImagePattern {
            bitmap: BitmapId(bitmap),
            ..pattern(TextureFilter::Trilinear, Wrap::Repeat)
        };
        Texture {
            transform,
            ..Texture::new(Mapping::Uv, Pattern::Image(pattern))
        }
        .prepared()
    };
    let scaled = StTransform::new(Vec2::ZERO, 0.0, Vec2::splat(2.0));
    let all = [
        texture(0, StTransform::IDENTITY),
        texture(1, StTransform::IDENTITY),
        texture(2, StTransform::IDENTITY),
        texture(0, scaled),
    ];
    let textures = Textures {
        textures: &all,
        bitmaps: &bitmaps,
    };
    let axes = [
        round(3.0, 32, 16),
        [Vec2::new(0.4, -0.1), Vec2::new(-0.0, 1e-3)],
        [Vec2::new(f32::INFINITY, 0.0), Vec2::Y],
        [Vec2::new(f32::NAN, 0.1), Vec2::new(0.1, 1e30)],
    ];
    let size = Vec2::new(32.0, 16.0);
    for footprint in axes {
        let alone = TexturePoint {
            uv: Vec2::new(0.3, 0.7),
            footprint,
            ..TexturePoint::new(Vec3::ZERO, Vec3::Z)
        };
        let shared = TexturePoint {
            shared_footprint: SharedFootprint::new(footprint, size),
            ..alone
        };
        assert!(shared.shared_footprint.on(size).is_some());
        for texture in &all {
            let [alone, shared] = [&alone, &shared].map(|at| texture.eval(&textures, at));
            let bits = |c: Rgb| [c.r, c.g, c.b].map(f32::to_bits);
            assert_eq!(bits(shared), bits(alone), "{footprint:?}");
        }
    }
}
