//! The points of a finer surface and of its limit: the rules of Catmull-Clark and Loop, with creases.
//!
//! An edge of sharpness s is a crease on s levels. Where s is no whole number, the last of them is a mixture, and vertices change
//! from one rule to the next with the mean of what is left of their edges. Boundaries are creases of infinite sharpness. Of a
//! vertex with two creases the rule is that of a cubic B-spline along them; with more of them it stays where it is.
//!
//! Sources: E. Catmull and J. Clark, "Recursively Generated B-Spline Surfaces on Arbitrary Topological Meshes", 1978,
//! doi:10.1016/0010-4485(78)90110-0; C. Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987; T. DeRose, M. Kass and
//! T. Truong, "Subdivision Surfaces in Character Animation", 1998, doi:10.1145/280814.280826, whose rules OpenSubdiv has; H. Hoppe
//! et al., "Piecewise Smooth Surface Reconstruction", 1994, doi:10.1145/192161.192233.

use std::{collections::HashMap, f64::consts::TAU};

use glam::DVec3;

use super::topology::{Faces, Net, after, before, interpolated, mean, split_of};
use crate::shape::mesh::Scheme;

/// Points at the vertices of a net: positions in space, or texture coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Controls<'a> {
    pub faces: &'a Faces,
    pub net: &'a Net,
    pub points: &'a [DVec3],
    /// The sharpness of each edge.
    pub sharpness: &'a [f32],
    /// The vertices that never move.
    pub is_corner: &'a [bool],
}

/// The creases at a vertex.
#[derive(Clone, Copy, Debug, Default)]
struct Creases {
    count: u32,
    /// The sum of their other ends.
    ends: DVec3,
}

/// The rule for a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    Smooth,
    Crease,
    Corner,
}

impl Creases {
    fn add(&mut self, end: DVec3) {
        self.count += 1;
        self.ends += end;
    }

    fn rule(&self) -> Rule {
        match self.count {
            0 | 1 => Rule::Smooth,
            2 => Rule::Crease,
            _ => Rule::Corner,
        }
    }
}

/// The creases at a vertex on this level and on the next one.
#[derive(Clone, Copy, Debug, Default)]
struct SharpVertex {
    now: Creases,
    next: Creases,
    /// The sum of the sharpness of edges that are no creases on the next level, and their number.
    ending: (f64, u32),
}

/// The vertices at creases.
fn sharp_vertices(controls: &Controls<'_>) -> HashMap<u32, SharpVertex> {
    let mut sharp: HashMap<u32, SharpVertex> = HashMap::new();
    for (ends, &sharpness) in controls.net.edges.iter().zip(controls.sharpness) {
        if sharpness <= 0.0 {
            continue;
        }
        for [at, other] in [[ends[0], ends[1]], [ends[1], ends[0]]] {
            let end = controls.points[other as usize];
            let vertex = sharp.entry(at).or_default();
            vertex.now.add(end);
            if sharpness > 1.0 {
                vertex.next.add(end);
            } else {
                vertex.ending.0 += f64::from(sharpness);
                vertex.ending.1 += 1;
            }
        }
    }
    sharp
}

/// The sums over what is around the vertices.
struct Around {
    /// The number of edges.
    valence: Vec<u32>,
    /// The sum of the other ends of edges.
    ends: Vec<DVec3>,
}

fn around(controls: &Controls<'_>) -> Around {
    let count = controls.points.len();
    let mut around = Around {
        valence: vec![0; count],
        ends: vec![DVec3::ZERO; count],
    };
    for &[a, b] in &controls.net.edges {
        for [at, other] in [[a, b], [b, a]].map(|pair| pair.map(|v| v as usize)) {
            around.valence[at] += 1;
            around.ends[at] += controls.points[other];
        }
    }
    around
}

/// The weight of each neighbour of a vertex with `valence` of them by Loop's rule.
fn loop_weight(valence: f64) -> f64 {
    let beta = 0.375 + 0.25 * libm::cos(TAU / valence);
    (0.625 - beta * beta) / valence
}

