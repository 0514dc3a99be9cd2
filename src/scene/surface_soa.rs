//! Surface interactions of many hits, as blocks of arrays.

use super::{
    SurfaceInteraction,
    interaction::{HitGeometry, SmoothSurface, lift_along},
};
use crate::{
    math::{
        Dispatch, Frame, Vec3, VectorLoop,
        block::{Each, LANES, get, set},
        float::select,
    },
    shape::triangle,
};

/// A block of surfaces.
#[derive(Debug, Default)]
#[repr(align(64))]
pub struct SoaBlock {
    /// Not 0 for triangles in world space, given by their corners and the weights of the last two.
    is_triangle: Each<u32>,
    corners: [[Each; 3]; 3],
    weights: [Each; 2],
    /// Not 0 if single precision is too coarse for the triangle.
    failed: Each<u32>,
    p: [Each; 3],
    p_error: [Each; 3],
    ng: [Each; 3],
    smooth: [Each; 3],
    lift: [Each; 3],
    /// Direction of the ray.
    d: [Each; 3],
    wo: [Each; 3],
    ns: [Each; 3],
    ray_origins: [[Each; 3]; 2],
    frame: [[Each; 3]; 3],
}

impl SoaBlock {
    #[inline(always)]
    fn geometry(&self, i: usize) -> HitGeometry {
        HitGeometry {
            p: get(&self.p, i),
            p_error: get(&self.p_error, i),
            ng: get(&self.ng, i),
            smooth: get(&self.smooth, i),
            lift: get(&self.lift, i),
        }
    }

    #[inline(always)]
    fn corners(&self, i: usize) -> [Vec3; 3] {
        let [a, b, c] = &self.corners;
        [get(a, i), get(b, i), get(c, i)]
    }

    #[inline(always)]
    fn set_point(&mut self, i: usize, p: Vec3, p_error: Vec3, ng: Vec3) {
        set(&mut self.p, i, p);
        set(&mut self.p_error, i, p_error);
        set(&mut self.ng, i, ng);
    }

    /// Returns the fields of surface `i` that opaque shading reads, equal to the results of [`SurfaceInteraction`]'s methods.
    #[inline(always)]
    pub fn viewed(&self, i: usize) -> ViewedSurface {
        let [s, t, n] = &self.frame;
        let ng = get(&self.ng, i);
        let front = ng.dot(get(&self.wo, i));
        let side = if front >= 0.0 { 1.0 } else { -1.0 };
        let [above, below] = &self.ray_origins;
        ViewedSurface {
            frame: Frame {
                s: get(s, i),
                t: get(t, i) * side,
                n: get(n, i) * side,
            },
            wo: get(&self.wo, i),
            p: get(&self.p, i),
            lift: get(&self.lift, i),
            ng: ng * side,
            origin: select(front < 0.0, get(below, i), get(above, i)),
        }
    }
}

/// The side of an opaque surface that faces the viewer.
pub struct ViewedSurface {
    /// A frame around [`SurfaceInteraction::viewed_normal`].
    pub frame: Frame,
    pub wo: Vec3,
    pub p: Vec3,
    lift: Vec3,
    ng: Vec3,
    /// The origin of rays that start on the triangle itself.
    origin: Vec3,
}

impl ViewedSurface {
    /// The origin of the ray that leaves along the unit direction `w`.
    #[inline(always)]
    pub fn origin(&self, w: Vec3) -> Vec3 {
        self.origin + lift_along(w, self.lift, self.ng, self.frame.n)
    }
}

/// Computes the hit points on triangles.
struct TrianglePoints<'a>(&'a mut [SoaBlock]);

impl VectorLoop for TrianglePoints<'_> {
    #[inline(always)]
    fn run(self) {
        for block in self.0 {
            for i in 0..LANES {
                let [u, v] = [block.weights[0][i], block.weights[1][i]];
                let (point, is_exact) = triangle::point_in_f32(block.corners(i), u, v);
                let is_triangle = block.is_triangle[i] != 0;
                block.failed[i] = u32::from(is_triangle & !is_exact);
                let known = block.geometry(i);
                block.set_point(
                    i,
                    select(is_triangle, point.p, known.p),
                    select(is_triangle, point.p_error, known.p_error),
                    select(is_triangle, point.ng, known.ng),
                );
            }
        }
    }
}

