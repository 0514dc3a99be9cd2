//! The settings of a viewer.

use std::{net::SocketAddr, path::PathBuf};

/// The settings of a viewer.
#[derive(Clone, Debug)]
pub struct ViewerOptions {
    /// The address to serve on; port 0 means any free port.
    pub listen: SocketAddr,
    /// The camera path file that is edited. It need not exist.
    pub camera_path: PathBuf,
    /// Returns the shell command that renders the scene, with these values of flags instead of the given ones.
    pub command: fn(&[(&str, String)]) -> String,
}
