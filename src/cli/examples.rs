//! Examples at the end of the help of commands: each line is a command line and, behind two spaces, what it is for.

pub const RENDER: &str = "\
Examples:
  batch-render model.glb                                            a model by itself, EXR and PNG
  batch-render scene.toml --frames path.csv -o 'out/f.####.exr'     a sequence along a camera path
  batch-render scene.toml --frames path.csv --skip-existing         go on where a job was killed
  batch-render model.glb --turntable 36 -o turn.gif                 once around, a moving picture
  batch-render *.glb --views orbit:36@20 -o 'out/{scene}/####.exr'  many models from many sides
  batch-render model.glb -o - --output-format png > model.png       a picture on standard output

Completions of a shell: `batch-render completions bash` (fish, zsh). Manual page: `batch-render man`.";

pub const CHECK: &str = "\
Examples:
  batch-render check scene.toml                   what it consists of, or all that is wrong with it
  batch-render check model.glb --strict --json    a model that is refused unless all of it is rendered";

pub const BENCH: &str = "\
Examples:
  batch-render bench scene.toml --report out/bench    all structures on the same rays, with charts
  batch-render bench scene.toml --picture             where the time of the picture goes";

pub const MERGE: &str = "\
Examples:
  batch-render merge whole.exr left.exr right.exr    two crops of one frame";

pub const DENOISE: &str = "\
Examples:
  batch-render denoise 'noisy.####.exr' -o 'clean.####.exr'    a sequence with the passes of --aovs denoise";

pub const SUBMIT: &str = "\
Examples:
  batch-render submit scene.toml --engine slurm --bundle farm --frames path.csv -o 'out/f.####.exr'";

#[cfg(test)]
mod tests {
    use clap::{Command, CommandFactory, Parser};

    use crate::cli::args::Args;

    /// The command lines at the end of the help.
    fn examples(command: &Command) -> Vec<String> {
        let text = command
            .get_after_long_help()
            .map(ToString::to_string)
            .unwrap_or_default();
        let lines = text.lines().filter(|line| line.starts_with("  batch-render "));
        let typed = lines.map(|line| line.trim().split("  ").next().unwrap_or_default().to_owned());
        typed.collect()
    }

    #[test]
    fn examples_of_the_help_are_command_lines() {
        let root = Args::command();
        let mut count = 0;
        for line in root.get_subcommands().chain([&root]).flat_map(examples) {
            let words = shlex::split(&line).expect("quoted for a shell");
            let words = words.iter().take_while(|word| *word != ">");
            Args::try_parse_from(words).unwrap_or_else(|e| panic!("{line}: {e}"));
            count += 1;
        }
        assert!(count >= 18, "{count}");
    }

    #[test]
    fn the_help_with_examples_fits_into_120_columns() {
        let root = Args::command();
        for command in root.get_subcommands().chain([&root]) {
            let text = command
                .get_after_long_help()
                .map(ToString::to_string)
                .unwrap_or_default();
            let longest = text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
            assert!(longest <= 120, "{}: {longest}", command.get_name());
        }
    }
}
