//! The names of columns with their aliases, and the positions of columns in a file.

use crate::{
    assets::camera_path::{PathProblem, PathProblems},
    camera::{CameraDesc, intrinsics},
    value::UnknownName,
};

use super::table::Row;

/// The name of each column and its aliases; `*` stands for x, y or z.
const NAMES: &[(&str, &str)] = &[
    (
        "frame",
        "frames frame_number framenumber frame_no frameno frame_num frame_id frame_index frame_idx fr",
    ),
    ("time", "t timestamp time_s time_sec time_seconds seconds secs sec"),
    (
        "eye_*",
        "* t* t_* eye* pos_* pos* position_* position* p_* cam_* cam* camera_* cam_pos_* camera_pos_* \
         camera_position_* location_* location* loc_* loc* translate_* translate* translation_* translation* trans_* \
         origin_* from_* lookfrom_* look_from_* pose_position_*",
    ),
    (
        "target_*",
        "target* tgt_* tgt* lookat_* lookat* look_at_* at_* aim_* aim* to_* center_* centre_* interest_* \
         center_of_interest_* coi_* poi_* point_of_interest_* focus_point_*",
    ),
    ("up_*", "up* up_vector_* upvector_* up_vec_* vup_* world_up_*"),
    ("roll", "bank roll_deg roll_degrees"),
    (
        "q*",
        "q_* quat_* quat* quaternion_* rotation_quaternion_* orientation_* pose_orientation_*",
    ),
    (
        "qw",
        "q_w quat_w quatw quaternion_w rotation_quaternion_w orientation_w pose_orientation_w",
    ),
    (
        "rot_*",
        "r* r_* rot* rotate_* rotate* rotation_* rotation* euler_* euler* rotation_euler_*",
    ),
    (
        "fov",
        "vfov v_fov yfov y_fov fov_y fovy fov_v fov_deg fov_degrees vertical_fov fov_vertical vertical_field_of_view",
    ),
    (
        "fov_x",
        "hfov h_fov xfov x_fov fovx fov_h horizontal_fov fov_horizontal horizontal_field_of_view",
    ),
    (
        "focal_length",
        "focal focallength focal_mm focal_length_mm lens lens_mm",
    ),
    (
        "sensor_width",
        "sensorwidth sensor_w sensor_width_mm film_width filmback_width haperture",
    ),
    (
        "sensor_height",
        "sensorheight sensor_h sensor_height_mm film_height filmback_height vaperture",
    ),
    (
        "focus_distance",
        "focus focusdistance focus_dist focal_distance focaldistance dof_distance",
    ),
    ("fstop", "f_stop fnumber f_number aperture_fstop"),
    ("aperture_radius", "apertureradius lens_radius"),
    ("shutter_open", "shutteropen shutter_start"),
    ("shutter_close", "shutterclose shutter_end"),
    ("readout", "readout_time rolling_shutter"),
    ("ipd", "interaxial eye_separation interpupillary_distance"),
    ("convergence", "convergence_distance"),
    ("shift_x", "shiftx lens_shift_x"),
    ("shift_y", "shifty lens_shift_y"),
    ("interp", "interpolation interp_mode"),
    ("name", "label shot shot_name camera_name marker comment note"),
];

/// The least length of an alias that is suggested: short names are similar to everything.
const SHORTEST_SUGGESTION: usize = 4;

/// Pairs of a column's name and a name or alias. Names come first, so that suggestions prefer them.
fn patterns() -> impl Iterator<Item = (&'static str, &'static str)> {
    let of_pinholes = intrinsics::COLUMNS.iter().map(|column| (column.name, column.aliases));
    let all = NAMES.iter().copied().chain(of_pinholes);
    let own = all.clone().map(|(name, _)| (name, name));
    own.chain(all.flat_map(|(name, others)| others.split_whitespace().map(move |other| (name, other))))
}

/// The name in lower case, with `_` for other separators.
fn plain(word: &str) -> String {
    let plain: String = word
        .trim()
        .chars()
        .map(|c| if matches!(c, ' ' | '.' | '-') { '_' } else { c })
        .collect();
    plain.to_lowercase()
}

/// The column whose name or alias is `word`.
pub(super) fn canonical(word: &str) -> Option<String> {
    let word = plain(word);
    patterns().find_map(|(name, pattern)| match pattern.split_once('*') {
        None => (pattern == word).then(|| name.to_owned()),
        Some((before, after)) => {
            let axis = word.strip_prefix(before)?.strip_suffix(after)?;
            matches!(axis, "x" | "y" | "z").then(|| name.replace('*', axis))
        }
    })
}

/// The tables of a scene file.
const TABLES: [&str; 8] = [
    "object",
    "light",
    "material",
    "texture",
    "background",
    "camera",
    "render",
    "output",
];

/// Whether `word` is the name of a value of a scene file, and none of a column of a camera path.
pub(super) fn is_value_name(word: &str) -> bool {
    let mut steps = word.split('.');
    match (steps.next(), steps.next()) {
        (Some("camera"), Some(kind)) => CameraDesc::NAMES.contains(&kind) && steps.next().is_some(),
        // Those of a model by itself.
        (Some("node" | "transform"), Some(_)) => true,
        (Some(table), Some(_)) => TABLES.contains(&table),
        _ => false,
    }
}

