//! Copies of a mesh at a node, by EXT_mesh_gpu_instancing.

use glam::{DAffine3, DQuat, DVec3};

use super::{document::Document, error::GltfProblem, json::index};
use crate::math::keys::normalized;

/// The transforms of the copies of a node's mesh, relative to the node; the identity alone without the extension.
pub(super) fn copies(document: &Document<'_>, node: usize) -> Result<Vec<DAffine3>, GltfProblem> {
    let path = format!("/nodes/{node}/extensions/EXT_mesh_gpu_instancing/attributes");
    let Some(attributes) = document.raw.pointer(&path) else {
        return Ok(vec![DAffine3::IDENTITY]);
    };
    let read = |e: GltfProblem| e.within(&format!("the instances of node {node}"));
    let vectors = |name: &str| -> Result<Option<Vec<DVec3>>, GltfProblem> {
        let accessor = index(attributes, name);
        let found = accessor.map(|a| document.floats::<3>(a)).transpose().map_err(read)?;
        Ok(found.map(|v| v.into_iter().map(|v| DVec3::from_array(v.map(f64::from))).collect()))
    };
    let rotations = index(attributes, "ROTATION")
        .map(|a| document.floats::<4>(a))
        .transpose()
        .map_err(read)?;
    let (moves, scales) = (vectors("TRANSLATION")?, vectors("SCALE")?);
    let lengths = [
        moves.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
    ];
    let mut lengths = lengths.into_iter().flatten();
    // Attributes with names of their own tell how many copies there are too.
    let named = attributes.as_object().and_then(|all| all.keys().next());
    let named = named.and_then(|name| index(attributes, name));
    let named = named.map(|i| document.count(i)).transpose().map_err(read)?;
    let count = lengths.next().or(named).unwrap_or(0);
    if lengths.any(|n| n != count) {
        return Err(GltfProblem::broken(format!(
            "the instances of node {node} have attributes of several lengths"
        )));
    }
    document.reserve(count.saturating_mul(size_of::<DAffine3>()) as u64)?;
    let copy = |i: usize| {
        let rotation = rotations
            .as_ref()
            .map_or(DQuat::IDENTITY, |r| normalized(DQuat::from_array(r[i].map(f64::from))));
        DAffine3::from_scale_rotation_translation(
            scales.as_ref().map_or(DVec3::ONE, |s| s[i]),
            rotation,
            moves.as_ref().map_or(DVec3::ZERO, |m| m[i]),
        )
    };
    let copies: Vec<DAffine3> = (0..count).map(copy).collect();
    match copies.iter().position(|c| !c.is_finite()) {
        Some(i) => Err(GltfProblem::broken(format!(
            "instance {i} of node {node} is infinitely large or far away"
        ))),
        None => Ok(copies),
    }
}