/// Computes shading views.
struct ShadingViews<'a>(&'a mut [SoaBlock]);

impl VectorLoop for ShadingViews<'_> {
    #[inline(always)]
    fn run(self) {
        for block in self.0 {
            for i in 0..LANES {
                let view = block.geometry(i).shading_view(get(&block.d, i));
                set(&mut block.wo, i, view.wo);
                set(&mut block.ns, i, view.ns);
                let [above, below] = &mut block.ray_origins;
                set(above, i, view.ray_origins[0]);
                set(below, i, view.ray_origins[1]);
                let [s, t, n] = &mut block.frame;
                set(s, i, view.frame.s);
                set(t, i, view.frame.t);
                set(n, i, view.frame.n);
            }
        }
    }
}

/// Surfaces in blocks.
#[derive(Debug, Default)]
pub struct SurfaceSoa {
    blocks: Vec<SoaBlock>,
    len: usize,
}

impl SurfaceSoa {
    /// Removes all surfaces.
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds a surface; returns its block and lane.
    #[inline(always)]
    fn next(&mut self, d: Vec3) -> (&mut SoaBlock, usize) {
        let (block, i) = (self.len / LANES, self.len % LANES);
        self.len += 1;
        if block == self.blocks.len() {
            self.blocks.push(SoaBlock::default());
        }
        let block = &mut self.blocks[block];
        set(&mut block.d, i, d);
        (block, i)
    }

    /// Adds the hit of a ray along `d`.
    #[inline(always)]
    pub(super) fn push_geometry(&mut self, geometry: &HitGeometry, d: Vec3) {
        let (block, i) = self.next(d);
        block.is_triangle[i] = 0;
        block.set_point(i, geometry.p, geometry.p_error, geometry.ng);
        set(&mut block.smooth, i, geometry.smooth);
        set(&mut block.lift, i, geometry.lift);
    }

    /// Adds the hit of a ray along `d` on a triangle, by the weights of its last two corners.
    #[inline(always)]
    pub(super) fn push_triangle(&mut self, corners: [Vec3; 3], [u, v]: [f32; 2], smooth: SmoothSurface, d: Vec3) {
        let (block, i) = self.next(d);
        block.is_triangle[i] = 1;
        for (column, corner) in block.corners.iter_mut().zip(&corners) {
            set(column, i, *corner);
        }
        (block.weights[0][i], block.weights[1][i]) = (u, v);
        set(&mut block.smooth, i, smooth.normal);
        set(&mut block.lift, i, smooth.lift);
    }

    /// The surfaces in blocks; the last one may be partly filled.
    pub(super) fn blocks(&self) -> &[SoaBlock] {
        &self.blocks[..self.len.div_ceil(LANES)]
    }

    /// Computes the interactions of all surfaces.
    pub(super) fn compute(&mut self, on: impl Dispatch) {
        let blocks = &mut self.blocks[..self.len.div_ceil(LANES)];
        on.dispatch(TrianglePoints(blocks));
        for block in &mut *blocks {
            let failed = block.failed;
            if failed == [0; LANES] {
                continue;
            }
            for i in (0..LANES).filter(|i| failed[*i] != 0) {
                let point = triangle::surface_point(block.corners(i), block.weights[0][i], block.weights[1][i]);
                block.set_point(i, point.p, point.p_error, point.ng);
            }
        }
        on.dispatch(ShadingViews(blocks));
    }

