//! Conversion of a key to cells, by the columns of a file.

use glam::{DMat3, DQuat, DVec3};

use super::{
    edit::{AddedColumn, CellChange, EditError, number},
    layout::{ApertureKind, Clock, Layout, OrientationColumns, SensorKind, ViewKind},
};
use crate::camera::{
    LensOverrides, LookAt, Pose, RotationOrder,
    lens::{Aperture, FieldOfView, Sensor},
    path::{Interp, PathKey},
};

/// The changes of cells that store a key in a row.
#[derive(Debug)]
pub(super) struct KeyCells<'a> {
    layout: &'a Layout,
    /// The number of columns before any is added.
    columns: usize,
    /// The number of the other keys.
    others: usize,
    pub cells: Vec<CellChange>,
    pub added: Vec<AddedColumn>,
}

impl<'a> KeyCells<'a> {
    pub fn new(layout: &'a Layout, columns: usize, others: usize) -> Self {
        Self {
            layout,
            columns,
            others,
            cells: Vec::new(),
            added: Vec::new(),
        }
    }

    fn set(&mut self, column: usize, v: f64) {
        self.cells.push(CellChange::number(column, v));
    }

    /// Sets a cell of a new column.
    fn add(&mut self, name: &'static str, v: f64, others: Vec<Option<f64>>) {
        self.set(self.columns + self.added.len(), v);
        self.added.push(AddedColumn { name, others });
    }

    pub fn frame(&mut self, frame: f64) {
        self.cells.push(frame_cell(self.layout, frame));
    }

    pub fn eye(&mut self, eye: DVec3) {
        for (column, v) in self.layout.eye.into_iter().zip(eye.to_array()) {
            self.set(column, v);
        }
    }

    /// Sets the orientation of `pose`, which looks at `at`. `near` are the path's angles near the frame, if it has angles.
    pub fn orientation(&mut self, at: &LookAt, pose: &Pose, near: Option<DVec3>) {
        let axes = pose.world_from_camera().matrix3;
        match self.layout.orientation {
            OrientationColumns::Target { target, up, roll } => {
                for (column, v) in target.into_iter().zip(at.target.to_array()) {
                    self.set(column, v);
                }
                self.up(at.up, up);
                match roll {
                    Some(column) => self.set(column, at.roll),
                    None if at.roll != 0.0 => self.add("roll", at.roll, vec![Some(0.0); self.others]),
                    None => {}
                }
            }
            OrientationColumns::Quaternion(columns) => {
                let q = DQuat::from_mat3(&axes);
                for (column, v) in columns.into_iter().zip(q.to_array()) {
                    self.set(column, v);
                }
            }
            OrientationColumns::Euler { degrees, order } => {
                let angles = unwound(order, &axes, near);
                for (column, v) in degrees.into_iter().zip(angles.to_array()) {
                    self.set(column, v);
                }
            }
        }
    }

    fn up(&mut self, up: DVec3, columns: Option<[usize; 3]>) {
        match columns {
            Some(columns) => {
                for (column, v) in columns.into_iter().zip(up.to_array()) {
                    self.set(column, v);
                }
            }
            None if up != DVec3::Y => {
                let names = ["up_x", "up_y", "up_z"];
                for ((name, v), other) in names.into_iter().zip(up.to_array()).zip(DVec3::Y.to_array()) {
                    self.add(name, v, vec![Some(other); self.others]);
                }
            }
            None => {}
        }
    }

