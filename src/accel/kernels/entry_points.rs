//! Where rays begin that start next to one another and go the same way, as those to one light do.
//!
//! Near the root they meet the same nodes, so a group of them goes there together: of the boxes that what encloses the
//! rays meets, the largest is opened again and again as long as no more than eight are left. These make a node of its own,
//! the head, at which each of the rays begins.
//!
//! Looking for a head is one long chain of steps, so several are made at once and each waits while others go on. Rays
//! that do not go the same way begin at the root, and so do the rest of a batch where too little is saved to pay: for a
//! wide group, nodes are opened that few of its rays come to.
//! Scenes with instances, where boxes are widened for a ray's origin, go without.

use std::hint::select_unpredictable;

use super::{
    ray_selection::PREFETCH_DISTANCE, ray_state::RayState, shaft::Shaft, traversal::NodeSource, tree::WideTree,
};
use crate::{
    accel::wide::node::{EMPTY, LEAF, WideNode},
    geometry::slab::LEAVE,
    math::Ray,
    simd::lanes::{Eight, Floats, Mask, SimdLevel},
};

/// Rays that have a head in common.
const GROUP: usize = 64;

/// Heads that are made at once.
const BUILT_TOGETHER: usize = 4;

/// Boxes that are tried for a head.
const MAX_OPENED: usize = 8;

/// How many of the nodes opened for a head a ray must come to by itself, as parts of eight, so that the head pays: so many
/// tests are saved, less that of the head, and making it takes about one more.
const MIN_SAVED: usize = 22;

/// The first heads of a batch, of which that is found out.
const TRIAL_GROUPS: usize = 16;

/// The heads of the rays that begin next, and of those that have begun last.
pub struct EntryPoints {
    /// Behind them the root.
    nodes: [WideNode; 2 * BUILT_TOGETHER + 1],
    /// The number of each group's head.
    numbers: [u32; 2 * BUILT_TOGETHER],
    growing: [EntryBuilder; BUILT_TOGETHER],
    /// How many were made of a batch.
    made: usize,
    /// Of the nodes opened for the first [`TRIAL_GROUPS`], how many one ray of each head comes to.
    saved: usize,
    /// Whether some were made that no pass has come to yet.
    is_ahead: bool,
}

/// That of the root.
const ROOT: u32 = 2 * BUILT_TOGETHER as u32;

/// A ray that is to begin.
pub struct Next {
    pub ray: usize,
    /// The number of its head.
    pub head: u32,
    /// Rays that will begin soon, and those of which a head will be made.
    pub soon: [usize; 2],
}

/// A head that is being made.
#[derive(Clone, Default)]
struct EntryBuilder {
    /// What encloses its rays.
    around: Shaft,
    /// Whether its rays go the same way.
    goes_together: bool,
    boxes: OpenBoxes,
    /// In a trial, one of its rays.
    example: RayState,
}

/// The boxes that are met and not opened, as a node has them: `count` at the end of each row.
#[repr(C, align(64))]
#[derive(Clone, Default)]
struct OpenBoxes {
    /// As bits.
    planes: [BoxRow; 6],
    child: BoxRow,
    /// Half of each box's surface, as bits.
    area: BoxRow,
    /// In a trial, whether the example meets it.
    is_met: BoxRow,
    count: usize,
}

/// The area of what is not opened, as bits: a negative one.
const CLOSED_AREA: u32 = 1 << 31;

/// A node's eight, and before them room for a store of eight.
type BoxRow = [u32; 16];

impl EntryPoints {
    /// How many rays' heads are made at once.
    const RAYS: usize = BUILT_TOGETHER * GROUP;

    pub fn new() -> Self {
        Self {
            nodes: [WideNode::NOTHING; 2 * BUILT_TOGETHER + 1],
            numbers: [ROOT; 2 * BUILT_TOGETHER],
            growing: std::array::from_fn(|_| EntryBuilder::default()),
            made: 0,
            saved: 0,
            is_ahead: false,
        }
    }

    /// For a batch.
    #[inline(always)]
    pub fn begin(&mut self, tree: &WideTree) {
        // SAFETY: there is a root.
        self.nodes[ROOT as usize] = *unsafe { tree.node(tree.root()) };
        (self.made, self.saved) = (0, 0);
        self.is_ahead = false;
    }

    /// Whether it pays to look for heads, if that is known.
    pub fn verdict(&self) -> Option<bool> {
        (self.made >= TRIAL_GROUPS).then_some(8 * self.saved >= MIN_SAVED * TRIAL_GROUPS)
    }

    /// After all rays that have begun have passed their heads.
    #[inline(always)]
    pub fn passed(&mut self) {
        self.is_ahead = false;
    }

