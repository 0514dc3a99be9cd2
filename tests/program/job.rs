//! Jobs by the library: what they read, and what they do where their files are whole already.

use std::{
    path::{Path, PathBuf},
    sync::Mutex,
};

use crate::common::{Folder, repo, stderr};
use batch_render::{
    assets::ContentHash,
    batch::{Existing, Job, JobEvent, Observer, Policy, Request, Summary},
    describe::Overrides,
    error::Error,
    render::Control,
    warnings::WarningKind,
};

/// Records which frames were skipped.
#[derive(Default)]
struct Skipped(Mutex<Vec<i32>>);

impl Observer for Skipped {
    fn event(&self, event: &JobEvent<'_>) {
        if let JobEvent::FrameSkipped { frame } = event {
            self.0.lock().expect("not poisoned").push(*frame);
        }
    }
}

const CAMERA: &str = "[render]\nwidth = 8\nheight = 8\nsamples = 1\n\
    [camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n";

fn scene(scale: &str) -> String {
    format!("{CAMERA}[[object]]\nshape.mesh = {{ file = 'a.obj' }}\ntransform = {{ scale = {scale} }}\n")
}

fn run(scene: &Path, request: &Request) -> Result<(Summary, Vec<i32>), Error> {
    let (job, skipped) = (Job::open(scene, request)?, Skipped::default());
    let summary = job.run(job.load()?, &skipped, &Control::default())?;
    Ok((summary, skipped.0.into_inner().expect("not poisoned")))
}

#[test]
fn a_job_whose_frames_are_whole_builds_no_acceleration_structure() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let path = folder.write("s.toml", &scene("2"));
    let request = Request {
        turntable: Some("3".parse().expect("a number of frames")),
        overrides: Overrides::default().with("output.files", &*folder.path("f.####.exr").to_string_lossy()),
        policy: Policy {
            existing: Existing::Skip,
            ..Policy::default()
        },
        ..Request::default()
    };
    let (summary, skipped) = run(&path, &request).expect("renders");
    assert_eq!((summary.rendered, skipped.len()), (3, 0));
    assert!(summary.scene.build_time.is_some());

    let (summary, skipped) = run(&path, &request).expect("nothing to render");
    assert_eq!((summary.rendered, summary.skipped), (0, 3));
    assert_eq!(skipped, [1, 2, 3]);
    assert_eq!((summary.scene.triangles, summary.scene.build_time), (1, None));

    // A frame that is cut short has to be rendered again.
    let cut = folder.path("f.0002.exr");
    let bytes = std::fs::read(&cut).expect("readable");
    std::fs::write(&cut, &bytes[..bytes.len() - 1]).expect("writable");
    let (summary, skipped) = run(&path, &request).expect("renders");
    assert_eq!((summary.rendered, skipped), (1, vec![1, 3]));
    assert!(summary.scene.build_time.is_some());

    // Of a scene that loads, but over which nothing can be built, these are not the frames.
    let huge = folder.write("s.toml", &scene("1e15"));
    assert!(matches!(run(&huge, &request), Err(Error::Compile(_))));
}

#[test]
fn the_manifest_names_every_file_that_a_picture_depends_on() {
    let folder = Folder::new();
    let texture: Vec<u8> = b"P".to_vec();
    std::fs::write(folder.path("t.png"), texture).expect("writable");
    folder.write("a.mtl", "newmtl m\nmap_Kd t.png\n");
    folder.write(
        "a.obj",
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n",
    );
    let csv = folder.write("path.csv", crate::common::SMALL_PATH);
    let path = folder.write("s.toml", &scene("2"));
    let request = Request {
        camera_path: Some(csv),
        missing_assets: batch_render::assets::store::MissingAssets::Placeholder,
        ..Request::default()
    };
    let job = Job::open(&path, &request).expect("a scene");
    job.load().expect("a placeholder for the texture");
    let names: Vec<PathBuf> = job.files().manifest().into_iter().map(|(p, _)| p).collect();
    let expected = ["a.mtl", "a.obj", "path.csv", "s.toml", "t.png"].map(|name| folder.path(name));
    assert_eq!(names, expected);
    let (_, hash) = job.files().manifest()[3].clone();
    assert_eq!(hash, ContentHash::of(scene("2").as_bytes()));
}

