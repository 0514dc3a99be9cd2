//! A batch script of Slurm: an array job, each of whose tasks renders a part of the frames, or one task with all of them.

use super::task::{Step, Task};
use crate::cli::replay::quoted;

/// The script of a step, whose tasks write their logs into `bundle`.
pub fn script(task: &Task, step: &Step, bundle: &str) -> String {
    let tasks = task.frames.len().div_ceil(task.chunk as usize).max(1);
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
        option(&format!("{bundle}/{log}.log")),
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

    #[test]
    fn the_script_quotes_what_a_shell_would_split() {
        let task = Task {
            name: "batch-render my scene".to_owned(),
            folder: "/a b".to_owned(),
            program: "/usr/bin/batch-render".to_owned(),
            arguments: vec!["my scene.toml".to_owned(), "-o".to_owned(), "f.####.exr".to_owned()],
            steps: Step::list(false, false, Some("a film.png")),
            frames: FrameRange::of(1..=25),
            chunk: 10,
        };
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
}
