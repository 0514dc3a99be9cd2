//! Interpolated vertex attributes of a mesh: second texture coordinates, colours and tangents.

use super::MeshRecord;
use crate::{
    math::{Vec2, Vec4},
    texture::VertexAttributes,
};

impl MeshRecord {
    /// Whether [`MeshRecord::attributes`] are more than [`VertexAttributes::NONE`].
    #[inline]
    pub(super) fn has_attributes(&self) -> bool {
        !self.second_uvs.is_empty() || !self.colors.is_empty()
    }

    /// The attributes at the weights `u` and `v` of the last two `corners` (indices into the mesh's arrays).
    pub(super) fn attributes(&self, corners: [usize; 3], u: f32, v: f32) -> VertexAttributes {
        let weights = [(1.0 - u - v).max(0.0), u, v];
        let mut attributes = VertexAttributes::NONE;
        if !self.second_uvs.is_empty() {
            let [a, b, c] = corners.map(|i| self.second_uvs[i]);
            attributes.second_uv_origin = self.uv_origins[1];
            attributes.second_uv = a * weights[0] + b * weights[1] + c * weights[2];
            attributes.second_per_uv = match self.uvs.is_empty() {
                true => [b - a, c - a],
                false => second_per_uv(corners.map(|i| self.uvs[i]), [a, b, c]),
            };
        }
        if !self.colors.is_empty() {
            let [a, b, c] = corners.map(|i| self.colors[i]);
            let own = VertexAttributes::of_color(a * weights[0] + b * weights[1] + c * weights[2]);
            (attributes.color, attributes.opacity) = (own.color, own.opacity);
        }
        attributes
    }

    /// The tangent with the side of the bitangent at the same weights; zero if the mesh has none.
    pub(super) fn tangent(&self, corners: [usize; 3], u: f32, v: f32) -> Vec4 {
        if self.tangents.is_empty() {
            return Vec4::ZERO;
        }
        let [a, b, c] = corners.map(|i| self.tangents[i]);
        let along = a * (1.0 - u - v) + b * u + c * v;
        along.truncate().extend(a.w)
    }
}

/// The derivative of the second texture coordinates with respect to the first.
fn second_per_uv([a, b, c]: [Vec2; 3], [a2, b2, c2]: [Vec2; 3]) -> [Vec2; 2] {
    let (ab, ac) = (b - a, c - a);
    let det = ab.perp_dot(ac);
    if det == 0.0 {
        return [Vec2::ZERO; 2];
    }
    let (ab2, ac2) = (b2 - a2, c2 - a2);
    [(ab2 * ac.y - ac2 * ab.y) / det, (ac2 * ab.x - ab2 * ac.x) / det]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_coordinates_change_with_the_first_as_the_corners_say() {
        // Rotated by 90 degrees and scaled by 2.
        let first = [Vec2::new(0.1, 0.2), Vec2::new(0.7, 0.3), Vec2::new(0.2, 0.9)];
        let second = first.map(|uv| Vec2::new(-uv.y, uv.x) * 2.0 + 5.0);
        let [along_u, along_v] = second_per_uv(first, second);
        assert!((along_u - Vec2::new(0.0, 2.0)).length() < 1e-5, "{along_u}");
        assert!((along_v - Vec2::new(-2.0, 0.0)).length() < 1e-5, "{along_v}");
    }
}
