//! Meshes that are stored once for many places: the same scene as with a copy for each place.

use std::{f32::consts::TAU, sync::Arc};

use crate::common::Folder;
use batch_render::{
    accel::{AccelKind, TreeId},
    assets::Store,
    camera::{Camera, Lens, LookAt, Pose, perspective::PerspectiveLens},
    compile::{self, Instancing},
    describe,
    geometry::Hit,
    integrator::whitted::Whitted,
    light::{Light, point::PointLight},
    material::{Material, MaterialId, matte::Matte},
    math::{
        DVec3, Ray, Rgb, Transform, Vec2, Vec3,
        hash::{pcg4d, unit_f32},
    },
    render::{self, Settings},
    scene::{
        Background, GroupId, LightLinks, MeshId, MeshPose, ObjectId, Scene, SceneBuilder, SceneShading, SceneUpdate,
        SceneUpdateError, SurfaceInteraction,
    },
    shape::{Shape, mesh::Mesh, sphere::Sphere},
    texture::Color,
};

/// Numbers in [-1, 1).
fn random(i: u32, purpose: u32) -> Vec3 {
    let [x, y, z, _] = pcg4d([i, purpose, 3, 9]);
    Vec3::new(unit_f32(x), unit_f32(y), unit_f32(z)) * 2.0 - 1.0
}

/// A lumpy ball of `4 n^2` triangles with smooth normals and texture coordinates.
fn ball(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..=2 * n {
            let (s, t) = (j as f32 / (2 * n) as f32, i as f32 / n as f32);
            let (turn, polar) = (TAU * s, TAU * 0.5 * t.clamp(0.01, 0.99));
            let r = libm::sinf(polar);
            let p = Vec3::new(r * libm::cosf(turn), libm::cosf(polar), -r * libm::sinf(turn));
            mesh.positions.push(p * (1.0 + 0.1 * libm::sinf(5.0 * turn)));
            mesh.uvs.push(Vec2::new(s, 1.0 - t));
        }
    }
    let at = |i: u32, j: u32| i * (2 * n + 1) + j;
    for i in 0..n {
        for j in 0..2 * n {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh.normals = mesh.smooth_normals();
    mesh
}

/// A glTF asset of nested nodes: two balls and a fan of two primitives stand in several places each, turned, stretched
/// and mirrored; one ball stands alone.
fn write_gltf(folder: &Folder) {
    let (fine, coarse) = (ball(12), ball(6));
    let mut bytes = Vec::new();
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut add = |data: Vec<u8>, count: usize, kind: &str, component: u32, more: &str| {
        views.push(format!(
            r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#,
            bytes.len(),
            data.len()
        ));
        accessors.push(format!(
            r#"{{"bufferView":{},"componentType":{component},"count":{count},"type":"{kind}"{more}}}"#,
            views.len() - 1
        ));
        bytes.extend(data);
        accessors.len() - 1
    };
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut primitives = Vec::new();
    for (mesh, material, normals) in [(&fine, 0, true), (&coarse, 1, false)] {
        let flat = |v: &[Vec3]| v.iter().flat_map(|v| v.to_array()).collect::<Vec<f32>>();
        let corners: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let uvs: Vec<f32> = mesh.uvs.iter().flat_map(|v| v.to_array()).collect();
        let count = mesh.positions.len();
        let bounds = r#","min":[-2,-2,-2],"max":[2,2,2]"#;
        let p = add(floats(&flat(&mesh.positions)), count, "VEC3", 5126, bounds);
        let n = add(floats(&flat(&mesh.normals)), count, "VEC3", 5126, "");
        let t = add(floats(&uvs), count, "VEC2", 5126, "");
        let i = add(corners, 3 * mesh.triangles.len(), "SCALAR", 5125, "");
        let more = if normals {
            format!(r#","NORMAL":{n},"TEXCOORD_0":{t}"#)
        } else {
            String::new()
        };
        primitives.push(format!(
            r#"{{"attributes":{{"POSITION":{p}{more}}},"indices":{i},"material":{material}}}"#
        ));
    }
    let [smooth, flat] = [&primitives[0], &primitives[1]];
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,5]}}],
        "nodes":[
          {{"children":[1,2],"rotation":[0,0.3826834,0,0.9238795],"scale":[1,1.5,0.7]}},
          {{"mesh":0,"children":[3,4],"translation":[-2,0,0]}},
          {{"mesh":0,"scale":[-1,0.5,1],"translation":[2,0,0],"rotation":[0.2,0,0.1,0.97]}},
          {{"mesh":1,"translation":[0,2,0],"scale":[0.5,0.6,-0.7]}},
          {{"mesh":1,"translation":[0,-2,0.5],"scale":[1,0.1,1]}},
          {{"mesh":2,"translation":[0,0,-2.5]}}],
        "meshes":[{{"primitives":[{smooth}]}},{{"primitives":[{flat},{smooth}]}},{{"primitives":[{flat}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"metallicFactor":0,"baseColorFactor":[0.8,0.3,0.2,1]}}}},
                     {{"pbrMetallicRoughness":{{"metallicFactor":0,"baseColorFactor":[0.2,0.4,0.8,1]}}}}],
        "buffers":[{{"uri":"m.bin","byteLength":{}}}],"bufferViews":[{}],"accessors":[{}]}}"#,
        bytes.len(),
        views.join(","),
        accessors.join(",")
    );
    std::fs::write(folder.path("m.bin"), bytes).expect("writable");
    folder.write("m.gltf", &json);
}

