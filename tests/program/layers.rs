//! A truth for each layer that compositors and denoisers read beside the picture.

use crate::common::Folder;
use batch_render::{
    batch::{Job, Request},
    describe::Overrides,
    film::{Film, FilmLayout, PassRequest, passes::BEAUTY},
    math::Vec3,
    render::Control,
};

/// The films of a scene: all passes of `aovs`, in all frames of the camera path where there is one.
fn films(scene: &str, path: Option<&str>, aovs: &[&str]) -> Vec<Film> {
    let folder = Folder::new();
    let request = Request {
        overrides: Overrides::default().with("output.aovs", aovs.to_vec()),
        camera_path: path.map(|text| folder.write("path.csv", text)),
        ..Request::default()
    };
    let job = Job::open(&folder.write("s.toml", scene), &request).unwrap_or_else(|e| panic!("{e}"));
    let mut scenes = job.scenes(job.compile().unwrap_or_else(|e| panic!("{e}")));
    let film = |i| job.render_frame(&mut scenes, i, &Control::default()).expect("a film");
    (0..job.plan.frames.len()).map(film).collect()
}

/// The values of a pass with `N` channels.
fn values<'a, const N: usize>(film: &'a Film, pass: &str) -> &'a [[f32; N]] {
    film.plane(pass).expect("a pass").values.as_chunks().0
}

/// A scene of one material, `m`, under a sky of radiance 1.
fn white_sky(render: &str, material: &str, object: &str) -> String {
    format!(
        "[render]\nwidth = 16\nheight = 16\n{render}\n[camera]\nperspective = {{ eye = [0, 0, 4], target = [0, 0, 0], fov = 20 }}\n\
         [background]\ncolor = [1, 1, 1]\n[material.m]\n{material}\n[[object]]\nmaterial = \"m\"\n{object}\n"
    )
}

const BALL: &str = "shape.sphere = { center = [0, 0, 0], radius = 0.5 }";
const WALL: &str = "shape.plane = { point = [0, 0, 0], normal = [0.3, 0.2, 1] }";

#[test]
fn the_albedo_of_a_matte_surface_is_what_its_material_says() {
    let scene = white_sky("samples = 4", "matte = { albedo = [0.6, 0.3, 0.1] }", WALL);
    let film = &films(&scene, None, &["albedo"])[0];
    for pixel in values::<3>(film, "albedo") {
        let off = (Vec3::from(*pixel) - Vec3::new(0.6, 0.3, 0.1)).abs().max_element();
        assert!(off < 1e-6, "{pixel:?}");
    }
}

#[test]
fn an_albedo_is_the_light_of_a_surface_under_a_white_sky_after_one_bounce() {
    for material in [
        "principled = { base_color = [0.7, 0.4, 0.2], roughness = 0.4 }",
        "principled = { base_color = [0.9, 0.8, 0.3], roughness = 0.3, metallic = 1 }",
        "metal = { preset = \"gold\", roughness = 0.3 }",
        "matte = { albedo = [0.5, 0.5, 0.5], roughness = 0.8 }",
        "mirror = { reflectance = [0.8, 0.7, 0.6] }",
    ] {
        let render = "samples = 256\nintegrator.path = { max_depth = 2 }";
        let film = &films(&white_sky(render, material, WALL), None, &["albedo"])[0];
        let mean = |pixels: &mut dyn Iterator<Item = [f32; 3]>| {
            pixels.map(Vec3::from).sum::<Vec3>() / film.window.area() as f32
        };
        let albedo = mean(&mut values::<3>(film, "albedo").iter().copied());
        let light = mean(&mut film.beauty().iter().map(|[r, g, b, _]| [*r, *g, *b]));
        let off = ((albedo - light) / light).abs().max_element();
        assert!(off < 0.01, "{material}: {albedo} and {light}");
    }
}

