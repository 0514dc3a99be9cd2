//! Tests on textures that are made of others: they are what their formulas say, near and far.

use crate::{
    math::{Rgb, Vec2, Vec3, hash},
    texture::{
        Color, Mapping, Pattern, Scalar, Texture, TextureId, TexturePoint, Textures, Warp,
        gradient::{Along, GradientPattern, GradientWrap},
        invert::Invert,
        mix::MixPattern,
        multiply::Multiply,
        noise::{Noise, NoiseChannels, NoiseForm},
        ramp::{ColorRamp, Interpolation, MAX_STOPS, Stop},
        remap::{Beyond, Remap},
        two_colors::TwoColors,
    },
    value::Channel,
};

const NOISE: TextureId = TextureId(0);
const STRIPES: TextureId = TextureId(1);
const MADE: TextureId = TextureId(2);
/// The next texture that a test adds.
const NEXT: TextureId = TextureId(3);

/// Noise in colours, a repeated gradient, a texture that is made of them, and what `more` adds.
fn with(made: Pattern, more: &[Texture]) -> Vec<Texture> {
    let noise = Noise {
        colors: TwoColors([Rgb::new(0.0, 0.1, 0.2), Rgb::new(1.0, 0.8, 0.9)]),
        form: NoiseForm::Fbm,
        scale: 2.0,
        octaves: 3,
        lacunarity: 2.0,
        gain: 0.5,
        seed: 1,
        channels: NoiseChannels::Colored,
    };
    let gradient = GradientPattern {
        colors: [Rgb::BLACK, Rgb::WHITE],
        along: Along::Linear,
        wrap: GradientWrap::Repeat,
    };
    let first = [Pattern::Noise(noise), Pattern::Gradient(gradient), made];
    let first = first.map(|pattern| Texture::new(Mapping::Uv, pattern));
    [&first, more].concat()
}

fn at(i: u32) -> TexturePoint {
    let [u, v, ..] = hash::pcg4d([i, 3, 5, 7]).map(hash::unit_f32);
    TexturePoint {
        uv: Vec2::new(u, v) * 30.0,
        dpdu: Vec3::X,
        dpdv: Vec3::Y,
        ..TexturePoint::new(Vec3::ZERO, Vec3::Z)
    }
}

fn look_up(textures: &[Texture], id: TextureId, at: &TexturePoint) -> Rgb {
    let bitmaps = &[];
    Textures { textures, bitmaps }.color(&Color::Texture(id), at)
}

fn assert_near(a: Rgb, b: Rgb) {
    assert!((a - b).map(f32::abs).max_component() < 1e-5, "{a:?} {b:?}");
}

/// Asserts that `made` is `formula` of the noise and the gradient at many points.
fn assert_is(made: Pattern, formula: impl Fn(Rgb, Rgb) -> Rgb) {
    let textures = with(made, &[]);
    for i in 0..200 {
        let at = at(i);
        let [noise, stripes, made] = [NOISE, STRIPES, MADE].map(|id| look_up(&textures, id, &at));
        assert_near(made, formula(noise, stripes));
    }
}

fn red_of(id: TextureId) -> Scalar {
    Scalar::Texture(id, Channel::R, 1.0)
}

fn ramp(input: Scalar, interpolation: Interpolation, given: &[(f32, Rgb)]) -> Pattern {
    let mut stops = [Stop::default(); MAX_STOPS];
    for (stop, (at, color)) in stops.iter_mut().zip(given) {
        *stop = Stop { at: *at, color: *color };
    }
    Pattern::Ramp(ColorRamp {
        input,
        stops,
        count: given.len(),
        interpolation,
    })
}

#[test]
fn a_prepared_texture_has_the_bits_of_one_that_is_not() {
    let product = Pattern::Multiply(Multiply([Color::Texture(NOISE), Color::Texture(STRIPES)]));
    let warped = Texture {
        warp: Some(Warp {
            by: Color::Texture(NOISE),
            amount: Vec3::new(0.3, -0.2, 0.0),
        }),
        factor: Rgb::new(0.5, 2.0, 1.0),
        ..with(product, &[])[STRIPES.0 as usize]
    };
    let textures = with(product, &[warped]);
    let prepared: Vec<Texture> = textures.iter().map(|texture| texture.prepared()).collect();
    let plain: Vec<bool> = prepared.iter().map(|texture| texture.is_plain).collect();
    assert_eq!(plain, [true, true, true, false]);
    for i in 0..50 {
        for id in [NOISE, STRIPES, MADE, NEXT] {
            assert_eq!(look_up(&textures, id, &at(i)), look_up(&prepared, id, &at(i)));
        }
    }
}

