//! `batch-render submit`: the files with which a farm renders a job.
//!
//! The farm runs this program with the same render options, on parts of the frames. Nothing is rendered here, but the scene is read
//! and the frames are known.

mod openjd;
mod slurm;
mod task;

use std::{
    env,
    ffi::OsStr,
    fs,
    path::Path,
    process::{Command, Stdio},
};

use anyhow::{Context, bail};
use batch_render::{
    batch::{FrameRange, Job, shows_finished},
    error::Error,
    output::atomic,
    simd::Isa,
};

use super::{
    args::{Engine, SubmitArgs},
    create::cannot_create,
    outlets::Outlets,
    progress::say,
    replay::Replay,
    request::request,
    turns::{Written, refuse_shared_names, turns},
};
use task::{Step, Task};

/// Flags of `submit` itself.
const FARM: [&str; 4] = ["engine", "bundle", "chunk", "run"];

/// Flags that are not passed on beside these: a step gets them with values of its own.
const OF_STEPS: [&str; 7] = [
    "range",
    "part-base",
    "progress",
    "denoise-step",
    "skip-existing",
    "overwrite",
    "preview",
];

/// Writes the bundle, and starts it if that is asked for.
pub fn run(args: &SubmitArgs, simd: Isa) -> anyhow::Result<()> {
    args.render.settings.refuse_stream()?;
    if args.render.input_format.is_some() {
        let message = "--input-format: the scene of a farm is a file, and not on standard input";
        return Err(Error::Usage(message.to_owned()).into());
    }
    if cfg!(windows) && args.engine == Engine::Slurm {
        let message =
            "--engine slurm: scripts of Slurm are for Linux, and so are the paths in them: submit from a Linux machine";
        return Err(Error::Usage(message.to_owned()).into());
    }
    let task = task(args, simd)?;
    if args.engine == Engine::Openjd {
        openjd::check(&task)?;
    }
    fs::create_dir_all(&args.bundle).map_err(|source| cannot_create(source, &args.bundle))?;
    let bundle = std::path::absolute(&args.bundle).with_context(|| format!("cannot find {}", args.bundle.display()))?;
    let files = match args.engine {
        Engine::Openjd => vec![("template.yaml", openjd::template(&task))],
        Engine::Slurm => {
            let folder = farm_text(bundle.as_os_str())?;
            slurm::check_folder(folder)?;
            let script = |step: &Step| (step.kind.script(), slurm::script(&task, step, folder));
            task.steps.iter().map(script).collect()
        }
    };
    let files: Vec<_> = files
        .into_iter()
        .map(|(name, text)| (bundle.join(name), text))
        .collect();
    atomic::write_together(&files).map_err(Error::Output)?;
    for (file, _) in &files {
        say(&format!("wrote {}", file.display()));
    }
    if args.engine == Engine::Slurm
        && let Some(warning) = slurm::warning(&task)
    {
        tracing::warn!("{warning}");
    }
    if !args.run {
        return Ok(());
    }
    match args.engine {
        Engine::Openjd => {
            let last = task.steps.last().expect("a job renders").kind.name();
            let mut command = Command::new("openjd");
            command
                .arg("run")
                .arg(bundle.join("template.yaml"))
                .args(["--step", last]);
            if task.steps.len() > 1 {
                command.arg("--run-dependencies");
            }
            succeed(&mut command)
        }
        Engine::Slurm => run_slurm(&task, &bundle),
    }
}

/// Hands the steps to Slurm, each to begin when the one before has succeeded.
fn run_slurm(task: &Task, bundle: &Path) -> anyhow::Result<()> {
    let mut before: Option<String> = None;
    for step in &task.steps {
        let mut command = Command::new("sbatch");
        command.arg("--parsable");
        command.args(before.map(|id| format!("--dependency=afterok:{id}")));
        let output = command
            .arg(bundle.join(step.kind.script()))
            .stderr(Stdio::inherit())
            .output();
        let output = output.context("cannot start `sbatch`")?;
        if !output.status.success() {
            bail!("`sbatch` has failed: {}", output.status);
        }
        // The number of the job, and the cluster's name after a semicolon where there are several.
        let said = String::from_utf8_lossy(&output.stdout);
        let id = said.trim().split(';').next().unwrap_or_default().to_owned();
        say(&format!("submitted job {id}"));
        before = Some(id);
    }
    Ok(())
}

fn succeed(command: &mut Command) -> anyhow::Result<()> {
    let name = command.get_program().to_string_lossy().into_owned();
    let status = command.status().with_context(|| format!("cannot start `{name}`"))?;
    if !status.success() {
        bail!("`{name}` has failed: {status}");
    }
    Ok(())
}