/// The asset as it is, stretched and mirrored, and in a checker that sticks to the object; a ball from another file,
/// among them one that is flat, which no instance can be.
const OBJECTS: &str = "
[texture.uv]
checker = { a = [1, 1, 1], b = [0.1, 0.1, 0.1], scale = 8 }
[texture.sphere]
checker = { a = [1, 0.8, 0.2], b = [0.1, 0.1, 0.4], scale = 6 }
mapping.spherical = {}
[material.uv]
matte = { albedo = 'texture.uv' }
[material.sphere]
phong = { color = 'texture.sphere' }
[[object]]
name = 'as it is'
shape.mesh = { file = 'm.gltf' }
[[object]]
name = 'mirrored'
shape.mesh = { file = 'm.gltf' }
transform = { translate = [7, 0, -3], rotate = [10, 40, 0], scale = [-1, 1.2, 0.8] }
[[object]]
name = 'checkered'
material = 'uv'
shape.mesh = { file = 'm.gltf' }
transform = { translate = [-7, 1, -3], rotate = [0, -40, 15] }
[[object]]
name = 'spherical'
material = 'sphere'
shape.mesh = { file = 'm.gltf' }
transform = { translate = [0, 5, -2], scale = [1, 0.5, -1] }
[[light]]
sun = { direction = [-0.4, -1, -0.7], irradiance = 2 }
[[light]]
point = { position = [3, 4, 6], intensity = 20 }
";

fn scene(folder: &Folder, accel: AccelKind, instancing: Instancing) -> Scene {
    let desc = describe::load(
        &folder.write("s.toml", OBJECTS),
        &batch_render::describe::Overrides::default(),
        std::fs::read,
    )
    .unwrap_or_else(|e| panic!("{e}"));
    compile::scene_instancing(&desc, accel, &Store::default(), instancing).unwrap_or_else(|e| panic!("{e}"))
}

fn surfaces(scene: &Scene, rays: &[Ray]) -> Vec<Option<SurfaceInteraction>> {
    let mut hits: Vec<Option<Hit>> = vec![None; rays.len()];
    scene.geometry.accel.nearest(rays, &mut hits);
    let surface = |(ray, hit): (&Ray, &Option<Hit>)| hit.map(|hit| scene.surface(ray, &hit));
    rays.iter().zip(&hits).map(surface).collect()
}

fn rays(count: u32, size: f32) -> Vec<Ray> {
    let ray = |i| {
        let o = random(i, 1) * Vec3::new(2.0 * size, size, size) + Vec3::Z * size;
        Ray::new(o, random(i, 2) * Vec3::new(size, 0.4 * size, 0.4 * size) - o)
    };
    (0..count).map(ray).collect()
}

fn picture(scene: &Scene) -> Vec<[f32; 4]> {
    let settings = Settings::new([96, 54], 4);
    let pose = Pose::look_at(DVec3::new(0.0, 3.0, 20.0), &LookAt::new(DVec3::new(0.0, 1.0, 0.0))).expect("a pose");
    let lens = Lens::Perspective(PerspectiveLens::vertical(35.0));
    let camera = Camera::new(&pose, &lens, settings.resolution);
    let whitted = Whitted {
        max_depth: 3,
        ambient: Rgb::gray(0.1),
    };
    let film = render::render(scene, &camera, &whitted, &settings).expect("a film");
    film.beauty().to_vec()
}

