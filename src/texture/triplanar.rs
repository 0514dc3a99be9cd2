//! The mapping of flat pictures onto bodies without texture coordinates, from three sides.

use serde::Deserialize;

use super::{
    TexturePoint,
    solid::{Solid, SolidDesc, SolidSpace},
};
use crate::{
    math::{DMat3, DVec2, DVec3},
    value::{Finite, List, OneOrEach, Point, SpaceScale, UnitInterval},
};

/// The keys of a mapping from three sides.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TriplanarDesc {
    #[serde(default)]
    pub space: SolidSpace,
    pub scale: Option<OneOrEach<SpaceScale, 3>>,
    pub rotate: Option<List<Finite, 3>>,
    pub offset: Option<Point>,
    pub blend: Option<UnitInterval>,
}

impl TriplanarDesc {
    /// Compiles the mapping for a scene around `origin`.
    pub fn compile(&self, origin: DVec3) -> Triplanar {
        let desc = SolidDesc {
            scale: self.scale,
            rotate: self.rotate,
            offset: self.offset,
        };
        Triplanar {
            solid: desc.compile(self.space, origin),
            rotation: desc.rotation(),
            blend: self.blend.map_or(0.3, |blend| blend.0),
        }
    }
}

/// Three coordinates, of which each side of a body shows two.
#[derive(Clone, Copy, Debug)]
pub struct Triplanar {
    pub(super) solid: Solid,
    rotation: DMat3,
    /// From 0, where sides meet at an edge, to 1.
    blend: f32,
}

/// A side of a body: the axis that it faces along, and 1 or -1 for the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    axis: usize,
    sign: f64,
}

impl Side {
    /// The two coordinates that the side shows: as seen from its front s runs to the right and t, on the sides of x and z, along y.
    pub fn st(self, p: DVec3) -> DVec2 {
        match self.axis {
            0 => DVec2::new(-p.z * self.sign, p.y),
            1 => DVec2::new(p.x, -p.z * self.sign),
            _ => DVec2::new(p.x * self.sign, p.y),
        }
    }
}

impl Triplanar {
    /// The sides that a point shows and their shares, which are 1 together.
    pub(super) fn sides(&self, at: &TexturePoint) -> [(Side, f32); 3] {
        let n = (self.rotation * self.solid.normal(at).as_dvec3()).as_vec3();
        let most = n.abs().max_element();
        let share = |axis: usize| {
            let part = n[axis].abs() / most;
            if part == 1.0 {
                1.0
            } else if self.blend > 0.0 {
                (part - (1.0 - self.blend)).max(0.0) / self.blend
            } else {
                0.0
            }
        };
        let shares = [0, 1, 2].map(share);
        let sum: f32 = shares.iter().sum();
        [0, 1, 2].map(|axis| {
            let sign = f64::from(n[axis].signum());
            (Side { axis, sign }, shares[axis] / sum)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::{Rgb, Vec2, Vec3},
        texture::{Mapping, Pattern, Texture, Textures, checker::Checker},
    };

    #[test]
    fn sides_share_a_point_and_edges_are_sharp_without_a_blend() {
        let shares = |blend, n: Vec3| {
            let desc = TriplanarDesc {
                blend,
                ..TriplanarDesc::default()
            };
            let sides = desc
                .compile(DVec3::ZERO)
                .sides(&TexturePoint::new(Vec3::ZERO, n.normalize()));
            sides.map(|(_, share)| share)
        };
        let sharp = Some(UnitInterval(0.0));
        assert_eq!(shares(sharp, Vec3::new(0.1, -0.9, 0.2)), [0.0, 1.0, 0.0]);
        assert_eq!(shares(sharp, Vec3::new(1.0, 1.0, 0.2)), [0.5, 0.5, 0.0]);
        assert_eq!(shares(None, Vec3::new(0.1, 0.0, -0.9)), [0.0, 0.0, 1.0]);
        for n in [Vec3::new(0.3, 0.4, 0.5), Vec3::new(-0.7, 0.1, 0.69), Vec3::ONE] {
            let all = shares(Some(UnitInterval(1.0)), n);
            assert!((all.iter().sum::<f32>() - 1.0).abs() < 1e-6, "{all:?}");
            assert!(all.iter().all(|share| *share > 0.0), "{all:?}");
        }
    }

    #[test]
    fn each_side_of_a_box_shows_the_picture_upright() {
        let (white, black) = (Rgb::WHITE, Rgb::BLACK);
        let checker = Checker {
            colors: [white, black],
            scale: 1.0,
        };
        let mapping = Mapping::Triplanar(TriplanarDesc::default().compile(DVec3::ZERO));
        let texture = Texture::new(mapping, Pattern::Checker(checker));
        let textures = Textures {
            textures: &[texture],
            bitmaps: &[],
        };
        let at = |p: [f32; 3], n: Vec3| texture.eval(&textures, &TexturePoint::new(Vec3::from_array(p), n));
        // s and t are 0.5 and 1.5 or 0.5.
        for (p, n) in [
            ([0.5, 1.5, 9.0], Vec3::Z),
            ([-0.5, 1.5, 9.0], -Vec3::Z),
            ([9.0, 1.5, -0.5], Vec3::X),
            ([9.0, 1.5, 0.5], -Vec3::X),
            ([0.5, 9.0, -1.5], Vec3::Y),
            ([0.5, 9.0, 1.5], -Vec3::Y),
        ] {
            assert_eq!(at(p, n), black, "{n}");
            let lower = [p[0], p[1] - 1.0, p[2]];
            if n.y == 0.0 {
                assert_eq!(at(lower, n), white, "{n}");
            }
        }
        let leaning = TexturePoint {
            uv: Vec2::ZERO,
            ..TexturePoint::new(Vec3::new(0.5, 0.5, -1.5), Vec3::new(0.0, 1.0, 1.0).normalize())
        };
        // White on the side of z, black on that of y.
        assert!((texture.eval(&textures, &leaning) - Rgb::gray(0.5)).max_component() < 1e-6);
    }
}
