//! A batch script of Slurm: an array job, each of whose tasks renders a part of the frames, or one task with all of them.

use batch_render::error::Error;

use super::task::{Step, Task};
use crate::cli::replay::quoted;

/// The most tasks of an array by Slurm's default, `MaxArraySize=1001`: the highest index is one less.
const USUAL_TASKS: usize = 1000;

/// Refuses a folder for logs of whose name Slurm makes another one.
pub fn check_folder(bundle: &str) -> Result<(), Error> {
    if bundle.contains(['\\', '"']) {
        let message = format!(
            "Slurm gives logs no numbers in a folder with a backslash or a quote: choose another --bundle: {bundle}"
        );
        return Err(Error::Usage(message));
    }
    Ok(())
}

/// The warning about an array that a cluster with Slurm's default settings refuses.
pub fn warning(task: &Task) -> Option<String> {
    let (tasks, chunk) = (tasks(task), task.frames.len().div_ceil(USUAL_TASKS));
    (tasks > USUAL_TASKS).then(|| {
        format!(
            "an array of {tasks} tasks is more than the {USUAL_TASKS} that many clusters allow (MaxArraySize): use --chunk {chunk}"
        )
    })
}

/// The number of tasks of a step whose tasks render a chunk each.
fn tasks(task: &Task) -> usize {
    task.frames.len().div_ceil(task.chunk as usize).max(1)
}

/// The script of a step, whose tasks write their logs into `bundle`.
pub fn script(task: &Task, step: &Step, bundle: &str) -> String {
    let tasks = tasks(task);
    let (array, log, part) = if step.kind.is_whole() {
        (String::new(), "%j", String::new())
    } else {
        let part = format!(" --part \"$SLURM_ARRAY_TASK_ID/{tasks}\"");
        (format!("#SBATCH --array=1-{tasks}\n"), "%A_%a", part)
    };
    let words: Vec<String> = task.arguments.iter().map(quoted).collect();
    let own: Vec<String> = step.own.iter().map(quoted).collect();
    format!(
        "#!/bin/sh\n\
         # One task of the array renders one part of the frames. A task that is killed or requeued goes on where it stopped.\n\
         #SBATCH --job-name={}\n\
         {array}\
         #SBATCH --chdir={}\n\
         #SBATCH --output={}\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         exec {} {} --range={}{part} {} --progress plain\n",
        option(&task.name),
        option(&task.folder),
        // Slurm replaces `%` and a letter in this name, and `%%` is a plain `%`.
        option(&format!("{}/{log}.log", bundle.replace('%', "%%"))),
        quoted(&task.program),
        words.join(" "),
        task.frames,
        own.join(" "),
    )
}

/// A value of an option in a comment that Slurm reads.
fn option(value: &str) -> String {
    if value.chars().all(|c| c.is_ascii_alphanumeric() || "-_./%".contains(c)) {
        value.to_owned()
    } else {
        format!("\"{}\"", value.replace('\\', "\\\\").replace('"', "\\\""))
    }
}

#[cfg(test)]
mod tests {
    use batch_render::batch::FrameRange;

    use super::*;

    fn task(frames: i64) -> Task {
        Task {
            name: "batch-render my scene".to_owned(),
            folder: "/a b".to_owned(),
            program: "/usr/bin/batch-render".to_owned(),
            arguments: vec!["my scene.toml".to_owned(), "-o".to_owned(), "f.####.exr".to_owned()],
            steps: Step::list(false, false, Some("a film.png")),
            frames: FrameRange::of(1..=frames),
            chunk: 10,
        }
    }

    #[test]
    fn the_script_quotes_what_a_shell_would_split() {
        let task = task(25);
        let [script, last] = [0, 1].map(|step| script(&task, &task.steps[step], "/bundle"));
        assert!(script.contains("#SBATCH --array=1-3\n"), "{script}");
        assert!(script.contains("#SBATCH --chdir=\"/a b\"\n"), "{script}");
        assert!(
            script.contains(
                "'my scene.toml' -o 'f.####.exr' --range=1-25 --part \"$SLURM_ARRAY_TASK_ID/3\" --skip-existing"
            ),
            "{script}"
        );
        assert!(
            last.contains("--range=1-25 --preview='a film.png' --skip-existing") && !last.contains("array="),
            "{last}"
        );
    }

    #[test]
    fn a_percent_sign_of_a_folder_is_no_pattern_of_a_log() {
        let task = task(25);
        let script = script(&task, &task.steps[0], "/b 100%A%j/50%");
        assert!(
            script.contains("#SBATCH --output=\"/b 100%%A%%j/50%%/%A_%a.log\"\n"),
            "{script}"
        );
        assert!(check_folder("/b 100%A%j").is_ok());
        assert!(check_folder("/a\\b").is_err() && check_folder("/a\"b").is_err());
    }

    #[test]
    fn an_array_beyond_the_usual_limit_is_warned_of_with_a_chunk_that_fits() {
        assert_eq!(warning(&task(10_000)), None);
        let large = task(24_001);
        let warning = warning(&large).expect("a warning");
        assert!(
            warning.contains("2401 tasks") && warning.ends_with("--chunk 25"),
            "{warning}"
        );
        assert_eq!(super::warning(&Task { chunk: 25, ..large }), None);
    }
}
