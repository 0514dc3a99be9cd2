//! The arguments of `batch-render convert-camera`.

use std::path::PathBuf;

use batch_render::camera::RotationOrder;
use clap::Args as ClapArgs;

use super::values::{not_negative, resolution};

pub const EXAMPLES: &str = "\
Examples:
  batch-render convert-camera sparse/0 camera.chan                  COLMAP to Nuke
  batch-render convert-camera transforms.json sparse/0/images.bin   NeRF to COLMAP, binary
  batch-render convert-camera path.csv cameras.glb                  a node with a camera for each frame
  batch-render convert-camera path.csv transforms.json --resolution 1920x1080
  batch-render convert-camera trajectory.txt sparse/0 --lens calibration.yml";

#[derive(Debug, ClapArgs)]
pub struct ConvertArgs {
    /// Cameras: a file that --frames takes
    #[arg(value_name = "IN")]
    pub from: PathBuf,

    /// The file to write; its name is the format, as for --frames. COLMAP's files are written into its folder
    #[arg(value_name = "OUT")]
    pub to: PathBuf,

    /// Width and height of the pictures, for lenses in pixels; calibrated lenses are scaled
    #[arg(long, value_name = "WxH", value_parser = resolution)]
    pub resolution: Option<[u32; 2]>,

    /// Give all cameras the first lens of this file of cameras
    #[arg(long, value_name = "FILE")]
    pub lens: Option<PathBuf>,

    /// Frames per second, for files with times
    #[arg(long, value_name = "N", value_parser = not_negative)]
    pub fps: Option<f64>,

    /// Order of rotations by angles, such as ZXY
    #[arg(long, value_name = "ORDER")]
    pub rotation_order: Option<RotationOrder>,
}
