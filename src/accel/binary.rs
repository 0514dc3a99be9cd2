//! The binary tree that the others are made of, grown from the top in parallel.
//!
//! A set of boxes is cut in two ([`super::split`]) until what is left fits a leaf. Sets of some thousand boxes are
//! *pieces*: each is grown by one thread, with arrays and numbers of its own, and handed to what is to be made of it
//! while it lies in the cache. Where the cuts are depends on the boxes alone.
//!
//! Time is linear in the number of primitives for each level, and there are at most some hundred levels: below
//! [`DEEP`] sets are cut by count. Triangles that equal an earlier one corner for corner are left out where many share a
//! centre: the earlier one wins at the same `t` anyway.

use rayon::prelude::*;

use super::{
    Geometry, Quality,
    prims::{Fate, Prims},
    spatial::{Cutter, Side},
    split::{Bounds, How, Ref, cost, split},
};
use crate::math::Aabb;

/// The most primitives of a piece.
const PIECE_PRIMS: usize = 1 << 14;

/// From this level on sets are cut by count.
const DEEP: u32 = 64;

/// Fewer primitives are not cut through.
const MIN_CUT: usize = 8;

/// How many more places in leaves there may be than primitives, as a part of these.
const SPARE: f32 = 0.5;

/// Cuts through primitives are tried where the two sides share so much of the surface around all.
const LEAST_OVERLAP: f32 = 1e-5;

/// A node of a tree in depth-first order: a node's first child follows it, and all children come after their parents.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flat {
    /// The box around everything below.
    pub bounds: Aabb,
    /// Of a node with children the second one's index, of a leaf its first place in [`Tree::ids`], or a piece's number.
    pub link: u32,
    /// How many primitives a leaf holds, [`Flat::INNER`] for a node with children, [`Flat::PIECE`] for a piece.
    pub count: u32,
}

impl Flat {
    pub const INNER: u32 = 0;
    pub const PIECE: u32 = u32::MAX;

    pub fn is_leaf(&self) -> bool {
        self.count != Self::INNER
    }
}

/// A binary tree.
#[derive(Default)]
pub(super) struct Tree {
    pub nodes: Vec<Flat>,
    /// The leaves' primitives, in the order of the leaves.
    pub ids: Vec<u32>,
}

/// A tree whose leaves are pieces.
pub(super) struct Forest<T> {
    pub top: Vec<Flat>,
    pub pieces: Vec<T>,
}

/// What goes into a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaves {
    /// The most triangles. Of anything else there is one.
    pub triangles: usize,
}

/// A tree over `prims`, of whose pieces `finish` makes what is kept of them. `None` where there are none.
pub(super) fn build<T: Send>(
    prims: Prims,
    geometry: &Geometry,
    quality: Quality,
    leaves: Leaves,
    finish: impl Fn(Tree) -> T + Sync,
) -> Option<Forest<T>> {
    let (mut refs, bounds) = (prims.refs, prims.around);
    if refs.is_empty() {
        return None;
    }
    let cutter = Cutter {
        geometry,
        reach: prims.reach,
    };
    let grower = Grower {
        geometry,
        fate: prims.fate,
        quality,
        leaves,
        cutter,
        least_overlap: LEAST_OVERLAP * bounds.boxes.aabb().half_area(),
    };
    let mut forest = Forest {
        top: Vec::new(),
        pieces: Vec::new(),
    };
    let top = if quality == Quality::High && prims.fate == Fate::Fixed {
        let spare = (refs.len() as f32 * SPARE) as usize;
        grower.top_cutting(Set { refs, bounds, spare }, 0, &finish)
    } else {
        grower.top(&mut refs, bounds, 0, &finish)
    };
    top.flatten(&mut forest);
    Some(forest)
}

/// The same in one piece.
pub(super) fn build_whole(prims: Prims, geometry: &Geometry, quality: Quality, leaves: Leaves) -> Option<Tree> {
    build(prims, geometry, quality, leaves, |tree| tree).map(join)
}

