//! The arguments of `batch-render fly`.

use std::{
    net::{IpAddr, Ipv4Addr},
    path::PathBuf,
};

use batch_render::{camera::RotationOrder, shape::mesh::LightUnits};
use clap::Args as ClapArgs;

use super::{settings::Settings, values};

/// The keys of the page.
pub const KEYS: &str = "\
Keys of the page:
  Up, Down          forward and back           W, S
  Left, Right       left and right             A, D
  F1, F2            up and down                E, Q
  Z, X              roll to the left and right
  Shift             five times as far
  + and -, wheel    longer and shorter steps
  Drag              look around
  Click             what is under the pointer; with Shift, focus on it
  P, F              what is in the middle; focus on it
  Home              the camera of the scene
  , and .           one frame back and forward
  Page Up, Down     the key before and after
  Space             play, stop
  K, Delete         set the key of the frame; delete it
  Ctrl+S            save the camera path
  H                 this list

W, A, S, D, E and Q count by their place on an American keyboard, all others by their character.
A press is one step; a key that is held moves on at the speed that the page shows. Tab goes to the
fields and buttons, Escape back to the picture.";

#[derive(Debug, ClapArgs)]
pub struct FlyArgs {
    /// The scene file, or a model: OBJ, glTF, GLB, PLY or STL
    pub scene: PathBuf,

    /// Camera path to edit, a CSV file; it need not exist
    #[arg(long, value_name = "FILE", default_value = "camera_path.csv")]
    pub frames: PathBuf,

    /// Port of the page; 0 is any that is free
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,

    /// Address to serve on; with any but a loopback address, others on the network can reach the page
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    pub listen: IpAddr,

    /// Open the page in the browser
    #[arg(long)]
    pub open: bool,

    #[command(flatten)]
    pub settings: Settings,

    /// See a model by its camera of this name, or of this number from 0
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,

    /// Values over frames, a CSV file of columns such as light.key.point.intensity
    #[arg(long, value_name = "FILE")]
    pub values: Option<PathBuf>,

    /// Values that are drawn at random for each frame, a TOML file of distributions such as "light.key.point.intensity" = [1, 10]
    #[arg(long, value_name = "FILE")]
    pub random: Option<PathBuf>,

    /// Play an animation of a glTF model by itself, or all of them; repeatable
    #[arg(long, value_name = "NAME|all")]
    pub animation: Vec<String>,

    /// Frames per second
    #[arg(long, value_name = "N", value_parser = values::frame_rate)]
    pub fps: Option<f64>,

    /// Order of a camera path's rotations rot_x, rot_y and rot_z, such as ZXY
    #[arg(long, value_name = "ORDER")]
    pub rotation_order: Option<RotationOrder>,

    /// Threads to render with [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Memory that the scene may take, such as 512M or 8G [default: 3/4 of what is free]
    #[arg(long, value_name = "SIZE", value_parser = values::size)]
    pub max_memory: Option<u64>,

    /// Memory for textures, such as 8G, beyond which larger ones are shown at a lower resolution [default: half of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = values::size)]
    pub texture_memory: Option<u64>,

    /// Show a glTF model with its materials of this variant
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,

    /// Unit of the lights of a glTF model: as its program writes them, candela and lux (683 lm/W), or W/sr and W/m2
    #[arg(long, value_name = "UNIT", value_parser = values::light_units())]
    pub light_units: Option<LightUnits>,

    /// Radius in metres of the points of a PLY file without faces
    #[arg(long, value_name = "METRES", value_parser = values::radius)]
    pub point_radius: Option<f32>,

    /// Let models name files outside of their own folders
    #[arg(long)]
    pub allow_outside: bool,
}
