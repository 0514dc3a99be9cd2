//! The picture that a rectangle or a disk shines with: where it is bright, and how its bright parts are sampled.
//!
//! The picture is cut into blocks, and these into cells. A block is chosen by its light and by the solid angle under which it is
//! seen, a cell by its light alone. A picture that is nearly even is not sampled: the surface is, as without a picture.

use super::{LightFind, area::AreaSample};
use crate::{
    math::{DVec3, Rgb, Vec2, Vec3, distribution::PiecewiseConstant2D, parallel},
    texture::{Color, ScenePlace, TexturePoint, Textures},
    value::{ColorSource, Point, Problem, Spanned},
};

/// The blocks along a side.
const BLOCKS: usize = 8;

/// The most cells along a side of a block.
const MAX_CELLS: usize = 32;

/// The points of a cell along a side at which a texture is evaluated, at least: light leaks from a texel into its neighbours.
const MIN_POINTS: usize = 2;

/// The points of a cell along a side at which a texture with texels is evaluated, at most.
const MAX_POINTS_OF_IMAGE: usize = 8;

/// The variance of the picture, in squares of its mean, up to which it is nearly even.
const MAX_VARIANCE: f64 = 0.05;

/// The least light of a cell, relative to the mean: cells that are black at all evaluated points can still be sampled.
const FLOOR: f64 = 0.001;

/// The shape that is cut out of a screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outline {
    Rectangle,
    /// The ellipse that touches the sides.
    Ellipse,
}

/// The place of a picture in the world: a rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Screen {
    /// The point with the coordinates 0 and 0.
    pub corner: Vec3,
    /// The sides along which the coordinates grow to 1.
    pub sides: [Vec3; 2],
    /// Unit.
    pub normal: Vec3,
    pub outline: Outline,
}

impl Screen {
    /// The rectangle with this centre and these half sides, to the right and upwards as seen along the unit `normal`: the picture
    /// is upright for those on whom it shines.
    pub fn new(center: DVec3, [right, up]: [DVec3; 2], normal: Vec3, outline: Outline, origin: DVec3) -> Self {
        Self {
            corner: Point::new(center + right - up).relative_to(origin),
            sides: [right * -2.0, up * 2.0].map(|side| side.as_vec3()),
            normal,
            outline,
        }
    }
}

/// The picture of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    pub(super) color: Color,
    pub(super) screen: Screen,
    /// Whether the radiance of the lamp is that of the mean of the picture.
    pub(super) keeps_power: bool,
}

/// The light of a picture.
#[derive(Clone, Debug)]
pub struct PictureMap {
    /// The mean over the picture and its channels.
    mean: f32,
    /// `None` if the picture is nearly even.
    blocks: Option<Blocks>,
}

#[derive(Clone, Debug)]
struct Blocks {
    /// The light of each block, row by row.
    weights: [[f32; BLOCKS]; BLOCKS],
    /// The cells of each block, row by row.
    cells: Vec<PiecewiseConstant2D>,
    /// The cells along each side of a block.
    size: [usize; 2],
}

/// The sums of the light of some points.
#[derive(Clone, Copy, Default)]
struct Sums {
    light: f64,
    squares: f64,
    count: f64,
}

/// The sums of the weights of blocks up to and with each, as they are seen from a point.
struct SeenBlocks {
    rows: [f32; BLOCKS],
    columns: [[f32; BLOCKS]; BLOCKS],
}

impl Screen {
    /// The coordinates of a point of its plane.
    #[inline]
    pub fn st(&self, p: Vec3) -> Vec2 {
        let from_corner = p - self.corner;
        Vec2::from_array(self.sides.map(|side| from_corner.dot(side) / side.length_squared()))
    }

    #[inline]
    pub fn point(&self, st: Vec2) -> Vec3 {
        self.corner + self.sides[0] * st.x + self.sides[1] * st.y
    }

    fn texture_point(&self, st: Vec2) -> TexturePoint {
        let (place, [dpdu, dpdv]) = (TexturePoint::in_scene(self.point(st), self.normal), self.sides);
        TexturePoint {
            uv: st,
            dpdu,
            dpdv,
            scene: ScenePlace {
                dpdu,
                dpdv,
                ..place.scene
            },
            ..place
        }
    }

    /// In m^2, of the whole rectangle.
    fn area(&self) -> f32 {
        self.sides[0].cross(self.sides[1]).length()
    }

    pub fn contains(&self, st: Vec2) -> bool {
        match self.outline {
            Outline::Rectangle => true,
            Outline::Ellipse => (st - 0.5).length_squared() <= 0.25,
        }
    }

    /// The density of a point `p` of the surface by solid angle, in sr^-1, where `per_st` is its density by coordinates.
    #[inline]
    fn pdf(&self, from: Vec3, p: Vec3, per_st: f32) -> f32 {
        let to = p - from;
        let d2 = to.length_squared();
        let pdf = per_st * d2 * d2.sqrt() / (self.area() * to.dot(self.normal).abs());
        if pdf.is_finite() { pdf } else { 0.0 }
    }
}

