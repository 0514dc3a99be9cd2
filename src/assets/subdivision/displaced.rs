//! Displacement of a refined surface.

use glam::{DVec2, DVec3};

use super::surface::Surface;

impl Surface {
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

    /// Moves every place along its normal by the mean of the heights of its values, so that seams do not tear. `height` is that of
    /// a part at a position, with these texture coordinates; they are 0 where a part has none.
    pub fn displace(&mut self, height: impl Fn(usize, DVec3, DVec2) -> f64) {
        let mut at_places = vec![(0.0, 0_u32); self.positions.len()];
        let mut is_counted = vec![false; self.values.vertices as usize];
        let mut start = 0;
        for (part, end) in self.part_ends.iter().enumerate() {
            for corner in self.faces.corners_of_first(start)..self.faces.corners_of_first(*end) {
                let [value, place] = [&self.values, &self.places].map(|net| net.corners[corner] as usize);
                if !std::mem::replace(&mut is_counted[value], true) {
                    let uv = self.uvs.get(value).copied().unwrap_or_default();
                    let (sum, count) = &mut at_places[place];
                    *sum += height(part, self.positions[place], uv);
                    *count += 1;
                }
            }
            start = *end;
        }
        let normals = self.place_normals();
        for (position, (normal, (sum, count))) in self.positions.iter_mut().zip(normals.into_iter().zip(at_places)) {
            if count > 0 {
                *position += normal * (sum / f64::from(count));
            }
        }
    }
}
