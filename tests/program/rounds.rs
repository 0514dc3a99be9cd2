//! A frame that is rendered in rounds of samples is the same frame, is there early, and stops when it is told to.

use std::sync::{Mutex, atomic::AtomicUsize, atomic::Ordering};
use std::time::Duration;

use crate::common::{Folder, SMALL_SCENE};
use batch_render::{
    batch::{Job, Request},
    describe::Overrides,
    film::{Film, FilmLayout, passes::BEAUTY},
    render::{
        Cancel, Cancelled, Control, Counters, RenderError, Renderer, SampleBudget, Settings, TileResult, TileSink,
    },
    scene::Scene,
};

struct Small {
    job: Job,
    scene: Scene,
}

impl Small {
    /// A scene of 20 samples with all passes.
    fn new() -> Self {
        let folder = Folder::new();
        let request = Request {
            overrides: Overrides::default().with("output.aovs", "all"),
            ..Request::default()
        };
        let job = Job::open(&folder.write("s.toml", SMALL_SCENE), &request).expect("a scene");
        let scene = job.compile().expect("a scene");
        Self { job, scene }
    }

    fn render(&self, renderer: &Renderer, samples: SampleBudget, control: &Control<'_>) -> Result<Film, RenderError> {
        let plan = &self.job.plan;
        let settings = Settings {
            samples,
            ..plan.picture.settings.clone()
        };
        renderer.render(
            &self.scene,
            &plan.frames[0].camera,
            plan.picture.integrator.as_dyn(),
            &settings,
            control,
        )
    }
}

fn bits(film: &Film) -> Vec<Vec<u32>> {
    let plane = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect();
    film.planes().iter().map(|p| plane(&p.values)).collect()
}

/// The bits of the passes that do not depend on how many samples are to come: which half a sample is in does.
fn bits_so_far(film: &Film) -> Vec<Vec<u32>> {
    let is_by_halves = |i: &usize| film.planes()[*i].spec.pass.is_by_halves();
    let all = bits(film).into_iter().enumerate();
    all.filter(|(i, _)| !is_by_halves(i)).map(|(_, plane)| plane).collect()
}

#[test]
fn rounds_do_not_change_a_bit_of_any_pass() {
    let (small, renderer) = (Small::new(), Renderer::new());
    let once = small
        .render(&renderer, SampleBudget::fixed(20), &Control::default())
        .expect("a film");
    for budget in [
        SampleBudget::progressive(20),
        SampleBudget {
            min: 7,
            ..SampleBudget::fixed(20)
        },
        SampleBudget {
            doubles: true,
            ..SampleBudget::fixed(20).within(Duration::MAX)
        },
    ] {
        // The renderer's memory of the frame before must not show.
        let film = small.render(&renderer, budget, &Control::default()).expect("a film");
        assert!(bits(&film) == bits(&once), "{budget:?}");
    }
}

/// Keeps the picture of the first round.
struct FirstRound {
    film: Mutex<Film>,
    tiles: AtomicUsize,
}

impl TileSink for FirstRound {
    fn tile(&self, tile: &TileResult<'_>) {
        if tile.samples.start == 0 {
            tile.resolve_into(&mut self.film.lock().expect("a film"));
        }
        self.tiles.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn the_first_round_is_the_picture_of_its_samples() {
    let (small, renderer) = (Small::new(), Renderer::new());
    let settings = &small.job.plan.picture.settings;
    let layout = FilmLayout::new(BEAUTY, &settings.passes, small.scene.shading.light_groups.names()).expect("a layout");
    let sink = FirstRound {
        film: Mutex::new(Film::new(settings.resolution, settings.window, &layout)),
        tiles: AtomicUsize::new(0),
    };
    let counters = Counters::default();
    let control = Control {
        counters: Some(&counters),
        sink: Some(&sink),
        ..Control::default()
    };
    small
        .render(
            &renderer,
            SampleBudget {
                min: 4,
                ..SampleBudget::fixed(20)
            },
            &control,
        )
        .expect("a film");
    let four = small
        .render(&renderer, SampleBudget::fixed(4), &Control::default())
        .expect("a film");
    let first = sink.film.into_inner().expect("a film");
    assert!(bits_so_far(&first) == bits_so_far(&four));
    assert!(bits_so_far(&four).len() > 20);
    // Rounds of 4, 4, 8 and 4 samples.
    assert_eq!(sink.tiles.into_inner() % 4, 0);
    assert_eq!(counters.samples(), 20 * settings.window.area() as u64);
}

#[test]
fn a_cancelled_frame_is_given_up_and_the_renderer_goes_on() {
    let (small, renderer, cancel) = (Small::new(), Renderer::new(), Cancel::default());
    cancel.cancel();
    let control = Control {
        cancel: Some(&cancel),
        ..Control::default()
    };
    let given_up = small.render(&renderer, SampleBudget::fixed(20), &control);
    assert_eq!(given_up.err(), Some(RenderError::Cancelled(Cancelled)));
    assert!(
        small
            .render(&renderer, SampleBudget::fixed(1), &Control::default())
            .is_ok()
    );
}
