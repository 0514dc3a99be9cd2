//! Tests on patterns without files: their means over an area, from afar, and over a footprint.

mod algebra;
mod bounds;
mod hostile;

use std::cell::RefCell;

use super::{
    Mapping, Pattern, Texture, TexturePoint, Textures,
    brick::Brick,
    gradient::{Along, GradientPattern, GradientWrap},
    noise::{Noise, NoiseChannels, NoiseForm},
    solid::{SolidDesc, SolidSpace},
    two_colors::TwoColors,
    voronoi::{CellValue, Voronoi},
};
use crate::{
    math::{DVec3, Rgb, Vec2, Vec3, hash},
    value::Point,
};

const BLACK_TO_WHITE: [Rgb; 2] = [Rgb::BLACK, Rgb::WHITE];

fn noise(form: NoiseForm) -> Pattern {
    Pattern::Noise(Noise {
        colors: TwoColors(BLACK_TO_WHITE),
        form,
        scale: 1.0,
        octaves: 3,
        lacunarity: 2.0,
        gain: 0.5,
        seed: 5,
        channels: NoiseChannels::Gray,
    })
}

fn voronoi(value: CellValue) -> Pattern {
    Pattern::Voronoi(Voronoi {
        colors: TwoColors(BLACK_TO_WHITE),
        value,
        scale: 1.0,
        seed: 3,
    })
}

fn gradient(wrap: GradientWrap) -> Pattern {
    Pattern::Gradient(GradientPattern {
        colors: BLACK_TO_WHITE,
        along: Along::Linear,
        wrap,
    })
}

const BRICK: Brick = Brick {
    colors: [Rgb::new(0.6, 0.2, 0.1), Rgb::new(0.4, 0.1, 0.1)],
    mortar: Rgb::new(0.8, 0.8, 0.7),
    size: [1.0, 0.5],
    gap: 0.1,
    shift: 0.5,
    seed: 1,
};

/// A pattern, the means that its manual page tells on s and t and in space, and the part of the error of a single point that a
/// footprint of the width of half a feature has, at most.
struct Example {
    pattern: Pattern,
    means: [Rgb; 2],
    error: f32,
}

fn examples() -> Vec<Example> {
    let example = |pattern, [plane, space]: [f32; 2], error| Example {
        pattern,
        means: [plane, space].map(Rgb::gray),
        error,
    };
    let of_bricks = (1.0 - 0.1) * (1.0 - 0.1 / 0.5);
    let wall = Rgb::new(0.5, 0.15, 0.1) * of_bricks + BRICK.mortar * (1.0 - of_bricks);
    vec![
        example(noise(NoiseForm::Fbm), [0.5, 0.5], 0.55),
        example(noise(NoiseForm::Turbulence), [0.249, 0.22], 0.55),
        example(voronoi(CellValue::Distance), [0.43, 0.52], 0.75),
        example(voronoi(CellValue::Edge), [0.269, 0.197], 0.65),
        example(voronoi(CellValue::Cell), [0.5, 0.5], 0.9),
        example(gradient(GradientWrap::Repeat), [0.5, 0.5], 0.2),
        example(gradient(GradientWrap::Mirror), [0.5, 0.5], 0.2),
        Example {
            pattern: Pattern::Brick(BRICK),
            means: [wall, wall],
            error: 0.25,
        },
    ]
}

/// The mappings to s and t and to three coordinates.
fn mappings() -> [Mapping; 2] {
    [
        Mapping::Uv,
        Mapping::Solid(SolidDesc::default().compile(SolidSpace::Object, DVec3::ZERO)),
    ]
}

/// Random numbers from 0 to 1.
fn random(i: u32, k: u32) -> [f32; 4] {
    hash::pcg4d([i, k, 77, 1]).map(hash::unit_f32)
}

/// A point of a plane that leans against the axes where `is_solid`, with a footprint of this width.
fn point(i: u32, is_solid: bool, width: f32) -> TexturePoint {
    let [x, y, z, _] = random(i, 0).map(|v| v * 1000.0);
    let axes = if is_solid {
        [Vec3::new(0.48, 0.6, 0.64), Vec3::new(-0.8, 0.6, 0.0)]
    } else {
        [Vec3::X, Vec3::Y]
    };
    TexturePoint {
        uv: Vec2::new(x, y),
        dpdu: axes[0],
        dpdv: axes[1],
        footprint: [Vec2::X * width, Vec2::Y * width],
        ..TexturePoint::new(Vec3::new(x, y, z), Vec3::Z)
    }
}

fn value(texture: &Texture, at: &TexturePoint) -> Rgb {
    let textures = Textures {
        textures: &[],
        bitmaps: &[],
    };
    texture.eval(&textures, at)
}

fn largest(color: Rgb) -> f32 {
    color.map(f32::abs).max_component()
}

/// Calls `test` with each pattern, its place among the mappings, its texture and its mean.
fn for_each(test: impl Fn(&Example, bool, &Texture, Rgb)) {
    for example in examples() {
        for (k, mapping) in mappings().into_iter().enumerate() {
            let texture = Texture::new(mapping, example.pattern);
            test(&example, k == 1, &texture, example.means[k]);
        }
    }
}

