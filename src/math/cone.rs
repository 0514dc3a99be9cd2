//! How wide the part of the world is that a pixel's ray stands for: what textures are filtered by.

/// A cone about a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cone {
    /// Across the ray at its origin, in m.
    pub width: f32,
    /// The whole angle by which it opens, in radians.
    pub spread: f32,
}

impl Cone {
    /// Across the ray at distance `t` (m), in m; for small angles.
    pub fn width_at(self, t: f32) -> f32 {
        self.width + self.spread * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_widens_with_distance_from_what_it_is_at_its_origin() {
        let (width, spread) = (0.5, 0.01);
        assert_eq!(Cone { width, spread }.width_at(100.0), 1.5);
        assert_eq!(Cone::default().width_at(3.0), 0.0);
    }
}
