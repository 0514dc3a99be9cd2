//! A job template of Open Job Description with chunks of frames.
//!
//! Parameters whose defaults are absolute paths are strings: `openjd run` refuses such defaults of PATH parameters.

use super::task::Task;

/// The template, as YAML.
pub fn template(task: &Task) -> String {
    let steps: Vec<String> = (0..task.steps.len()).map(|index| step(task, index)).collect();
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
        steps.concat(),
    )
}

/// The step of this index.
fn step(task: &Task, index: usize) -> String {
    let step = &task.steps[index];
    let (range, parameters) = if step.kind.is_whole() {
        ("--range={{Param.Frames}}", "")
    } else {
        ("--range={{Task.Param.Frame}}", PARAMETERS)
    };
    // `sh -c` goes to the folder where relative paths begin.
    let mut words: Vec<String> = ["-c", "cd -- \"$1\" && shift && exec \"$@\"", "sh"].map(text).to_vec();
    words.push(text("{{Param.Folder}}"));
    words.push(text("{{Param.Program}}"));
    words.extend(task.arguments.iter().map(|word| text(word)));
    words.push(text(range));
    words.extend(step.own.iter().map(|word| text(word)));
    words.extend(["--progress", "openjd"].map(text));
    let args: String = words.iter().map(|word| format!("            - {word}\n")).collect();
    let before = index.checked_sub(1).map(|before| task.steps[before].kind.name());
    let after = before.map(|name| format!("    dependencies:\n      - dependsOn: {name}\n"));
    format!(
        "  - name: {}\n{}{parameters}    \
         script:\n      \
         actions:\n        \
         onRun:\n          command: sh\n          args:\n{args}          \
         cancelation:\n            mode: NOTIFY_THEN_TERMINATE\n            notifyPeriodInSeconds: 30\n",
        step.kind.name(),
        after.unwrap_or_default(),
    )
}

/// The parameters of a step whose tasks have a chunk of the frames each.
const PARAMETERS: &str = "    \
    parameterSpace:\n      \
    taskParameterDefinitions:\n        \
    - name: Frame\n          type: CHUNK[INT]\n          range: \"{{Param.Frames}}\"\n          \
    chunks:\n            defaultTaskCount: \"{{Param.ChunkSize}}\"\n            \
    targetRuntimeSeconds: \"{{Param.TargetSeconds}}\"\n            rangeConstraint: NONCONTIGUOUS\n";

/// A YAML string of this text, in which OpenJD may replace parameters.
fn text(text: &str) -> String {
    // JSON strings are YAML strings.
    serde_json::Value::from(text).to_string()
}
