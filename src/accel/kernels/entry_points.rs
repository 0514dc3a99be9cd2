//! Common entry points for groups of coherent shadow rays, as in multi-level ray tracing (Reshetov
//! et al., 2005).
//!
//! Near the root, rays to one light visit the same nodes, so a group of them traverses these
//! together. Of the boxes that the group's shaft intersects, the largest is opened repeatedly, as
//! long as no more than eight boxes are left. These boxes form a node of their own, the entry node,
//! at which each of the rays starts.
//!
//! The search for an entry node is one long chain of dependent steps, so several are built at once
//! to hide the latency. Incoherent groups start at the root. So do the other rays of a batch if the
//! trial groups save too little: for a wide group, nodes are opened that few of its rays visit.
//! Scenes with instances, where boxes are padded for a ray's origin, do not use entry points.

use std::hint::select_unpredictable;

use super::{
    ray_selection::PREFETCH_DISTANCE, ray_state::RayState, shaft::Shaft, traversal::NodeSource, tree::WideTree,
};
use crate::{
    accel::wide::node::{EMPTY, LEAF, WideNode},
    geometry::slab::EXIT_PADDING,
    math::Ray,
    simd::lanes::{Eight, Floats, Mask, SimdLevel},
};

/// The number of rays that share an entry node.
const GROUP: usize = 64;

/// The number of entry nodes that are built at once.
const BUILT_TOGETHER: usize = 4;

/// The number of boxes that are tried for an entry node.
const MAX_OPENED: usize = 8;

/// The smallest number of opened nodes, in eighths, that a ray must otherwise visit itself for an
/// entry node to pay off. These tests are saved, less that of the entry node; building it costs
/// about one more test.
const MIN_SAVED: usize = 22;

/// The number of groups of a batch that are measured.
const TRIAL_GROUPS: usize = 16;

/// The entry nodes of the rays that start next and of those that started last.
pub struct EntryPoints {
    /// The entry nodes, and then the root.
    nodes: [WideNode; 2 * BUILT_TOGETHER + 1],
    /// The index of each group's entry node.
    numbers: [u32; 2 * BUILT_TOGETHER],
    builders: [EntryBuilder; BUILT_TOGETHER],
    /// The number of entry nodes that were built for the batch.
    built: usize,
    /// The number of nodes opened for the first [`TRIAL_GROUPS`] that one ray of each group visits.
    saved: usize,
    /// Whether there are entry nodes that no pass has visited yet.
    is_pending: bool,
}

/// The index of the root.
const ROOT: u32 = 2 * BUILT_TOGETHER as u32;

/// The next ray to start.
pub struct Next {
    pub ray: usize,
    /// The index of its entry node.
    pub entry: u32,
    /// Indices of rays to prefetch: one that starts soon, and one for which an entry node is built
    /// soon.
    pub prefetch: [usize; 2],
}

/// An entry node under construction.
#[derive(Clone, Default)]
struct EntryBuilder {
    /// The bounds of its rays.
    shaft: Shaft,
    /// Whether its rays are coherent.
    is_coherent: bool,
    boxes: OpenBoxes,
    /// In a trial, one of its rays.
    example: RayState,
}

/// The boxes that are hit and not opened, in the layout of a node. The last `count` elements of
/// each row are valid.
#[repr(C, align(64))]
#[derive(Clone, Default)]
struct OpenBoxes {
    /// As bits of floats.
    planes: [BoxRow; 6],
    child: BoxRow,
    /// Half of each box's surface area, as bits.
    area: BoxRow,
    /// In a trial, whether the example ray hits the box.
    is_met: BoxRow,
    count: usize,
}

/// The area of a box that must not be opened, as bits: negative zero.
const CLOSED_AREA: u32 = 1 << 31;

/// The eight elements of a node, after room for a store of eight.
type BoxRow = [u32; 16];

impl EntryPoints {
    /// The number of rays whose entry nodes are built at once.
    const RAYS: usize = BUILT_TOGETHER * GROUP;

    pub fn new() -> Self {
        Self {
            nodes: [WideNode::NOTHING; 2 * BUILT_TOGETHER + 1],
            numbers: [ROOT; 2 * BUILT_TOGETHER],
            builders: std::array::from_fn(|_| EntryBuilder::default()),
            built: 0,
            saved: 0,
            is_pending: false,
        }
    }

