//! The two kinds of queries: nearest hit and occlusion.

use crate::geometry::{Hit, InstanceId, PrimId};

/// The value of [`Best::key`] if there is no hit so far.
pub const NOTHING: u32 = u32::MAX;

/// The nearest hit so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Best {
    /// The ray's end if there is no hit.
    pub t: f32,
    pub u: f32,
    pub v: f32,
    /// The [`PrimId::key`] of the hit, or [`NOTHING`].
    pub key: u32,
}

impl Best {
    pub const fn none(tmax: f32) -> Self {
        Self {
            t: tmax,
            u: 0.0,
            v: 0.0,
            key: NOTHING,
        }
    }

    /// Returns the state of a ray that ends at `tmax`, with an earlier result.
    pub fn of(hit: &Option<Hit>, tmax: f32) -> Self {
        match hit {
            None => Self::none(tmax),
            Some(hit) => Self {
                t: hit.t,
                u: hit.u,
                v: hit.v,
                key: hit.prim.key(0),
            },
        }
    }

    /// Returns whether a hit at `t` with this key is nearer, or equally near with a lower key.
    #[inline(always)]
    pub fn loses_to(&self, t: f32, key: u32) -> bool {
        (t < self.t) | ((t == self.t) & (key < self.key))
    }
}

/// A kind of query.
pub trait Query {
    type Answer;
    /// Whether any hit ends the query, as for occlusion.
    const ANY: bool;

    /// Returns whether there is an earlier result.
    fn is_known(answer: &Self::Answer) -> bool;
    /// Returns the instance of the earlier result.
    fn instance(answer: &Self::Answer) -> InstanceId;
    /// Returns the initial state of a ray that ends at `tmax`, or `None` if the query is already
    /// resolved.
    fn begin(answer: &Self::Answer, tmax: f32) -> Option<Best>;
    fn end(best: &Best, instance: InstanceId) -> Self::Answer;
}

/// The query for the nearest hit.
pub enum Nearest {}

impl Query for Nearest {
    type Answer = Option<Hit>;
    const ANY: bool = false;

    #[inline(always)]
    fn is_known(answer: &Option<Hit>) -> bool {
        answer.is_some()
    }

    #[inline(always)]
    fn instance(answer: &Option<Hit>) -> InstanceId {
        answer.map_or(InstanceId::NONE, |hit| hit.instance)
    }

    #[inline(always)]
    fn begin(answer: &Option<Hit>, tmax: f32) -> Option<Best> {
        Some(Best::of(answer, tmax))
    }

    #[inline(always)]
    fn end(best: &Best, instance: InstanceId) -> Option<Hit> {
        // Selected without a branch, which would be unpredictable.
        PrimId::of_key(best.key).map(|prim| Hit {
            t: best.t,
            u: best.u,
            v: best.v,
            prim,
            instance,
        })
    }
}

/// The query whether there is any hit.
pub enum Occluded {}

impl Query for Occluded {
    type Answer = bool;
    const ANY: bool = true;

    #[inline(always)]
    fn is_known(answer: &bool) -> bool {
        *answer
    }

    #[inline(always)]
    fn instance(_answer: &bool) -> InstanceId {
        InstanceId::NONE
    }

    #[inline(always)]
    fn begin(answer: &bool, tmax: f32) -> Option<Best> {
        (!answer).then_some(Best::none(tmax))
    }

    #[inline(always)]
    fn end(best: &Best, _instance: InstanceId) -> bool {
        best.key != NOTHING
    }
}
