//! Pictures on surfaces, seen through a camera: what pixels make of texels.

use batch_render::{
    accel::AccelKind,
    camera::{Camera, Lens, LookAt, Pose, perspective::PerspectiveLens},
    film::Film,
    integrator::{path::PathDesc, whitted::Whitted},
    material::{Material, Sidedness, emitter::Emitter, matte::Matte},
    math::{DVec3, Rgb, Vec2, Vec3},
    render::{self, Settings},
    scene::{Background, Scene, SceneBuilder},
    shape::{
        Shape,
        mesh::Mesh,
        quad::{Quad, QuadDesc},
    },
    texture::{
        Bitmap, Color, Mapping, Pattern, StTransform, Texture,
        bitmap::Storage,
        image::{ImagePattern, TextureFilter, Wrap},
    },
    value::{List, Point, Spanned},
};

fn quad(corners: [Vec3; 4]) -> Shape {
    let corners = corners.map(|p| Point(p.as_dvec3()));
    let desc = QuadDesc {
        corners: Spanned::new(0..0, List(corners)),
    };
    let quad: Quad = desc.compile(DVec3::ZERO).expect("a quad");
    Shape::Quad(quad)
}

/// One quad with `bitmap` on it `repeat` times, in both directions.
fn scene(corners: [Vec3; 4], bitmap: Bitmap, filter: TextureFilter, repeat: f32) -> Scene {
    let mut builder = SceneBuilder::new(Background::new(Rgb::BLACK));
    let bitmap = builder.bitmap(bitmap);
    let texture = builder.texture(Texture {
        transform: StTransform::new(Vec2::ZERO, 0.0, Vec2::splat(repeat)),
        ..Texture::new(
            Mapping::Uv,
            Pattern::Image(ImagePattern {
                bitmap,
                filter,
                wrap: [Wrap::Repeat; 2],
            }),
        )
    });
    let material = builder.material(Material::Matte(Matte::smooth(Color::Texture(texture))));
    builder.shape("quad", quad(corners), None, material);
    builder.build(AccelKind::default()).expect("a scene")
}

/// A picture of nothing but the texture's colours.
fn shoot(scene: &Scene, eye: DVec3, target: DVec3, fov: f64, side: u32) -> Film {
    let at = LookAt {
        target,
        up: DVec3::Y,
        roll: 0.0,
    };
    let pose = Pose::look_at(eye, &at).expect("a pose");
    let lens = Lens::Perspective(PerspectiveLens::vertical(fov));
    let camera = Camera::new(&pose, &lens, [side, side]);
    let bare = Whitted {
        max_depth: 1,
        ambient: Rgb::WHITE,
    };
    let settings = Settings::new([side, side], 1);
    render::render(scene, &camera, &bare, &settings).expect("a film")
}

/// A board whose squares are single texels.
fn board(side: u32) -> Bitmap {
    let value = |i: u32| {
        if (i % side + i / side).is_multiple_of(2) {
            0
        } else {
            255
        }
    };
    Bitmap::new([side; 2], 1, Storage::Linear8((0..side * side).map(value).collect()))
}

fn mean_and_variance(values: &[f32]) -> (f32, f32) {
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f32>() / values.len() as f32;
    (mean, variance)
}

#[test]
fn a_far_board_at_a_grazing_angle_is_gray_with_one_sample() {
    let floor = [[-50.0, 50.0], [50.0, 50.0], [50.0, -50.0], [-50.0, -50.0]];
    let floor = floor.map(|[x, z]| Vec3::new(x, 0.0, z));
    // Squares of 10 cm, 20 to 80 m away, from a height of 1 m: several to a pixel, and ten times as many along.
    let far = |filter| {
        let scene = scene(floor, board(256), filter, 4.0);
        let film = shoot(&scene, DVec3::new(0.0, 1.0, 45.0), DVec3::new(0.0, 1.0, 0.0), 10.0, 64);
        let rows = &film.beauty()[37 * 64..50 * 64];
        mean_and_variance(&rows.iter().map(|p| p[0]).collect::<Vec<_>>())
    };
    let (mean, variance) = far(TextureFilter::Trilinear);
    let (_, without) = far(TextureFilter::Nearest);
    assert!((mean - 0.5).abs() < 0.01, "{mean}");
    assert!(without > 0.2, "{without}");
    assert!(variance < 0.01 * without, "{variance} of {without}");
}

