//! How much light rough surfaces send back, by tables.
//!
//! The facets of [`super::microfacet`] scatter once; what would bounce between them is lost, up to two thirds of the light.
//! Divided by the albedo of white facets, a lobe loses nothing: it is as strong as all bounces together, in the shape of the
//! first. The same albedos share light out between layers. Source: Turquin, "Practical multiple scattering compensation for
//! microfacet models", 2019; Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 course.
//!
//! A table is integrated when it is first asked, always to the same bits, in some hundredths of a second, and is linear
//! between its nodes: off by less than 0.01 for isotropic facets (tested). Its axes are the perceived roughness and the root of a
//! cosine: of the direction or, where all that counts is how far facets hide each other, of the direction on the stretched
//! surface ([`Ggx::stretched_cos`]).

use std::sync::{LazyLock, OnceLock};

use super::{fresnel, microfacet::Ggx, sheen};
use crate::math::{Vec2, Vec3, trig};

/// Nodes along each axis of a table.
const N: usize = 24;
/// Points of an integral over facets: around the half turn, and by steepness.
const POINTS: [usize; 2] = [24, 32];

type Grid = [[f32; N]; N];

/// Linear between the nodes of `grid`; `row` and `column` from 0 to 1.
#[inline]
fn lookup(grid: &Grid, row: f32, column: f32) -> f32 {
    let place = |v: f32| {
        let v = v.clamp(0.0, 1.0) * (N - 1) as f32;
        let i = (v as usize).min(N - 2);
        (i, v - i as f32)
    };
    let ((i, fi), (j, fj)) = (place(row), place(column));
    let along = |r: &[f32; N]| r[j] * (1.0 - fj) + r[j + 1] * fj;
    along(&grid[i]) * (1.0 - fi) + along(&grid[i + 1]) * fi
}

fn node(i: usize) -> f32 {
    i as f32 / (N - 1) as f32
}

/// A table of `f` of the facets of each row and the direction that `wo` says for the place of each column.
fn tabulate(wo: impl Fn(&Ggx, f32) -> Vec3, f: impl Fn(&Ggx, Vec3) -> f32) -> Grid {
    std::array::from_fn(|i| {
        let ggx = Ggx::from_roughness(node(i).max(0.04), 0.0);
        std::array::from_fn(|j| f(&ggx, wo(&ggx, (node(j) * node(j)).max(1e-3))))
    })
}

/// The direction whose [`Ggx::stretched_cos`] is `t`.
fn stretched_direction(ggx: &Ggx, t: f32) -> Vec3 {
    let a = ggx.alpha.x;
    let cos = t * a / (1.0 - t * t + t * t * a * a).sqrt();
    direction(cos.min(1.0))
}

fn direction(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos)
}

/// Where `ggx` is on the axis of roughness. Anisotropic facets lose about as much as isotropic ones of the same mean square
/// alpha: the albedo is off by 3 % at usual strengths, by 7 % at the most.
#[inline]
fn row(ggx: &Ggx) -> f32 {
    if ggx.alpha.x == ggx.alpha.y {
        return ggx.alpha.x.sqrt();
    }
    (0.5 * ggx.alpha.length_squared()).sqrt().sqrt()
}

/// Where a cosine is on its axis, which is denser towards grazing ones.
#[inline]
fn column(cos: f32) -> f32 {
    cos.sqrt()
}

/// The mean of `f` over the facets that are seen from `wo`.
fn mean_over_facets<const K: usize>(ggx: &Ggx, wo: Vec3, f: impl Fn(Vec3) -> [f32; K]) -> [f32; K] {
    let mut sum = [0.0_f64; K];
    let [turns, slopes] = POINTS;
    for i in 0..turns {
        for j in 0..slopes {
            // One half of the turn: the other is its mirror image. Denser towards the steep facets, which lose light.
            let q = (j as f32 + 0.5) / slopes as f32;
            let u = Vec2::new(0.5 * (i as f32 + 0.5) / turns as f32, 1.0 - q * q * q);
            let values = f(ggx.sample_normal(wo, u));
            for (sum, v) in sum.iter_mut().zip(values) {
                *sum += f64::from(v * 3.0 * q * q);
            }
        }
    }
    sum.map(|s| (s / (turns * slopes) as f64) as f32)
}

/// The part of the light that a facet `h` reflects, if all, that leaves the surface.
fn seen(ggx: &Ggx, wo: Vec3, h: Vec3) -> f32 {
    ggx.reflection(wo, fresnel::reflect(wo, h)).map_or(0.0, |f| f.seen)
}

/// Albedo of facets that reflect everything.
static MIRRORS: LazyLock<Grid> = LazyLock::new(|| {
    tabulate(stretched_direction, |ggx, wo| {
        let [one, all] = mean_over_facets(ggx, wo, |h| [1.0, seen(ggx, wo, h)]);
        all / one
    })
});

/// The mean of Schlick's term over the light that facets reflect; columns are of the cosine itself.
static GRAZING: LazyLock<Grid> = LazyLock::new(|| {
    tabulate(
        |_, cos| direction(cos),
        |ggx, wo| {
            let [all, grazing] = mean_over_facets(ggx, wo, |h| {
                let seen = seen(ggx, wo, h);
                [seen, seen * fresnel::schlick_term(wo.dot(h))]
            });
            grazing / all
        },
    )
});

/// The albedo of facets that reflect all light, seen from `wo`.
#[inline]
pub fn mirrors(ggx: &Ggx, wo: Vec3) -> f32 {
    if ggx.is_smooth() {
        return 1.0;
    }
    lookup(&MIRRORS, row(ggx), column(ggx.stretched_cos(wo)))
}

