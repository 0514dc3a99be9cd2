//! Quaternions in tables of values: four columns, which move as one rotation on the shortest arc.

use std::{
    collections::{BTreeMap, HashMap},
    sync::Arc,
};

use glam::DQuat;

use super::{
    Entity,
    cell_faults::Faults,
    parts::QUATERNION,
    values::{Column, Curve, Values},
};
use crate::{
    assets::camera_path::{ValueCell, ValueColumn, ValueTable},
    math::track::Track,
    value::Problem,
};

/// The columns of a rotation.
#[derive(Default)]
struct RotationColumns {
    quaternion: [Option<usize>; 4],
    angle: Option<usize>,
}

/// Lets the columns of each quaternion move as one rotation. `sources` are those of the columns of `values`.
pub(super) fn join(values: &mut Values, sources: &[(&ValueTable, &ValueColumn)], faults: &mut Faults<'_>) {
    let mut rotations: BTreeMap<(Entity, Vec<String>), RotationColumns> = BTreeMap::new();
    for (at, column) in values.columns.iter().enumerate() {
        let Some((last, key)) = column.path.split_last() else {
            continue;
        };
        if key.last().is_none_or(|key| key != "rotate") {
            continue;
        }
        let own = rotations.entry((column.entity, key.to_vec())).or_default();
        match QUATERNION.iter().position(|name| name == last) {
            Some(component) => own.quaternion[component] = Some(at),
            None => own.angle = Some(at),
        }
    }
    for RotationColumns { quaternion, angle } in rotations.into_values() {
        let Some(first) = quaternion.iter().flatten().next().copied() else {
            continue;
        };
        let problem = |message: String| Problem {
            span: None,
            message,
            help: None,
        };
        let header = |at: usize| values.head(&values.columns[at]);
        if let Some(angle) = angle {
            let other = &values.columns[angle].name;
            let message = format!("a quaternion and `{other}` are the same rotation: give one of them");
            faults.add(header(first), problem(message));
            continue;
        }
        let whole: Option<Vec<usize>> = quaternion.into_iter().collect();
        let file = |column: &Column| column.file;
        let is_of_one_file = |at: &usize| file(&values.columns[*at]) == file(&values.columns[first]);
        let Some(whole) = whole.filter(|whole| whole.iter().all(is_of_one_file)) else {
            let message = format!("a quaternion needs the columns {} in one table", QUATERNION.join(", "));
            faults.add(header(first), problem(message));
            continue;
        };
        if matches!(values.columns[first].curve, Curve::Random(_)) {
            // Its numbers are drawn each by itself, and the rotation is normalised.
            continue;
        }
        match track(&whole, sources) {
            Ok(track) => {
                let track = Arc::new(track);
                for (component, at) in whole.into_iter().enumerate() {
                    values.columns[at].curve = Curve::Rotation(Arc::clone(&track), component);
                }
            }
            Err((at, row, message)) => {
                let (column, table) = (&values.columns[at], sources[at].0);
                let (path, line) = (&values.files[column.file].path, table.rows[row as usize].line);
                let origin = format!("{}:{line}: {}", path.display(), column.name);
                faults.add(origin, problem(message));
            }
        }
    }
}

/// The rotations of these four columns over time; or the column and the row of a fault, and what it is.
fn track(columns: &[usize], sources: &[(&ValueTable, &ValueColumn)]) -> Result<Track<DQuat>, (usize, u32, String)> {
    let mut cells: BTreeMap<u32, HashMap<usize, f64>> = BTreeMap::new();
    for &at in columns {
        for (row, cell) in &sources[at].1.cells {
            let ValueCell::Number(v) = cell else {
                return Err((at, *row, "expected a number".to_owned()));
            };
            cells.entry(*row).or_default().insert(at, *v);
        }
    }
    let (table, source) = sources[columns[0]];
    let mut keys = Vec::with_capacity(cells.len());
    for (row, numbers) in cells {
        let mut rotation = [0.0; 4];
        for (component, at) in rotation.iter_mut().zip(columns) {
            let missing = || (*at, row, "a row gives all of a quaternion or nothing".to_owned());
            *component = *numbers.get(at).ok_or_else(missing)?;
        }
        let rotation = DQuat::from_array(rotation);
        let length = rotation.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err((columns[0], row, "a quaternion has a length above 0".to_owned()));
        }
        let row = table.rows[row as usize];
        keys.push((row.frame, Some(rotation), source.interp.unwrap_or(row.interp)));
    }
    Ok(Track::new(keys))
}
