//! A scene built in code: the cube of `scenes/cube` as a mesh, in the same place and light. Give it a name to write to.

use std::{error::Error, path::Path};

use batch_render::{
    accel::AccelKind,
    camera::{Camera, Lens, LookAt, Pose, perspective::PerspectiveLens},
    integrator::whitted::Whitted,
    light::{Light, point::PointLight},
    material::{Material, matte::Matte, phong::Phong},
    math::{DVec3, Rgb, Vec3},
    output::{self, FrameMetadata},
    render::{self, Settings},
    scene::{Background, Scene, SceneBuilder},
    shape::mesh::Mesh,
    texture::Color,
};

/// The cube and its floor.
pub fn cube_scene() -> Result<Scene, Box<dyn Error>> {
    let mut scene = SceneBuilder::new(Background::new(Rgb::new(0.6, 0.75, 0.95)));
    let red = scene.material(Material::Phong(Phong {
        color: Color::Constant(Rgb::new(0.8, 0.1, 0.06)),
        specular: Rgb::gray(0.4),
        shininess: 30.0,
        ..Phong::default()
    }));
    let albedo = Color::Constant(Rgb::gray(0.6));
    let gray = scene.material(Material::Matte(Matte::smooth(albedo)));
    let lamp = PointLight::new(Vec3::new(2.5, 5.0, 4.0), Rgb::gray(40.0));
    scene.light(Light::Point(lamp));
    scene.mesh("cube", cube(Vec3::new(-1.0, 0.1, -1.0), Vec3::new(1.0, 2.1, 1.0)), red)?;
    let corners = [[-6.0, 6.0], [6.0, 6.0], [6.0, -6.0], [-6.0, -6.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    let floor = Mesh {
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    scene.mesh("floor", floor, gray)?;
    Ok(scene.build(AccelKind::default())?)
}

/// Twelve triangles, wound outwards. Corner k is at the maximum on axis a where bit a of k is set.
fn cube(min: Vec3, max: Vec3) -> Mesh {
    let corner = |k: usize| Vec3::from_array([0, 1, 2].map(|a| if k >> a & 1 == 1 { max[a] } else { min[a] }));
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}

#[allow(dead_code, reason = "a test takes the scene only")]
fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "out/procedural_scene.png".into());
    let settings = Settings::new([320, 240], 16);
    let pose = Pose::look_at(DVec3::new(3.0, 3.2, 5.0), &LookAt::new(DVec3::new(0.0, 0.8, 0.0)))?;
    let camera = Camera::new(
        &pose,
        &Lens::Perspective(PerspectiveLens::vertical(36.0)),
        settings.resolution,
    );
    let (max_depth, ambient) = (5, Rgb::gray(0.2));
    let whitted = Whitted { max_depth, ambient };
    let film = render::render(&cube_scene()?, &camera, &whitted, &settings)?;
    output::write_still(Path::new(&out), &film, &FrameMetadata::new(1, &settings, &whitted))?;
    Ok(())
}
