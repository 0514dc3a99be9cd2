//! Vertices that are shaded in batches, beside the same shaded one by one.

use crate::common::Folder;
use batch_render::{
    batch::{Job, Request},
    describe::Overrides,
    integrator::{Integrator, ShadingOutput, VertexContext},
    render::{Control, Renderer},
    sampler::Draw,
    scene::Scene,
};

/// An integrator whose vertices are shaded one by one.
struct OneByOne<'a>(&'a dyn Integrator);

impl Integrator for OneByOne<'_> {
    fn vertex(&self, context: &VertexContext<'_>, out: &mut ShadingOutput) {
        self.0.vertex(context, out);
    }

    fn batched_draws(&self, scene: &Scene, depth: u32) -> Vec<Draw> {
        self.0.batched_draws(scene, depth)
    }
}

/// Matte things of all kinds, a mirror, a thin pane, and `lights`.
fn scene(integrator: &str, lights: &str) -> String {
    format!(
        "[render]\nwidth = 40\nheight = 24\nsamples = 4\n{integrator}\n\
         [camera]\nperspective = {{ eye = [0, 1, 6], target = [0, 0, 0] }}\n\
         [texture.squares]\nchecker = {{ a = [0.9, 0.6, 0.3], b = 0, scale = 9 }}\n\
         [material.floor]\nmatte = {{ albedo = \"texture.squares\" }}\n\
         [material.wall]\nmatte = {{ albedo = [0.7, 0.5, 0.4] }}\n\
         [material.clay]\nmatte = {{ albedo = 0.5, roughness = 0.7 }}\n\
         [material.plastic]\nprincipled = {{ base_color = 0.4 }}\n\
         [material.worn]\nprincipled = {{ base_color = \"texture.squares\", roughness = \"texture.squares\", \
         metallic = 0.6, clearcoat = 0.8, clearcoat_roughness = 0.2 }}\n\
         [material.lacquer]\nprincipled = {{ base_color = [0.6, 0.1, 0.1], clearcoat = 1 }}\n\
         [material.gold]\nmetal = {{ color = [1, 0.78, 0.34], roughness = 0.3 }}\n\
         [material.iron]\nmetal = {{ eta = [2.9, 2.9, 2.6], k = [3.1, 2.9, 2.8], roughness = \"texture.squares\" }}\n\
         [material.mirror]\nmirror = {{}}\n\
         [material.pane]\nglass = {{ thin_walled = true }}\n\
         [material.lamp]\nemitter = {{ radiance = [9, 8, 6] }}\n\
         [[object]]\nmaterial = \"floor\"\n\
         shape.quad = {{ corners = [[-5, -1, -5], [-5, -1, 5], [5, -1, 5], [5, -1, -5]] }}\n\
         [[object]]\nmaterial = \"wall\"\nshape.sphere = {{ center = [-1.5, 0, 0], radius = 1 }}\n\
         [[object]]\nmaterial = \"clay\"\nshape.sphere = {{ center = [0.5, -0.4, 1], radius = 0.6 }}\n\
         [[object]]\nmaterial = \"plastic\"\nshape.sphere = {{ center = [2, -0.3, 0.5], radius = 0.7 }}\n\
         [[object]]\nmaterial = \"worn\"\nshape.cylinder = {{ base = [-0.5, -1, 1.5], radius = 0.3, height = 1 }}\n\
         [[object]]\nmaterial = \"lacquer\"\nshape.sphere = {{ center = [2, 1, 0.5], radius = 0.4 }}\n\
         [[object]]\nmaterial = \"gold\"\nshape.sphere = {{ center = [0, 0.6, 0], radius = 0.4 }}\n\
         [[object]]\nmaterial = \"iron\"\nshape.sphere = {{ center = [-2.5, 0.8, 0.5], radius = 0.4 }}\n\
         [[object]]\nmaterial = \"mirror\"\nshape.sphere = {{ center = [1, 0.5, -2], radius = 1 }}\n\
         [[object]]\nmaterial = \"pane\"\n\
         shape.quad = {{ corners = [[-3, -1, 2], [-1, -1, 2], [-1, 1, 2], [-3, 1, 2]] }}\n\
         {lights}"
    )
}

const LAMP: &str = "[[object]]\nmaterial = \"lamp\"\n\
                    shape.quad = { corners = [[-1, 3, -1], [1, 3, -1], [1, 3, 1], [-1, 3, 1]] }\n";
const NEAR_LAMP: &str = "[[object]]\nmaterial = \"lamp\"\n\
                         shape.quad = { corners = [[3, -1, -1], [3, 0, -1], [3, 0, 1], [3, -1, 1]] }\n";
const OTHERS: &str = "[[light]]\ngroup = \"bulbs\"\npoint = { position = [-3, 2, 2], intensity = 10 }\n\
                      [[light]]\nsun = { direction = [-1, -1, -0.5], irradiance = 2, angle = 2 }\n\
                      [[light]]\nsun = { direction = [1, -1, -0.5], irradiance = 1 }\n";

#[test]
fn vertices_in_batches_are_shaded_as_one_by_one() {
    let folder = Folder::new();
    let path = "integrator.path = { max_depth = 7, roulette_depth = 2 }";
    let clamped = "integrator.path = { clamp_direct = 0.5, clamp_indirect = 0.3, strategy = \"light\" }";
    let all = format!("[background]\ncolor = 0.3\n{LAMP}{NEAR_LAMP}{OTHERS}");
    let scenes = [
        (path, LAMP),
        (path, NEAR_LAMP),
        (path, OTHERS),
        (path, &all),
        (clamped, &all),
        ("integrator.path = { strategy = \"bsdf\" }", &all),
    ];
    for (integrator, lights) in scenes {
        let file = folder.write("s.toml", &scene(integrator, lights));
        for overrides in [Overrides::default(), Overrides::default().with("output.aovs", "all")] {
            let request = Request {
                overrides,
                ..Request::default()
            };
            let job = Job::open(&file, &request).expect("a job");
            let scene = job.compile().expect("a scene");
            let [batches, single] = [
                job.plan.picture.integrator.as_dyn(),
                &OneByOne(job.plan.picture.integrator.as_dyn()),
            ]
            .map(|by| {
                let (camera, settings) = (&job.plan.frames[0].camera, &job.plan.picture.settings);
                let film = Renderer::new().render(&scene, camera, by, settings, &Control::default());
                let film = film.expect("a picture");
                let planes = film.planes().iter().map(|plane| plane.values.clone());
                planes.collect::<Vec<_>>()
            });
            assert!(batches.iter().flatten().any(|v| *v > 0.0));
            assert!(batches == single, "{integrator} {lights}");
        }
    }
}
