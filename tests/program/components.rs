//! Light sorted by components and by light groups sums to the beauty, and sorting it changes nothing.

use crate::common::Folder;
use batch_render::{
    batch::{Job, Plan, Request},
    describe::Overrides,
    film::{
        Film, PassRequest, PassSpec,
        passes::{PASSES, PassSource},
    },
    render::{Control, Renderer, Settings},
    scene::Scene,
};

/// All lobes: chalk, plastic with a coat and a sheen, metal, clear and frosted glass, a veil; a lamp, a sun, a point light, a sky.
const SCENE: &str = r#"
[render]
width = 32
height = 24
samples = 16
integrator.path = { max_depth = 6 }

[camera]
perspective = { eye = [0, 1.5, 6], target = [0, 0.6, 0], fov = 45 }

[background]
color = [0.2, 0.3, 0.5]
GROUP_DAY

[material]
floor.matte = { albedo = [0.7, 0.6, 0.5], roughness = 0.5 }
car.principled = { base_color = [0.6, 0.1, 0.1], roughness = 0.4, clearcoat = 1, sheen_color = 0.3 }
gold.metal = { preset = "gold", roughness = 0.2 }
clear.glass = {}
frosted.glass = { roughness = 0.4 }
veil.principled = { base_color = [0.2, 0.5, 0.2], opacity = 0.4 }
lamp.emitter = { radiance = [9, 7, 5] }

[[object]]
material = "floor"
shape.quad = { corners = [[-4, 0, -4], [-4, 0, 4], [4, 0, 4], [4, 0, -4]] }
[[object]]
material = "car"
shape.sphere = { center = [-1.6, 0.6, 0], radius = 0.6 }
[[object]]
material = "gold"
shape.sphere = { center = [-0.3, 0.6, -0.5], radius = 0.6 }
[[object]]
material = "clear"
shape.sphere = { center = [0.8, 0.5, 0.8], radius = 0.5 }
[[object]]
material = "frosted"
shape.sphere = { center = [1.7, 0.6, 0], radius = 0.6 }
[[object]]
material = "veil"
shape.disk = { center = [-0.8, 0.8, 1.5], normal = [0, 0, 1], radius = 0.5 }
[[object]]
name = "lamp"
material = "lamp"
GROUP_WARM
shape.sphere = { center = [0, 2.2, -1], radius = 0.3 }

[[light]]
GROUP_DAY
sun = { direction = [-1, -2, -1], irradiance = 1, angle = 2 }
[[light]]
point = { position = [2, 3, 2], intensity = 4 }
"#;

fn film(scene: &Scene, plan: &Plan, passes: &[&str]) -> Film {
    let settings = Settings {
        passes: PassRequest::parse_list(passes.iter().copied()).expect("passes"),
        ..plan.picture.settings.clone()
    };
    Renderer::new()
        .render(
            scene,
            &plan.frames[0].camera,
            plan.picture.integrator.as_dyn(),
            &settings,
            &Control::default(),
        )
        .expect("a film")
}

/// The names of the light components.
fn components() -> Vec<&'static str> {
    let is_component = |spec: &&PassSpec| matches!(spec.source, PassSource::Light(_));
    PASSES.iter().filter(is_component).map(|spec| spec.name).collect()
}

/// The planes of the light groups.
fn group_planes(film: &Film) -> Vec<&[[f32; 3]]> {
    let groups = film
        .planes()
        .iter()
        .filter(|p| matches!(p.spec.pass.source, PassSource::LightGroup));
    groups.map(|p| p.values.as_chunks().0).collect()
}

fn plane<'a>(film: &'a Film, name: &str) -> &'a [[f32; 3]] {
    film.plane(name).expect("a pass").values.as_chunks().0
}

#[test]
fn light_components_and_light_groups_each_sum_to_the_beauty_which_stays_the_same() {
    for integrator in ["path", "whitted"] {
        each_family_sums_to_the_beauty(integrator);
    }
}