    /// Sets the lens parameters of the key. `others` returns those of the other keys, for new columns.
    ///
    /// # Errors
    /// The file stores one of them in another form, such as a focal length instead of an angle.
    pub fn lens(&mut self, lens: &LensOverrides, others: &dyn Fn() -> Vec<LensOverrides>) -> Result<(), EditError> {
        let of = |value: &dyn Fn(&LensOverrides) -> Option<f64>| others().iter().map(value).collect::<Vec<_>>();
        match (self.layout.view, lens.view) {
            (Some((ViewKind::Vertical, column)), Some(FieldOfView::Vertical(v)))
            | (Some((ViewKind::Horizontal, column)), Some(FieldOfView::Horizontal(v)))
            | (Some((ViewKind::FocalLength, column)), Some(FieldOfView::FocalLength(v))) => self.set(column, v),
            (Some(_), Some(_)) => return Err(EditError::OtherWay("the view")),
            (None, Some(view)) => {
                let (name, v) = view_column(view);
                let other = |lens: &LensOverrides| lens.view.map(view_column).filter(|c| c.0 == name).map(|c| c.1);
                self.add(name, v, of(&other));
            }
            (_, None) => {}
        }
        // The viewer does not change the sensor, which the file or the scene defines.
        match (self.layout.sensor, lens.sensor) {
            (Some((SensorKind::Width, column)), Some(Sensor::Width(v)))
            | (Some((SensorKind::Height, column)), Some(Sensor::Height(v))) => self.set(column, v),
            _ => {}
        }
        match (self.layout.aperture, lens.aperture) {
            (Some((ApertureKind::FStop, column)), Some(Aperture::FStop(v)))
            | (Some((ApertureKind::Radius, column)), Some(Aperture::Radius(v))) => self.set(column, v),
            (Some(_), Some(_)) => return Err(EditError::OtherWay("the aperture")),
            (None, Some(aperture)) => {
                let (name, v) = aperture_column(aperture);
                let other =
                    |lens: &LensOverrides| lens.aperture.map(aperture_column).filter(|c| c.0 == name).map(|c| c.1);
                self.add(name, v, of(&other));
            }
            (_, None) => {}
        }
        let layout = self.layout;
        let mut plain =
            |column: Option<usize>, name, value: fn(&LensOverrides) -> Option<f64>| match (column, value(lens)) {
                (Some(column), Some(v)) => self.set(column, v),
                (None, Some(v)) => self.add(name, v, of(&value)),
                (_, None) => {}
            };
        plain(layout.focus_distance, "focus_distance", |lens| lens.focus_distance);
        plain(layout.shift[0], "shift_x", |lens| lens.shift_x);
        plain(layout.shift[1], "shift_y", |lens| lens.shift_y);
        Ok(())
    }

    /// Sets the interpolation and the name, if the file has columns for them.
    pub fn words(&mut self, key: &PathKey) {
        let interp = match key.interp {
            Interp::Smooth => None,
            Interp::Linear => Some("linear".to_owned()),
            Interp::Step => Some("hold".to_owned()),
        };
        let words = [(self.layout.interp, interp), (self.layout.name, key.name.clone())];
        for (column, text) in words {
            if let (Some(column), Some(text)) = (column, text) {
                self.cells.push(CellChange { column, text });
            }
        }
    }
}

/// The cell of a key's frame or time.
pub(super) fn frame_cell(layout: &Layout, frame: f64) -> CellChange {
    match layout.clock {
        Clock::Frame(column) => CellChange::number(column, frame),
        // Microseconds are precise enough at all common frame rates.
        Clock::Time { column, fps } => CellChange {
            column,
            text: number((frame / fps * 1e6).round() / 1e6),
        },
    }
}

fn view_column(view: FieldOfView) -> (&'static str, f64) {
    match view {
        FieldOfView::Vertical(v) => ("fov", v),
        FieldOfView::Horizontal(v) => ("fov_x", v),
        FieldOfView::FocalLength(v) => ("focal_length", v),
    }
}

fn aperture_column(aperture: Aperture) -> (&'static str, f64) {
    match aperture {
        Aperture::Radius(v) => ("aperture_radius", v),
        Aperture::FStop(v) => ("fstop", v),
    }
}

/// The angles of a rotation, shifted by whole turns to be closest to `near`.
fn unwound(order: RotationOrder, axes: &DMat3, near: Option<DVec3>) -> DVec3 {
    let angles = order.angles(axes);
    let Some(near) = near else { return angles };
    angles + ((near - angles) / 360.0).round() * 360.0
}
