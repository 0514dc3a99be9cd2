//! Tables with evenly spaced nodes from 0 to 1, interpolated linearly.

/// Between which of `nodes` nodes, even from 0 to 1, `v` lies, and where between them.
#[inline(always)]
pub(super) fn locate(v: f32, nodes: usize) -> (usize, f32) {
    let v = v.clamp(0.0, 1.0) * (nodes - 1) as f32;
    // By way of 32 bits, which vectors can convert.
    let i = (v as i32).min(nodes as i32 - 2);
    (i as usize, v - i as f32)
}

pub(super) fn node(i: usize, nodes: usize) -> f32 {
    i as f32 / (nodes - 1) as f32
}

/// The cosine at a node of an axis by its root, not 0.
pub(super) fn cos_of(k: usize, nodes: usize) -> f32 {
    let root: f32 = node(k, nodes);
    (root * root).max(1e-3)
}

#[inline(always)]
pub(super) fn lerp(a: f32, b: f32, f: f32) -> f32 {
    a * (1.0 - f) + b * f
}

/// Linear between the nodes of `row`, even from 0 to 1.
#[inline]
pub(super) fn along(row: &[f32], v: f32) -> f32 {
    let (i, f) = locate(v, row.len());
    lerp(row[i], row[i + 1], f)
}

/// The position of a cosine on the table's axis, which is denser towards grazing angles.
#[inline(always)]
pub(super) fn column(cos: f32) -> f32 {
    cos.sqrt()
}
