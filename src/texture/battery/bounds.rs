//! Tests on the bounds of textures over triangles.

use crate::{
    math::{DVec3, Rgb, Vec2, Vec3, hash},
    texture::{
        Bitmap, BitmapId, Color, MappingDesc, Pattern, Texture, TextureId, TexturePoint, Textures,
        image::{ImagePattern, TextureFilter, Wrap},
    },
};

/// Random numbers from -1 to 1.
fn random(i: u32, k: u32) -> Vec3 {
    let [x, y, z, _] = hash::pcg4d([i, k, 9, 4]).map(hash::unit_f32);
    Vec3::new(x, y, z) * 2.0 - 1.0
}

#[test]
fn no_point_of_a_triangle_is_brighter_than_its_bound() {
    let texels = (0..64).map(|i| if i % 29 == 0 { 5.0 } else { 0.1 });
    let bitmap = Bitmap::from_floats([8, 8], 1, texels.collect());
    let mappings = [
        "uv = {}",
        "planar = { s = { axis = 'x', from = -1, to = 1 }, t = { axis = 'z', from = 2, to = -1 } }",
        "object = { scale = 0.7, rotate = [10, 20, 30], offset = [0.4, 0, 0] }",
        "world = { scale = [3, 2, 1] }",
        "triplanar = { scale = 0.4 }",
        "spherical = {}",
    ];
    let mut dark = [0; 6];
    for (k, mapping) in mappings.iter().enumerate() {
        for (i, wrap) in (0..200).zip(
            [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror, Wrap::Black]
                .into_iter()
                .cycle(),
        ) {
            let mapping = toml::from_str::<MappingDesc>(mapping).unwrap();
            let image = ImagePattern {
                bitmap: BitmapId(0),
                filter: TextureFilter::Linear,
                wrap: [wrap; 2],
            };
            let texture = Texture::new(mapping.compile(DVec3::ZERO).unwrap(), Pattern::Image(image));
            let textures = Textures {
                textures: &[texture],
                bitmaps: std::slice::from_ref(&bitmap),
            };
            let size = if i % 3 == 0 { 2.0 } else { 0.1 };
            let corners = [0, 1, 2].map(|k| random(i, 7) * 3.0 + random(i, k) * size);
            let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let point = |[u, v]: [f32; 2]| {
                let p = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
                TexturePoint {
                    uv: Vec2::new(p.x, p.y - p.z),
                    ..TexturePoint::new(p, n)
                }
            };
            let source = Color::Texture(TextureId(0));
            let bound = textures.max_within(&source, &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(point));
            dark[k] += u32::from(bound < 1.0);
            for j in 0..300 {
                let uv = random(i, 100 + j).truncate() * 0.5 + 0.5;
                let uv = if uv.x + uv.y > 1.0 { 1.0 - uv } else { uv };
                let found = textures.color(&source, &point([uv.x, uv.y])).max_component();
                assert!(found <= bound * 1.001, "{mapping:?} {wrap:?}: {found} {bound}");
            }
        }
    }
    // The bound tells dark triangles where coordinates are affine.
    assert!(dark[..4].iter().all(|count| *count > 20), "{dark:?}");
}

#[test]
fn a_texture_far_away_has_the_bound_of_the_whole() {
    let bitmap = Bitmap::from_floats([1, 1], 1, vec![3.0]);
    let image = ImagePattern {
        bitmap: BitmapId(0),
        filter: TextureFilter::Linear,
        wrap: [Wrap::Clamp; 2],
    };
    let textures = Textures {
        textures: &[Texture::new(crate::texture::Mapping::Uv, Pattern::Image(image))],
        bitmaps: std::slice::from_ref(&bitmap),
    };
    let at = TexturePoint {
        uv: Vec2::splat(1e30),
        ..TexturePoint::new(Vec3::ZERO, Vec3::Z)
    };
    let source = Color::Texture(TextureId(0));
    assert_eq!(textures.color(&source, &at), Rgb::gray(3.0));
    assert_eq!(textures.max_within(&source, &[at; 3]), 3.0);
}
