//! The two questions a ray can ask.

use crate::geometry::{Hit, InstanceId, PrimId};

/// No hit so far, as [`Best::id`].
pub const NOTHING: u32 = u32::MAX;

/// The nearest hit so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Best {
    /// The ray's end where there is none.
    pub t: f32,
    pub u: f32,
    pub v: f32,
    /// The primitive's number plus one, or [`NOTHING`].
    pub id: u32,
}

impl Best {
    pub const fn none(tmax: f32) -> Self {
        Self {
            t: tmax,
            u: 0.0,
            v: 0.0,
            id: NOTHING,
        }
    }

    /// Whether a hit at `t` of the primitive with number `id - 1` is nearer, or as near and has the lower number.
    #[inline(always)]
    pub fn loses_to(&self, t: f32, id: u32) -> bool {
        (t < self.t) | ((t == self.t) & (id < self.id))
    }
}

/// What is asked.
pub trait Query {
    type Answer;
    /// Whether any hit will do.
    const ANY: bool;

    /// Whether anything is known already.
    fn is_known(answer: &Self::Answer) -> bool;
    /// The instance of what is known already.
    fn instance(answer: &Self::Answer) -> InstanceId;
    /// What is known of a ray that ends at `tmax`; `None` where there is nothing left to ask.
    fn begin(answer: &Self::Answer, tmax: f32) -> Option<Best>;
    fn end(best: &Best, instance: InstanceId) -> Self::Answer;
}

/// What does the ray meet first?
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
        Some(match answer {
            None => Best::none(tmax),
            Some(hit) => Best {
                t: hit.t,
                u: hit.u,
                v: hit.v,
                id: hit.prim.index() + 1,
            },
        })
    }

    #[inline(always)]
    fn end(best: &Best, instance: InstanceId) -> Option<Hit> {
        // Chosen without a branch, which nobody could foretell.
        PrimId::one_below(best.id).map(|prim| Hit {
            t: best.t,
            u: best.u,
            v: best.v,
            prim,
            instance,
        })
    }
}

/// Does the ray meet anything?
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
        best.id != NOTHING
    }
}
