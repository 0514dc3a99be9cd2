//! The program `batch-render`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