/// The albedo of facets that reflect as Schlick says, seen from `wo`, as weights of the reflectance at normal incidence and of
/// the one at grazing incidence.
#[inline]
pub fn schlick(ggx: &Ggx, wo: Vec3) -> [f32; 2] {
    if ggx.is_smooth() {
        let grazing = fresnel::schlick_term(wo.z.abs());
        return [1.0 - grazing, grazing];
    }
    let all = mirrors(ggx, wo);
    let grazing = all * lookup(&GRAZING, row(ggx), column(wo.z.abs()));
    [all - grazing, grazing]
}

/// Means of [`schlick`] over all directions, by their cosine.
static SCHLICK_MEANS: LazyLock<[[f32; 2]; N]> = LazyLock::new(|| {
    const STEPS: usize = 64;
    std::array::from_fn(|i| {
        let ggx = Ggx::from_roughness(node(i), 0.0);
        let mut sum = [0.0_f64; 2];
        for k in 0..STEPS {
            let cos = (k as f32 + 0.5) / STEPS as f32;
            let [a, b] = schlick(&ggx, direction(cos));
            sum[0] += f64::from(a * cos);
            sum[1] += f64::from(b * cos);
        }
        sum.map(|s| (2.0 * s / STEPS as f64) as f32)
    })
});

/// The mean of [`schlick`] over all directions, weighted by their cosine: what a surface of light sees of it.
#[inline]
pub fn schlick_mean(ggx: &Ggx) -> [f32; 2] {
    let x = row(ggx) * (N - 1) as f32;
    let i = (x as usize).min(N - 2);
    let f = x - i as f32;
    let [a, b] = [SCHLICK_MEANS[i], SCHLICK_MEANS[i + 1]];
    [a[0] * (1.0 - f) + b[0] * f, a[1] * (1.0 - f) + b[1] * f]
}

/// Slices of the table for clear boundaries, even in the root of the logarithm of the index: denser towards 1, where none is.
const SLICES: usize = 24;
/// The highest index of the table; the lowest is its inverse.
const HIGHEST: f32 = 3.0;
static BOUNDARIES: [OnceLock<Grid>; SLICES] = [const { OnceLock::new() }; SLICES];

/// Albedo of clear facets, by reflection and by transmission together.
fn boundary_slice(k: usize) -> &'static Grid {
    BOUNDARIES[k].get_or_init(|| {
        let x = 2.0 * k as f32 / (SLICES - 1) as f32 - 1.0;
        let eta = trig::pow(HIGHEST, x * x.abs());
        tabulate(
            |_, cos| direction(cos),
            |ggx, wo| {
                let [one, all] = mean_over_facets(ggx, wo, |h| {
                    let reflected = fresnel::dielectric(wo.dot(h), eta);
                    let passed = fresnel::refract(wo, h, eta).and_then(|wi| ggx.transmission(wo, wi, eta));
                    let passed = passed.map_or(0.0, |f| f.seen);
                    [1.0, reflected * seen(ggx, wo, h) + (1.0 - reflected) * passed]
                });
                all / one
            },
        )
    })
}

/// The albedo of clear facets seen from `wo`, by reflection and by transmission together; `eta` is the index on the other side
/// over the one on the side of `wo`.
pub fn boundary(ggx: &Ggx, wo: Vec3, eta: f32) -> f32 {
    if ggx.is_smooth() {
        return 1.0;
    }
    let log = trig::ln(eta) / trig::ln(HIGHEST);
    let x = 0.5 + 0.5 * log.abs().sqrt().copysign(log);
    let x = x.clamp(0.0, 1.0) * (SLICES - 1) as f32;
    let k = (x as usize).min(SLICES - 2);
    let f = x - k as f32;
    let (r, t) = (row(ggx), column(wo.z.abs()));
    lookup(boundary_slice(k), r, t) * (1.0 - f) + lookup(boundary_slice(k + 1), r, t) * f
}

/// Albedo of a white sheen, by roughness and root of the cosine.
static SHEEN: LazyLock<Grid> = LazyLock::new(|| {
    const STEPS: usize = 48;
    std::array::from_fn(|i| {
        let roughness = sheen::LEAST_ROUGHNESS + (1.0 - sheen::LEAST_ROUGHNESS) * node(i);
        std::array::from_fn(|j| {
            let wo = direction(node(j) * node(j));
            let mut sum = 0.0_f64;
            for k in 0..STEPS {
                // Denser towards the rim, where sheen is.
                let q = (k as f32 + 0.5) / STEPS as f32;
                let z = q * q;
                let sin = (1.0 - z * z).sqrt();
                for l in 0..STEPS {
                    let q_phi = (l as f32 + 0.5) / STEPS as f32;
                    let (s, c) = trig::sin_cos(std::f32::consts::PI * q_phi);
                    let wi = Vec3::new(sin * c, sin * s, z);
                    sum += f64::from(sheen::raw_f_cos(roughness, wo, wi) * 2.0 * q);
                }
            }
            (sum * f64::from(std::f32::consts::TAU) / (STEPS * STEPS) as f64) as f32
        })
    })
});

/// The albedo of a white sheen before it is scaled down where it would be above 1.
pub fn raw_sheen(roughness: f32, cos: f32) -> f32 {
    let row = (roughness - sheen::LEAST_ROUGHNESS) / (1.0 - sheen::LEAST_ROUGHNESS);
    lookup(&SHEEN, row, column(cos.abs()))
}
