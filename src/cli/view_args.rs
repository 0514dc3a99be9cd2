//! The arguments for views around a scene and for stereo.

use batch_render::{batch::ViewSet, camera::stereo::Stereo};
use clap::Args as ClapArgs;

use super::heading;

#[derive(Debug, ClapArgs)]
pub struct ViewArgs {
    /// Render views around the scene: orbit:N, orbit:N@ELEVATION, hemisphere:N, sphere:N or cube; repeatable
    ///
    /// All look at the middle of what is visible in frame 1, and see all of it. The frames are numbered from 1 through all of them.
    #[arg(long, value_name = "SPEC", value_delimiter = ',', conflicts_with_all = ["frames", "turntable", "frame_to_fit"], hide_short_help = true, help_heading = heading::FRAMES)]
    pub views: Vec<ViewSet>,

    /// Share of the picture that views let the scene fill
    #[arg(long, value_name = "FRACTION", requires = "views", default_value_t = 0.9, hide_short_help = true, help_heading = heading::FRAMES)]
    pub fit: f64,

    /// Render the pictures of two eyes: ipd=METRES, and convergence=METRES, eye=left|right or
    /// layout=side-by-side|top-bottom if wanted
    ///
    /// {eye} in any argument stands for left or right, as in -o 'out/{eye}.####.exr'. With a layout both are halves of one picture,
    /// the left eye on the left or above. A panorama becomes omnidirectional stereo.
    #[arg(long, value_name = "SPEC", hide_short_help = true, help_heading = heading::FRAMES)]
    pub stereo: Option<Stereo>,
}
