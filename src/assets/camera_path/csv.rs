//! `camera_path.csv`: a header with names of columns, and a row for every frame or keyframe.
//!
//! Cells are separated by commas, semicolons or tabs, whichever the header has most of, or as a line `sep=;` before it
//! says. UTF-8, with or without a byte order
//! mark; any line ends. Blank lines, rows of empty cells and lines that begin with `#` are skipped, but `# rotation_order: ZXY` is
//! heard, and so is a header behind `#` above numbers, as numpy writes it. Columns without a name before the first one are an index
//! of pandas and skipped. Columns come in any order and their names in any case; a space, a point or a hyphen in a name counts as
//! `_`. Metres, degrees, right-handed; the camera looks along its -z with +y up.
//!
//! | column | type | unit | needed |
//! |---|---|---|---|
//! | `frame` | whole number | frames | this or `time`; of both, `frame` counts |
//! | `time` | number | s | needs a frame rate |
//! | `eye_x eye_y eye_z` | numbers | m | yes |
//! | `target_x target_y target_z` | numbers, not the eye | m | one of these three |
//! | `qx qy qz qw` | quaternion of unit length within 1e-3, camera to world | | |
//! | `rot_x rot_y rot_z` | angles; the order must be said | degrees | |
//! | `up_x up_y up_z` | numbers, with a target; where no row says anything +y | | |
//! | `roll` | number, with a target | degrees | |
//! | `fov`, `fov_x` or `focal_length` | vertical or horizontal angle, or length above 0 | degrees, mm | |
//! | `sensor_width` or `sensor_height` | number above 0 | mm | |
//! | `fstop` or `aperture_radius` | number above 0; at least 0 | , m | |
//! | `focus_distance` | number above 0 | m | |
//! | `shutter_open`, `shutter_close` | numbers; `shutter_open` is 0 where it is empty | frames | |
//! | `shift_x`, `shift_y` | numbers | picture widths | |
//! | `fx`, `fy`, `cx`, `cy`, `skew` | intrinsics of a pinhole: numbers above 0, numbers | pixels | |
//! | `width`, `height` | the size of the pictures of the intrinsics, whole numbers above 0 | pixels | |
//! | `k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4` or `fisheye_k1` to `fisheye_k4` | its distortion | | |
//! | `readout` | time of a rolling shutter | frames | |
//! | `ipd`, `convergence` | numbers above 0: the distances of stereo | m | |
//! | `interp` | `smooth`, `linear` or `hold`, from this row to the next; empty is `smooth` | | |
//! | `name` | text | | |
//!
//! Frames must rise. A time makes the frame `time * fps`; one within half a millisecond (at most 0.05 frames) of a whole
//! frame is that frame, because files round times, and any other lies between two frames. An empty cell of a column
//! that is not needed says nothing: what it is about moves past that row, from the rows before to the rows after that
//! do say something, and where only one side does, has that side's value. A cut between two shots is a row with `hold`
//! before it, also where there is a row at every frame: motion blur would run through it otherwise.

use std::fmt::Write as _;

use glam::DQuat;

use crate::camera::{
    intrinsics::{COLUMNS, IntrinsicsOverrides},
    path::CameraPath,
};

use super::{
    CameraPathFormat, CameraPathOptions, PathProblem, PathProblems, Source,
    held::{Holds, POSES, Target, Written},
    still::Still,
};

mod columns;
pub mod document;
pub mod edit;
mod key_cells;
mod layout;
mod lines;
mod rows;
mod table;
pub mod values;

pub(super) const FORMAT: CameraPathFormat = CameraPathFormat {
    name: "csv",
    extensions: &["csv", "tsv"],
    names: &[],
    read,
    holds: Holds {
        names: true,
        view: true,
        center: true,
        pixels: true,
        skew: true,
        distortion: |_| true,
        ..POSES
    },
    write,
};

/// The camera path of a file.
fn read(source: &Source<'_>) -> Result<CameraPath, PathProblems> {
    read_bytes(source.bytes, source.options)
}