    /// Writes the computed geometry of surface `k` to `surface`.
    #[inline(always)]
    pub(super) fn set_geometry(&self, k: usize, surface: &mut SurfaceInteraction) {
        let (block, i) = (&self.blocks[k / LANES], k % LANES);
        surface.p = get(&block.p, i);
        surface.lift = get(&block.lift, i);
        surface.ng = get(&block.ng, i);
        surface.wo = get(&block.wo, i);
        surface.ns = get(&block.ns, i);
        let [above, below] = &block.ray_origins;
        surface.ray_origins = [get(above, i), get(below, i)];
        let [s, t, n] = &block.frame;
        surface.frame.s = get(s, i);
        surface.frame.t = get(t, i);
        surface.frame.n = get(n, i);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{math::Plain, simd::Isa};

    fn point(size: f32) -> impl Strategy<Value = Vec3> {
        [-1.0..1.0_f32, -1.0..1.0, -1.0..1.0].prop_map(move |p| Vec3::from(p) * size)
    }

    /// Triangles of normal, tiny or no area.
    fn corners() -> impl Strategy<Value = [Vec3; 3]> {
        let size = prop_oneof![Just(1.0), Just(1e-9), Just(1e9)];
        let corner = size.prop_flat_map(|size| [point(size), point(size), point(size)]);
        prop_oneof![
            4 => corner,
            1 => point(1.0).prop_map(|a| [a, a, a]),
        ]
    }

    /// A ray's direction; a hit on a triangle, or a point with its normal; and the shading normal.
    type Met = (Vec3, Result<([Vec3; 3], [f32; 2]), (Vec3, Vec3)>, Vec3);

    fn met() -> impl Strategy<Value = Met> {
        let geometry = (point(100.0), point(1.0).prop_map(|n| n.normalize_or(Vec3::Y)));
        let triangle = (corners(), [0.0..0.5_f32, 0.0..0.5]);
        let smooth = prop_oneof![Just(Vec3::ZERO), point(1.0)];
        let d = point(3.0).prop_filter("a direction", |d| d.length() > 0.01);
        (d, prop_oneof![triangle.prop_map(Ok), geometry.prop_map(Err)], smooth)
    }

    fn smooth_surface(normal: Vec3) -> SmoothSurface {
        let lift = normal * 1e-3;
        SmoothSurface { normal, lift }
    }

    fn geometry(p: Vec3, p_error: Vec3, ng: Vec3, smooth: Vec3) -> HitGeometry {
        let SmoothSurface { normal, lift } = smooth_surface(smooth);
        HitGeometry {
            p,
            p_error,
            ng,
            smooth: normal,
            lift,
        }
    }

    fn bits(surface: &SurfaceInteraction) -> Vec<u32> {
        let Frame { s, t, n } = surface.frame;
        let [above, below] = surface.ray_origins;
        [surface.p, surface.ng, surface.ns, surface.wo, above, below, s, t, n]
            .iter()
            .flat_map(|v| v.to_array().map(f32::to_bits))
            .collect()
    }

    proptest! {
        #[test]
        fn many_are_found_as_one_by_one(met in prop::collection::vec(met(), 1..40)) {
            let mut soa = SurfaceSoa::default();
            let find = |soa: &mut SurfaceSoa, on: Option<Isa>| {
                soa.clear();
                for (d, what, smooth) in &met {
                    match what {
                        Ok((corners, weights)) => soa.push_triangle(*corners, *weights, smooth_surface(*smooth), *d),
                        Err((p, ng)) => {
                            let p_error = p.abs() * 1e-6;
                            soa.push_geometry(&geometry(*p, p_error, *ng, *smooth), *d);
                        }
                    }
                }
                match on {
                    Some(simd) => soa.compute(simd),
                    None => soa.compute(Plain),
                }
                (0..met.len()).map(|k| {
                    let mut surface = SurfaceInteraction::unset();
                    soa.set_geometry(k, &mut surface);
                    surface
                }).collect::<Vec<_>>()
            };
            let mut levels = vec![find(&mut soa, None)];
            levels.extend(Isa::available().into_iter().map(|simd| find(&mut soa, Some(simd))));
            for (k, (d, what, smooth)) in met.iter().enumerate() {
                let geometry = match *what {
                    Ok((corners, [u, v])) => {
                        let point = triangle::surface_point(corners, u, v);
                        geometry(point.p, point.p_error, point.ng, *smooth)
                    }
                    Err((p, ng)) => geometry(p, p.abs() * 1e-6, ng, *smooth),
                };
                let mut alone = SurfaceInteraction::unset();
                alone.set_geometry(&geometry, &geometry.shading_view(*d));
                for level in &levels {
                    prop_assert_eq!(bits(&level[k]), bits(&alone));
                }
            }
        }
    }
}
