//! A job template of Open Job Description with chunks of frames.
//!
//! Parameters whose defaults are absolute paths are strings: `openjd run` refuses such defaults of PATH parameters.

use super::task::{Step, Task};

/// The template, as YAML.
pub fn template(task: &Task) -> String {
    let existing = if task.overwrites {
        "--overwrite"
    } else {
        "--skip-existing"
    };
    let steps = task
        .steps()
        .iter()
        .map(|(kind, own)| step(task, *kind, &[own, &[existing][..]].concat()));
    format!(
        "specificationVersion: jobtemplate-2023-09\n\
         extensions: [TASK_CHUNKING]\n\
         name: {}\n\
         parameterDefinitions:\n  \
         - name: Frames\n    type: STRING\n    default: {}\n  \
         - name: ChunkSize\n    type: INT\n    minValue: 1\n    default: {}\n  \
         - name: TargetSeconds\n    type: INT\n    minValue: 0\n    default: 0\n    \
         description: Seconds that a chunk is to take, from the time of those before; 0 keeps their size\n  \
         - name: Program\n    type: STRING\n    default: {}\n  \
         - name: Folder\n    type: STRING\n    default: {}\n    description: Where relative paths begin\n\
         steps:\n{}",
        text(&task.name),
        text(&task.frames.to_string().replace('x', ":")),
        task.chunk,
        text(&task.program),
        text(&task.folder),
        steps.collect::<String>(),
    )
}

/// A step, whose tasks get these arguments too.
fn step(task: &Task, kind: Step, own: &[&str]) -> String {
    // `sh -c` goes to the folder where relative paths begin.
    let mut words: Vec<String> = ["-c", "cd -- \"$1\" && shift && exec \"$@\"", "sh"].map(text).to_vec();
    words.push(text("{{Param.Folder}}"));
    words.push(text("{{Param.Program}}"));
    words.extend(task.arguments.iter().map(|word| text(word)));
    words.push(text("--range={{Task.Param.Frame}}"));
    words.extend(own.iter().chain(&["--progress", "openjd"]).map(|word| text(word)));
    let args: String = words.iter().map(|word| format!("            - {word}\n")).collect();
    let (name, after) = match kind {
        Step::Render => ("Render", ""),
        Step::Denoise => ("Denoise", "    dependencies:\n      - dependsOn: Render\n"),
    };
    format!(
        "  - name: {name}\n{after}    \
         parameterSpace:\n      \
         taskParameterDefinitions:\n        \
         - name: Frame\n          type: CHUNK[INT]\n          range: \"{{{{Param.Frames}}}}\"\n          \
         chunks:\n            defaultTaskCount: \"{{{{Param.ChunkSize}}}}\"\n            \
         targetRuntimeSeconds: \"{{{{Param.TargetSeconds}}}}\"\n            rangeConstraint: NONCONTIGUOUS\n    \
         script:\n      \
         actions:\n        \
         onRun:\n          command: sh\n          args:\n{args}          \
         cancelation:\n            mode: NOTIFY_THEN_TERMINATE\n            notifyPeriodInSeconds: 30\n",
    )
}

/// A YAML string of this text, in which OpenJD may replace parameters.
fn text(text: &str) -> String {
    // JSON strings are YAML strings.
    serde_json::Value::from(text).to_string()
}