#[test]
fn clear_glass_has_an_albedo_of_one() {
    let film = &films(&white_sky("samples = 4", "glass = {}", BALL), None, &["albedo"])[0];
    let middle = values::<3>(film, "albedo")[16 * 8 + 8];
    assert!(middle.iter().all(|v| (v - 1.0).abs() < 1e-5), "{middle:?}");
}

#[test]
fn a_place_is_the_eye_and_the_distance_along_the_ray_far_from_the_origin_too() {
    let scene = white_sky("samples = 4", "matte = { albedo = 0.5 }", WALL);
    for shift in [0.0, 50_000.0] {
        let scene = scene
            .replace(
                "eye = [0, 0, 4], target = [0, 0, 0]",
                &format!("eye = [{shift}, 0, 4], target = [{shift}, 0, 0]"),
            )
            .replace("point = [0, 0, 0]", &format!("point = [{shift}, 0, 0]"));
        let film = &films(&scene, None, &["P", "distance", "depth"])[0];
        let places = values::<3>(film, "P").iter().zip(values::<1>(film, "distance"));
        for ((p, [distance]), [depth]) in places.zip(values::<1>(film, "depth")) {
            let p = p.map(f64::from);
            let from_eye = glam::DVec3::new(p[0] - shift, p[1], p[2] - 4.0);
            assert!(
                (from_eye.length() - f64::from(*distance)).abs() < 2e-2_f64.min(1e-5 + shift * 1e-7),
                "{p:?}"
            );
            assert!((-from_eye.z - f64::from(*depth)).abs() < 1e-5, "{p:?}");
            let above = (0.3 * from_eye.x + 0.2 * from_eye.y + p[2]).abs();
            assert!(above < 1e-5 + shift * 1e-7, "{p:?} is {above} m from the plane");
        }
    }
}

/// A film's `P` at a place between pixel centres, in pixels.
fn place_at(film: &Film, x: f32, y: f32) -> Option<Vec3> {
    let (places, width) = (values::<3>(film, "P"), film.window.width() as usize);
    let (x, y) = (x - 0.5, y - 0.5);
    let (i, j) = (x.floor(), y.floor());
    if i < 0.0 || j < 0.0 || i as usize + 1 >= width || j as u32 + 1 >= film.window.height() {
        return None;
    }
    let at = |di: usize, dj: usize| Vec3::from(places[(j as usize + dj) * width + i as usize + di]);
    let (fx, fy) = (x - i, y - j);
    let rows = [0, 1].map(|dj| at(0, dj).lerp(at(1, dj), fx));
    Some(rows[0].lerp(rows[1], fy))
}