fn read_bytes(bytes: &[u8], options: &CameraPathOptions) -> Result<CameraPath, PathProblems> {
    let table = table::Table::read(bytes)?;
    let layout = layout::Layout::read(&table, options)?;
    let keys = rows::read(&table, &layout)?;
    CameraPath::new(&keys).map_err(|e| PathProblem::of_file(e.to_string()).into())
}

/// A row for every frame, with a quaternion, and the lens as it was given: in pixels or by its angle.
fn write(target: &Target<'_>, cameras: &[Still]) -> Written {
    let intrinsics = intrinsics(cameras)?;
    let given = |i: &usize| intrinsics.iter().any(|lens| lens.0[*i].is_some());
    let pixel_columns: Vec<usize> = (0..COLUMNS.len()).filter(given).collect();
    let has_angle = pixel_columns.is_empty();
    let has_view = has_angle
        && cameras
            .iter()
            .any(|camera| camera.fov.is_some() || camera.pixels.is_some());
    let shifts: Vec<[f64; 2]> = cameras.iter().map(shift).collect();
    let has_shift = has_angle && shifts.iter().any(|shift| *shift != [0.0; 2]);
    let has_names = cameras.iter().any(|camera| camera.name.is_some());
    let mut text = "frame,eye_x,eye_y,eye_z,qx,qy,qz,qw".to_owned();
    for i in &pixel_columns {
        write!(text, ",{}", COLUMNS[*i].name).expect("a text grows");
    }
    let columns = [
        (has_view, ",fov"),
        (has_shift, ",shift_x,shift_y"),
        (has_names, ",name"),
    ];
    text.extend(
        columns
            .iter()
            .filter(|(is_there, _)| *is_there)
            .map(|(_, names)| *names),
    );
    for (i, (camera, [x, y])) in cameras.iter().zip(shifts).enumerate() {
        let rotation = DQuat::from_mat3(&camera.axes).to_array();
        write!(text, "\n{}", camera.frame).expect("a text grows");
        let view = has_view.then(|| camera.view("csv")).transpose()?;
        let shift = has_shift.then_some([x, y]);
        let pixels = pixel_columns
            .iter()
            .map(|column| intrinsics[i].0[*column].unwrap_or_default());
        let numbers = camera.eye.to_array().into_iter().chain(rotation).chain(pixels);
        for number in numbers.chain(view).chain(shift.into_iter().flatten()) {
            write!(text, ",{}", edit::number(number)).expect("a text grows");
        }
        if has_names {
            let name = camera.name.as_deref().unwrap_or_default().replace('"', "\"\"");
            write!(text, ",\"{name}\"").expect("a text grows");
        }
    }
    target.file(text + "\n")
}

/// The intrinsics of cameras whose lenses were given in pixels; none if one was not.
fn intrinsics(cameras: &[Still]) -> Result<Vec<IntrinsicsOverrides>, String> {
    if !cameras.iter().all(|camera| camera.is_calibrated) {
        return Ok(Vec::new());
    }
    let of = |camera: &Still| Ok(IntrinsicsOverrides::of(&camera.lens("csv")?.lens()?).unwrap_or_default());
    let all: Vec<IntrinsicsOverrides> = cameras.iter().map(of).collect::<Result<_, String>>()?;
    let columns = std::array::from_fn(|i| all.iter().find_map(|lens| lens.0[i]));
    match IntrinsicsOverrides(columns).is_of_two_models() {
        true => Err("csv files have one model of distortion: fisheyes and other lenses are two files".to_owned()),
        false => Ok(all),
    }
}

/// The shift of a lens, in picture widths.
fn shift(camera: &Still) -> [f64; 2] {
    let Some(lens) = &camera.pixels else { return [0.0; 2] };
    let (Some([width, height]), [cx, cy]) = (lens.size, lens.center.map(Option::unwrap_or_default)) else {
        return [0.0; 2];
    };
    let shift = [(0.5 * width - cx) / width, (cy - 0.5 * height) / width];
    // Rounding is no shift.
    shift.map(|part| if part.abs() < 1e-12 { 0.0 } else { part })
}

#[cfg(test)]
mod tests;
