//! The version of the program, for bug reports: `--version` tells how it was built and what it runs on, `-V` the number alone.

use std::{
    env::consts::{ARCH, OS},
    sync::OnceLock,
};

use batch_render::simd::Isa;

/// The text of `--version` behind the name of the program.
pub fn long() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        // Whoever builds from a repository tells the commit; a package of the source has none.
        let commit = option_env!("BATCH_RENDER_COMMIT").map(|commit| format!(" ({commit})"));
        let features = if cfg!(feature = "viewer") { "viewer" } else { "none" };
        let levels: Vec<&str> = Isa::available().into_iter().map(Isa::name).collect();
        format!(
            "{}{}\nfeatures: {features}\nsystem: {OS}, {ARCH}\nvectors: {} (this processor has {})",
            env!("CARGO_PKG_VERSION"),
            commit.unwrap_or_default(),
            Isa::best().name(),
            levels.join(", "),
        )
    })
}