#[test]
fn a_point_followed_forward_or_back_lands_on_its_place_in_that_frame() {
    for lens in ["perspective", "fisheye", "panorama", "orthographic"] {
        let rest = match lens {
            "perspective" => ", fov = 40",
            "orthographic" => ", height = 3",
            _ => "",
        };
        let scene = white_sky(
            "samples = 1",
            "matte = { albedo = 0.5 }",
            "shape.sphere = { center = [0, 0, 0], radius = 9 }",
        )
        .replace("width = 16\nheight = 16", "width = 96\nheight = 64")
        .replace(
            "perspective = { eye = [0, 0, 4], target = [0, 0, 0], fov = 20 }",
            &format!("{lens} = {{ eye = [0, 0, 4], target = [0, 0, 0]{rest} }}"),
        );
        let path = "frame, eye_x, eye_y, eye_z, target_x, target_y, target_z\n1, 0, 0, 4, 0, 0, 0\n2, 0.1, 0.05, 3.8, 0.2, 0, 0\n";
        let films = films(&scene, Some(path), &["P", "forward", "backward", "depth", "distance"]);
        let (first, second) = (&films[0], &films[1]);
        let depth = if matches!(lens, "perspective" | "orthographic") {
            "depth"
        } else {
            "distance"
        };
        let mut followed = 0;
        for (own, other, pass, sign) in [(first, second, "forward", 1.0), (second, first, "backward", -1.0)] {
            for (i, motion) in values::<3>(own, pass).iter().enumerate() {
                let (x, y) = ((i % 96) as f32 + 0.5, (i / 96) as f32 + 0.5);
                let there = [x + sign * motion[0], y - sign * motion[1]];
                let Some(found) = place_at(other, there[0], there[1]) else {
                    continue;
                };
                let p = Vec3::from(values::<3>(own, "P")[i]);
                if p == Vec3::ZERO || found == Vec3::ZERO {
                    continue;
                }
                let Some(beside) = place_at(other, there[0] + 1.0, there[1]) else {
                    continue;
                };
                let pixel = found.distance(beside);
                // Near the poles a line between two pixels is no place on the ball.
                if lens == "panorama" && !(12.0..52.0).contains(&y) {
                    continue;
                }
                if lens == "fisheye" && glam::Vec2::new(x - 48.0, y - 32.0).length() > 25.0 || pixel > 1.0 {
                    continue;
                }
                assert!(
                    p.distance(found) < 0.05 * pixel + 1e-4,
                    "{lens} {pass} {i}: {p} and {found}, {pixel}"
                );
                let far = values::<1>(other, depth)[there[1] as usize * 96 + there[0] as usize][0];
                let expected = values::<1>(own, depth)[i][0] + sign * motion[2];
                assert!((far - expected).abs() < 0.15, "{lens} {pass} {i}: {far} and {expected}");
                followed += 1;
            }
        }
        assert!(followed > 2000, "{lens}: {followed}");
        // Beyond the ends of the path nothing moves.
        assert!(values::<3>(first, "backward").iter().all(|m| *m == [0.0; 3]));
        assert!(values::<3>(second, "forward").iter().all(|m| *m == [0.0; 3]));
    }
}

#[test]
fn nothing_moves_over_a_cut_and_a_still_camera_moves_nothing() {
    let scene = white_sky("samples = 1", "matte = { albedo = 0.5 }", WALL);
    let head = "frame, eye_x, eye_y, eye_z, target_x, target_y, target_z, interp\n";
    let path = format!("{head}1, 0, 0, 4, 0, 0, 0, hold\n2, 1, 0, 4, 0, 0, 0, hold\n3, 1, 0, 4, 0, 0, 0, hold\n");
    for film in films(&scene, Some(&path), &["forward", "backward"]) {
        for pass in ["forward", "backward"] {
            let largest = values::<3>(&film, pass)
                .iter()
                .flatten()
                .fold(0.0_f32, |m, v| m.max(v.abs()));
            assert!(largest < 1e-4, "{pass}: {largest}");
        }
    }
}

#[test]
fn the_variance_is_that_of_pixels_with_other_seeds() {
    let scene = |seed: u32| {
        let render = format!("samples = 16\nseed = {seed}\nsampler = \"independent\"\nfilter = \"box\"");
        white_sky(&render, "matte = { albedo = [0.8, 0.4, 0.1] }", WALL)
            + "[[object]]\nmaterial = \"m\"\nshape.sphere = { center = [0.2, 0.1, 0.4], radius = 0.4 }\n"
    };
    let films: Vec<Film> = (0..64)
        .map(|seed| films(&scene(seed), None, &["variance", "sampleCount"]).remove(0))
        .collect();
    let n = films.len() as f64;
    let (mut found, mut told) = (0.0, 0.0);
    for i in 0..256 {
        let values_of = films.iter().map(|f| f64::from(f.beauty()[i][0]));
        let mean = values_of.clone().sum::<f64>() / n;
        found += values_of.map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
        told += films
            .iter()
            .map(|f| f64::from(values::<3>(f, "variance")[i][0]))
            .sum::<f64>()
            / n;
        assert!(films.iter().all(|f| values::<1>(f, "sampleCount")[i] == [16.0]));
    }
    assert!(found > 0.0 && (told / found - 1.0).abs() < 0.05, "{told} and {found}");
}