impl Blocks {
    /// The weights of the blocks as they are seen from a point: their light times their approximate solid angle.
    #[inline]
    fn seen(&self, screen: &Screen, from: Vec3) -> SeenBlocks {
        const STEP: f32 = 1.0 / BLOCKS as f32;
        let [across, up] = screen.sides.map(|side| side * STEP);
        // Bounds the solid angle of the block next to the point.
        let radius_squared = (across.length_squared() + up.length_squared()) * 0.25;
        let radius = radius_squared.sqrt();
        let first = screen.corner + (across + up) * 0.5 - from;
        let height = first.dot(screen.normal).abs();
        let (mut rows, mut columns) = ([0.0; BLOCKS], [[0.0; BLOCKS]; BLOCKS]);
        let mut all = 0.0;
        for (i, (row, weights)) in columns.iter_mut().zip(&self.weights).enumerate() {
            let start = first + up * i as f32;
            let mut sum = 0.0;
            for (j, (to, weight)) in row.iter_mut().zip(weights).enumerate() {
                let d2 = (start + across * j as f32).length_squared() + radius_squared;
                sum += weight * (height + radius) / (d2 * d2.sqrt());
                *to = sum;
            }
            all += sum;
            rows[i] = all;
        }
        SeenBlocks { rows, columns }
    }

    /// The density of a cell by coordinates, where `block` is the probability of its block and `cell` that of the cell in it.
    #[inline]
    fn per_st(&self, block: f32, cell: f32) -> f32 {
        block * cell * (self.size[0] * self.size[1] * BLOCKS * BLOCKS) as f32
    }

    /// The density by coordinates with which a point is sampled.
    fn density(&self, screen: &Screen, from: Vec3, st: Vec2) -> f32 {
        let counts = self.size.map(|cells| cells * BLOCKS);
        let cell = |k: usize| ((st[k].max(0.0) * counts[k] as f32) as usize).min(counts[k] - 1);
        let (column, row) = (cell(0), cell(1));
        let (j, i) = (column / self.size[0], row / self.size[1]);
        let seen = self.seen(screen, from);
        let block = part(&seen.rows, i) * part(&seen.columns[i], j);
        let table = &self.cells[i * BLOCKS + j];
        self.per_st(block, table.pmf(column % self.size[0], row % self.size[1]))
    }

    /// The coordinates of a point by two uniform numbers in `[0, 1)`, and its density by coordinates.
    #[inline]
    fn sample(&self, screen: &Screen, from: Vec3, u: Vec2) -> (Vec2, f32) {
        let seen = self.seen(screen, from);
        let (i, row, v) = choose(&seen.rows, u.y);
        let (j, column, u) = choose(&seen.columns[i], u.x);
        let [x, y] = self.cells[i * BLOCKS + j].sample(Vec2::new(u, v));
        let place = |block: usize, cell: usize, within: f32, size: usize| {
            ((block * size + cell) as f32 + within) / (size * BLOCKS) as f32
        };
        let st = Vec2::new(
            place(j, x.index, x.within, self.size[0]),
            place(i, y.index, y.within, self.size[1]),
        );
        (st, self.per_st(row * column, x.pmf * y.pmf))
    }
}

/// The probability of a block in a list of sums.
#[inline]
fn part(sums: &[f32; BLOCKS], i: usize) -> f32 {
    (sums[i] - i.checked_sub(1).map_or(0.0, |i| sums[i])) / sums[BLOCKS - 1]
}

/// The block that a uniform number selects by sums, its probability, and a new uniform number.
#[inline]
fn choose(sums: &[f32; BLOCKS], u: f32) -> (usize, f32, f32) {
    let place = (u * sums[BLOCKS - 1]).min(sums[BLOCKS - 1].next_down());
    let i = sums[..BLOCKS - 1].iter().filter(|sum| **sum <= place).count();
    let before = i.checked_sub(1).map_or(0.0, |i| sums[i]);
    let within = (place - before) / (sums[i] - before);
    (i, part(sums, i), within.clamp(0.0, 1.0_f32.next_down()))
}

impl Picture {
    /// The picture of a texture, if there is one, on a screen.
    ///
    /// # Errors
    /// There is no such texture, or it is a colour.
    pub(super) fn new(
        texture: &Option<Spanned<ColorSource>>,
        screen: Screen,
        find: &LightFind<'_>,
    ) -> Result<Option<Self>, Problem> {
        let Some(source) = texture else {
            return Ok(None);
        };
        let color = (find.color)(source)?;
        if color.is_constant() {
            return Err(Problem::at(source.span(), "expected \"texture.NAME\", found a colour"));
        }
        Ok(Some(Self {
            color,
            screen,
            keeps_power: false,
        }))
    }

    /// The colour at coordinates of the screen. Numbers below 0, as colours outside of the working space have them, give no light.
    #[inline]
    fn color_at(&self, textures: &Textures<'_>, st: Vec2) -> Rgb {
        textures
            .color(&self.color, &self.screen.texture_point(st))
            .max(Rgb::BLACK)
    }