    /// Starts a batch.
    #[inline(always)]
    pub fn begin(&mut self, tree: &WideTree) {
        // SAFETY: the tree has a root.
        self.nodes[ROOT as usize] = *unsafe { tree.node(tree.root()) };
        (self.built, self.saved) = (0, 0);
        self.is_pending = false;
    }

    /// Returns whether entry points pay off, if this is known.
    pub fn pays_off(&self) -> Option<bool> {
        (self.built >= TRIAL_GROUPS).then_some(8 * self.saved >= MIN_SAVED * TRIAL_GROUPS)
    }

    /// Must be called after all rays that have started have passed their entry nodes.
    #[inline(always)]
    pub fn passed(&mut self) {
        self.is_pending = false;
    }

    /// Returns the ray at position `upcoming` of `list`; positions must be requested in order.
    /// Returns `None` if rays that have started must first pass their entry nodes, because these
    /// would be overwritten. This happens if many rays of a pass are already resolved.
    #[inline(always)]
    pub fn next<L: SimdLevel>(
        &mut self,
        level: L,
        tree: &WideTree,
        rays: &[Ray],
        list: &[u32],
        upcoming: usize,
    ) -> Option<Next> {
        if upcoming.is_multiple_of(Self::RAYS) {
            if self.is_pending {
                return None;
            }
            self.is_pending = true;
            let first = upcoming / GROUP % (2 * BUILT_TOGETHER);
            if self.pays_off() == Some(false) {
                self.numbers = [ROOT; 2 * BUILT_TOGETHER];
            } else {
                self.build_next(level, tree, rays, &list[upcoming..], first);
            }
        }
        let ray = |at: usize| list[at.min(list.len() - 1)] as usize;
        Some(Next {
            ray: ray(upcoming),
            entry: self.numbers[upcoming / GROUP % (2 * BUILT_TOGETHER)],
            prefetch: [ray(upcoming + PREFETCH_DISTANCE), ray(upcoming + Self::RAYS)],
        })
    }

    /// Builds the entry nodes of the next groups, from the index `first` on.
    #[inline(always)]
    fn build_next<L: SimdLevel>(&mut self, level: L, tree: &WideTree, rays: &[Ray], list: &[u32], first: usize) {
        let is_trial = self.built < TRIAL_GROUPS;
        for (k, builder) in self.builders.iter_mut().enumerate() {
            // The last groups may be empty; any rays will do then.
            let group = list.get(k * GROUP..).filter(|rest| !rest.is_empty()).unwrap_or(list);
            let group = &group[..group.len().min(GROUP)];
            builder.is_coherent = builder.shaft.enclose(level, rays, group, tree.padding.reach);
            if is_trial {
                // If the ray cannot hit anything, the previous example is kept. Examples affect
                // only whether entry points pay off.
                let example = group[group.len() / 2] as usize;
                builder.example.start(level, &rays[example], example, tree.padding);
            }
            builder.boxes.begin(tree.root());
        }
        for _ in 0..MAX_OPENED {
            for builder in &mut self.builders {
                // SAFETY: the boxes are those of this tree.
                let saves = unsafe { builder.open(level, tree, is_trial) };
                self.saved += usize::from(saves & builder.is_coherent);
            }
        }
        self.built += BUILT_TOGETHER;
        for (k, builder) in (first..).zip(&self.builders) {
            self.numbers[k] = if builder.is_coherent { k as u32 } else { ROOT };
            builder.boxes.write(level, &mut self.nodes[k]);
        }
    }
}

impl NodeSource for EntryPoints {
    #[inline(always)]
    unsafe fn node(&self, number: u32) -> &WideNode {
        &self.nodes[number.min(ROOT) as usize]
    }
}