/// Whether a column by this name says of its row when it is and what follows it.
pub(super) fn is_of_time(name: &str) -> bool {
    ["frame", "time", "interp", "name"].contains(&name)
}

/// All names and aliases, with the patterns expanded.
fn all_names() -> impl Iterator<Item = String> {
    patterns().flat_map(|(_, pattern)| match pattern.contains('*') {
        true => ["x", "y", "z"].map(|axis| pattern.replace('*', axis)).to_vec(),
        false => vec![pattern.to_owned()],
    })
}

/// The positions of a file's columns.
#[derive(Debug)]
pub(super) struct Columns {
    /// The column's own name, or `None` for an unnamed column.
    names: Vec<Option<String>>,
    /// The suggestions for unknown columns.
    meant: Vec<String>,
}

impl Columns {
    /// Reads a header; unknown and duplicate columns become problems.
    pub fn read(header: &Row, problems: &mut PathProblems) -> Self {
        let mut columns = Self {
            names: Vec::new(),
            meant: Vec::new(),
        };
        for word in &header.cells {
            let name = canonical(word).filter(|_| !is_value_name(word));
            let first = name.as_deref().and_then(|name| columns.get(name));
            if let (Some(first), Some(name)) = (first, &name) {
                let twice = format!("{name} is given twice: by '{}' and by '{word}'", &header.cells[first]);
                problems.push(PathProblem::of_line(header.line, twice));
            } else if name.is_none() && !word.is_empty() && !is_value_name(word) {
                columns.unknown(header.line, word, problems);
            }
            columns.names.push(name);
        }
        columns
    }

    /// The columns of time and interpolation in a file of values.
    pub fn of_time(header: &Row) -> Self {
        let names = header
            .cells
            .iter()
            .map(|word| canonical(word).filter(|name| is_of_time(name)));
        Self {
            names: names.collect(),
            meant: Vec::new(),
        }
    }

    fn unknown(&mut self, line: usize, word: &str, problems: &mut PathProblems) {
        let names: Vec<_> = all_names()
            .filter(|name| name.len() >= SHORTEST_SUGGESTION || canonical(name).as_ref() == Some(name))
            .collect();
        let unknown = UnknownName::new("column", word, names.iter().map(String::as_str)).with_fallback(None);
        self.meant.extend(unknown.suggestion().and_then(canonical));
        problems.push(PathProblem::of_line(line, unknown.to_string()));
    }

    /// The index of a column by its name.
    pub fn get(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n.as_deref() == Some(name))
    }

    /// The indices of columns of which a file must have all or none; missing ones become a problem.
    pub fn group<const N: usize>(
        &self,
        line: usize,
        names: [&str; N],
        problems: &mut PathProblems,
    ) -> Option<[usize; N]> {
        let found = names.map(|name| self.get(name));
        if found.iter().all(Option::is_none) {
            return None;
        }
        self.report_missing(line, &names, problems);
        found.iter().all(Option::is_some).then(|| found.map(|i| i.unwrap_or(0)))
    }

    /// The indices of required columns; missing ones become a problem.
    pub fn needed<const N: usize>(
        &self,
        line: usize,
        names: [&str; N],
        problems: &mut PathProblems,
    ) -> Option<[usize; N]> {
        if names.iter().all(|name| self.get(name).is_none()) {
            self.report_missing(line, &names, problems);
        }
        self.group(line, names, problems)
    }

    fn report_missing(&self, line: usize, names: &[&str], problems: &mut PathProblems) {
        let missing: Vec<_> = names
            .iter()
            .copied()
            .filter(|name| self.get(name).is_none() && !self.is_meant(name))
            .collect();
        if !missing.is_empty() {
            let plural = if missing.len() > 1 { "s" } else { "" };
            problems.push(PathProblem::of_line(
                line,
                format!("missing column{plural}: {}", missing.join(" ")),
            ));
        }
    }

    /// Whether an unknown column was probably meant to be this one, so that its absence is not reported again.
    pub fn is_meant(&self, name: &str) -> bool {
        self.meant.iter().any(|meant| meant == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_go_by_many_names() {
        let cases = [
            ("Frame", "frame"),
            ("TX", "eye_x"),
            ("Cam Y", "eye_y"),
            ("location.z", "eye_z"),
            ("x", "eye_x"),
            ("look_at_x", "target_x"),
            ("LookAtZ", "target_z"),
            ("timestamp", "time"),
            ("vfov", "fov"),
            ("hFOV", "fov_x"),
            ("lens", "focal_length"),
            ("rotation_quaternion_w", "qw"),
            ("qx", "qx"),
            ("q_z", "qz"),
            ("rx", "rot_x"),
            ("rotation-euler-y", "rot_y"),
            ("shift_x", "shift_x"),
        ];
        for (word, name) in cases {
            assert_eq!(canonical(word).as_deref(), Some(name), "{word}");
        }
        assert_eq!(canonical("eye_w"), None);
        assert_eq!(canonical(""), None);
    }

    #[test]
    fn no_name_means_two_columns() {
        let mut names: Vec<_> = all_names().collect();
        names.sort_unstable();
        let twice: Vec<_> = names.windows(2).filter(|pair| pair[0] == pair[1]).collect();
        assert_eq!(twice, Vec::<&[String]>::new());
    }
}