#[test]
fn instances_are_the_copies_that_they_stand_for() {
    let folder = Folder::new();
    write_gltf(&folder);
    let baked = scene(&folder, AccelKind::Wide, Instancing::Never);
    let shared = scene(&folder, AccelKind::Wide, Instancing::Always);
    let (a, b) = (baked.geometry.accel.stats(), shared.geometry.accel.stats());
    assert_eq!((a.instances, a.seen, a.prims as u64), (0, b.seen, b.seen));
    // Of each object five units: two meshes of one primitive that repeat, one of two primitives, one that stands alone.
    assert!(b.instances >= 4 * 5 && b.prims * 8 < a.prims, "{b:?}");
    assert_eq!(baked.geometry.objects.len(), shared.geometry.objects.len());
    assert_eq!(baked.shading.materials.len(), shared.shading.materials.len());
    let rays = rays(30_000, 9.0);
    let (mut met, mut odd) = (0, 0);
    for (a, b) in surfaces(&baked, &rays).iter().zip(&surfaces(&shared, &rays)) {
        let (Some(a), Some(b)) = (a, b) else {
            odd += u32::from(a.is_some() != b.is_some());
            continue;
        };
        met += 1;
        let near = |a: Vec3, b: Vec3, error: f32| (a - b).length() <= error * (1.0 + a.length());
        let same = near(a.p, b.p, 1e-5)
            && near(a.ng, b.ng, 1e-4)
            && near(a.ns, b.ns, 1e-4)
            && near(a.texture.p, b.texture.p, 1e-4)
            && near(a.texture.n, b.texture.n, 1e-4)
            && (a.texture.uv - b.texture.uv).length() < 1e-3
            && near(a.dpdu, b.dpdu, 1e-2)
            && near(a.dpdv, b.dpdv, 1e-2)
            && (a.object, a.material) == (b.object, b.material);
        odd += u32::from(!same);
    }
    // At an edge either side may be met.
    assert!(met > 6000 && odd * 200 < met, "{odd} of {met}");
}

#[test]
fn instances_give_the_picture_that_copies_give() {
    let folder = Folder::new();
    write_gltf(&folder);
    let baked = picture(&scene(&folder, AccelKind::Wide, Instancing::Never));
    let shared = picture(&scene(&folder, AccelKind::Wide, Instancing::Always));
    let differ = |a: &[f32; 4], b: &[f32; 4]| (0..4).any(|k| (a[k] - b[k]).abs() > 1e-3 * (1.0 + a[k].abs()));
    let different = baked.iter().zip(&shared).filter(|(a, b)| differ(a, b)).count();
    assert!(different * 200 < baked.len(), "{different} of {} pixels", baked.len());
    let seen = baked.iter().filter(|p| p[3] > 0.0 && p[0] > 0.05).count();
    assert!(seen > 500, "{seen} pixels show something");
    // And to the bit whatever the accelerator.
    assert!(picture(&scene(&folder, AccelKind::Bvh2, Instancing::Always)) == shared);
}

#[test]
fn rays_that_leave_an_instance_do_not_meet_where_they_left() {
    let folder = Folder::new();
    write_gltf(&folder);
    let shared = scene(&folder, AccelKind::Wide, Instancing::Always);
    let (mut left, mut met) = (0, 0);
    for (i, surface) in surfaces(&shared, &rays(20_000, 9.0)).iter().enumerate() {
        let Some(surface) = surface else { continue };
        let w = random(i as u32, 5).normalize();
        // Nearly along the surface nothing is certain.
        if w.dot(surface.ng).abs() < 0.02 {
            continue;
        }
        let transmitted = w.dot(surface.ng) * surface.wo.dot(surface.ng) < 0.0;
        let ray = Ray {
            tmax: 1e-3,
            ..surface.spawn_ray(transmitted, w)
        };
        left += 1;
        let again = surfaces(&shared, &[ray])[0];
        met += u32::from(again.is_some_and(|again| (again.ng - surface.ng).length() < 1e-3));
    }
    assert!(left > 4000 && met == 0, "{met} of {left}");
}

/// A builder with a matte material.
fn builder() -> (SceneBuilder, MaterialId) {
    let mut scene = SceneBuilder::new(Background::new(Rgb::gray(0.2)));
    let albedo = Color::Constant(Rgb::gray(0.7));
    let gray = scene.material(Material::Matte(Matte::smooth(albedo)));
    scene.light(Light::Point(PointLight::new(
        Vec3::new(3.0, 9.0, 9.0),
        Rgb::gray(200.0),
    )));
    (scene, gray)
}