impl EntryBuilder {
    /// Opens the largest box of an inner node if the children that are hit fit. Otherwise this box
    /// is not tried again. In a trial, returns whether it was opened and the example ray visits the
    /// node. The code has no unpredictable branch.
    ///
    /// # Safety
    /// The boxes are those of nodes of `tree`.
    #[inline(always)]
    unsafe fn open<L: SimdLevel>(&mut self, level: L, tree: &WideTree, is_trial: bool) -> bool {
        let boxes = &mut self.boxes;
        let (lane, is_inner) = boxes.largest(level);
        let child = select_unpredictable(is_inner, boxes.child[lane], tree.root());
        // SAFETY: this is an inner child of one of the nodes, or the root.
        let node = unsafe { tree.node(child) };
        let met = self.shaft.intersect_node(level, node).bits();
        let fits = is_inner & (boxes.count + met.count_ones() as usize <= 8 + 1);
        boxes.area[lane] = CLOSED_AREA;
        let saves = is_trial & fits & (boxes.is_met[lane] != 0);
        // If the children do not fit, all boxes are others, and the moved box goes to an invalid
        // lane.
        let others = boxes.count - usize::from(fits);
        let lane = select_unpredictable(fits, lane, 0);
        let met = select_unpredictable(fits, met, 0);
        // SAFETY: the mask has eight lanes.
        let met = unsafe { Eight::new(met) };
        let [x, y, z] = [extent(level, node, 0), extent(level, node, 1), extent(level, node, 2)];
        let area = x.mul_add(y.add(z), y.mul(z)).to_array();
        for (row, planes) in boxes.planes.iter_mut().zip(&node.planes) {
            replace(level, row, lane, others, met, bytemuck::cast_ref(planes));
        }
        replace(level, &mut boxes.child, lane, others, met, &node.child);
        replace(level, &mut boxes.area, lane, others, met, bytemuck::cast_ref(&area));
        if is_trial {
            let (enter, leave) = self.example.state.intersect_node(level, node, None);
            let by_example = level.met(enter, leave.mul(level.splat8(EXIT_PADDING))).bits();
            let is_met = std::array::from_fn(|k| by_example >> k & 1);
            replace(level, &mut boxes.is_met, lane, others, met, &is_met);
        }
        boxes.count = others + met.bits().count_ones() as usize;
        saves
    }
}

/// Moves the first valid element of a row to `lane`, and inserts those of `lanes` before the
/// `others`, of which there are at most eight.
#[inline(always)]
fn replace<L: SimdLevel>(level: L, row: &mut BoxRow, lane: usize, others: usize, lanes: Eight, from: &[u32; 8]) {
    row[lane % 16] = row[(15 - others) % 16];
    let to = row[(8 - others) % 9..]
        .first_chunk_mut()
        .expect("there is room for eight");
    level.push_any(lanes, from, to);
}

#[inline(always)]
fn extent<L: SimdLevel>(level: L, node: &WideNode, axis: usize) -> L::F8 {
    level
        .load8(&node.planes[2 * axis + 1])
        .sub(level.load8(&node.planes[2 * axis]))
}

impl OpenBoxes {
    /// Resets the boxes to the root alone, whose box is unknown.
    fn begin(&mut self, root: u32) {
        self.child[15] = root;
        self.area[15] = 1.0_f32.to_bits();
        self.is_met[15] = 1;
        self.count = 1;
    }

    /// Returns the lane of the largest box of an inner node, and whether there is one.
    #[inline(always)]
    fn largest<L: SimdLevel>(&self, level: L) -> (usize, bool) {
        // Leaves and invalid lanes get a negative area.
        let area: [u32; 8] = std::array::from_fn(|k| {
            let is_valid = k + self.count >= 8;
            self.area[8 + k] | (self.child[8 + k] & LEAF | u32::from(!is_valid)) << 31
        });
        let area = level.load8(bytemuck::cast_ref(&area));
        let largest = area.reduce_max();
        let lanes = area.eq(level.splat8(largest)).bits();
        (8 + lanes.trailing_zeros() as usize % 8, largest > 0.0)
    }

    /// Writes the boxes to a node.
    #[inline(always)]
    fn write<L: SimdLevel>(&self, level: L, node: &mut WideNode) {
        for (k, (planes, row)) in node.planes.iter_mut().zip(&self.planes).enumerate() {
            *planes = self.last(level, row, WideNode::NOTHING.planes[k][0]);
        }
        node.child = bytemuck::cast(self.last(level, &self.child, f32::from_bits(EMPTY)));
    }

    /// Returns the valid elements of a row, and `before` in the others.
    #[inline(always)]
    fn last<L: SimdLevel>(&self, level: L, row: &BoxRow, before: f32) -> [f32; 8] {
        let is_valid = level.mask16(0xffff_0000 >> self.count & 0xffff);
        let row = level.load16(bytemuck::cast_ref(row));
        let row = row.select(is_valid, level.splat16(before)).to_array();
        row.as_chunks().0[1]
    }
}

#[cfg(test)]
mod tests;
