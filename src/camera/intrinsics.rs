//! Intrinsics that a camera path gives: a column, a row of [`COLUMNS`].
//!
//! They are in the units of the scene file. What becomes of them is in [`pinhole`](super::pinhole).

/// The number that a column gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Across (0) or down (1).
    Focal(usize),
    Center(usize),
    Skew,
    Size(usize),
    /// By the index of the coefficient.
    OpenCv(usize),
    KannalaBrandt(usize),
}

/// A column.
#[derive(Debug)]
pub struct IntrinsicsColumn {
    pub name: &'static str,
    /// Other names, with spaces between.
    pub aliases: &'static str,
    pub(super) part: Part,
}

const fn column(name: &'static str, aliases: &'static str, part: Part) -> IntrinsicsColumn {
    IntrinsicsColumn { name, aliases, part }
}

/// All columns.
pub const COLUMNS: [IntrinsicsColumn; 23] = [
    column("fx", "fl_x focal_x focal_length_x", Part::Focal(0)),
    column("fy", "fl_y focal_y focal_length_y", Part::Focal(1)),
    column("cx", "principal_x principal_point_x", Part::Center(0)),
    column("cy", "principal_y principal_point_y", Part::Center(1)),
    column("skew", "", Part::Skew),
    column("width", "image_width", Part::Size(0)),
    column("height", "image_height", Part::Size(1)),
    column("k1", "", Part::OpenCv(0)),
    column("k2", "", Part::OpenCv(1)),
    column("p1", "", Part::OpenCv(2)),
    column("p2", "", Part::OpenCv(3)),
    column("k3", "", Part::OpenCv(4)),
    column("k4", "", Part::OpenCv(5)),
    column("k5", "", Part::OpenCv(6)),
    column("k6", "", Part::OpenCv(7)),
    column("s1", "", Part::OpenCv(8)),
    column("s2", "", Part::OpenCv(9)),
    column("s3", "", Part::OpenCv(10)),
    column("s4", "", Part::OpenCv(11)),
    column("fisheye_k1", "", Part::KannalaBrandt(0)),
    column("fisheye_k2", "", Part::KannalaBrandt(1)),
    column("fisheye_k3", "", Part::KannalaBrandt(2)),
    column("fisheye_k4", "", Part::KannalaBrandt(3)),
];

/// The names of all columns.
pub(super) const NAMES: [&str; COLUMNS.len()] = {
    let mut names = [""; COLUMNS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = COLUMNS[i].name;
        i += 1;
    }
    names
};

impl IntrinsicsColumn {
    /// Whether the column may have this number.
    pub fn takes(&self, v: f64) -> bool {
        match self.part {
            Part::Focal(_) => v > 0.0 && v <= f64::from(f32::MAX),
            Part::Size(_) => v >= 1.0 && v <= f64::from(u32::MAX) && v.fract() == 0.0,
            _ => v.is_finite(),
        }
    }

    /// The numbers that it takes, in words.
    pub fn expected(&self) -> &'static str {
        match self.part {
            Part::Focal(_) => "above 0",
            Part::Size(_) => "a whole number above 0",
            _ => "finite",
        }
    }
}

/// The intrinsics of a camera path; `None` keeps those of the scene's camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IntrinsicsOverrides(
    /// In the order of [`COLUMNS`].
    pub [Option<f64>; COLUMNS.len()],
);

impl IntrinsicsOverrides {
    pub(super) fn given(&self) -> impl Iterator<Item = (&'static IntrinsicsColumn, f64)> {
        COLUMNS
            .iter()
            .zip(self.0)
            .filter_map(|(column, value)| Some((column, value?)))
    }

    /// The names of the columns that are given.
    pub fn columns(&self) -> impl Iterator<Item = &'static str> {
        self.given().map(|(column, _)| column.name)
    }

    pub(super) fn part(&self, part: Part) -> Option<f64> {
        self.given().find(|(column, _)| column.part == part).map(|(_, v)| v)
    }

    /// Whether the numbers may be those of a lens.
    pub fn is_valid(&self) -> bool {
        self.given().all(|(column, v)| column.takes(v))
    }

    /// Whether coefficients of two models are given.
    pub fn is_of_two_models(&self) -> bool {
        let has = |is: fn(Part) -> bool| self.given().any(|(column, _)| is(column.part));
        has(|part| matches!(part, Part::OpenCv(_))) && has(|part| matches!(part, Part::KannalaBrandt(_)))
    }

    /// The size of the pictures for which they hold, in pixels.
    pub fn size(&self) -> Option<[f64; 2]> {
        Some([self.part(Part::Size(0))?, self.part(Part::Size(1))?])
    }
}
