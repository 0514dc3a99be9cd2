//! Lamps that show a picture: one light, however it is looked for.

use crate::{
    light::{Light, LightDesc, LightFind, LightTables, PictureMap},
    math::{DVec3, Ray, Rgb, Vec2, Vec3, hash::mix32, hash::unit_f32},
    texture::{
        Bitmap, BitmapId, Color, Mapping, Pattern, Texture, TextureId, Textures,
        image::{ImagePattern, TextureFilter, Wrap},
        invert::Invert,
    },
};

/// A gray picture of these texels, bottom row first.
struct Shown {
    textures: Vec<Texture>,
    bitmaps: Vec<Bitmap>,
}

impl Shown {
    fn new(side: u32, filter: TextureFilter, texel: impl Fn(u32, u32) -> f32) -> Self {
        let rows = (0..side).rev().flat_map(|y| (0..side).map(move |x| (x, y)));
        let values = rows.map(|(x, y)| texel(x, y)).collect();
        Self {
            textures: vec![Texture::new(
                Mapping::Uv,
                Pattern::Image(ImagePattern {
                    bitmap: BitmapId(0),
                    filter,
                    wrap: [Wrap::Clamp; 2],
                }),
            )],
            bitmaps: vec![Bitmap::from_floats([side, side], 1, values)],
        }
    }

    fn textures(&self) -> Textures<'_> {
        Textures {
            textures: &self.textures,
            bitmaps: &self.bitmaps,
        }
    }

    /// A light that shows the picture, and the picture's light.
    fn light(&self, text: &str) -> (Light, PictureMap) {
        let light = light(text);
        let map = light.picture().expect("a picture").map(&self.textures());
        (light, map)
    }

    fn tables<'a>(&'a self, map: &'a PictureMap) -> LightTables<'a> {
        LightTables {
            textures: self.textures(),
            picture: Some(map),
            ..LightTables::NONE
        }
    }
}

fn light(text: &str) -> Light {
    let desc: LightDesc = toml::from_str(text).expect("a light");
    let find = LightFind {
        color: &|_| Ok(Color::Texture(TextureId(0))),
        ..LightFind::nothing(DVec3::ZERO)
    };
    desc.compile(&find).expect("a valid light")
}

fn number(i: u32) -> f32 {
    unit_f32(mix32(i))
}

/// Means of samples of the irradiance on a surface at `from` of normal `n`, and the variance of a sample.
fn irradiance(light: &Light, tables: &LightTables<'_>, (from, n): (Vec3, Vec3), count: u32) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..count {
        let u = Vec2::new((i as f32 + 0.5) / count as f32, number(i));
        let found = light.sample(tables, from, u).map_or(0.0, |sample| {
            f64::from(sample.li.g * sample.wi.dot(n).max(0.0) / sample.pdf.unwrap_or(1.0))
        });
        sum += found;
        squares += found * found;
    }
    let mean = sum / f64::from(count);
    (mean, squares / f64::from(count) - mean * mean)
}

const SQUARE: &str = "position = [0, 2, 0], direction = [0, -1, 0], up = [0, 0, -1], size = [2, 2]";

#[test]
fn a_picture_of_one_colour_has_the_bits_of_none() {
    let white = Shown::new(8, TextureFilter::Nearest, |_, _| 1.0);
    let kinds = [
        format!("rect = {{ {SQUARE}, radiance = [1, 2, 3]"),
        format!("rect = {{ {SQUARE}, power = 7, spread = 0.4, two_sided = true"),
        "disk = { position = [0, 2, 0], direction = [0.3, -1, 0], radius = 0.7, power = 7".to_owned(),
    ];
    for keys in kinds {
        let (shown, map) = white.light(&format!("{keys}, texture = 'texture.white' }}"));
        let plain = light(&format!("{keys} }}"));
        for i in 0..500 {
            let from = Vec3::new(number(i) - 0.5, number(i + 1000), number(i + 2000) - 0.5) * 4.0;
            let u = Vec2::new(number(i + 3000), number(i + 4000));
            let found = shown.sample(&white.tables(&map), from, u);
            assert_eq!(found, plain.sample(&LightTables::NONE, from, u), "{keys}");
        }
    }
}

