//! The settings of a viewer.

use std::{net::SocketAddr, path::PathBuf};

/// The settings of a viewer.
#[derive(Clone, Debug)]
pub struct ViewerOptions {
    /// The address to serve on; port 0 is any that is free.
    pub listen: SocketAddr,
    /// The camera path file that is edited. It need not exist.
    pub camera_path: PathBuf,
    /// Returns the command that renders the scene, for a shell, with these values of flags instead of those that were given.
    pub command: fn(&[(&str, String)]) -> String,
}
