//! The cameras of views: all look at the middle of what is visible, from so far that it fits into the picture.

use std::ops::RangeInclusive;

use super::{
    fit::{bounds_at, box_corners, retreat},
    views::{FIRST, Views},
};
use crate::{
    assets::Store,
    camera::{Camera, FilmSize, Lens, LensOverrides, LookAt, Pose, SceneCamera},
    describe::{SceneDesc, ValueSource},
    error::Error,
    math::{DAabb, DVec3},
};

/// The distance from the vertical axis, relative to the size of the scene, below which a camera counts as being in it.
const IN_AXIS: f64 = 1e-6;

/// The bounds of what is visible in the first frame.
///
/// # Errors
/// The scene has nothing with bounds, or its files or values are wrong.
pub(in crate::batch) fn view_bounds(
    desc: &SceneDesc,
    store: &Store,
    (tables, fps): (&[ValueSource], f64),
) -> Result<DAabb, Error> {
    let values = super::values::values(desc, tables)?;
    let (bounds, _) = bounds_at((desc, store), (values.as_deref(), fps), FIRST as f64)?;
    if bounds.is_finite() && bounds.half_diagonal() > 0.0 {
        return Ok(bounds);
    }
    Err(Error::Boundless {
        flag: "--views",
        path: desc.source.path.clone(),
    })
}

/// The cameras of the views of one scene.
pub(super) struct ViewCameras<'a> {
    views: &'a Views,
    bounds: DAabb,
    /// The scene's own camera, whose lens they have.
    own: SceneCamera,
    film: FilmSize,
    start: DVec3,
}

impl<'a> ViewCameras<'a> {
    /// The cameras for a scene with these bounds.
    ///
    /// # Errors
    /// The scene's own camera has no perspective.
    pub fn new(views: &'a Views, bounds: DAabb, own: SceneCamera, film: FilmSize) -> Result<Self, Error> {
        if Camera::new(&own.pose, &own.lens, film).pinhole().is_none() {
            return Err(Error::Usage(format!(
                "--views: only a perspective camera without distortion is moved, and the scene's is `{}`",
                own.lens.name()
            )));
        }
        let towards = (own.pose.eye() - bounds.center()).with_y(0.0);
        let is_aside = towards.length() > IN_AXIS * bounds.half_diagonal();
        Ok(Self {
            views,
            bounds,
            own,
            film,
            // A camera above or below the middle has no such direction: the views start in front then.
            start: if is_aside { towards.normalize() } else { DVec3::Z },
        })
    }

    /// The frames of all views.
    pub fn frames(&self) -> RangeInclusive<i64> {
        self.views.frames()
    }

    /// The camera of a frame with this lens, or that of the scene's own camera.
    ///
    /// # Errors
    /// The lens is shifted so far that it does not see what is in front of it, or the numbers are too large.
    pub fn camera(&self, frame: i64, lens: Option<&Lens>) -> Result<SceneCamera, Error> {
        let lens = lens.unwrap_or(&self.own.lens);
        let refuse = |message: &str| Error::Usage(format!("--views: {message}"));
        let center = self.bounds.center();
        let direction = self.views.direction(frame, self.start);
        let direction = direction.ok_or_else(|| refuse("there is no such frame"))?;
        let look = |distance: f64| {
            let pose = Pose::look_at(center + direction * distance, &LookAt::new(center));
            pose.map_err(|_| refuse("the scene is too small or too far away"))
        };
        let near = self.bounds.half_diagonal();
        let view = Camera::new(&look(near)?, lens, self.film).pinhole();
        let corners = box_corners(&self.bounds);
        let back = view.and_then(|view| retreat(&view, self.film, (&corners, 1.0 / self.views.fit)));
        let back = back.ok_or_else(|| refuse("the lens is shifted so far that nothing in front of it is seen"))?;
        let distance = near + back;
        Ok(SceneCamera {
            pose: look(distance)?,
            // A lens that focuses on its target stays focused on it.
            lens: lens.with_overrides(&LensOverrides::default(), Some(distance)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::perspective::PerspectiveLens;

    #[test]
    fn the_box_touches_the_wanted_share_of_the_picture_from_every_side() {
        let bounds = DAabb {
            min: DVec3::new(-1.0, 2.0, 5.0),
            max: DVec3::new(3.0, 3.0, 5.5),
        };
        let sets = ["orbit:7@-20", "orbit:3@89.9", "hemisphere:20", "sphere:31", "cube"];
        let eye = bounds.center() + DVec3::new(0.0, 0.0, 9.0);
        let pose = Pose::look_at(eye, &LookAt::new(DVec3::ZERO)).expect("a pose");
        for (film, degrees, fit) in [([64, 48], 40.0, 0.9), ([30, 90], 110.0, 0.5), ([50, 50], 3.0, 1.0)] {
            let lens = Lens::Perspective(PerspectiveLens::vertical(degrees));
            let sets = sets.map(|text| text.parse().expect("a set")).to_vec();
            let views = Views { sets, fit };
            let cameras = ViewCameras::new(&views, bounds, SceneCamera { pose, lens }, film).expect("a perspective");
            for frame in cameras.frames() {
                let SceneCamera { pose, lens } = cameras.camera(frame, None).expect("a camera");
                let camera = Camera::new(&pose, &lens, film);
                let [width, height] = film.map(f64::from);
                let share = box_corners(&bounds).map(|corner| {
                    let place = camera.project(corner).expect("it is in front of the camera");
                    let [x, y] = [place.x / width, place.y / height].map(|at| (2.0 * at - 1.0).abs());
                    x.max(y)
                });
                let largest = share.into_iter().fold(0.0, f64::max);
                assert!((largest - fit).abs() < 1e-9, "{frame}: {largest}");
                let aim = (bounds.center() - pose.eye()).normalize();
                assert!(aim.distance(pose.forward()) < 1e-12 && pose.up().y > -1e-12, "{frame}");
            }
        }
    }
}
