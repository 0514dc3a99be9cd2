//! Passes of data and pictures that are no light: depth, normals, parameters, objects, and ambient occlusion.

use std::path::Path;

use batch_render::{
    batch::{Job, Request},
    describe::{self, Overrides, Source},
    film::Film,
    math::Vec3,
    render::Control,
};

const SIDE: u32 = 16;
/// At (0, 0, 5), looking along -z; the picture's edges are at 45 degrees.
const CAMERA: &str = "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0], fov = 90 }\n";
const MATERIAL: &str = "[material.m]\nmatte = { albedo = [0.5, 0.5, 0.5] }\n";

/// The film of a scene whose `[render]` has `render`; `show` is the pass that is shown.
fn shoot(render: &str, show: Option<&str>, scene: &str) -> Film {
    let text = format!("[render]\nwidth = {SIDE}\nheight = {SIDE}\n{render}\n{MATERIAL}{scene}");
    let source = Source::new(Path::new("scene.toml").into(), text);
    let desc = describe::parse(source).unwrap_or_else(|e| panic!("{e}"));
    let show = show.map(|pass| Overrides::default().with("output.show", pass));
    let request = Request {
        overrides: show.unwrap_or_default(),
        ..Request::default()
    };
    let job = Job::new(desc, &request).unwrap_or_else(|e| panic!("{e}"));
    let scene = job.compile().unwrap_or_else(|e| panic!("{e}"));
    job.render_frame(&mut job.scenes(scene), 0, &Control::default())
        .expect("a film")
}

/// The values of a pass with `N` channels.
fn values<'a, const N: usize>(film: &'a Film, pass: &str) -> &'a [[f32; N]] {
    film.plane(pass).expect("a pass").values.as_chunks().0
}

fn alphas(film: &Film) -> impl Iterator<Item = f32> + '_ {
    film.beauty().iter().map(|p| p[3])
}

/// The direction of the ray through a pixel's centre, 1 m long along the line of sight.
fn through(pixel: usize) -> Vec3 {
    let at = |n: u32| (n as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
    Vec3::new(at(pixel as u32 % SIDE), -at(pixel as u32 / SIDE), -1.0)
}

#[test]
fn depth_and_distance_put_every_pixel_on_the_plane_that_it_sees() {
    let plane = "[[object]]\nmaterial = \"m\"\nshape.plane = { point = [0, 0, -3], normal = [0.2, 0.1, 1] }\n";
    // A lens and samples have no say.
    let camera = CAMERA.replace("fov", "aperture_radius = 0.2, fov");
    for camera in [CAMERA, &camera] {
        let film = |pass| shoot("samples = 16", Some(pass), &format!("{camera}{plane}"));
        let (depth, distance) = (film("depth"), film("distance"));
        let (depths, distances) = (values::<1>(&depth, "depth"), values::<1>(&distance, "distance"));
        for (i, ([depth], [distance])) in depths.iter().zip(distances).enumerate() {
            let at_one = through(i);
            let by_depth = Vec3::new(0.0, 0.0, 5.0) + at_one * *depth;
            let by_distance = Vec3::new(0.0, 0.0, 5.0) + at_one.normalize() * *distance;
            for p in [by_depth, by_distance] {
                let above = (p - Vec3::new(0.0, 0.0, -3.0)).dot(Vec3::new(0.2, 0.1, 1.0));
                assert!(above.abs() < 1e-4, "{i}: {p}");
            }
        }
        assert!(alphas(&depth).all(|alpha| alpha == 1.0));
    }
}

#[test]
fn where_nothing_is_met_it_is_far_away_and_transparent() {
    let disk = "[[object]]\nmaterial = \"m\"\nshape.disk = { center = [0, 0, 0], normal = [0, 0, 1], radius = 2 }\n";
    let film = shoot("", Some("depth"), &format!("{CAMERA}{disk}"));
    let middle = (SIDE / 2 * SIDE + SIDE / 2) as usize;
    assert_eq!((values(&film, "depth")[0], film.beauty()[0][3]), ([1e10], 0.0));
    assert_eq!(film.beauty()[middle][3], 1.0);
    assert!((values::<1>(&film, "depth")[middle][0] - 5.0).abs() < 1e-6);
    let film = shoot("", Some("N"), &format!("{CAMERA}{disk}"));
    assert_eq!((values(&film, "N")[0], film.beauty()[0][3]), ([0.0; 3], 0.0));
}

#[test]
fn normals_are_the_authored_ones_in_world_space_with_their_signs() {
    for normal in [Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.48, 0.6, -0.64)] {
        let [x, y, z] = normal.to_array();
        let plane = format!(
            "[[object]]\nmaterial = \"m\"\nshape.plane = {{ point = [0, 0, -30], normal = [{x}, {y}, {z}] }}\n"
        );
        let film = shoot("", Some("N"), &format!("{CAMERA}{plane}"));
        let normals = values::<3>(&film, "N").iter().zip(alphas(&film));
        let seen: Vec<_> = normals.filter(|(_, alpha)| *alpha == 1.0).collect();
        assert!(seen.len() > 100);
        for (n, _) in seen {
            assert!((Vec3::from_array(*n) - normal).length() < 1e-6);
        }
    }
}

