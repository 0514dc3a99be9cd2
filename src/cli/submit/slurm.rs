//! A batch script of Slurm: an array job, each of whose tasks renders a part of the frames.

use super::task::Task;
use crate::cli::replay::quoted;

/// The script of a step whose tasks get these arguments of their own; they write their logs into `bundle`.
pub fn script(task: &Task, own: &[&str], bundle: &str) -> String {
    let tasks = task.frames.len().div_ceil(task.chunk as usize).max(1);
    let frames = &task.frames;
    let arguments = task.arguments.iter().map(quoted);
    let words: Vec<String> = arguments.chain(own.iter().map(|word| (*word).to_owned())).collect();
    let existing = if task.overwrites {
        "--overwrite"
    } else {
        "--skip-existing"
    };
    format!(
        "#!/bin/sh\n\
         # One task of the array renders one part of the frames. A task that is killed or requeued goes on where it stopped.\n\
         #SBATCH --job-name={}\n\
         #SBATCH --array=1-{tasks}\n\
         #SBATCH --chdir={}\n\
         #SBATCH --output={}\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         exec {} {} --range={frames} --part \"$SLURM_ARRAY_TASK_ID/{tasks}\" {existing} --progress plain\n",
        option(&task.name),
        option(&task.folder),
        option(&format!("{bundle}/%A_%a.log")),
        quoted(&task.program),
        words.join(" "),
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
            denoises: false,
            overwrites: false,
            frames: FrameRange::of(1..=25),
            chunk: 10,
        };
        let script = script(&task, &[], "/bundle");
        assert!(script.contains("#SBATCH --array=1-3\n"), "{script}");
        assert!(script.contains("#SBATCH --chdir=\"/a b\"\n"), "{script}");
        assert!(
            script.contains(
                "'my scene.toml' -o 'f.####.exr' --range=1-25 --part \"$SLURM_ARRAY_TASK_ID/3\" --skip-existing"
            ),
            "{script}"
        );
    }
}
