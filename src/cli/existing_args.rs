//! The flags about files that exist.

use clap::Args as ClapArgs;

use super::heading;

#[derive(Debug, ClapArgs)]
pub struct ExistingArgs {
    /// Render frames again whose files exist (the default)
    #[arg(long, hide_short_help = true, help_heading = heading::OUTPUT, group = "existing")]
    pub overwrite: bool,

    /// Skip frames whose files are there as this job would write them
    ///
    /// Every file carries a fingerprint of all inputs, the camera and the settings, and a checksum of its own bytes. What is
    /// missing, cut off, altered, or was rendered otherwise is rendered again, and a line says why.
    #[arg(long, help_heading = heading::OUTPUT, group = "existing")]
    pub skip_existing: bool,

    /// List the frames that --skip-existing would render, with the reasons, and stop
    #[arg(long, hide_short_help = true, help_heading = heading::OUTPUT, conflicts_with_all = ["overwrite", "fail_existing"])]
    pub list_stale: bool,

    /// Stop before rendering if a file exists
    #[arg(long, hide_short_help = true, help_heading = heading::OUTPUT, group = "existing")]
    pub fail_existing: bool,
}

impl ExistingArgs {
    /// Whether frames are skipped. A list of stale frames is the same with and without.
    pub fn skips(&self) -> bool {
        self.skip_existing && !self.list_stale
    }
}