#[test]
fn parameters_of_a_quad_run_from_corner_to_corner() {
    let quad = "[[object]]\nmaterial = \"m\"\n\
                shape.quad = { corners = [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]] }\n";
    let film = shoot("", Some("UV"), &format!("{CAMERA}{quad}"));
    for (i, [u, v]) in values(&film, "UV").iter().enumerate() {
        let d = through(i);
        assert!(
            (u - (0.5 + 0.5 * d.x)).abs() < 1e-5 && (v - (0.5 + 0.5 * d.y)).abs() < 1e-5,
            "{i}: {u} {v}"
        );
    }
}

#[test]
fn objects_are_numbered_in_the_order_of_the_file() {
    let ball =
        |x: i32| format!("[[object]]\nmaterial = \"m\"\nshape.sphere = {{ center = [{x}, 0, 0], radius = 1 }}\n");
    let film = shoot("", Some("objectId"), &format!("{CAMERA}{}{}", ball(-2), ball(2)));
    let row = (SIDE / 2 * SIDE) as usize;
    let ids = &values::<1>(&film, "objectId")[row..row + SIDE as usize];
    let mut ids: Vec<u32> = ids.iter().map(|[id]| id.to_bits()).collect();
    ids.dedup();
    assert_eq!(ids, [0, 1, 0, 2, 0]);
}

/// The part of the sky that the floor sees at the origin, where the camera looks at nothing else.
fn open_sky(integrator: &str, above: &str) -> f32 {
    let camera = "[camera]\nperspective = { eye = [0.2, 0.2, 0], target = [0, 0, 0], fov = 0.5 }\n";
    let floor = "[[object]]\nmaterial = \"m\"\nshape.plane = { point = [0, 0, 0], normal = [0, 1, 0] }\n";
    let above = format!("[[object]]\nmaterial = \"m\"\nshape.{above}\n");
    let film = shoot(
        &format!("samples = 32\nintegrator.occlusion = {{ {integrator} }}"),
        None,
        &format!("{camera}{floor}{above}"),
    );
    film.beauty().iter().map(|p| p[0]).sum::<f32>() / film.beauty().len() as f32
}

#[test]
fn occlusion_under_disks_planes_and_domes_has_its_analytic_value() {
    let disk = "disk = { center = [0, 1, 0], normal = [0, -1, 0], radius = 1 }";
    let ceiling = "plane = { point = [0, 1, 0], normal = [0, -1, 0] }";
    let dome = "sphere = { center = [0, 0, 0], radius = 1 }";
    // The form factor of a disk of radius r at height h is r^2 / (r^2 + h^2); a ceiling hides what is nearer than the
    // distance, up to the cosine h / distance.
    for (integrator, above, expected) in [
        ("samples = 4", disk, 0.5),
        ("samples = 4, distance = 2", ceiling, 0.25),
        ("samples = 2", ceiling, 0.0),
        ("distance = 0.999", ceiling, 1.0),
        ("distance = 0", dome, 0.0),
        ("distance = 0.9", dome, 1.0),
    ] {
        let found = open_sky(integrator, above);
        assert!(
            (found - expected).abs() < 0.01,
            "{integrator}, {above}: {found} for {expected}"
        );
    }
}
