//! A disk that is full or read-only: the job ends at once, and what is under its own name is complete.

use std::{
    fs,
    process::{Command, Output},
};

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, stderr};
use libtest_mimic::{Failed, Trial};

pub fn trials() -> Vec<Trial> {
    let trials = [
        trial!(
            "a full disk ends the job at once and leaves complete files only",
            full_disk,
        ),
        trial!("a full disk ends a job that keeps sums at once", full_disk_of_sums),
        trial!(
            "a full disk leaves all scripts of a farm as they were",
            full_disk_of_scripts
        ),
        trial!("a read-only disk ends the job at once", read_only_disk),
    ];
    let is_possible = on_small_disk(&Folder::new(), "true").is_ok_and(|output| output.status.success());
    let trials = trials.map(|trial| match is_possible {
        true => trial,
        false => trial
            .with_kind("needs mount namespaces of Linux")
            .with_ignored_flag(true),
    });
    trials.into()
}

/// A shell in a mount namespace of its own, in a folder with a small memory disk at `disk`.
fn on_small_disk(folder: &Folder, script: &str) -> std::io::Result<Output> {
    fs::create_dir(folder.path("disk"))?;
    Command::new("unshare")
        .args(["--map-root-user", "--mount", "sh", "-c"])
        .arg(format!("mount -t tmpfs -o size=64k none disk && {script}"))
        .current_dir(folder.path(""))
        .output()
}

fn full_disk() -> Result<(), Failed> {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    let script = format!(
        "{} s.toml --frames path.csv --resolution 100x100 --samples 4 --progress none -o disk/f.####.exr; code=$?; \
         ls -A disk; for f in disk/*; do cp $f kept.exr; done; exit $code",
        env!("CARGO_BIN_EXE_batch-render")
    );
    let output = on_small_disk(&folder, &script)?;
    assert_eq!(output.status.code(), Some(74), "{}", stderr(&output));
    let message = stderr(&output);
    assert!(
        message.starts_with("error: cannot write output: No space left on device (os error 28): disk/f.000"),
        "{message}"
    );
    let left = String::from_utf8(output.stdout)?;
    assert!(left.lines().all(|l| l.starts_with("f.000")), "no temporaries: {left}");
    // What is there is complete.
    exr::prelude::read_first_rgba_layer_from_file(
        folder.path("kept.exr"),
        |_, _| (),
        |_, _, _: (f32, f32, f32, f32)| (),
    )?;
    Ok(())
}

fn full_disk_of_sums() -> Result<(), Failed> {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    let script = format!(
        "{} s.toml --frames path.csv --resolution 100x100 --samples 4 --keep-sums --progress none -o disk/f.####.exr",
        env!("CARGO_BIN_EXE_batch-render")
    );
    let output = on_small_disk(&folder, &script)?;
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(74), "{message}");
    let of_first = "error: cannot write output: No space left on device (os error 28): disk/f.0001.exr.sums";
    assert!(
        message.starts_with(of_first) && !message.contains("f.0002"),
        "{message}"
    );
    Ok(())
}

fn full_disk_of_scripts() -> Result<(), Failed> {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    // Room for one of two scripts.
    let script = format!(
        "submit() {{ {} submit --engine slurm --bundle disk s.toml --frames path.csv -q --denoise $1; }}; submit --seed=1 && \
         cp -r disk old && {{ dd if=/dev/zero of=disk/fill bs=4k 2>/dev/null; truncate -s -4096 disk/fill; submit --seed=2; code=$?; \
         ls -A disk; cmp disk/frames.sbatch old/frames.sbatch && cmp disk/denoise.sbatch old/denoise.sbatch && exit $code; }}",
        env!("CARGO_BIN_EXE_batch-render")
    );
    let output = on_small_disk(&folder, &script)?;
    assert_eq!(output.status.code(), Some(74), "{}", stderr(&output));
    let left = String::from_utf8(output.stdout)?;
    assert!(
        left.ends_with("denoise.sbatch\ndenoise.sbatch\nfill\nframes.sbatch\n"),
        "{left}"
    );
    Ok(())
}

fn read_only_disk() -> Result<(), Failed> {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    let script = format!(
        "mount -o remount,ro none disk && {} s.toml --frames path.csv --progress none -o disk/f.####.exr",
        env!("CARGO_BIN_EXE_batch-render")
    );
    let output = on_small_disk(&folder, &script)?;
    assert_eq!(output.status.code(), Some(74), "{}", stderr(&output));
    assert!(stderr(&output).contains("Read-only file system"), "{}", stderr(&output));
    Ok(())
}
