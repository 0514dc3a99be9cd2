//! The headings of the help, in the order in which they appear.

pub const FRAMES: &str = "Frames";
pub const OUTPUT: &str = "Output";
pub const PICTURE: &str = "Picture";
pub const STAGE: &str = "Stage";
pub const JOB: &str = "Job";
pub const FARM: &str = "Farm";
pub const GENERAL: &str = "General";