#[test]
fn a_pixel_that_is_four_texels_wide_sees_the_mean_of_sixteen() {
    let value = |i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
    let mut bitmap = Bitmap {
        storage: Storage::Linear8((0..64 * 64).map(value).collect()),
        ..board(64)
    };
    let wall = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let fov = 2.0 * 0.5_f64.atan().to_degrees();
    let scene = scene(wall, bitmap.clone(), TextureFilter::Trilinear, 1.0);
    let film = shoot(&scene, DVec3::Z, DVec3::ZERO, fov, 16);
    batch_render::texture::mipmap::build(&mut bitmap);
    for [x, y] in [[7, 7], [8, 7], [7, 8], [8, 8]] {
        let expected = bitmap.level(2).rgb(x, y).r;
        let found = film.beauty()[(y * 16 + x) as usize][0];
        assert!((found - expected).abs() < 0.01, "{x} {y}: {found} for {expected}");
    }
}

#[test]
fn from_near_every_filter_but_nearest_gives_the_same_bits() {
    let wall = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let shot = |filter| {
        let scene = scene(wall, board(8), filter, 1.0);
        shoot(&scene, DVec3::new(0.1, 0.05, 1.0), DVec3::ZERO, 40.0, 48)
            .beauty()
            .to_vec()
    };
    assert_eq!(shot(TextureFilter::Trilinear), shot(TextureFilter::Linear));
    assert_ne!(shot(TextureFilter::Trilinear), shot(TextureFilter::Nearest));
}

/// A floor of 2 m under a lamp of 8 x 8 x 2 triangles, which the camera does not see. A quarter of them is bright.
fn under_a_textured_lamp(filter: TextureFilter) -> Scene {
    let mut builder = SceneBuilder::new(Background::new(Rgb::BLACK));
    let is_bright = |i: u32| (i % 64 / 8 + 3 * (i / 64 / 8)).is_multiple_of(4);
    let value = |i: u32| if is_bright(i) { 255 } else { 0 };
    let bitmap = builder.bitmap(Bitmap::new(
        [64; 2],
        1,
        Storage::Srgb8((0..64 * 64).map(value).collect()),
    ));
    let texture = builder.texture(Texture::new(
        Mapping::Uv,
        Pattern::Image(ImagePattern {
            bitmap,
            filter,
            wrap: [Wrap::Repeat; 2],
        }),
    ));
    let lamp = builder.material(Material::Emitter(Emitter {
        radiance: Color::Texture(texture),
        scale: 100.0,
        sidedness: Sidedness::Both,
    }));
    let corner = |i: u32| Vec2::new((i % 9) as f32, (i / 9) as f32) / 8.0;
    let cells = (0..72).filter(|i| i % 9 < 8);
    let mesh = Mesh {
        positions: (0..81)
            .map(|i| Vec3::new(corner(i).x - 0.5, 1.0, corner(i).y - 0.5))
            .collect(),
        uvs: (0..81).map(corner).collect(),
        triangles: cells
            .flat_map(|i| [[i, i + 1, i + 9], [i + 1, i + 10, i + 9]])
            .collect(),
        ..Mesh::default()
    };
    builder.mesh("lamp", mesh, lamp).expect("a mesh");
    let floor = builder.material(Material::Matte(Matte::smooth(Color::Constant(Rgb::gray(0.8)))));
    let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    builder.shape("floor", quad(corners), None, floor);
    builder.build(AccelKind::default()).expect("a scene")
}

#[test]
fn a_textured_lamp_gives_the_same_light_by_every_filter_and_strategy() {
    let at = LookAt {
        target: DVec3::ZERO,
        up: DVec3::Z,
        roll: 0.0,
    };
    let pose = Pose::look_at(DVec3::new(0.0, 0.9, 0.0), &at).expect("a pose");
    let camera = Camera::new(&pose, &Lens::Perspective(PerspectiveLens::vertical(40.0)), [8, 8]);
    let shot = |filter, strategy, samples| {
        let path: PathDesc = toml::from_str(&format!("strategy = \"{strategy}\"")).expect("a strategy");
        let path = path.compile().expect("an integrator");
        let settings = Settings::new([8, 8], samples);
        let film = render::render(&under_a_textured_lamp(filter), &camera, &path, &settings).expect("a film");
        film.beauty().iter().map(|p| p[0]).collect::<Vec<_>>()
    };
    let light = shot(TextureFilter::Linear, "light", 256);
    let (mean, _) = mean_and_variance(&light);
    for (strategy, samples) in [("light", 256), ("mis", 256), ("bsdf", 512)] {
        let pixels = shot(TextureFilter::Trilinear, strategy, samples);
        assert_eq!(pixels, shot(TextureFilter::Linear, strategy, samples), "{strategy}");
        let differences: Vec<f32> = pixels.iter().zip(&light).map(|(a, b)| a - b).collect();
        let (difference, variance) = mean_and_variance(&differences);
        let bound = 4.0 * (variance / 64.0).sqrt();
        assert!(bound < 0.1 * mean, "{strategy}: {bound} of {mean}");
        assert!(difference.abs() <= bound, "{strategy}: {difference} of {mean}");
    }
}
