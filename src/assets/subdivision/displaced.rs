//! Displacement of a refined surface.

use glam::DVec3;

use super::surface::Surface;

impl Surface {
    /// The part that each value belongs to, and its place.
    pub fn owners_of_values(&self) -> Vec<(usize, u32)> {
        let mut owners = vec![(0, 0); self.values.vertices as usize];
        let mut start = 0;
        for (part, end) in self.part_ends.iter().enumerate() {
            for corner in (start..*end).flat_map(|face| self.faces.corners(face)) {
                owners[self.values.corners[corner] as usize] = (part, self.places.corners[corner]);
            }
            start = *end;
        }
        owners
    }

    /// The unit normal of each place: the mean over all faces around it, weighed by the area at the corner; 0 where that cancels.
    fn place_normals(&self) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for face in self.faces.all() {
            for corner in face.clone() {
                sums[self.places.corners[corner] as usize] += self.corner_normal(corner, &face);
            }
        }
        sums.into_iter().map(DVec3::normalize_or_zero).collect()
    }

    /// Moves every place along its normal by the mean of the heights of its values, so that seams do not tear.
    pub fn displace(&mut self, heights: &[f64]) {
        let mut at_places = vec![(0.0, 0_u32); self.positions.len()];
        let mut is_counted = vec![false; heights.len()];
        for (value, place) in self.values.corners.iter().zip(&self.places.corners) {
            let value = *value as usize;
            if !std::mem::replace(&mut is_counted[value], true) {
                let (sum, count) = &mut at_places[*place as usize];
                *sum += heights[value];
                *count += 1;
            }
        }
        let normals = self.place_normals();
        for (position, (normal, (sum, count))) in self.positions.iter_mut().zip(normals.into_iter().zip(at_places)) {
            if count > 0 {
                *position += normal * (sum / f64::from(count));
            }
        }
    }
}
