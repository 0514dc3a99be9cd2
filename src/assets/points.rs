//! Point clouds.

use glam::DAffine3;

use crate::math::{Aabb, Vec3, Vec4, parallel};

/// Points of a model, rendered as spheres.
#[derive(Clone, Debug, Default)]
pub struct PointCloud {
    /// Finite, at least one.
    pub positions: Vec<Vec3>,
    /// Linear colours with opacity: none, or one for each point.
    pub colors: Vec<Vec4>,
    /// An index into the model's materials.
    pub material: usize,
    pub model_from_points: DAffine3,
    /// The default radius of the spheres, in m: the mean distance of a point to its nearest neighbour.
    pub radius: f32,
}

impl PointCloud {
    /// The bytes of its arrays.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.positions[..]) + size_of_val(&self.colors[..])) as u64
    }

    /// The bounds of all spheres.
    pub fn bounds(&self) -> Aabb {
        let Aabb { min, max } = Aabb::from_points(self.positions.iter().copied());
        Aabb {
            min: min - self.radius,
            max: max + self.radius,
        }
    }
}

/// The number of points whose nearest neighbours are searched.
const SAMPLES: usize = 256;

/// The most points of a leaf.
const LEAF_POINTS: usize = 16;

/// The mean distance of points to their nearest neighbours, in m, estimated from a few points at even steps of the list. Points
/// at the same position are no neighbours. 1 if there is no other point.
pub fn mean_spacing(positions: &[Vec3]) -> f32 {
    let mut tree = positions.to_vec();
    sort_into_tree(&mut tree, 0);
    let step = positions.len().div_ceil(SAMPLES).max(1);
    let mut squares = parallel::map(positions.iter().step_by(step), |p| {
        nearest_squared(&tree, 0, *p, f32::INFINITY)
    });
    squares.retain(|square| square.is_finite());
    let sum: f64 = squares.iter().map(|square| f64::from(*square).sqrt()).sum();
    if sum > 0.0 {
        (sum / squares.len() as f64) as f32
    } else {
        1.0
    }
}

/// Sorts points into a k-d tree: the middle one splits them along `axis`, and both halves are trees along the next axis.
fn sort_into_tree(points: &mut [Vec3], axis: usize) {
    if points.len() <= LEAF_POINTS {
        return;
    }
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
    let (below, above) = points.split_at_mut(middle);
    let next = (axis + 1) % 3;
    rayon::join(|| sort_into_tree(below, next), || sort_into_tree(&mut above[1..], next));
}

/// The squared distance from `p` to the nearest point of a tree at another position, or `best` if that is less.
fn nearest_squared(tree: &[Vec3], axis: usize, p: Vec3, best: f32) -> f32 {
    let nearer = |best: f32, q: &Vec3| {
        let square = q.distance_squared(p);
        if square > 0.0 { square.min(best) } else { best }
    };
    if tree.len() <= LEAF_POINTS {
        return tree.iter().fold(best, nearer);
    }
    let middle = tree.len() / 2;
    let (below, above) = (&tree[..middle], &tree[middle + 1..]);
    let from_plane = p[axis] - tree[middle][axis];
    let (near, far) = if from_plane < 0.0 {
        (below, above)
    } else {
        (above, below)
    };
    let next = (axis + 1) % 3;
    let best = nearest_squared(near, next, p, nearer(best, &tree[middle]));
    if from_plane * from_plane < best {
        nearest_squared(far, next, p, best)
    } else {
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_square_lattice_are_one_step_apart() {
        let lattice = |n: usize, step: f32| -> Vec<Vec3> {
            (0..n * n)
                .map(|i| Vec3::new((i % n) as f32, 7.0, (i / n) as f32) * step)
                .collect()
        };
        for (n, step) in [(2, 1.0), (5, 0.25), (150, 0.01)] {
            let found = mean_spacing(&lattice(n, step));
            assert!((found / step - 1.0).abs() < 1e-3, "{n}: {found}");
        }
    }

    #[test]
    fn the_nearest_point_of_a_tree_is_that_of_a_search_through_all() {
        let number = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
        let points: Vec<Vec3> = (0..500)
            .map(|i| Vec3::new(number(3 * i), number(3 * i + 1) * 0.1, number(3 * i + 2)))
            .collect();
        let mut tree = points.clone();
        sort_into_tree(&mut tree, 0);
        for p in &points {
            let others = points.iter().map(|q| q.distance_squared(*p)).filter(|d| *d > 0.0);
            let expected = others.fold(f32::INFINITY, f32::min);
            assert_eq!(nearest_squared(&tree, 0, *p, f32::INFINITY), expected);
        }
    }

    #[test]
    fn points_without_neighbours_have_a_spacing() {
        assert_eq!(mean_spacing(&[Vec3::X]), 1.0);
        assert_eq!(mean_spacing(&[Vec3::X; 9]), 1.0);
        assert_eq!(mean_spacing(&[Vec3::X, Vec3::X, Vec3::ZERO]), 1.0);
        assert_eq!(mean_spacing(&[]), 1.0);
    }
}