    /// The factor of the lamp's radiance at a point of its surface.
    #[inline]
    pub(super) fn factor(&self, textures: &Textures<'_>, map: &PictureMap, p: Vec3) -> Rgb {
        let color = self.color_at(textures, self.screen.st(p));
        if self.keeps_power && map.mean > 0.0 {
            color / map.mean
        } else {
            color
        }
    }

    /// The mean factor of the lamp's radiance.
    pub(super) fn mean_factor(&self, map: &PictureMap) -> f32 {
        if self.keeps_power { 1.0 } else { map.mean }
    }

    /// Samples a point by its light as it is seen from `from`; the outer `None` if the picture is nearly even, the inner one if the
    /// point is no part of the lamp.
    #[inline]
    pub(super) fn sample(&self, map: &PictureMap, from: Vec3, u: Vec2) -> Option<Option<AreaSample>> {
        let blocks = map.blocks.as_ref()?;
        let (st, per_st) = blocks.sample(&self.screen, from, u);
        let p = self.screen.point(st);
        let pdf = self.screen.pdf(from, p, per_st);
        let is_part = pdf > 0.0 && self.screen.contains(st);
        Some(is_part.then(|| AreaSample::in_world(p, self.screen.normal, pdf)))
    }

    /// The density of [`Picture::sample`] for a point, in sr^-1; `None` if the picture is nearly even.
    #[inline]
    pub(super) fn pdf(&self, map: &PictureMap, from: Vec3, p: Vec3) -> Option<f32> {
        let blocks = map.blocks.as_ref()?;
        let per_st = blocks.density(&self.screen, from, self.screen.st(p));
        Some(self.screen.pdf(from, p, per_st))
    }

    /// The light of the picture.
    pub fn map(&self, textures: &Textures<'_>) -> PictureMap {
        let (texels, most) = match &self.color {
            Color::Constant(_) => ([1.0; 2], MIN_POINTS),
            Color::Texture(id) | Color::Tinted(id, _) => {
                let middle = self.screen.texture_point(Vec2::splat(0.5));
                let texels = textures.texel(*id, &middle).to_array().map(|size| 1.0 / size);
                let most = if textures.has_image(*id) {
                    MAX_POINTS_OF_IMAGE
                } else {
                    MIN_POINTS
                };
                (texels, most)
            }
        };
        let size = texels.map(|n| ((n / BLOCKS as f32).ceil() as usize).clamp(1, MAX_CELLS));
        let counts = size.map(|cells| cells * BLOCKS);
        let points: [usize; 2] =
            std::array::from_fn(|k| ((texels[k] / counts[k] as f32).ceil() as usize).clamp(MIN_POINTS, most));
        let cell = |index: usize| {
            let (column, row) = (index % counts[0], index / counts[0]);
            let mut sums = Sums::default();
            for k in 0..points[0] * points[1] {
                let place = |cell: usize, point: usize, axis: usize| (cell * points[axis]) as f32 + point as f32 + 0.5;
                let st = Vec2::new(
                    place(column, k % points[0], 0) / (counts[0] * points[0]) as f32,
                    place(row, k / points[0], 1) / (counts[1] * points[1]) as f32,
                );
                if self.screen.contains(st) {
                    let light = f64::from(self.color_at(textures, st).mean());
                    sums.light += light;
                    sums.squares += light * light;
                    sums.count += 1.0;
                }
            }
            sums
        };
        let cells = parallel::map(0..counts[0] * counts[1], cell);
        let all = cells.iter().fold(Sums::default(), |sum, cell| Sums {
            light: sum.light + cell.light,
            squares: sum.squares + cell.squares,
            count: sum.count + cell.count,
        });
        let mean = all.light / all.count;
        let is_even = all.squares * all.count <= (1.0 + MAX_VARIANCE) * all.light * all.light;
        PictureMap {
            mean: mean as f32,
            blocks: if is_even {
                None
            } else {
                Blocks::new(&cells, size, FLOOR * mean * (points[0] * points[1]) as f64)
            },
        }
    }
}

impl Blocks {
    /// The blocks of these cells, row by row, each with at least the light `floor`; `None` if that is 0.
    fn new(cells: &[Sums], size: [usize; 2], floor: f64) -> Option<Self> {
        let width = size[0] * BLOCKS;
        let weight = |column: usize, row: usize| cells[row * width + column].light + floor;
        let mut weights = [[0.0; BLOCKS]; BLOCKS];
        let mut tables = Vec::with_capacity(BLOCKS * BLOCKS);
        for (i, row) in weights.iter_mut().enumerate() {
            for (j, to) in row.iter_mut().enumerate() {
                let own = |x: usize, y: usize| weight(j * size[0] + x, i * size[1] + y);
                let sum: f64 = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| own(x, y))).sum();
                *to = sum as f32;
                tables.push(PiecewiseConstant2D::new(size, |y, weights| {
                    weights.iter_mut().enumerate().for_each(|(x, to)| *to = own(x, y));
                })?);
            }
        }
        Some(Self {
            weights,
            cells: tables,
            size,
        })
    }
}

#[cfg(test)]
mod tests;