fn each_family_sums_to_the_beauty(integrator: &str) {
    let folder = Folder::new();
    let scene_of = |name: &str, day: &str, warm: &str| {
        let text = SCENE.replace("GROUP_DAY", day).replace("GROUP_WARM", warm);
        let request = Request {
            overrides: Overrides::default().with("render.integrator", integrator),
            ..Request::default()
        };
        let job = Job::open(&folder.write(name, &text), &request).expect("a scene");
        (job.compile().expect("a scene"), job.plan)
    };
    let (scene, plan) = scene_of("plain.toml", "", "");
    let plain = film(&scene, &plan, &[]);
    assert_eq!(plain.planes().len(), 1);

    let (scene, plan) = scene_of("groups.toml", "group = 'day'", "group = 'warm'");
    assert_eq!(scene.shading.light_groups.names(), ["", "warm", "day"]);
    let sorted = film(&scene, &plan, &["all"]);
    assert_eq!(sorted.beauty(), plain.beauty(), "passes change the picture");

    let of_components: Vec<_> = components().into_iter().map(|name| plane(&sorted, name)).collect();
    let of_groups = group_planes(&sorted);
    assert_eq!((of_components.len(), of_groups.len()), (6, 3));
    for (family, layers) in [("components", &of_components), ("groups", &of_groups)] {
        for (i, pixel) in sorted.beauty().iter().enumerate() {
            for c in 0..3 {
                let sum: f32 = layers.iter().map(|l| l[i][c]).sum();
                assert!(
                    (sum - pixel[c]).abs() <= 1e-5 * pixel[c].max(0.1),
                    "{integrator}, {family}, pixel {i}: {sum} is not {}",
                    pixel[c]
                );
            }
        }
    }
    for (k, layer) in of_components.iter().chain(&of_groups).enumerate() {
        let mean = layer.iter().flatten().sum::<f32>() / (3 * layer.len()) as f32;
        // Whitted's integrator has no indirect diffuse light where nothing is ambient.
        let is_empty = integrator == "whitted" && components().get(k) == Some(&"diffuse_indirect");
        assert_eq!(mean > 1e-3, !is_empty, "{integrator}: layer {k} has {mean}");
    }
}

#[test]
fn each_light_is_in_its_own_group_and_chalk_alone_is_diffuse() {
    let folder = Folder::new();
    let path = folder.write(
        "s.toml",
        "[render]\nwidth = 8\nheight = 8\nsamples = 4\nintegrator.path = { max_depth = 2 }\n\
         [camera]\northographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 1 }\n\
         [material.wall]\nmatte = { albedo = 0.5 }\n\
         [[object]]\nmaterial = \"wall\"\nshape.quad = { corners = [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]] }\n\
         [[light]]\nsun = { direction = [0, 0, -1], irradiance = 2, angle = 0 }\n\
         [[light]]\ngroup = \"key\"\nsun = { direction = [0, 0, -1], irradiance = 4, angle = 0 }\n",
    );
    let request = Request {
        overrides: Overrides::default().with("render.samples", 256),
        ..Request::default()
    };
    let job = Job::open(&path, &request).expect("a scene");
    let scene = job.compile().expect("a scene");
    let film = film(&scene, &job.plan, &["all"]);
    let mean_of = |layer: &[[f32; 3]]| layer.iter().map(|p| p[0]).sum::<f32>() / layer.len() as f32;
    let mean = |name: &str| mean_of(plane(&film, name));
    // Of one sun E rho / pi.
    let of_sun = |irradiance: f32| irradiance * 0.5 / std::f32::consts::PI;
    assert!((mean("diffuse_direct") - of_sun(6.0)).abs() < 0.01);
    assert!((mean("lightgroup_default") - of_sun(2.0)).abs() < 0.01);
    assert!((mean("lightgroup_key") - of_sun(4.0)).abs() < 0.01);
    assert!(components()[1..].iter().all(|name| mean(name) == 0.0));
}