/// The points of the vertices of the next level.
pub(super) fn refined_points(controls: &Controls<'_>, scheme: Scheme) -> Vec<DVec3> {
    let Controls {
        faces,
        net,
        points,
        sharpness,
        is_corner,
    } = *controls;
    let split = split_of(scheme, faces);
    if scheme == Scheme::Linear {
        return interpolated(points, net, faces, split);
    }
    let at = |vertex: u32| points[vertex as usize];
    let is_loop = scheme == Scheme::Loop;
    let centers: Vec<DVec3> = match is_loop {
        true => Vec::new(),
        false => faces.all().map(|face| mean(&net.corners[face], at)).collect(),
    };
    // The sums over the faces at each edge and at each vertex of what counts of these faces.
    let mut at_edges = vec![DVec3::ZERO; net.edges.len()];
    let Around {
        valence,
        ends: mut sums,
    } = around(controls);
    for (number, face) in faces.all().enumerate() {
        for corner in face.clone() {
            let edge = net.edge_of[corner] as usize;
            match is_loop {
                true => at_edges[edge] += at(net.corners[before(corner, &face)]),
                false => {
                    at_edges[edge] += centers[number];
                    sums[net.corners[corner] as usize] += centers[number];
                }
            }
        }
    }
    let smooth = |vertex: usize| {
        let (p, n) = (points[vertex], f64::from(valence[vertex]));
        match is_loop {
            true => {
                let weight = loop_weight(n);
                p * (1.0 - n * weight) + sums[vertex] * weight
            }
            false => p * ((n - 2.0) / n) + sums[vertex] / (n * n),
        }
    };
    let sharp = sharp_vertices(controls);
    let vertex = |vertex: usize| {
        if is_corner[vertex] || valence[vertex] == 0 {
            return points[vertex];
        }
        let by = |creases: &Creases| match creases.rule() {
            Rule::Smooth => smooth(vertex),
            Rule::Crease => points[vertex] * 0.75 + creases.ends * 0.125,
            Rule::Corner => points[vertex],
        };
        let Some(SharpVertex { now, next, ending }) = sharp.get(&(vertex as u32)) else {
            return smooth(vertex);
        };
        if now.rule() == next.rule() {
            return by(now);
        }
        let share = (ending.0 / f64::from(ending.1)).min(1.0);
        by(next) * (1.0 - share) + by(now) * share
    };
    let edge = |edge: usize| {
        let [a, b] = net.edges[edge].map(at);
        let middle = (a + b) * 0.5;
        let share = f64::from(sharpness[edge].clamp(0.0, 1.0));
        if share == 1.0 {
            return middle;
        }
        let smooth = match is_loop {
            true => (a + b) * 0.375 + at_edges[edge] * 0.125,
            false => (a + b + at_edges[edge]) * 0.25,
        };
        smooth * (1.0 - share) + middle * share
    };
    let vertices = (0..points.len()).map(vertex);
    let edges = (0..net.edges.len()).map(edge);
    let fine: Vec<DVec3> = vertices.chain(edges).collect();
    fine.into_iter().chain(centers).collect()
}

/// The points on the limit surface of the vertices of a surface of triangles, by Loop's rule, or of quadrilaterals.
pub(super) fn limit_points(controls: &Controls<'_>, scheme: Scheme) -> Vec<DVec3> {
    let Controls {
        faces,
        net,
        points,
        is_corner,
        ..
    } = *controls;
    if scheme == Scheme::Linear {
        return points.to_vec();
    }
    let Around { valence, ends } = around(controls);
    let mut opposite = Vec::new();
    if scheme == Scheme::CatmullClark {
        opposite = vec![DVec3::ZERO; points.len()];
        for face in faces.all() {
            for corner in face.clone() {
                let across = net.corners[after(after(corner, &face), &face)];
                opposite[net.corners[corner] as usize] += points[across as usize];
            }
        }
    }
    let sharp = sharp_vertices(controls);
    let limit = |vertex: usize| {
        let (p, n) = (points[vertex], f64::from(valence[vertex]));
        let creases = sharp.get(&(vertex as u32)).map(|v| v.now).unwrap_or_default();
        if is_corner[vertex] || valence[vertex] == 0 {
            return p;
        }
        match (creases.rule(), scheme) {
            (Rule::Corner, _) => p,
            (Rule::Crease, _) => (p * 4.0 + creases.ends) / 6.0,
            (Rule::Smooth, Scheme::Loop) => {
                let weight = 1.0 / (n + 0.375 / loop_weight(n));
                p * (1.0 - n * weight) + ends[vertex] * weight
            }
            (Rule::Smooth, _) => (p * (n * n) + ends[vertex] * 4.0 + opposite[vertex]) / (n * (n + 5.0)),
        }
    };
    (0..points.len()).map(limit).collect()
}