#[test]
fn irradiance_of_a_gradient_is_the_integral_of_its_radiance() {
    // Brighter to the right as it is seen from below, that is towards +x with -z above seen along
    // -y: towards -x seen from the floor.
    let side = 64;
    let gradient = Shown::new(side, TextureFilter::Linear, |x, _| (x as f32 + 0.5) / side as f32);
    let (rect, map) = gradient.light(&format!("rect = {{ {SQUARE}, radiance = 3, texture = 'texture.g' }}"));
    let expected = |from: DVec3| {
        let n = 400;
        let mut sum = 0.0;
        for i in 0..n * n {
            let [s, t] = [i % n, i / n].map(|k| (f64::from(k) + 0.5) / f64::from(n));
            let to = DVec3::new(1.0 - 2.0 * s, 2.0, 2.0 * t - 1.0) - from;
            let d2 = to.length_squared();
            sum += 3.0 * s * to.y * to.y / (d2 * d2);
        }
        sum * 4.0 / f64::from(n * n)
    };
    for from in [[0.0, 0.0, 0.0], [1.5, 1.0, 0.3], [-1.5, 1.0, 0.3], [0.2, 1.8, -0.4]] {
        let (found, _) = irradiance(
            &rect,
            &gradient.tables(&map),
            (Vec3::from(from.map(|x: f64| x as f32)), Vec3::Y),
            40_000,
        );
        let expected = expected(DVec3::from(from));
        assert!(
            (found / expected - 1.0).abs() < 0.01,
            "{from:?}: {found}, not {expected}"
        );
    }
}

#[test]
fn power_is_that_of_the_whole_picture() {
    for (side, filter) in [(16, TextureFilter::Nearest), (200, TextureFilter::Linear)] {
        let spots = Shown::new(side, filter, |x, y| if (x * 7 + y * 3) % 11 == 0 { 9.0 } else { 0.2 });
        for keys in [
            "rect = { position = [0, 2, 0], direction = [0, -1, 0], size = [0.2, 0.1]",
            "disk = { position = [0, 2, 0], direction = [0, -1, 0], radius = 0.1",
        ] {
            let (lamp, map) = spots.light(&format!("{keys}, power = 5, texture = 'texture.t' }}"));
            let far = Vec3::new(0.0, -98.0, 0.0);
            let (found, _) = irradiance(&lamp, &spots.tables(&map), (far, Vec3::Y), 20_000);
            // The intensity along the normal is the power by pi.
            let expected = 5.0 / std::f64::consts::PI / 1e4;
            assert!(
                (found / expected - 1.0).abs() < 0.01,
                "{keys} {side}: {found} {expected}"
            );
        }
    }
}

/// A dark picture with a bright spot of 6 x 6 texels of 128, in the middle of its right half as seen from the front.
fn spot() -> Shown {
    Shown::new(128, TextureFilter::Nearest, |x, y| {
        if (93..99).contains(&x) && (61..67).contains(&y) {
            100.0
        } else {
            0.0
        }
    })
}

#[test]
fn a_bright_spot_is_hardly_noisier_than_a_rect_in_its_place() {
    let dark = spot();
    let (lamp, map) = dark.light(&format!(
        "rect = {{ {SQUARE}, radiance = 1, texture = 'texture.spot' }}"
    ));
    // Its right half as seen from below lies at -x.
    let width = 2.0 * 6.0 / 128.0;
    let alone = light(&format!(
        "rect = {{ position = [-0.5, 2, 0], direction = [0, -1, 0], up = [0, 0, -1], size = [{width}, {width}], radiance = 100 }}"
    ));
    for from in [[0.0, 0.0, 0.0], [-0.6, 1.7, 0.1], [1.4, 1.5, 0.0], [-3.0, 0.5, 2.0]] {
        let at = (Vec3::from(from), Vec3::Y);
        let (found, variance) = irradiance(&lamp, &dark.tables(&map), at, 20_000);
        let (expected, least) = irradiance(&alone, &LightTables::NONE, at, 20_000);
        assert!(
            (found / expected - 1.0).abs() < 0.01,
            "{from:?}: {found}, not {expected}"
        );
        // A few samples in a thousand look at the dark parts.
        let relative = (variance / (found * found)).sqrt();
        let own = (least / (expected * expected)).sqrt();
        assert!(relative < 0.15 + 1.1 * own, "{from:?}: {relative}, and {own} alone");
    }
}

#[test]
fn a_ray_along_a_sample_finds_the_picture_and_the_density_of_the_sample() {
    let kinds = [
        "rect = { position = [0, 2, 0], target = [0.3, 0, 0], size = [1.5, 1], radiance = 2, texture = 'texture.t' }",
        "disk = { position = [0, 2, 0], target = [0.3, 0, 0], radius = 0.8, power = 9, texture = 'texture.t', two_sided = true }",
    ];
    let spots = Shown::new(40, TextureFilter::Linear, |x, y| number(x * 40 + y).powi(4));
    for text in kinds {
        let (lamp, map) = spots.light(text);
        let (tables, (surface, _)) = (spots.tables(&map), lamp.surface().expect("a surface"));
        let (mut found, mut others) = (0, 0);
        for i in 0..1000 {
            let from = Vec3::new(number(i) - 0.5, number(i + 1000), number(i + 2000) - 0.5) * 4.0;
            let u = Vec2::new(number(i + 3000), number(i + 4000));
            let Some(sample) = lamp.sample(&tables, from, u) else {
                continue;
            };
            let ray = Ray::new(from, sample.wi);
            let Some(hit) = surface.intersect(&ray) else { continue };
            if surface.surface(&ray, &hit).ng.dot(sample.wi).abs() < 0.4 || (hit.t - sample.distance).abs() > 1e-3 {
                continue;
            }
            let (radiance, pdf) = lamp.seen(&tables, from, sample.wi, &hit);
            let own = sample.pdf.expect("a density");
            let is_same = (pdf / own - 1.0).abs() < 5e-3 && (radiance.g / sample.li.g - 1.0).abs() < 2e-2;
            found += u32::from(is_same);
            others += u32::from(!is_same);
        }
        // A point next to the edge of a cell may be found in the next one.
        assert!(found > 150 && others * 50 < found, "{text}: {found}, not {others}");
    }
}

