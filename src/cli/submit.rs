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
    batch::{FrameRange, Job},
    error::Error,
    output::{Contents, FilePattern, atomic},
    simd::Isa,
};

use super::{
    args::{Engine, SubmitArgs},
    create::cannot_create,
    progress::say,
    replay::Replay,
    request::request,
};
use task::{Step, Task};

/// Flags that are not passed on: those of `submit` itself, and those that a step gets with values of its own.
const OWN: [&str; 11] = [
    "engine",
    "bundle",
    "chunk",
    "run",
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
    let task = task(args, simd)?;
    fs::create_dir_all(&args.bundle).map_err(|source| cannot_create(source, &args.bundle))?;
    let bundle = fs::canonicalize(&args.bundle).with_context(|| format!("cannot find {}", args.bundle.display()))?;
    let files = match args.engine {
        Engine::Openjd => vec![("template.yaml", openjd::template(&task))],
        Engine::Slurm => {
            let folder = utf8(bundle.as_os_str())?;
            let script = |step: &Step| (step.kind.script(), slurm::script(&task, step, folder));
            task.steps.iter().map(script).collect()
        }
    };
    for (name, text) in files {
        let file = bundle.join(name);
        atomic::write(&file, |out| Ok(out.write_all(text.as_bytes())?)).map_err(Error::Output)?;
        say(&format!("wrote {}", file.display()));
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
    if args.render.part.is_some() {
        return Err(Error::Usage("--part is what the farm's tasks are given: submit the whole job".to_owned()).into());
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
    let job = Job::open(scene, &request(&args.render, simd)?)?;
    let preview = args.render.preview.as_deref();
    let is_picture = |pattern: &FilePattern| pattern.format().contents() == Contents::Picture;
    let has_pictures = job.plan.files.picture.as_ref().is_some_and(is_picture);
    if preview.is_some() && !has_pictures {
        let message =
            "--preview on a farm is made of the PNG files of all tasks: give -o with a name that ends in .png";
        return Err(Error::Usage(message.to_owned()).into());
    }
    let preview = preview.map(|path| utf8(path.as_os_str())).transpose()?;
    let steps = Step::list(args.render.denoise.is_some(), existing.overwrite, preview);
    let arguments = render_arguments(Replay::of_process()?)?;
    if let Some(word) = arguments
        .iter()
        .chain(steps.iter().flat_map(|step| &step.own))
        .find(|word| args.engine == Engine::Openjd && word.contains("{{"))
    {
        return Err(Error::Usage(format!("OpenJD would read a parameter in `{word}`")).into());
    }
    let program = env::current_exe().context("cannot find this program")?;
    let folder = env::current_dir().context("cannot find the current folder")?;
    Ok(Task {
        name: format!("batch-render {}", job.desc.name()),
        folder: utf8(folder.as_os_str())?.to_owned(),
        program: utf8(program.as_os_str())?.to_owned(),
        arguments,
        steps,
        frames: FrameRange::of(job.plan.frames.iter().map(|frame| frame.number.into())),
        chunk: args.chunk,
    })
}

fn utf8(path: &OsStr) -> anyhow::Result<&str> {
    path.to_str()
        .with_context(|| format!("this is not UTF-8, which a farm's file needs: {}", path.display()))
}

/// The arguments of `submit` that are render options and choose no frames.
fn render_arguments(typed: Replay) -> anyhow::Result<Vec<String>> {
    let kept = typed.without(&OWN).arguments();
    kept.iter().map(|word| Ok(utf8(word)?.to_owned())).collect()
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
}
