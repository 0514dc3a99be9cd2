//! Messages about bad input: each scene of `tests/bad` is rendered, and says on stderr exactly what stands in the file beside it.
//!
//! A scene's first lines may be comments `# args: ...` (more arguments), `# exit: N` (65 unless said) and `# scene: FILE`
//! (another scene is rendered than this file). With `BLESS=1` the expected messages are written anew: read the difference.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use libtest_mimic::{Failed, Trial};

pub fn trials() -> Vec<Trial> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad");
    let mut scenes: Vec<PathBuf> = fs::read_dir(folder)
        .expect("tests/bad")
        .map(|e| e.expect("readable").path())
        .filter(|p| p.extension().is_some_and(|e| e == "toml"))
        .collect();
    scenes.sort();
    let trials = scenes.into_iter().map(|scene| {
        let name = scene.file_stem().expect("a name").to_string_lossy().into_owned();
        trial!(name, move || says_what_is_wrong(&scene))
    });
    trials.collect()
}

/// The value of the comment `# key: value` among the first lines.
fn comment<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    text.lines()
        .map_while(|l| l.strip_prefix("# "))
        .find_map(|l| l.strip_prefix(key)?.strip_prefix(':'))
        .map(str::trim)
}

fn says_what_is_wrong(scene: &Path) -> Result<(), Failed> {
    let text = fs::read_to_string(scene)?;
    let exit: i32 = comment(&text, "exit").unwrap_or("65").parse()?;
    let file = scene.file_name().expect("a name").to_string_lossy();
    let scene_file = comment(&text, "scene").unwrap_or(&file);
    let out = tempfile::tempdir()?;
    let output = Command::new(env!("CARGO_BIN_EXE_batch-render"))
        .current_dir(scene.parent().expect("a folder"))
        .arg(scene_file)
        .args(comment(&text, "args").unwrap_or_default().split_whitespace())
        .args(["--progress", "none", "-o"])
        .arg(out.path().join("frame.####.png"))
        .output()?;
    let stderr = String::from_utf8(output.stderr)?;
    let left: Vec<_> = fs::read_dir(out.path())?.collect();
    if exit != 0 && !left.is_empty() {
        return Err(format!("files were left: {left:?}").into());
    }
    if output.status.code() != Some(exit) {
        return Err(format!("exit code {:?} instead of {exit}\n{stderr}", output.status.code()).into());
    }
    let expected_file = scene.with_extension("stderr");
    if std::env::var_os("BLESS").is_some() {
        fs::write(&expected_file, &stderr)?;
    }
    let expected = fs::read_to_string(&expected_file)?;
    if of_any_system(&expected) != of_any_system(&stderr) {
        return Err(format!("--- expected\n{expected}\n--- found\n{stderr}").into());
    }
    Ok(())
}

/// The message without what systems say differently: separators of paths, the name of the program, and that there is no such file.
fn of_any_system(message: &str) -> String {
    if !cfg!(windows) {
        return message.to_owned();
    }
    let message = message.replace('\\', "/").replace("batch-render.exe", "batch-render");
    let lines = message.lines().map(|line| match line.split_once(" (os error 2)") {
        Some((before, after)) => {
            let (what, _) = before.rsplit_once(": ").unwrap_or((before, ""));
            format!("{what}: not found{after}")
        }
        None => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}