#[test]
fn a_mixture_is_the_weighted_sum() {
    let color = Rgb::new(0.3, 0.5, 0.1);
    let mixed = Pattern::Mix(MixPattern {
        sources: [Color::Texture(NOISE), Color::Constant(color)],
        factor: red_of(STRIPES),
    });
    assert_is(mixed, |noise, stripes| noise * (1.0 - stripes.r) + color * stripes.r);
}

#[test]
fn a_product_multiplies_channels() {
    let product = Pattern::Multiply(Multiply([Color::Texture(NOISE), Color::Texture(STRIPES)]));
    assert_is(product, |noise, stripes| noise * stripes);
}

#[test]
fn turning_over_twice_changes_nothing() {
    assert_is(Pattern::Invert(Invert(Color::Texture(NOISE))), |noise, _| {
        Rgb::WHITE - noise
    });
    let invert = |id| Pattern::Invert(Invert(Color::Texture(id)));
    let textures = with(invert(NOISE), &[Texture::new(Mapping::Uv, invert(MADE))]);
    for i in 0..50 {
        let [noise, twice] = [NOISE, NEXT].map(|id| look_up(&textures, id, &at(i)));
        assert_near(noise, twice);
    }
}

#[test]
fn a_range_is_remapped_in_a_straight_line() {
    let remap = |to, beyond| {
        Pattern::Remap(Remap {
            input: Color::Texture(NOISE),
            from: [0.4, 0.6],
            to,
            beyond,
        })
    };
    let part = |v: f32| (v - 0.4) / 0.2;
    assert_is(remap([0.9, 0.1], Beyond::Clamp), |noise, _| {
        noise.map(|v| 0.9 - 0.8 * part(v).clamp(0.0, 1.0))
    });
    assert_is(remap([1.0, 2.0], Beyond::Line), |noise, _| {
        noise.map(|v| (1.0 + part(v)).max(0.0))
    });
}

#[test]
fn ranges_wider_than_single_precision_have_a_middle() {
    const MOST: f32 = 3.4e38;
    let middle = |beyond| {
        Pattern::Remap(Remap {
            input: Color::Constant(Rgb::BLACK),
            from: [-MOST, MOST],
            to: [1.0, 2.0],
            beyond,
        })
    };
    for beyond in [Beyond::Clamp, Beyond::Line] {
        assert_is(middle(beyond), |_, _| Rgb::gray(1.5));
    }
    let stops = [(-MOST, Rgb::BLACK), (MOST, Rgb::gray(3.0))];
    let made = ramp(Scalar::Constant(0.0), Interpolation::Linear, &stops);
    assert_is(made, |_, _| Rgb::gray(1.5));
}

#[test]
fn a_ramp_goes_through_its_stops() {
    let [a, b] = [Rgb::new(0.1, 0.4, 0.9), Rgb::new(0.9, 0.2, 0.0)];
    let stops = [(0.25, a), (0.75, b)];
    let made = |interpolation| ramp(red_of(STRIPES), interpolation, &stops);
    let part = |v: f32| ((v - 0.25) / 0.5).clamp(0.0, 1.0);
    assert_is(made(Interpolation::Linear), |_, stripes| a + (b - a) * part(stripes.r));
    assert_is(
        made(Interpolation::Constant),
        |_, stripes| if stripes.r < 0.75 { a } else { b },
    );
    assert_is(made(Interpolation::Smooth), |_, stripes| {
        let t = part(stripes.r);
        a + (b - a) * (t * t * (3.0 - 2.0 * t))
    });
}

#[test]
fn a_factor_multiplies_any_texture() {
    let factor = Rgb::new(0.5, 2.0, 0.25);
    let mut textures = with(Pattern::Invert(Invert(Color::Texture(NOISE))), &[]);
    let before = textures.clone();
    for texture in &mut textures {
        texture.factor = factor;
    }
    for i in 0..50 {
        let of = |textures: &[Texture], id| look_up(textures, id, &at(i));
        assert_eq!(of(&textures, NOISE), of(&before, NOISE) * factor);
        let inverted = (Rgb::WHITE - of(&textures, NOISE)).max(Rgb::BLACK);
        assert_near(of(&textures, MADE), inverted * factor);
    }
}

#[test]
fn a_warp_moves_the_coordinates_by_what_it_reads() {
    let (by, amount) = (Rgb::new(0.75, 0.25, 0.5), Vec3::new(2.0, 3.0, 1.0));
    let mut textures = with(Pattern::Invert(Invert(Color::Texture(NOISE))), &[]);
    let still = textures.clone();
    textures[NOISE.0 as usize].warp = Some(Warp {
        by: Color::Constant(by),
        amount,
    });
    for i in 0..50 {
        let moved = TexturePoint {
            uv: at(i).uv + Vec2::new(1.0, -1.5),
            ..at(i)
        };
        let warped = look_up(&textures, NOISE, &at(i));
        assert_near(warped, look_up(&still, NOISE, &moved));
    }
}