    /// The one of the rays in `list` whose turn it is, the `upcoming`-th. They are asked for one after another. `None` where
    /// rays that have begun must pass their heads first, as these would be made anew: that happens where many rays of a pass have
    /// nothing to ask.
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
            if self.is_ahead {
                return None;
            }
            self.is_ahead = true;
            let first = upcoming / GROUP % (2 * BUILT_TOGETHER);
            if self.verdict() == Some(false) {
                self.numbers = [ROOT; 2 * BUILT_TOGETHER];
            } else {
                self.make(level, tree, rays, &list[upcoming..], first);
            }
        }
        let ray = |at: usize| list[at.min(list.len() - 1)] as usize;
        Some(Next {
            ray: ray(upcoming),
            head: self.numbers[upcoming / GROUP % (2 * BUILT_TOGETHER)],
            soon: [ray(upcoming + PREFETCH_DISTANCE), ray(upcoming + Self::RAYS)],
        })
    }

    /// Makes the heads of the groups that come next, from the `first` on.
    #[inline(always)]
    fn make<L: SimdLevel>(&mut self, level: L, tree: &WideTree, rays: &[Ray], list: &[u32], first: usize) {
        let is_trial = self.made < TRIAL_GROUPS;
        for (k, growing) in self.growing.iter_mut().enumerate() {
            // Nothing is left of the last groups, and then any ray will do.
            let group = list.get(k * GROUP..).filter(|rest| !rest.is_empty()).unwrap_or(list);
            let group = &group[..group.len().min(GROUP)];
            growing.goes_together = growing.around.enclose(level, rays, group, tree.padding.reach);
            if is_trial {
                // If it cannot meet anything, the one before stays: all that it says is whether heads pay.
                let example = group[group.len() / 2] as usize;
                growing.example.start(level, &rays[example], example, tree.padding);
            }
            growing.boxes.begin(tree.root());
        }
        for _ in 0..MAX_OPENED {
            for growing in &mut self.growing {
                // SAFETY: its boxes are of this tree.
                let saves = unsafe { growing.open(level, tree, is_trial) };
                self.saved += usize::from(saves & growing.goes_together);
            }
        }
        self.made += BUILT_TOGETHER;
        for (k, growing) in (first..).zip(&self.growing) {
            self.numbers[k] = if growing.goes_together { k as u32 } else { ROOT };
            growing.boxes.write(level, &mut self.nodes[k]);
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
    /// Opens the largest box of an inner node, if what is in it fits; otherwise it is not tried again. In a trial, whether it
    /// does and the example comes to that node. All without a branch that cannot be foretold.
    ///
    /// # Safety
    /// The boxes are of `tree`'s nodes.
    #[inline(always)]
    unsafe fn open<L: SimdLevel>(&mut self, level: L, tree: &WideTree, is_trial: bool) -> bool {
        let boxes = &mut self.boxes;
        let (lane, is_inner) = boxes.largest(level);
        let child = select_unpredictable(is_inner, boxes.child[lane], tree.root());
        // SAFETY: this is an inner child of one of the nodes, or the root.
        let node = unsafe { tree.node(child) };
        let met = self.around.cross(level, node).bits();
        let fits = is_inner & (boxes.count + met.count_ones() as usize <= 8 + 1);
        boxes.area[lane] = CLOSED_AREA;
        let saves = is_trial & fits & (boxes.is_met[lane] != 0);
        // Where it does not fit, all are others, and what is moved comes to where nothing counts.
        let others = boxes.count - usize::from(fits);
        let lane = select_unpredictable(fits, lane, 0);
        let met = select_unpredictable(fits, met, 0);
        // SAFETY: these are of eight lanes.
        let met = unsafe { Eight::new(met) };
        let [x, y, z] = [extent(level, node, 0), extent(level, node, 1), extent(level, node, 2)];
        let area = x.mul_add(y.add(z), y.mul(z)).to_array();
        for (row, planes) in boxes.planes.iter_mut().zip(&node.planes) {
            replace(level, row, lane, others, met, bytemuck::cast_ref(planes));
        }
        replace(level, &mut boxes.child, lane, others, met, &node.child);
        replace(level, &mut boxes.area, lane, others, met, bytemuck::cast_ref(&area));
        if is_trial {
            let (enter, leave) = self.example.course.cross(level, node, None);
            let by_example = level.met(enter, leave.mul(level.splat8(LEAVE))).bits();
            let is_met = std::array::from_fn(|k| by_example >> k & 1);
            replace(level, &mut boxes.is_met, lane, others, met, &is_met);
        }
        boxes.count = others + met.bits().count_ones() as usize;
        saves
    }
}

/// The first of a row's numbers comes to `lane`, and those of `lanes` come before the `others`, of which there are eight at most.
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
    /// The root alone, of which no box is known.
    fn begin(&mut self, root: u32) {
        self.child[15] = root;
        self.area[15] = 1.0_f32.to_bits();
        self.is_met[15] = 1;
        self.count = 1;
    }

    /// The lane of the largest box of an inner node, and whether there is one.
    #[inline(always)]
    fn largest<L: SimdLevel>(&self, level: L) -> (usize, bool) {
        // Leaves, and what does not count, get a sign.
        let area: [u32; 8] = std::array::from_fn(|k| {
            let counts = k + self.count >= 8;
            self.area[8 + k] | (self.child[8 + k] & LEAF | u32::from(!counts)) << 31
        });
        let area = level.load8(bytemuck::cast_ref(&area));
        let largest = area.reduce_max();
        let lanes = area.eq(level.splat8(largest)).bits();
        (8 + lanes.trailing_zeros() as usize % 8, largest > 0.0)
    }

    /// Makes them a node's.
    #[inline(always)]
    fn write<L: SimdLevel>(&self, level: L, node: &mut WideNode) {
        for (k, (planes, row)) in node.planes.iter_mut().zip(&self.planes).enumerate() {
            *planes = self.last(level, row, WideNode::NOTHING.planes[k][0]);
        }
        node.child = bytemuck::cast(self.last(level, &self.child, f32::from_bits(EMPTY)));
    }

    /// What counts of a row, and before it the same number.
    #[inline(always)]
    fn last<L: SimdLevel>(&self, level: L, row: &BoxRow, before: f32) -> [f32; 8] {
        let counts = level.mask16(0xffff_0000 >> self.count & 0xffff);
        let row = level.load16(bytemuck::cast_ref(row));
        let row = row.select(counts, level.splat16(before)).to_array();
        row.as_chunks().0[1]
    }
}

#[cfg(test)]
mod tests;