fn task(args: &SubmitArgs, simd: Isa) -> anyhow::Result<Task> {
    let scene = args.render.scene.as_deref().expect("the scene is a required argument");
    if !args.render.more.is_empty() {
        return Err(Error::Usage("a job of a farm has one scene: submit each by itself".to_owned()).into());
    }
    if args.render.part.is_some() {
        return Err(Error::Usage("--part is what the farm's tasks are given: submit the whole job".to_owned()).into());
    }
    if args.render.check || args.render.dry_run {
        let flag = if args.render.check { "check" } else { "dry-run" };
        let message = format!("--{flag} renders nothing, and a farm is to render: use it without submit");
        return Err(Error::Usage(message).into());
    }
    let existing = &args.render.existing;
    if existing.fail_existing || existing.list_stale {
        let flag = if existing.fail_existing {
            "fail-existing"
        } else {
            "list-stale"
        };
        let message = format!("--{flag} is not for a farm: each task skips the frames that it finds finished");
        return Err(Error::Usage(message).into());
    }
    let typed = Replay::of_process()?;
    let turns = turns(&args.render, &typed.clone().without(&FARM))?;
    refuse_shared_names(&turns, &[], simd)?;
    let mut written = Written::default();
    let jobs = turns.iter().map(|own| -> Result<Job, Error> {
        let job = Job::open(scene, &request(&own.args, &Outlets::new(&own.args)?, simd)?)?;
        job.check_files()?;
        written.add(scene, &job.plan, &[])?;
        Ok(job)
    });
    let jobs: Vec<Job> = jobs.collect::<Result<_, _>>()?;
    // Both eyes have the same frames.
    let job = &jobs[0];
    let preview = args.render.preview.as_deref();
    if preview.is_some() && !shows_finished(&job.plan) {
        let message = "--preview on a farm is made of the files of all tasks: name some that can be shown, PNG, JPEG or EXR \
                       (-o f.####.png), and with --show and --exposure auto not EXR alone";
        return Err(Error::Usage(message.to_owned()).into());
    }
    let preview = preview.map(|path| farm_text(path.as_os_str())).transpose()?;
    let steps = Step::list(args.render.denoise.is_some(), existing.overwrite, preview);
    let arguments = render_arguments(typed)?;
    let program = env::current_exe().context("cannot find this program")?;
    let folder = env::current_dir().context("cannot find the current folder")?;
    Ok(Task {
        name: Task::name_of(&job.desc.name()),
        folder: farm_text(folder.as_os_str())?.to_owned(),
        program: farm_text(program.as_os_str())?.to_owned(),
        arguments,
        steps,
        frames: FrameRange::of(job.plan.frames.iter().map(|frame| frame.number.into())),
        chunk: args.chunk,
    })
}

/// The text of a path or an argument, as it stands in a farm's file.
///
/// # Errors
/// It is not UTF-8, or has control characters or line separators: text after a line break would be a command of the script.
fn farm_text(word: &OsStr) -> anyhow::Result<&str> {
    let text = word
        .to_str()
        .with_context(|| format!("this is not UTF-8, which a farm's file needs: {}", word.display()))?;
    let is_refused = |c: &char| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}');
    match text.chars().find(is_refused) {
        Some(c) => Err(Error::Usage(format!(
            "a farm's file cannot hold the control character {c:?}: {text:?}"
        ))
        .into()),
        None => Ok(text),
    }
}

/// The arguments of `submit` that are render options and choose no frames.
fn render_arguments(typed: Replay) -> anyhow::Result<Vec<String>> {
    let kept = typed.without(&FARM).without(&OF_STEPS).arguments();
    kept.iter().map(|word| Ok(farm_text(word)?.to_owned())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn render_options_are_passed_on_and_the_farm_chooses_the_frames() {
        let typed = "b submit --engine slurm --bundle=out --chunk 5 s.toml --frames p.csv -vr 1-9 --samples 4 --run --overwrite --preview f.png";
        let replay = Replay::parse(typed.split(' ').map(Into::into)).expect("the command line is right");
        let mut kept = render_arguments(replay).expect("UTF-8");
        kept.sort();
        assert_eq!(kept, ["--frames=p.csv", "--samples=4", "--verbose", "s.toml"]);
    }

    #[test]
    fn no_control_character_gets_into_the_file_of_a_farm() {
        for c in [
            '\0', '\t', '\n', '\r', '\u{1b}', '\u{7f}', '\u{85}', '\u{2028}', '\u{2029}',
        ] {
            let error = farm_text(format!("a{c}b").as_ref()).expect_err("refused");
            assert!(error.to_string().contains(&format!("{c:?}")), "{error}");
        }
        for text in ["", "50% {a} 'b' \"c\" $d", "ünï漢🎬"] {
            assert_eq!(farm_text(text.as_ref()).expect("text"), text);
        }
    }
}
