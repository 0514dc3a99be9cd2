//! Jobs for farms: the files that `submit` writes do what one local run does.

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE};

const OPTIONS: [&str; 9] = [
    "s.toml",
    "--frames",
    "path.csv",
    "-o",
    "f.#.exr",
    "--resolution",
    "16x12",
    "--samples",
    "2",
];

fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    folder
}

/// Runs a task of `job/frames.sbatch` without Slurm.
fn run_task(folder: &Folder, task: u32) {
    let status = std::process::Command::new("sh")
        .arg(folder.path("job/frames.sbatch"))
        .env("SLURM_ARRAY_TASK_ID", task.to_string())
        .current_dir(folder.path(""))
        .stdout(std::process::Stdio::null())
        .status();
    assert!(status.expect("a shell").success());
}

#[cfg(unix)]
#[test]
fn the_tasks_of_a_batch_script_render_what_one_run_renders() {
    let whole = prepared();
    whole.succeed(&OPTIONS);
    let folder = prepared();
    let said = folder.succeed(
        &[
            &["submit", "--engine", "slurm", "--bundle", "job", "--chunk", "2"],
            &OPTIONS[..],
        ]
        .concat(),
    );
    assert!(
        said.starts_with("wrote ") && said.ends_with("frames.sbatch\n"),
        "{said}"
    );
    let script = String::from_utf8(folder.read("job/frames.sbatch")).expect("UTF-8");
    assert!(script.contains("#SBATCH --array=1-3\n"), "{script}");
    for task in 1..=3 {
        run_task(&folder, task);
    }
    for frame in 1..=5 {
        let name = format!("f.{frame}.exr");
        assert!(folder.read(&name) == whole.read(&name), "{name}");
    }
}

#[test]
fn a_job_template_has_the_frames_the_options_and_the_place() {
    let folder = prepared();
    let submit = ["submit", "--engine", "openjd", "--bundle", "job", "--range=1-5x2"];
    folder.succeed(&[&submit[..], &OPTIONS].concat());
    let template = String::from_utf8(folder.read("job/template.yaml")).expect("UTF-8");
    for line in [
        "specificationVersion: jobtemplate-2023-09",
        "    default: \"1-5:2\"",
        "            - \"s.toml\"",
        "            - \"--range={{Task.Param.Frame}}\"",
        "            - \"--skip-existing\"",
    ] {
        assert!(template.lines().any(|l| l == line), "{line}: {template}");
    }
    let message = folder.fail(2, &[&submit[..5], &["s.toml", "-o", "{{x}}.exr"]].concat());
    assert!(
        message.contains("OpenJD would read a parameter in `--output={{x}}.exr`"),
        "{message}"
    );
    let message = folder.fail(2, &[&submit[..5], &["s.toml", "--part", "1/2"]].concat());
    assert!(message.contains("submit the whole job"), "{message}");
    for flag in ["--fail-existing", "--list-stale"] {
        let message = folder.fail(2, &[&submit[..5], &["s.toml", flag]].concat());
        assert!(message.contains(flag), "{message}");
    }
}

#[test]
fn events_are_a_line_each_and_count_to_the_end() {
    let folder = prepared();
    let said = folder.succeed(&[&OPTIONS[..], &["--progress", "json"]].concat());
    let events: Vec<serde_json::Value> = said
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{line}: {e}")))
        .collect();
    let count = |kind: &str| events.iter().filter(|event| event["event"] == kind).count();
    assert_eq!(
        ["frame_started", "frame_rendered", "file_written", "frame_written"].map(count),
        [5; 4]
    );
    let said = folder.succeed(&[&OPTIONS[..], &["--progress", "openjd", "--skip-existing"]].concat());
    let progress: Vec<&str> = said
        .lines()
        .filter_map(|l| l.strip_prefix("openjd_progress: "))
        .collect();
    assert_eq!(progress, ["20.0", "40.0", "60.0", "80.0", "100.0"]);
}

/// A script with a second range fails in every task.
#[test]
fn a_range_among_bundled_flags_becomes_that_of_the_tasks() {
    let folder = prepared();
    let job = ["submit", "--engine", "openjd", "--bundle", "job"];
    folder.succeed(&[&job[..], &["s.toml", "--turntable", "5", "-vr", "1-5"]].concat());
    let template = String::from_utf8(folder.read("job/template.yaml")).expect("UTF-8");
    assert_eq!(template.matches("--range=").count(), 1, "{template}");
    assert!(template.contains("default: \"1-5\""), "{template}");
}

/// Every task would overwrite the film of the others with its own frames.
#[cfg(unix)]
#[test]
fn a_preview_is_made_by_a_step_after_all_tasks() {
    let folder = prepared();
    let job = [
        "--resolution",
        "16x12",
        "--samples",
        "2",
        "-o",
        "f.#.png",
        "--preview",
        "film.png",
    ];
    let job = [&OPTIONS[..3], &job].concat();
    for engine in ["slurm", "openjd"] {
        let submit = ["submit", "--engine", engine, "--bundle", "job", "--chunk", "2"];
        folder.succeed(&[&submit[..], &job].concat());
        let arrays = ["-o", "f.#.npz", "--preview", "film.png"];
        let message = folder.fail(2, &[&submit[..], &OPTIONS[..3], &arrays].concat());
        assert!(message.contains("made of the files of all tasks"), "{message}");
    }
    let template = String::from_utf8(folder.read("job/template.yaml")).expect("UTF-8");
    assert_eq!(template.matches("film.png").count(), 1, "{template}");
    let (tasks, last) = template.split_once("  - name: Preview\n").expect("a step");
    assert!(
        !tasks.contains("film.png") && last.starts_with("    dependencies:\n      - dependsOn: Render\n    script:")
    );
    assert!(
        last.contains("--range={{Param.Frames}}") && last.contains("--preview=film.png"),
        "{last}"
    );
    for (script, task) in [("frames", "1"), ("frames", "2"), ("frames", "3"), ("preview", "")] {
        assert!(folder.names().iter().all(|name| name != "film.png"));
        let status = std::process::Command::new("sh")
            .arg(folder.path(&format!("job/{script}.sbatch")))
            .env("SLURM_ARRAY_TASK_ID", task)
            .current_dir(folder.path(""))
            .stdout(std::process::Stdio::null())
            .status();
        assert!(status.expect("a shell").success());
    }
    let film = std::io::BufReader::new(std::fs::File::open(folder.path("film.png")).expect("it is there"));
    let film = png::Decoder::new(film).read_info().expect("a PNG");
    assert_eq!(film.info().animation_control.expect("it is animated").num_frames, 5);
}