#[test]
fn points_of_a_large_area_have_the_mean_of_the_manual() {
    const COUNT: u32 = 20_000;
    for_each(|_, is_solid, texture, mean| {
        let (mut sum, mut squares) = (Rgb::BLACK, Rgb::BLACK);
        for i in 0..COUNT {
            let deviation = value(texture, &point(i, is_solid, 0.0)) - mean;
            sum += deviation;
            squares += deviation * deviation;
        }
        let error = (squares / (COUNT as f32 * COUNT as f32)).map(f32::sqrt);
        let off = largest(sum / COUNT as f32);
        // The manual has three digits.
        assert!(off < 4.0 * error.max_component() + 5e-4, "{off} {error:?} {texture:?}");
    });
}

#[test]
fn a_footprint_that_is_wider_than_all_features_sees_the_mean() {
    for_each(|_, is_solid, texture, mean| {
        for i in 0..100 {
            let off = largest(value(texture, &point(i, is_solid, 1000.0)) - mean);
            assert!(off < 1e-3, "{off} {texture:?}");
        }
    });
}

#[test]
fn a_footprint_sees_nearly_the_mean_of_its_points() {
    const SIDE: u32 = 6;
    let parts = RefCell::new(Vec::new());
    for_each(|example, is_solid, texture, _| {
        let (mut of_points, mut of_footprints) = (0.0, 0.0);
        for i in 0..300 {
            let at = point(i, is_solid, 0.5);
            let cells = (0..SIDE * SIDE).map(|k| {
                let [x, y, ..] = random(i, k + 1);
                Vec2::new((k % SIDE) as f32 + x, (k / SIDE) as f32 + y) / SIDE as f32 - 0.5
            });
            let moved = cells.map(|d| value(texture, &at.moved(d * 0.5).without_footprint()));
            let mean = moved.fold(Rgb::BLACK, |sum, v| sum + v) / (SIDE * SIDE) as f32;
            of_points += (value(texture, &at.without_footprint()) - mean).map(|v| v * v).mean();
            of_footprints += (value(texture, &at) - mean).map(|v| v * v).mean();
        }
        parts
            .borrow_mut()
            .push((example.error, (of_footprints / of_points).sqrt()));
    });
    let parts = parts.into_inner();
    assert!(parts.iter().all(|(most, part)| part < most), "{parts:?}");
}

#[test]
fn footprints_without_a_width_and_places_without_a_number_are_finite() {
    for_each(|_, _, texture, _| {
        for (uv, width) in [
            (f32::NAN, 0.0),
            (f32::INFINITY, 1.0),
            (3e38, 1.0),
            (1e17, 0.1),
            (0.3, f32::INFINITY),
            (0.3, 3e38),
        ] {
            let at = TexturePoint {
                uv: Vec2::splat(uv),
                p: Vec3::splat(uv),
                ..point(1, true, width)
            };
            let found = value(texture, &at);
            assert!(found.is_finite(), "{uv} {width} {found:?} {texture:?}");
        }
    });
}

/// The hash of the bits of a pattern at many points.
fn bits(texture: &Texture) -> u32 {
    (0..500).fold(0, |h, i| {
        let at = point(i, true, 0.01 * (i % 50) as f32);
        let found = value(texture, &at).to_array();
        found
            .into_iter()
            .fold(h, |h, v| hash::mix32(h ^ v.to_bits()).wrapping_add(1))
    })
}

#[test]
fn patterns_have_the_same_bits_on_every_machine() {
    let mut found = Vec::new();
    for example in examples() {
        found.extend(mappings().map(|mapping| bits(&Texture::new(mapping, example.pattern))));
    }
    assert_eq!(found, BITS);
}

const BITS: [u32; 16] = [
    267972885, 2977089834, 1696398525, 1305863737, 1056374637, 274361441, 2032952665, 302197710, 2622617846,
    1520324584, 3133851735, 1021633715, 1962094978, 1739836392, 1890589784, 3525494339,
];

#[test]
fn a_texture_of_the_world_is_the_same_around_any_origin() {
    let origin = DVec3::new(431_250.0, 20.0, 5_649_830.0);
    let moved = SolidDesc {
        offset: Some(Point::new(origin)),
        ..SolidDesc::default()
    };
    for example in examples() {
        let far = SolidDesc::default().compile(SolidSpace::World, origin);
        let near = moved.compile(SolidSpace::Object, DVec3::ZERO);
        let [far, near] = [far, near].map(|solid| Texture::new(Mapping::Solid(solid), example.pattern));
        for i in 0..50 {
            let p = point(i, true, 0.0).p * 0.001;
            let found = value(&far, &TexturePoint::in_scene(p, Vec3::Z));
            assert_eq!(found, value(&near, &TexturePoint::new(p, Vec3::Z)), "{far:?}");
        }
    }
}
