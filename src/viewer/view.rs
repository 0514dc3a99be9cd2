//! The view of all pages, and the task to render it.

use std::sync::Arc;

use super::{base::Base, camera::ViewCamera, look::Look};
use crate::{
    batch::Plan,
    camera::{
        FilmSize, FrameCamera, Lens, Neighbours, PictureCamera,
        path::{CameraPath, PathError},
    },
    render::Cancel,
};

/// The view that pages see.
#[derive(Clone, Debug)]
pub struct View {
    /// Increases with each change.
    pub version: u64,
    /// The page that made the last change, and the number of its message.
    pub client: u64,
    pub seq: u64,
    /// May lie between two frames.
    pub frame: f64,
    pub camera: ViewCamera,
    /// The path that gives the camera at the frame; `None` for `camera` itself.
    pub path: Option<Arc<CameraPath>>,
    /// The lens of the path or of the moving camera that the camera has left, in place of the scene's.
    pub lens: Option<Lens>,
    /// Whether the camera is the scene's own, which values or animations move, where there is no path.
    pub is_home: bool,
}

impl View {
    /// The nearest whole frame. Frames lie within the limits of paths, which are less than 2^31.
    pub fn whole_frame(&self) -> i32 {
        self.frame.round() as i32
    }

    /// The lens that the camera and paths override.
    pub fn lens(&self, base: &Base) -> Lens {
        let kept = match self.path {
            Some(_) => None,
            None if self.is_home => self.moved_lens(base),
            None => self.lens,
        };
        kept.unwrap_or(base.lens)
    }

    /// The lens of the scene's camera at the frame, if values or animations move that camera.
    fn moved_lens(&self, base: &Base) -> Option<Lens> {
        let at = || base.job.camera(f64::from(self.whole_frame())).ok().flatten();
        base.job.moves_camera().then(at).flatten().map(|camera| camera.lens)
    }

    /// Takes the camera off the path or off that of the scene, whose lens it keeps.
    pub fn leave_path(&mut self, base: &Base) {
        if let Some(state) = self.path.take().and_then(|path| path.at(self.frame).ok()) {
            self.lens = Some(state.base(&base.lens));
        } else if self.is_home {
            self.lens = self.moved_lens(base);
        }
        self.is_home = false;
    }

    /// The camera for a film.
    pub fn frame_camera(&self, base: &Base, film: FilmSize) -> Result<FrameCamera, PathError> {
        let lens = &self.lens(base);
        let Some(path) = &self.path else {
            let own = || base.job.frame_camera(self.whole_frame(), film).ok();
            if let Some(own) = (self.is_home && base.job.moves_camera()).then(own).flatten() {
                return Ok(own);
            }
            let camera = self
                .camera
                .frame_camera(self.frame, (lens, base.job.desc.timing), film)?;
            // Before a scene that moves it rests in the frames around, too.
            let there = base.job.moves().then(|| PictureCamera::from(camera.camera(0.0)));
            return Ok(camera.with_neighbours(Neighbours {
                previous: there.clone(),
                next: there,
            }));
        };
        path.frame_camera(self.frame, |_| Ok(*lens), film)
    }
}

/// A view to be rendered.
pub struct Task {
    pub base: Arc<Base>,
    pub view: View,
    pub look: Look,
    pub plan: Arc<Plan>,
    pub cancel: Arc<Cancel>,
}