#[test]
fn the_density_of_samples_integrates_to_one() {
    let spots = Shown::new(40, TextureFilter::Linear, |x, y| number(x * 40 + y).powi(4));
    let (lamp, map) = spots.light(&format!("rect = {{ {SQUARE}, radiance = 2, texture = 'texture.t' }}"));
    let (tables, (surface, _)) = (spots.tables(&map), lamp.surface().expect("a surface"));
    for from in [Vec3::ZERO, Vec3::new(0.4, 1.7, 0.5), Vec3::new(-3.0, 1.0, 0.0)] {
        let (n, mut sum) = (800, 0.0);
        for i in 0..n * n {
            let [s, t] = [i % n, i / n].map(|k| (k as f32 + 0.5) / n as f32);
            let p = Vec3::new(2.0 * s - 1.0, 2.0, 2.0 * t - 1.0);
            let (to, w) = (p - from, (p - from).normalize());
            let Some(hit) = surface.intersect(&Ray::new(from, w)) else {
                continue;
            };
            let (_, pdf) = lamp.seen(&tables, from, w, &hit);
            sum += f64::from(pdf * w.y / to.length_squared());
        }
        let integral = sum * 4.0 / f64::from(n * n);
        assert!((integral - 1.0).abs() < 5e-3, "{from}: {integral}");
    }
}

#[test]
fn wrong_textures_are_refused() {
    let desc: LightDesc =
        toml::from_str(&format!("rect = {{ {SQUARE}, radiance = 2, texture = 0.5 }}")).expect("a light");
    let find = LightFind {
        color: &|_| Ok(Color::Constant(Rgb::WHITE)),
        ..LightFind::nothing(DVec3::ZERO)
    };
    let message = desc.compile(&find).expect_err("refused").message;
    assert_eq!(message, "expected \"texture.NAME\", found a colour");
}

#[test]
fn lamps_that_differ_in_their_power_alone_show_one_picture() {
    let lamp = |position: &str, power: u32| {
        light(&format!(
            "rect = {{ position = {position}, target = [0, 0, 0], size = [1, 2], power = {power}, texture = 'texture.a' }}"
        ))
    };
    let [one, two] = [1, 2].map(|power| lamp("[0, 3, 0]", power));
    assert!(one.picture().is_some() && one.picture() == two.picture());
    assert_ne!(one.picture(), lamp("[0, 4, 0]", 1).picture());
}

#[test]
fn texels_below_zero_give_no_light() {
    let cut = |least: f32| {
        Shown::new(16, TextureFilter::Nearest, move |x, y| {
            let sign = if (x + y) % 3 == 0 { -5.0 } else { 1.0 };
            (sign * (x as f32 + 1.0)).max(least)
        })
    };
    let text = format!("rect = {{ {SQUARE}, radiance = 2, texture = 'texture.t' }}");
    let [negative, black] = [-100.0, 0.0].map(cut);
    let [(lamp, map), (alike, map_of_black)] = [&negative, &black].map(|shown| shown.light(&text));
    for i in 0..500 {
        let from = Vec3::new(number(i) - 0.5, number(i + 1000), number(i + 2000) - 0.5);
        let u = Vec2::new(number(i + 3000), number(i + 4000));
        let found = lamp.sample(&negative.tables(&map), from, u);
        assert!(found.is_none_or(|found| found.li.g >= 0.0), "{found:?}");
        assert_eq!(found, alike.sample(&black.tables(&map_of_black), from, u));
    }
}

#[test]
fn a_picture_made_of_an_image_has_the_light_of_the_image() {
    // Spots of one texel in cells of many.
    let mut shown = Shown::new(512, TextureFilter::Nearest, |x, y| {
        f32::from(u8::from((x + 7 * y) % 61 == 0))
    });
    let text = format!("rect = {{ {SQUARE}, radiance = 2, texture = 'texture.t' }}");
    let (_, map) = shown.light(&text);
    let image = shown.textures[0];
    let invert = |id| Pattern::Invert(Invert(Color::Texture(TextureId(id))));
    shown.textures = vec![
        Texture::new(Mapping::Uv, invert(1)),
        Texture::new(Mapping::Uv, invert(2)),
        image,
    ];
    let (_, twice_inverted) = shown.light(&text);
    assert_eq!(map.mean, twice_inverted.mean);
}