fn place(i: u32) -> Transform {
    let wide = |v: Vec3| v.as_dvec3();
    let at = random(i, 7) * Vec3::new(8.0, 3.0, 3.0);
    Transform::from_parts(wide(at), wide(random(i, 8) * 180.0), wide(random(i, 9) * 0.2 + 0.4)).expect("invertible")
}

/// `count` balls and a sphere, over a floor.
fn balls(count: u32, mesh: Mesh, places: impl Fn(u32) -> Transform) -> (Scene, GroupId, Vec<ObjectId>) {
    let (mut scene, gray) = builder();
    let floor = Mesh {
        positions: [[-9.0, 9.0], [9.0, 9.0], [9.0, -9.0], [-9.0, -9.0]]
            .map(|[x, z]| Vec3::new(x, -4.0, z))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    scene.mesh("floor", floor, gray).expect("sound");
    let group = scene.group(vec![(mesh, gray)]).expect("sound");
    let mut objects: Vec<ObjectId> = (0..count)
        .map(|i| scene.instance("ball", group, places(i), None))
        .collect();
    let sphere = Shape::Sphere(Sphere {
        center: Vec3::ZERO,
        radius: 1.0,
    });
    objects.push(scene.shape("sphere", sphere, Some(places(count)), gray));
    (scene.build(AccelKind::Wide).expect("sound"), group, objects)
}

#[test]
fn a_scene_in_motion_is_the_scene_that_is_built_for_the_frame() {
    let (mut moving, group, objects) = balls(1000, ball(4), place);
    let is_moved = |i: u32| i == 17 || i == 1000;
    let motion = SceneUpdate {
        transforms: [17, 1000].map(|i| (objects[i], place(5000 + i as u32))).to_vec(),
        ..SceneUpdate::default()
    };
    let updated = moving.apply(&motion).expect("sound");
    assert_eq!((updated.built, updated.refitted), (vec![TreeId::Top], vec![]));
    let (built, ..) = balls(1000, ball(4), |i| place(if is_moved(i) { 5000 + i } else { i }));
    let compare = |a: &Scene, b: &Scene| {
        let rays = rays(10_000, 9.0);
        let (mut one, mut other) = (vec![None; rays.len()], vec![None; rays.len()]);
        a.geometry.accel.nearest(&rays, &mut one);
        b.geometry.accel.nearest(&rays, &mut other);
        assert!(one == other && one.iter().flatten().count() > 5000);
        assert!(picture(a) == picture(b));
    };
    compare(&moving, &built);

    let mesh = moving.meshes_of(group).next().expect("the ball");
    let mut bent = ball(4);
    for p in &mut bent.positions {
        p.y += 0.3 * p.x * p.x;
    }
    bent.normals = bent.smooth_normals();
    let motion = SceneUpdate {
        poses: vec![MeshPose {
            mesh,
            positions: bent.positions.clone(),
            normals: bent.normals.clone(),
            tangents: Vec::new(),
        }],
        ..SceneUpdate::default()
    };
    let updated = moving.apply(&motion).expect("sound");
    assert_eq!(
        (updated.built, updated.refitted),
        (vec![TreeId::Top], vec![TreeId::Group(group.0)])
    );
    let (built, ..) = balls(1000, bent, |i| place(if is_moved(i) { 5000 + i } else { i }));
    compare(&moving, &built);
}

#[test]
fn objects_of_many_instances_move_as_one() {
    let folder = Folder::new();
    write_gltf(&folder);
    let mut moving = scene(&folder, AccelKind::Wide, Instancing::Always);
    let t = Transform::from_parts(DVec3::new(1.0, 2.0, 0.5), DVec3::new(0.0, 30.0, 0.0), DVec3::ONE).expect("a move");
    let object = ObjectId(0);
    let motion = SceneUpdate {
        transforms: vec![(object, t)],
        ..SceneUpdate::default()
    };
    let updated = moving.apply(&motion).expect("sound");
    assert_eq!(updated.built, [TreeId::Top]);
    let text = OBJECTS.replacen(
        "file = 'm.gltf' }",
        "file = 'm.gltf' }\ntransform = { translate = [1, 2, 0.5], rotate = [0, 30, 0] }",
        1,
    );
    let desc = describe::load(
        &folder.write("moved.toml", &text),
        &batch_render::describe::Overrides::default(),
        std::fs::read,
    )
    .expect("a scene");
    let built =
        compile::scene_instancing(&desc, AccelKind::Wide, &Store::default(), Instancing::Always).expect("sound");
    let rays = rays(10_000, 9.0);
    let mut odd = 0;
    let (a, b) = (surfaces(&moving, &rays), surfaces(&built, &rays));
    for pair in a.iter().zip(&b) {
        let same = match pair {
            (Some(a), Some(b)) => {
                a.object == b.object && (a.p - b.p).length() < 1e-4 && (a.texture.p - b.texture.p).length() < 1e-3
            }
            (None, None) => true,
            _ => false,
        };
        odd += u32::from(!same);
    }
    assert!(odd < 50, "{odd}");
}

#[test]
fn another_shading_builds_no_tree() {
    let (mut scene, _, _) = balls(3, ball(4), place);
    let other = scene
        .with_shading(Arc::clone(&scene.shading))
        .expect("the same materials");
    assert!(Arc::ptr_eq(&scene.geometry, &other.geometry));
    assert_eq!(other.lights.count(), scene.lights.count());
    let update = SceneUpdate::default();
    assert_eq!(scene.apply(&update).expect_err("shared"), SceneUpdateError::Shared);
    drop(other);
    let groups = scene.shading.light_groups.clone();
    let bare = SceneShading::new(
        (vec![], vec![], vec![]),
        (vec![], vec![]),
        (vec![], vec![]),
        (groups, LightLinks::default()),
        scene.shading.background.clone(),
    );
    assert!(matches!(
        scene.with_shading(Arc::new(bare)).err(),
        Some(SceneUpdateError::TooFewMaterials { found: 0, .. })
    ));
    scene.apply(&update).expect("no longer shared");
}

#[test]
fn what_cannot_be_moved_says_so() {
    let (mut scene, _, _) = balls(3, ball(4), place);
    let mut refused = |transforms, poses| {
        let update = SceneUpdate {
            transforms,
            poses,
            ..SceneUpdate::default()
        };
        scene.apply(&update).expect_err("refused")
    };
    let baked = refused(vec![(ObjectId(0), place(1))], vec![]);
    assert_eq!(baked, SceneUpdateError::NotMovable(ObjectId(0)));
    let pose = |mesh, positions: Vec<Vec3>| {
        vec![MeshPose {
            mesh,
            positions,
            normals: Vec::new(),
            tangents: Vec::new(),
        }]
    };
    assert_eq!(
        refused(vec![], pose(MeshId(2), vec![])),
        SceneUpdateError::NoSuchMesh(MeshId(2))
    );
    let short = refused(vec![], pose(MeshId(0), vec![Vec3::ZERO; 3]));
    assert_eq!(short.to_string(), "mesh 0 has 4 vertices, not 3 positions");
    let nowhere = refused(vec![], pose(MeshId(0), vec![Vec3::NAN; 4]));
    assert!(matches!(nowhere, SceneUpdateError::Build(_)), "{nowhere}");
}

/// The most memory that this process has had, in bytes; `None` where nobody knows.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

/// Takes some ten seconds, and must be alone in its process for the figure to mean anything.
#[test]
#[ignore = "long, and alone: cargo test --test program instances -- --ignored"]
fn a_million_instances_of_ten_thousand_triangles_take_less_than_4_gb() {
    let mesh = ball(50);
    assert_eq!(mesh.triangles.len(), 10_000);
    let before = peak();
    let place = |i: u32| {
        let at = random(i, 7) * 100.0;
        let (at, turn) = (at.as_dvec3(), random(i, 8).as_dvec3() * 180.0);
        Transform::from_parts(at, turn, DVec3::splat(0.3)).expect("invertible")
    };
    let (scene, ..) = balls(1_000_000, mesh, place);
    let stats = scene.geometry.accel.stats();
    assert_eq!((stats.instances, stats.prims), (1_000_000, 10_003));
    assert!(stats.seen > 10_000_000_000);
    let seen = picture(&scene).iter().filter(|p| p[3] > 0.0).count();
    assert!(seen > 4000, "{seen}");
    println!("{stats:?}, peak {:?} of which {before:?} before", peak());
    assert!(peak().is_none_or(|bytes| bytes < 4 << 30));
}
