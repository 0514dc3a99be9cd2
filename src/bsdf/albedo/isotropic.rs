//! Facets that are as steep along one axis as along the other.
//!
//! The axes of the tables are the perceived roughness and the root of a cosine: of the direction
//! or, where all that counts is how far facets hide each other, of the direction on the stretched
//! surface ([`Ggx::stretched_cos`]). A test integrates the table again.

use super::table::{column, lerp, locate};
use crate::{bsdf::microfacet::Ggx, math::Vec3};

pub(super) const ROWS: usize = 48;
const COLUMNS: usize = 64;

/// The albedos for one roughness.
#[derive(Debug)]
struct IsotropicRow {
    /// Albedo of facets that reflect everything, by [`Ggx::stretched_cos`].
    mirrors: [f32; COLUMNS],
    /// The mean of Schlick's term over the light that they reflect, by the cosine.
    grazing: [f32; COLUMNS],
}

static TABLE: [IsotropicRow; ROWS] = read(include_bytes!("isotropic.bin"));

/// The number of bytes of a row.
const ROW_BYTES: usize = 2 * COLUMNS * size_of::<f32>();

/// Reads the table: row by row, all `mirrors` before all `grazing`, in little endian.
const fn read(bytes: &[u8; ROWS * ROW_BYTES]) -> [IsotropicRow; ROWS] {
    const EMPTY: IsotropicRow = IsotropicRow {
        mirrors: [0.0; COLUMNS],
        grazing: [0.0; COLUMNS],
    };
    let (numbers, _) = bytes.as_chunks::<4>();
    let mut rows = [EMPTY; ROWS];
    let mut i = 0;
    while i < ROWS * COLUMNS {
        let (row, column) = (i / COLUMNS, i % COLUMNS);
        let first = 2 * COLUMNS * row + column;
        rows[row].mirrors[column] = f32::from_le_bytes(numbers[first]);
        rows[row].grazing[column] = f32::from_le_bytes(numbers[first + COLUMNS]);
        i += 1;
    }
    rows
}

/// The place of a roughness between two rows.
#[derive(Clone, Copy, Debug)]
pub struct RowPlace {
    row: u8,
    f: f32,
}

impl RowPlace {
    #[inline]
    pub fn of_roughness(roughness: f32) -> Self {
        let (i, f) = locate(roughness, ROWS);
        Self { row: i as u8, f }
    }

    #[inline]
    pub fn of_facets(ggx: &Ggx) -> Self {
        Self::of_roughness(ggx.alpha.x.sqrt())
    }

    /// The place between the two rows.
    #[inline(always)]
    pub(super) fn fraction(self) -> f32 {
        self.f
    }

    /// Linear between a pair of numbers of each row.
    #[inline]
    pub(super) fn between(self, of: impl Fn(usize) -> [f32; 2]) -> [f32; 2] {
        let i = usize::from(self.row);
        let ([a, b], [c, d]) = (of(i), of(i + 1));
        [lerp(a, c, self.f), lerp(b, d, self.f)]
    }

    /// The two rows.
    #[inline]
    pub(super) fn rows(self) -> RowPair {
        let i = usize::from(self.row);
        RowPair {
            rows: [&TABLE[i], &TABLE[i + 1]],
            f: self.f,
        }
    }
}

/// The albedo of even facets that reflect everything, without a margin.
pub(super) fn even_mirrors(ggx: &Ggx, wo: Vec3) -> f32 {
    RowPlace::of_facets(ggx).rows().mirrors(ggx.stretched_cos(wo))
}

/// The place of a cosine between two columns, and where between them.
#[inline(always)]
pub(super) fn place(column: f32) -> (usize, f32) {
    locate(column, COLUMNS)
}

/// The numbers of a row in the columns about a place.
#[inline(always)]
fn pair(row: &[f32; COLUMNS], i: usize) -> [f32; 2] {
    // The place is below the last column, which the compiler need not be told again.
    let i = i.min(COLUMNS - 2);
    [row[i], row[i + 1]]
}

/// Numbers of two neighbouring columns in two neighbouring rows.
pub(super) struct Nodes(pub [[f32; 2]; 2]);

impl Nodes {
    /// Linear between them: at `f` between the columns and at `g` between the rows.
    #[inline(always)]
    pub fn between(&self, f: f32, g: f32) -> f32 {
        let [low, high] = self.0;
        lerp(lerp(low[0], low[1], f), lerp(high[0], high[1], f), g)
    }
}

/// The two rows between which a roughness lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowPair {
    rows: [&'static IsotropicRow; 2],
    f: f32,
}

impl RowPair {
    /// The nodes of [`RowPair::mirrors`] about a place.
    #[inline(always)]
    pub fn mirrors_about(self, i: usize) -> Nodes {
        let [low, high] = self.rows;
        Nodes([pair(&low.mirrors, i), pair(&high.mirrors, i)])
    }

    /// The nodes of [`RowPair::grazing`] about a place.
    #[inline(always)]
    pub fn grazing_about(self, i: usize) -> Nodes {
        let [low, high] = self.rows;
        Nodes([pair(&low.grazing, i), pair(&high.grazing, i)])
    }

    /// Albedo of facets that reflect everything, by [`Ggx::stretched_cos`].
    #[inline(always)]
    pub fn mirrors(self, stretched_cos: f32) -> f32 {
        let (i, f) = place(column(stretched_cos));
        self.mirrors_about(i).between(f, self.f)
    }

    /// The mean of Schlick's term over the light that facets reflect, by the cosine.
    #[inline(always)]
    pub fn grazing(self, cos: f32) -> f32 {
        let (i, f) = place(column(cos));
        self.grazing_about(i).between(f, self.f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::albedo::{
        integral::{FacetGrid, direction, facets, reflected},
        table::node,
    };

    const POINTS: FacetGrid = FacetGrid {
        turns: 24,
        slopes: 48,
        turn: 0.5,
        shift: 0.0,
    };

    /// The direction whose [`Ggx::stretched_cos`] is `t`.
    fn stretched_direction(ggx: &Ggx, t: f32) -> Vec3 {
        let a = ggx.alpha.x;
        let cos = t * a / (1.0 - t * t + t * t * a * a).sqrt();
        direction(cos.min(1.0))
    }

    fn integrated(i: usize) -> impl Iterator<Item = f32> {
        let ggx: Ggx = facets(node(i, ROWS));
        let cos = |j| {
            let root: f32 = node(j, COLUMNS);
            (root * root).max(1e-4)
        };
        let mirrors = move |j| reflected(POINTS, &ggx, stretched_direction(&ggx, cos(j)))[0];
        let grazing = move |j| reflected(POINTS, &ggx, direction(cos(j)))[1];
        (0..COLUMNS).map(mirrors).chain((0..COLUMNS).map(grazing))
    }

    #[test]
    fn the_table_equals_the_integrals() {
        for (i, row) in TABLE.iter().enumerate() {
            let table = row.mirrors.iter().chain(&row.grazing);
            assert!(
                table.copied().map(f32::to_bits).eq(integrated(i).map(f32::to_bits)),
                "row {i}"
            );
        }
    }

    #[test]
    #[ignore = "writes the table"]
    fn write_the_table() {
        let numbers = (0..ROWS).flat_map(integrated);
        let bytes: Vec<u8> = numbers.flat_map(f32::to_le_bytes).collect();
        std::fs::write("src/bsdf/albedo/isotropic.bin", bytes).expect("the source is writable");
    }
}
