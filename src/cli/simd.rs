//! Which vectors are used: the environment may force a level, for comparisons.

use std::env;

use batch_render::{error::Error, simd::Isa};

/// The variable that forces a level.
const VARIABLE: &str = "BATCH_RENDER_SIMD";

/// The level that the environment asks for, otherwise the best that this processor has.
pub fn from_environment() -> Result<Isa, Error> {
    let name = env::var_os(VARIABLE).unwrap_or_default();
    if name.is_empty() {
        return Ok(Isa::best());
    }
    let level = name.to_string_lossy().parse();
    level.map_err(|e| Error::Usage(format!("{VARIABLE}: {e}")))
}
