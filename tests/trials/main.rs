//! Tests that are made at run time: one for each golden picture, faulty scene, kind, pass, page of the manual or asset.
//!
//! The name of each begins with its module: `cargo test --test trials goldens` runs the golden pictures.

use libtest_mimic::Arguments;

/// Makes a trial whose name begins with the module that makes it.
macro_rules! trial {
    ($name:expr, $test:expr $(,)?) => {
        libtest_mimic::Trial::test(crate::in_module(module_path!(), &$name), $test)
    };
}

/// Makes a trial by `common::asset_trial` whose name begins with the module that makes it.
macro_rules! asset_trial {
    ($name:expr, $files:expr, $test:expr $(,)?) => {
        crate::common::asset_trial(crate::in_module(module_path!(), &$name), $files, $test)
    };
}

#[path = "../common/mod.rs"]
mod common;

mod assets;
mod bad;
mod disk;
mod goldens;
mod interface;
mod khronos;
mod kinds;
mod manifest;
mod manual;
mod passes;
mod poses;
mod references;
mod schema;

fn main() {
    let args = Arguments::from_args();
    let trials = [
        assets::trials(),
        bad::trials(),
        disk::trials(),
        goldens::trials(),
        interface::trials(),
        khronos::trials(),
        kinds::trials(),
        manifest::trials(),
        manual::trials(),
        passes::trials(),
        poses::trials(),
        references::trials(),
        schema::trials(),
    ];
    libtest_mimic::run(&args, trials.into_iter().flatten().collect()).exit();
}

/// Returns `name` behind the last part of a module's path.
fn in_module(module: &str, name: &impl std::fmt::Display) -> String {
    let module = module.rsplit("::").next().unwrap_or(module);
    format!("{module}::{name}")
}