/// A frame with the passes that denoisers read: a ball before a slanted wall, of which a part of the pixels sees neither.
fn denoise_films(sampler: &str, samples: u32, seeds: u32) -> Vec<Film> {
    let scene = |seed: u32| {
        let render = format!("samples = {samples}\nseed = {seed}\nsampler = \"{sampler}\"\nfilter = \"box\"");
        let wall = "shape.quad = { corners = [[-0.6, -0.6, 0], [0.5, -0.6, 0.3], [0.5, 0.6, 0.1], [-0.6, 0.6, -0.2]] }";
        white_sky(&render, "matte = { albedo = [0.8, 0.4, 0.1] }", wall)
            + "[[object]]\nmaterial = \"m\"\nshape.sphere = { center = [0.2, 0.1, 0.4], radius = 0.4 }\n"
    };
    (0..seeds)
        .map(|seed| films(&scene(seed), None, &["denoise"]).remove(0))
        .collect()
}

/// The variance over `films` of the first value of a pass, summed over all pixels.
fn true_variance(films: &[Film], pass: &str) -> f64 {
    let (n, width) = (films.len() as f64, films[0].plane(pass).expect("a pass").spec.width());
    let pixel = |i: usize| {
        let values = films
            .iter()
            .map(|f| f64::from(f.plane(pass).expect("a pass").values[i * width]));
        let mean = values.clone().sum::<f64>() / n;
        values.map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)
    };
    (0..256).filter(|i| is_seen(films, *i)).map(pixel).sum()
}

/// Whether all frames see a surface there: where some do not, the mean depth jumps to that of the background.
fn is_seen(films: &[Film], pixel: usize) -> bool {
    let depth = |film: &Film| values::<1>(film, "depth_mean")[pixel][0];
    films.iter().all(|film| depth(film) < 1e9)
}

/// The variance that the frames tell, in the mean over `films`; `estimate` reads that of a pixel.
fn told_variance(films: &[Film], estimate: impl Fn(&Film, usize) -> f32) -> f64 {
    let of = |film: &Film| {
        let pixels = (0..256).filter(|i| is_seen(films, *i));
        pixels.map(|i| f64::from(estimate(film, i))).sum::<f64>()
    };
    films.iter().map(of).sum::<f64>() / films.len() as f64
}

/// The told over the true variance of the beauty, the albedo, the normal and the depth.
fn variance_ratios(films: &[Film]) -> [f64; 4] {
    let first = |pass: &'static str| {
        move |film: &Film, i: usize| {
            let plane = film.plane(pass).expect("a pass");
            plane.values[i * plane.spec.width()]
        }
    };
    let halves = |film: &Film, i: usize| {
        let [a, b] = ["beauty_a", "beauty_b"].map(|half| values::<3>(film, half)[i][0]);
        (0.5 * (a - b)).powi(2)
    };
    [
        told_variance(films, halves) / true_variance(films, "beauty"),
        told_variance(films, first("albedo_variance")) / true_variance(films, "albedo"),
        told_variance(films, first("N_variance")) / true_variance(films, "N_mean"),
        told_variance(films, first("depth_variance")) / true_variance(films, "depth_mean"),
    ]
}

#[test]
fn halves_tell_the_variance_of_the_mean_where_samples_are_independent() {
    let ratios = variance_ratios(&denoise_films("independent", 16, 160));
    assert!(ratios.iter().all(|r| (r - 1.0).abs() < 0.08), "{ratios:?}");
}

/// The halves of a run of a sequence depend on each other. Where the variance falls with the number n of samples as n^-k, halves
/// tell 2^k - 1 times that of the mean: 1 for noise, and 7 for smooth functions, where k is 3 (Owen, "Scrambled net variance
/// for integrals of smooth functions", 1997, doi:10.1214/aos/1031594731).
#[test]
fn halves_of_a_sobol_sequence_tell_one_to_seven_times_the_variance() {
    for samples in [4, 16] {
        let ratios = variance_ratios(&denoise_films("sobol", samples, 96));
        assert!(ratios.iter().all(|r| (1.0..7.0).contains(r)), "{samples}: {ratios:?}");
    }
}

