//! A job template of Open Job Description with chunks of frames.
//!
//! Parameters whose defaults are absolute paths are strings: `openjd run` refuses such defaults of PATH parameters.

use batch_render::error::Error;

use super::task::Task;

/// The most characters of a parameter, by the specification.
const LONGEST_PARAMETER: usize = 1024;

/// Refuses words that OpenJD would change or not take.
pub fn check(task: &Task) -> Result<(), Error> {
    let mut words = task
        .arguments
        .iter()
        .chain(task.steps.iter().flat_map(|step| &step.own));
    if let Some(word) = words.find(|word| word.contains("{{") || word.contains("}}")) {
        return Err(Error::Usage(format!("OpenJD would read a parameter in `{word}`")));
    }
    match [&task.program, &task.folder].into_iter().find(|path| is_too_long(path)) {
        Some(path) => Err(Error::Usage(format!(
            "OpenJD takes paths of at most {LONGEST_PARAMETER} characters: {path}"
        ))),
        None => Ok(()),
    }
}

fn is_too_long(parameter: &str) -> bool {
    parameter.chars().count() > LONGEST_PARAMETER
}

/// The template, as YAML. A list of frames that is too long for a parameter is in the steps.
pub fn template(task: &Task) -> String {
    let list = task.frames.to_string().replace('x', ":");
    let (definition, range) = if is_too_long(&list) {
        (String::new(), list)
    } else {
        let definition = format!("  - name: Frames\n    type: STRING\n    default: {}\n", text(&list));
        (definition, "{{Param.Frames}}".to_owned())
    };
    let steps: Vec<String> = (0..task.steps.len()).map(|index| step(task, index, &range)).collect();
    format!(
        "specificationVersion: jobtemplate-2023-09\n\
         extensions: [TASK_CHUNKING]\n\
         name: {}\n\
         parameterDefinitions:\n{definition}  \
         - name: ChunkSize\n    type: INT\n    minValue: 1\n    default: {}\n  \
         - name: TargetSeconds\n    type: INT\n    minValue: 0\n    default: 0\n    \
         description: Seconds that a chunk is to take, from the time of those before; 0 keeps their size\n  \
         - name: Program\n    type: STRING\n    default: {}\n  \
         - name: Folder\n    type: STRING\n    default: {}\n    description: Where relative paths begin\n\
         steps:\n{}",
        text(&task.name),
        task.chunk,
        text(&task.program),
        text(&task.folder),
        steps.concat(),
    )
}

/// The step of this index, of the frames in `range`.
fn step(task: &Task, index: usize, range: &str) -> String {
    let step = &task.steps[index];
    let (own_range, parameters) = if step.kind.is_whole() {
        (range, String::new())
    } else {
        ("{{Task.Param.Frame}}", parameters(range))
    };
    // `sh -c` goes to the folder where relative paths begin.
    let mut words: Vec<String> = ["-c", "cd -- \"$1\" && shift && exec \"$@\"", "sh"].map(text).to_vec();
    words.push(text("{{Param.Folder}}"));
    words.push(text("{{Param.Program}}"));
    words.extend(task.arguments.iter().map(|word| text(word)));
    words.push(text(&format!("--range={own_range}")));
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

/// The parameters of a step whose tasks have a chunk of the frames in `range` each.
fn parameters(range: &str) -> String {
    format!(
        "    parameterSpace:\n      \
         taskParameterDefinitions:\n        \
         - name: Frame\n          type: CHUNK[INT]\n          range: {}\n          \
         chunks:\n            defaultTaskCount: \"{{{{Param.ChunkSize}}}}\"\n            \
         targetRuntimeSeconds: \"{{{{Param.TargetSeconds}}}}\"\n            rangeConstraint: NONCONTIGUOUS\n",
        text(range)
    )
}

/// A YAML string of this text, in which OpenJD may replace parameters.
fn text(text: &str) -> String {
    // JSON strings are YAML strings.
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use batch_render::batch::FrameRange;

    use super::*;
    use crate::cli::submit::task::Step;

    fn task(frames: FrameRange) -> Task {
        Task {
            name: Task::name_of(&"n".repeat(150)),
            folder: "/a".to_owned(),
            program: "/usr/bin/batch-render".to_owned(),
            arguments: vec!["s.toml".to_owned()],
            steps: Step::list(false, false, Some("film.png")),
            frames,
            chunk: 10,
        }
    }

    #[test]
    fn no_parameter_and_no_name_is_longer_than_the_specification_allows() {
        // 300 frames without a constant step.
        let scattered = task(FrameRange::of((1..=300).map(|i| i * i)));
        let list = scattered.frames.to_string();
        assert!(is_too_long(&list) && check(&scattered).is_ok());
        let template_of_many = template(&scattered);
        assert!(!template_of_many.contains("Frames"), "{template_of_many}");
        assert!(template_of_many.contains(&format!("          range: \"{list}\"\n")));
        assert!(template_of_many.contains(&format!("            - \"--range={list}\"\n")));
        let name = template_of_many
            .lines()
            .find_map(|l| l.strip_prefix("name: "))
            .expect("a name");
        assert_eq!(name.trim_matches('"').len(), 128);

        let few = template(&task(FrameRange::of(1..=300)));
        assert!(
            few.contains("  - name: Frames\n    type: STRING\n    default: \"1-300\"\n"),
            "{few}"
        );
        assert!(few.contains("          range: \"{{Param.Frames}}\"\n"), "{few}");
        let deep = Task {
            folder: format!("/{}", "f".repeat(1024)),
            ..task(FrameRange::of(1..=3))
        };
        assert!(check(&deep).is_err());
    }

    #[test]
    fn braces_that_the_engine_reads_are_refused() {
        for (word, is_right) in [("{a}.exr", true), ("{{a.exr", false), ("a}}.exr", false)] {
            let mut task = task(FrameRange::of(1..=3));
            task.arguments.push(word.to_owned());
            assert_eq!(check(&task).is_ok(), is_right, "{word}");
        }
    }
}