/// Models of which each has a triangle without area, and a texture that is missing.
fn flawed(folder: &Folder) -> PathBuf {
    folder.write("a.mtl", "newmtl m\nmap_Kd none.png\nKd x\n");
    let objects = ["d", "b", "a", "c", "e"].map(|name| {
        let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\nf 1/1 1/1 2/1\n";
        folder.write(&format!("{name}.obj"), text);
        format!("[[object]]\nshape.mesh = {{ file = '{name}.obj' }}\n")
    });
    folder.write("s.toml", &format!("{CAMERA}{}", objects.concat()))
}

#[test]
fn an_embedding_program_reads_the_warnings_of_a_job() {
    let folder = Folder::new();
    let path = flawed(&folder);
    let load = |threads| {
        let request = Request::default();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| Job::open(&path, &request)?.load()).expect("loads");
        request.warnings
    };
    let warnings = load(1);
    let all = warnings.list();
    let of = |kind| {
        all.iter()
            .filter(|w| w.kind == kind)
            .map(|w| &*w.subject)
            .collect::<Vec<_>>()
    };
    let files = ["a", "b", "c", "d", "e"].map(|name| folder.path(&format!("{name}.obj")).display().to_string());
    assert_eq!(of(WarningKind::NO_AREA), files);
    assert_eq!(of(WarningKind::MISSING_FILE).len(), 5);
    assert_eq!(of(WarningKind::STATEMENT), [folder.path("a.mtl").display().to_string()]);
    assert_eq!(warnings.lines().len(), 3);
    assert_eq!(load(4).list(), all);
}

#[test]
fn the_program_prints_a_kind_of_warning_once_and_lists_all_for_programs() {
    let folder = Folder::new();
    flawed(&folder);
    let check = folder.run(&["check", "s.toml", "--json"]);
    let said = stderr(&check);
    assert_eq!(said.lines().count(), 3, "{said}");
    let line = "warning: 1 triangle without area left out: a.obj (and 4 more like this: b.obj, c.obj, d.obj, ...)";
    assert!(said.contains(line), "{said}");
    let inventory: serde_json::Value = serde_json::from_slice(&check.stdout).expect("JSON");
    let listed = |of: &serde_json::Value| of["warnings"].as_array().map(Vec::len);
    assert_eq!(listed(&inventory), Some(11));
    assert_eq!(inventory["warnings"][0]["kind"], "missing-file");
    folder.succeed(&["s.toml", "-o", "f.exr", "--stats", "stats.json"]);
    let stats = std::fs::read(folder.path("stats.json")).expect("figures");
    // And that there is no light.
    assert_eq!(listed(&serde_json::from_slice(&stats).expect("JSON")), Some(12));
}

#[test]
fn the_manual_lists_every_kind_of_warning() {
    let manual = std::fs::read_to_string(repo("docs/interface.md")).expect("the manual");
    for kind in WarningKind::ALL {
        assert!(manual.contains(&format!("| `{}` |", kind.name())), "{}", kind.name());
    }
}

#[test]
fn every_material_that_gains_energy_is_among_the_warnings() {
    let request = Request::default();
    let job = Job::open(&repo("tests/bad/albedo_above_one.toml"), &request).expect("a scene");
    job.load().expect("loads");
    let all = request.warnings.list();
    let gains = all.iter().filter(|w| w.kind == WarningKind::ENERGY_GAIN);
    let gains: Vec<String> = gains
        .map(|w| format!("{} {}", w.subject, w.text.rsplit(' ').next().unwrap_or("")))
        .collect();
    let expected = [
        "car 1.1)",
        "chalk 1.25)",
        "flare 1.75)",
        "gold 1.5)",
        "mirror 1.2)",
        "plastic 2)",
        "poster 65504)",
        "tiles 1.4)",
        "window 3)",
    ];
    assert_eq!(gains, expected);
}
