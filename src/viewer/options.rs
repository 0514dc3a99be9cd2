//! The settings of a viewer.

use std::{net::SocketAddr, path::PathBuf};

/// The settings of a viewer.
#[derive(Clone, Debug)]
pub struct ViewerOptions {
    /// The address to serve on; port 0 is any that is free.
    pub listen: SocketAddr,
    /// The camera path file that is edited. It need not exist.
    pub camera_path: PathBuf,
    /// The command that renders the scene, as far as it is known: the program, the scene and the options of the job.
    pub command: Vec<String>,
}