#[test]
fn flags_of_jobs_that_render_nothing_reach_no_task() {
    let folder = prepared();
    for flag in ["--check", "--dry-run"] {
        let message = folder.fail(2, &["submit", "--engine", "slurm", "--bundle", "job", "s.toml", flag]);
        assert!(
            message.contains(&format!("{flag} renders nothing, and a farm is to render")),
            "{message}"
        );
        assert!(!folder.path("job").exists());
    }
}

/// A line break in a comment of the script would make the rest of the name a command.
#[cfg(unix)]
#[test]
fn names_with_control_characters_reach_no_script() {
    let folder = prepared();
    folder.write("a\ntouch INJECTED\n#.toml", SMALL_SCENE);
    for engine in ["slurm", "openjd"] {
        let submit = ["submit", "--engine", engine, "--bundle", "job"];
        for job in [
            &["a\ntouch INJECTED\n#.toml"][..],
            &["s.toml", "-o", "o\n/f.exr"],
            &["s.toml", "-o", "f\t.exr"],
        ] {
            let message = folder.fail(2, &[&submit[..], job].concat());
            assert!(message.contains("control character"), "{message}");
        }
    }
    assert!(!folder.path("job").exists());
    let message = folder.fail(2, &["submit", "--engine", "slurm", "--bundle", "b\nexit", "s.toml"]);
    assert!(message.contains("control character"), "{message}");
    assert!(!folder.path("b\nexit/frames.sbatch").exists());
}

/// Slurm runs on Unix alone: a folder with backslashes is refused.
#[cfg(unix)]
#[test]
fn an_array_that_many_clusters_refuse_is_warned_of() {
    let folder = prepared();
    let submit = [
        "submit", "--engine", "slurm", "--bundle", "50%j", "--chunk", "2", "s.toml", "-o", "f.#.exr",
    ];
    let output = folder.run(&[&submit[..], &["--turntable", "2400"]].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && said.contains("--chunk 3"), "{said}");
    let script = String::from_utf8(folder.read("50%j/frames.sbatch")).expect("UTF-8");
    assert!(script.contains("/50%%j/%A_%a.log\n"), "{script}");
}

#[test]
fn jobs_that_no_task_could_render_are_refused() {
    let folder = prepared();
    folder.write(
        "round.toml",
        "[camera]\npanorama = { eye = [0, 0, 5], target = [0, 0, 0] }\n",
    );
    folder.write(
        "flat.toml",
        "[camera]\northographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 4 }\n",
    );
    for (job, expected) in [
        (
            &["s.toml", "--stereo", "ipd=0.1", "-o", "f.#.exr"][..],
            "both eyes would write f.#.exr",
        ),
        (
            &["round.toml", "--stereo", "ipd=0.1,convergence=2", "-o", "{eye}.exr"],
            "do not converge",
        ),
        (
            &["flat.toml", "--stereo", "ipd=0.1", "-o", "{eye}.exr"],
            "the two eyes of an orthographic camera",
        ),
        (
            &["s.toml", "-o", "{eye}.exr"],
            "{eye} is the eye of --stereo, which is missing",
        ),
    ] {
        let message = folder.fail(2, &[&["submit", "--engine", "slurm", "--bundle", "job"], job].concat());
        assert!(message.contains(expected), "{message}");
        assert!(!folder.path("job").exists());
    }
}

#[test]
fn the_help_of_submit_offers_nothing_that_it_refuses() {
    let folder = Folder::new();
    let help = folder.succeed(&["submit", "--help"]);
    let words: Vec<&str> = help.split_whitespace().collect();
    for flag in [
        "[SCENE]...",
        "--check",
        "--dry-run",
        "--list-stale",
        "--fail-existing",
        "--part",
        "--input-format",
    ] {
        assert!(!words.contains(&flag), "{flag}");
    }
    assert!(words.contains(&"--stereo") && words.contains(&"--skip-existing"));
}

#[cfg(unix)]
#[test]
fn tasks_render_both_eyes_of_their_frames() {
    let (folder, whole) = (prepared(), prepared());
    let stereo = [
        "--stereo",
        "ipd=0.1",
        "--frames",
        "path.csv",
        "--resolution",
        "16x12",
        "--samples",
        "2",
    ];
    let stereo = [&["s.toml", "-o", "{scene}/{eye}.#.exr"], &stereo[..]].concat();
    whole.succeed(&stereo);
    let submit = ["submit", "--engine", "slurm", "--bundle", "job", "--chunk", "3"];
    folder.succeed(&[&submit[..], &stereo].concat());
    for task in 1..=2 {
        run_task(&folder, task);
    }
    for name in ["s/left.1.exr", "s/right.1.exr", "s/left.5.exr", "s/right.5.exr"] {
        assert!(folder.read(name) == whole.read(name), "{name}");
    }
}