fn join(forest: Forest<Tree>) -> Tree {
    let mut whole = Tree::default();
    // A piece takes the place of one node; what was behind that moves.
    let mut starts = Vec::with_capacity(forest.top.len());
    let mut next = 0;
    for node in &forest.top {
        starts.push(next as u32);
        next += if node.count == Flat::PIECE {
            forest.pieces[node.link as usize].nodes.len()
        } else {
            1
        };
    }
    whole.nodes.reserve_exact(next);
    for node in &forest.top {
        if node.count != Flat::PIECE {
            let link = starts[node.link as usize];
            whole.nodes.push(Flat { link, ..*node });
            continue;
        }
        let piece = &forest.pieces[node.link as usize];
        let (nodes, ids) = (whole.nodes.len() as u32, whole.ids.len() as u32);
        whole.nodes.extend(piece.nodes.iter().map(|node| Flat {
            link: node.link + if node.is_leaf() { ids } else { nodes },
            ..*node
        }));
        whole.ids.extend_from_slice(&piece.ids);
    }
    whole
}

/// The part of a tree above the pieces.
enum Top<T> {
    Piece(Aabb, T),
    Inner(Aabb, Box<[Top<T>; 2]>),
}

impl<T> Top<T> {
    fn flatten(self, forest: &mut Forest<T>) {
        let at = forest.top.len();
        match self {
            Self::Piece(bounds, piece) => {
                forest.top.push(Flat {
                    bounds,
                    link: forest.pieces.len() as u32,
                    count: Flat::PIECE,
                });
                forest.pieces.push(piece);
            }
            Self::Inner(bounds, children) => {
                forest.top.push(Flat {
                    bounds,
                    link: 0,
                    count: Flat::INNER,
                });
                let [first, second] = *children;
                first.flatten(forest);
                forest.top[at].link = forest.top.len() as u32;
                second.flatten(forest);
            }
        }
    }
}

/// A set that may grow by `spare` as its primitives are cut.
struct Set {
    refs: Vec<Ref>,
    bounds: Bounds,
    spare: usize,
}

struct Grower<'a> {
    geometry: &'a Geometry,
    fate: Fate,
    quality: Quality,
    leaves: Leaves,
    cutter: Cutter<'a>,
    least_overlap: f32,
}

