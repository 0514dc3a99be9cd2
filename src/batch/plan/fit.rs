//! Framing: the scene's camera is moved along its line of sight until all that it may see fits into the picture.
//!
//! What fits is the box of the visible objects, in all poses of the job's motion and for all angles of an orbit, whichever frames
//! a process renders. So all parts of a job have the same camera.

use super::turntable::Turn;
use crate::{
    assets::Store,
    batch::{
        Request,
        scenes::{load_options, moved_description},
    },
    camera::{Camera, PinholeView},
    compile,
    describe::{Diagnostics, SceneDesc, ValueSource, Values},
    error::Error,
    math::{DAabb, DVec3, transform::axis_rotation},
    value::Spanned,
};

/// The steps of a motion, and of an orbit, that are looked at.
const STEPS: u32 = 64;
/// The width of the picture relative to what fits into it.
const MARGIN: f64 = 1.08;

/// The description with its camera moved so that the whole scene fits.
///
/// # Errors
/// The camera has no perspective, moves over time, or the scene has nothing with bounds.
pub(in crate::batch) fn fitted(
    mut desc: SceneDesc,
    request: &Request,
    store: &Store,
    (tables, camera_moves): (&[ValueSource], bool),
) -> Result<SceneDesc, Error> {
    let refuse = |message: String| Err(Error::Usage(format!("--frame-to-fit: {message}")));
    if request.camera_path.is_some() {
        return refuse("the camera path says where the camera is".to_owned());
    }
    if camera_moves {
        return refuse("the camera of the model moves by itself".to_owned());
    }
    let no_camera = || Error::NoCamera {
        path: desc.source.path.clone(),
    };
    let camera = desc.camera.as_ref().ok_or_else(no_camera)?.get_ref();
    let setup = match camera.compile() {
        Ok(setup) => setup,
        // The plan tells what is wrong with it.
        Err(problems) => return Diagnostics::new(&desc.source, problems).map_or(Ok(desc), |d| Err(Error::Invalid(d))),
    };
    let size = desc.render.resolution();
    let Some(view) = Camera::new(&setup.pose, &setup.lens, size).pinhole() else {
        return refuse(format!(
            "only a perspective camera is moved, and the scene's is `{}`",
            setup.lens.name()
        ));
    };
    let values = super::values::values(&desc, tables)?;
    if let Some((name, _)) = values.iter().flat_map(|values| values.of_camera()).next() {
        return refuse(format!("`{name}` changes over time"));
    }
    let fps = super::frame_rate::fps(request);
    let at = |frame: f64| bounds_at((&desc, store), (values.as_deref(), fps), frame);
    let frames = values.as_ref().map(|values| values.sampled_frames());
    let first = frames.as_ref().map_or(0.0, |frames| *frames.start() as f64);
    let (start, end) = at(first)?;
    let mut spans: Vec<[f64; 2]> = end.map(|end| [0.0, end * fps]).into_iter().collect();
    spans.extend(frames.map(|frames| [*frames.start() as f64, *frames.end() as f64]));
    let mut bounds = start;
    for [from, to] in spans {
        for step in 0..=STEPS {
            let (box_then, _) = at(from + (to - from) * f64::from(step) / f64::from(STEPS))?;
            bounds = bounds.union(box_then);
        }
    }
    if !bounds.is_finite() {
        return Err(Error::Boundless {
            flag: "--frame-to-fit",
            path: desc.source.path.clone(),
        });
    }
    let points = swept(&bounds, start.center(), request.turntable);
    let Some(back) = retreat(&view, size, (&points, MARGIN)) else {
        return refuse("the lens is shifted so far that nothing in front of it is seen".to_owned());
    };
    let (_, look) = camera.view();
    let forward = -view.axes.z_axis;
    let eye = view.eye - forward * back;
    let distance = (look.target - eye).dot(forward);
    // The camera may have to pass the point that it looks at.
    let target = match distance > 1e-6 * (look.target - view.eye).length() {
        true => look.target,
        false => eye + forward * (bounds.center() - eye).dot(forward).max(f64::MIN_POSITIVE.sqrt()),
    };
    let span = desc.camera.as_ref().map(Spanned::span).unwrap_or_default();
    let moved = camera.clone().with_view(eye, target);
    desc.camera = Some(Spanned::new(span, moved));
    Ok(desc)
}

/// The bounds of what is visible at a time in frames, in m, and the end of the animations, in s.
pub(super) fn bounds_at(
    (desc, store): (&SceneDesc, &Store),
    (values, fps): (Option<&Values>, f64),
    frame: f64,
) -> Result<(DAabb, Option<f64>), Error> {
    let moved = values.and_then(|values| moved_description(desc, values, frame));
    let options = load_options(values, None, frame / fps);
    Ok(compile::visible_bounds(
        moved.as_ref().unwrap_or(desc),
        store,
        &options,
    )?)
}

/// The corners of a box, in all places that they have relative to the first camera of an orbit around the vertical axis through
/// `center`.
fn swept(bounds: &DAabb, center: DVec3, turn: Option<Turn>) -> Vec<DVec3> {
    let corners = box_corners(bounds);
    let Some(turn) = turn else { return corners.to_vec() };
    let turned = (0..STEPS).flat_map(|step| {
        let back = axis_rotation(1, -turn.degrees * f64::from(step) / f64::from(STEPS));
        corners.iter().map(move |corner| center + back * (*corner - center))
    });
    turned.collect()
}

/// The corners of a box.
pub(super) fn box_corners(bounds: &DAabb) -> [DVec3; 8] {
    let side = |i: usize, axis: usize| {
        if i >> axis & 1 == 0 {
            bounds.min[axis]
        } else {
            bounds.max[axis]
        }
    };
    std::array::from_fn(|i| DVec3::new(side(i, 0), side(i, 1), side(i, 2)))
}

/// The distance by which the camera has to move backwards so that it sees all points and no more than it must, in m, with this
/// width of the picture relative to what fits into it; `None` where no distance is enough.
pub(super) fn retreat(view: &PinholeView, size: [u32; 2], (points, margin): (&[DVec3], f64)) -> Option<f64> {
    let [width, height] = size.map(f64::from);
    let ([fx, fy], [cx, cy]) = (view.focal, view.center);
    // The slopes of the edges: to the right, to the left, up and down.
    let slopes = [(width - cx) / fx, cx / fx, cy / fy, (height - cy) / fy].map(|slope| slope / margin);
    if slopes.iter().any(|slope| *slope <= 0.0) {
        return None;
    }
    let [right, left, up, down] = slopes;
    let needed = points.iter().map(|p| {
        let p = view.axes.transpose() * (*p - view.eye);
        // A point at x to the right and z behind is visible if x <= (back - z) right.
        let across = (p.x / right).max(-p.x / left);
        p.z + across.max(p.y / up).max(-p.y / down)
    });
    let back = needed.fold(f64::NEG_INFINITY, f64::max);
    back.is_finite().then_some(back)
}
