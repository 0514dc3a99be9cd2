//! A node of the binary tree that is collapsed to the light tree.

use crate::light::LightBounds;

/// A node of the binary tree. A node of k lights and its descendants are 2k - 1 consecutive nodes; the left child follows its
/// parent.
#[derive(Clone, Copy)]
pub(super) struct BinaryNode {
    pub bounds: LightBounds,
    pub leaves: u32,
}