impl Grower<'_> {
    fn top<T: Send>(
        &self,
        mut refs: &mut [Ref],
        bounds: Bounds,
        level: u32,
        finish: &(impl Fn(Tree) -> T + Sync),
    ) -> Top<T> {
        let (level, kept) = self.look(refs, &bounds, level);
        refs = &mut refs[..kept];
        let aabb = bounds.boxes.aabb();
        if refs.len() <= PIECE_PRIMS {
            let mut tree = Tree {
                nodes: Vec::with_capacity(refs.len()),
                ids: Vec::with_capacity(refs.len()),
            };
            self.grow(refs, bounds, level, &mut tree);
            return Top::Piece(aabb, finish(tree));
        }
        let (middle, a, b) = split(refs, &bounds, self.how(level));
        let (left, right) = refs.split_at_mut(middle);
        let (left, right) = rayon::join(
            || self.top(left, a, level + 1, finish),
            || self.top(right, b, level + 1, finish),
        );
        Top::Inner(aabb, Box::new([left, right]))
    }

    fn grow(&self, refs: &mut [Ref], bounds: Bounds, level: u32, tree: &mut Tree) {
        let (level, kept) = self.look(refs, &bounds, level);
        let refs = &mut refs[..kept];
        let at = tree.nodes.len();
        let mut node = Flat {
            bounds: bounds.boxes.aabb(),
            link: tree.ids.len() as u32,
            count: Flat::INNER,
        };
        if self.is_leaf(refs) {
            node.count = refs.len() as u32;
            tree.ids.extend(refs.iter().map(Ref::index));
            tree.nodes.push(node);
            return;
        }
        tree.nodes.push(node);
        let (middle, a, b) = split(refs, &bounds, self.how(level));
        let (left, right) = refs.split_at_mut(middle);
        self.grow(left, a, level + 1, tree);
        tree.nodes[at].link = tree.nodes.len() as u32;
        self.grow(right, b, level + 1, tree);
    }

    fn top_cutting<T: Send>(&self, mut set: Set, level: u32, finish: &(impl Fn(Tree) -> T + Sync)) -> Top<T> {
        let aabb = set.bounds.boxes.aabb();
        let (level, kept) = self.look(&mut set.refs, &set.bounds, level);
        set.refs.truncate(kept);
        if set.refs.len() <= PIECE_PRIMS {
            let mut tree = Tree::default();
            self.grow_cutting(set, level, &mut tree);
            return Top::Piece(aabb, finish(tree));
        }
        let [left, right] = self.cut(set, level);
        let (left, right) = rayon::join(
            || self.top_cutting(left, level + 1, finish),
            || self.top_cutting(right, level + 1, finish),
        );
        Top::Inner(aabb, Box::new([left, right]))
    }

    fn grow_cutting(&self, mut set: Set, level: u32, tree: &mut Tree) {
        if set.spare == 0 || set.refs.len() <= MIN_CUT || level >= DEEP || set.bounds.is_point() {
            return self.grow(&mut set.refs, set.bounds, level, tree);
        }
        let at = tree.nodes.len();
        tree.nodes.push(Flat {
            bounds: set.bounds.boxes.aabb(),
            link: 0,
            count: Flat::INNER,
        });
        let [left, right] = self.cut(set, level);
        self.grow_cutting(left, level + 1, tree);
        tree.nodes[at].link = tree.nodes.len() as u32;
        self.grow_cutting(right, level + 1, tree);
    }

    /// Cuts between primitives or through them, whichever is better.
    fn cut(&self, mut set: Set, level: u32) -> [Set; 2] {
        let (middle, a, b) = split(&mut set.refs, &set.bounds, self.how(level));
        let overlap = a.boxes.aabb().intersection(b.boxes.aabb());
        let mut sides = None;
        if level < DEEP && set.spare > 0 && !overlap.is_empty() && overlap.half_area() > self.least_overlap {
            let thin = set.bounds.thin();
            let between = cost(&a.boxes, middle as u32, thin) + cost(&b.boxes, (set.refs.len() - middle) as u32, thin);
            let through = self.cutter.find(&set.refs, &set.bounds, thin);
            if let Some(plane) = through.filter(|plane| plane.cost < between) {
                let cut = self.cutter.cut(&set.refs, &plane);
                let total = cut[0].refs.len() + cut[1].refs.len();
                let sound = cut.iter().all(|side| !side.refs.is_empty());
                if sound && total <= set.refs.len() + set.spare {
                    set.spare = set.refs.len() + set.spare - total;
                    sides = Some(cut);
                }
            }
        }
        let [left, right] = sides.unwrap_or_else(|| {
            let right = set.refs.split_off(middle);
            [
                Side {
                    refs: set.refs,
                    bounds: a,
                },
                Side { refs: right, bounds: b },
            ]
        });
        let total = left.refs.len() + right.refs.len();
        let share = (set.spare as f64 * left.refs.len() as f64 / total as f64) as usize;
        [(left, share), (right, set.spare - share)].map(|(Side { refs, bounds }, spare)| Set { refs, bounds, spare })
    }

    fn is_leaf(&self, refs: &[Ref]) -> bool {
        let is_triangle = |r: &Ref| (r.index() as usize) < self.geometry.triangles.len();
        refs.len() == 1 || refs.len() <= self.leaves.triangles && refs.iter().all(is_triangle)
    }

    /// Which level to go on with, and how many primitives, where many have the same centre.
    fn look(&self, refs: &mut [Ref], bounds: &Bounds, level: u32) -> (u32, usize) {
        if level < DEEP && refs.len() > self.leaves.triangles && bounds.is_point() {
            let kept = match self.fate {
                Fate::Fixed => self.drop_copies(refs),
                Fate::Moving => refs.len(),
            };
            (DEEP, kept)
        } else {
            (level, refs.len())
        }
    }

    /// Moves triangles that equal one with a lower number to the end; how many others there are.
    fn drop_copies(&self, refs: &mut [Ref]) -> usize {
        let key = |r: &Ref| {
            let index = r.index() as usize;
            let corners = (index < self.geometry.triangles.len()).then(|| {
                self.geometry
                    .corners(index)
                    .map(|corner| corner.to_array().map(f32::to_bits))
            });
            (corners, index)
        };
        refs.par_sort_unstable_by_key(key);
        let mut kept = 1;
        for i in 1..refs.len() {
            let (corners, _) = key(&refs[i]);
            if corners.is_none() || corners != key(&refs[kept - 1]).0 {
                refs.swap(kept, i);
                kept += 1;
            }
        }
        kept
    }

    fn how(&self, level: u32) -> How {
        match self.quality {
            _ if level >= DEEP => How::ByCount,
            Quality::Fast => How::AlongLongest,
            Quality::Medium | Quality::High => How::ByArea,
        }
    }
}