/// The mean of a texture over many points.
fn mean(textures: &[Texture], id: TextureId) -> Rgb {
    const COUNT: u32 = 20_000;
    let sum = (0..COUNT).fold(Rgb::BLACK, |sum, i| sum + look_up(textures, id, &at(i)));
    sum / COUNT as f32
}

#[test]
fn a_ramp_from_afar_shows_the_mean_of_its_colours() {
    let far = TexturePoint {
        footprint: [Vec2::X * 1000.0, Vec2::Y * 1000.0],
        ..at(0)
    };
    let [dark, light] = [Rgb::gray(0.1), Rgb::new(0.9, 0.6, 0.3)];
    // A line in the gradient, and the upper third of noise: the colour of the mean is another one in both.
    for (input, stop, bound) in [(STRIPES, 0.8, 0.01), (NOISE, 0.55, 0.03)] {
        for interpolation in [Interpolation::Constant, Interpolation::Linear, Interpolation::Smooth] {
            let stops = [(0.3, dark), (stop, light)];
            let textures = with(ramp(red_of(input), interpolation, &stops), &[]);
            let (seen, expected) = (look_up(&textures, MADE, &far), mean(&textures, MADE));
            let off = (seen - expected).map(f32::abs).max_component();
            assert!(off < bound, "{input:?} {interpolation:?}: {seen:?} {expected:?}");
        }
    }
    let remap = Pattern::Remap(Remap {
        input: Color::Texture(STRIPES),
        from: [0.8, 1.0],
        to: [0.0, 1.0],
        beyond: Beyond::Clamp,
    });
    let textures = with(remap, &[]);
    let (seen, expected) = (look_up(&textures, MADE, &far), mean(&textures, MADE));
    assert!((seen.r - expected.r).abs() < 0.01, "{seen:?} {expected:?}");
}

#[test]
fn no_value_is_above_the_bound() {
    let mixed = Pattern::Mix(MixPattern {
        sources: [Color::Texture(NOISE), Color::Constant(Rgb::gray(0.7))],
        factor: red_of(STRIPES),
    });
    let product = Pattern::Multiply(Multiply([Color::Texture(NOISE), Color::Texture(STRIPES)]));
    let line = Pattern::Remap(Remap {
        input: Color::Texture(NOISE),
        from: [0.4, 0.6],
        to: [0.5, 0.2],
        beyond: Beyond::Line,
    });
    for made in [mixed, product, line] {
        let textures = with(made, &[]);
        let all = Textures {
            textures: &textures,
            bitmaps: &[],
        };
        let bound = all.max_value(&Color::Texture(MADE));
        for i in 0..500 {
            let found = look_up(&textures, MADE, &at(i)).max_component();
            assert!(found <= bound, "{made:?}: {found} {bound}");
        }
    }
}

#[test]
fn a_look_up_in_a_chain_takes_a_time_by_its_length() {
    let gray = [(0.0, Rgb::BLACK), (1.0, Rgb::WHITE)];
    let mut textures = with(Pattern::Invert(Invert(Color::Texture(NOISE))), &[]);
    // Each is the one before it, in four ways.
    for i in 0..48 {
        let last = TextureId(textures.len() as u32 - 1);
        let source = Color::Texture(last);
        let pattern = match i % 4 {
            0 => ramp(red_of(last), Interpolation::Linear, &gray),
            1 => Pattern::Remap(Remap {
                input: source,
                from: [0.0, 1.0],
                to: [0.0, 1.0],
                beyond: Beyond::Line,
            }),
            2 => Pattern::Mix(MixPattern {
                sources: [source, Color::Constant(Rgb::BLACK)],
                factor: Scalar::Constant(0.0),
            }),
            _ => Pattern::Multiply(Multiply([source, Color::Constant(Rgb::WHITE)])),
        };
        textures.push(Texture::new(Mapping::Uv, pattern));
    }
    let last = TextureId(textures.len() as u32 - 1);
    for i in 0..20 {
        let near = at(i);
        let far = TexturePoint {
            footprint: [Vec2::X * 0.1, Vec2::Y * 0.1],
            ..near
        };
        for (at, bound) in [(near, 1e-6), (far, 0.01)] {
            let (first, last) = (look_up(&textures, MADE, &at), look_up(&textures, last, &at));
            assert!((first.r - last.r).abs() < bound, "{first:?} {last:?}");
        }
    }
}