#[test]
fn the_two_halves_make_the_beauty_and_means_those_of_their_features() {
    for samples in [1, 5, 8] {
        let film = &denoise_films("sobol", samples, 1)[0];
        let weight = (samples / 2) as f32 / samples as f32;
        for (i, beauty) in film.beauty().iter().enumerate() {
            let [a, b] = ["beauty_a", "beauty_b"].map(|half| values::<3>(film, half)[i]);
            for c in 0..3 {
                let mean = a[c] * weight + b[c] * (1.0 - weight);
                assert!((mean - beauty[c]).abs() < 1e-5, "{samples} {i}: {a:?} {b:?} {beauty:?}");
            }
            let (normal, [depth]) = (values::<3>(film, "N_mean")[i], values::<1>(film, "depth_mean")[i]);
            let length = Vec3::from(normal).length();
            let is_covered = (Vec3::from(values::<3>(film, "albedo")[i]) - Vec3::new(0.8, 0.4, 0.1)).length() < 1e-5;
            assert!(
                length < 1.0 + 1e-5 && (depth > 1e9) == (length == 0.0),
                "{normal:?} {depth}"
            );
            assert!(depth > 1e9 || (2.9..4.4).contains(&depth), "{depth}");
            if samples == 1 {
                let variances = [
                    values::<3>(film, "N_variance")[i],
                    values::<3>(film, "albedo_variance")[i],
                ];
                assert!(a == b && variances == [[0.0; 3]; 2]);
                assert!(!is_covered || (length - 1.0).abs() < 1e-5, "{normal:?}");
            }
        }
    }
}

#[test]
fn numbers_of_objects_materials_and_instances_begin_at_one() {
    let scene = white_sky("samples = 1", "matte = { albedo = 0.5 }", BALL)
        + "[material.other]\nmatte = { albedo = 0.5 }\n[[object]]\nmaterial = \"other\"\nshape.plane = { point = [0, 0, -2], normal = [0, 0, 1] }\n";
    let film = &films(&scene, None, &["objectId", "materialId", "instanceId"])[0];
    let number = |pass: &str, pixel: usize| values::<1>(film, pass)[pixel][0].to_bits();
    let middle = 16 * 8 + 8;
    let numbers = ["objectId", "materialId", "instanceId"].map(|pass| [number(pass, middle), number(pass, 0)]);
    assert_eq!(numbers, [[1, 2], [1, 2], [0, 0]]);
}

#[cfg(target_os = "linux")]
#[test]
fn all_passes_of_a_scene_take_less_memory_than_their_numbers() {
    let folder = Folder::new();
    folder.write("s.toml", crate::common::SMALL_SCENE);
    let peak = |more: &[&str]| {
        let job = [
            "s.toml",
            "--resolution",
            "480x270",
            "--samples",
            "1",
            "-t",
            "2",
            "-q",
            "-o",
            "f.exr",
            "--stats",
            "f.json",
        ];
        folder.succeed(&[&job[..], more].concat());
        let stats: serde_json::Value = serde_json::from_slice(&folder.read("f.json")).expect("JSON");
        stats["frames"][0]["peak_memory_bytes"].as_f64().expect("a number")
    };
    let passes = PassRequest::parse_list(["all"]).expect("a list");
    let film = FilmLayout::new(BEAUTY, &passes, &[String::new()]).expect("a layout");
    let numbers = (480 * 270 * film.bytes_per_pixel()) as f64;
    let growth = peak(&["--aovs", "all"]) - peak(&[]);
    assert!(growth < 0.8 * numbers, "{growth} of {numbers}");
}
