//! Tracing of the rays of a cell, on the threads of the current rayon pool.

use super::rays::{BATCH, Buffers, RayKind};
use crate::{
    accel::{Accelerator, RayBatch},
    geometry::Hit,
    math::{Ray, parallel},
    native::{Coherence, Embree, RayHit, RayHit16},
};

/// A candidate.
#[derive(Clone, Copy)]
pub enum Tracer<'a> {
    Ours(&'a dyn Accelerator),
    /// Single-ray calls.
    Embree1(&'a Embree),
    /// Calls with packets of sixteen rays, those of 4 x 4 pixels where rays come from pixels.
    Embree16(&'a Embree, &'a Buffers),
}

/// Rays in the form that their tracer expects, and memory for its results.
pub enum Prepared<'r> {
    Nearest(&'r [Ray], Vec<Option<Hit>>),
    Occlusion(&'r [Ray], Vec<bool>),
    Singles(Vec<RayHit>),
    Packets(Packets),
}

/// Packets of rays.
pub struct Packets {
    queries: Vec<RayHit16>,
    /// The place of each ray in the packets.
    places: Vec<u32>,
}

impl Packets {
    /// Packs the rays of a whole kind.
    fn new(rays: &[Ray], order: &[u32]) -> Self {
        let mut places = vec![0; order.len()];
        for (place, &ray) in (0..).zip(order) {
            places[ray as usize] = place;
        }
        let packet = |rays_of: &[u32]| {
            let rays: Vec<Ray> = rays_of.iter().map(|&ray| rays[ray as usize]).collect();
            RayHit16::new(&rays)
        };
        Self {
            queries: parallel::map(order.chunks(16), packet),
            places,
        }
    }
}

impl Tracer<'_> {
    /// Prepares the rays. All work that is not tracing is done here, before the clock starts.
    pub fn prepare<'r>(&self, kind: RayKind, rays: &'r [Ray]) -> Prepared<'r> {
        match self {
            // Not `false`: the system would provide zeroed pages lazily, while the clock is
            // running.
            Self::Ours(_) if kind.is_occlusion() => Prepared::Occlusion(rays, vec![true; rays.len()]),
            Self::Ours(_) => Prepared::Nearest(rays, vec![None; rays.len()]),
            Self::Embree1(_) => Prepared::Singles(rays.iter().map(RayHit::new).collect()),
            Self::Embree16(_, buffers) => Prepared::Packets(Packets::new(rays, &buffers.packet_order(kind))),
        }
    }

    /// Traces all rays. Threads take batches one by one, so a thread whose core is shared takes
    /// fewer.
    pub fn trace(&self, kind: RayKind, prepared: &mut Prepared<'_>) {
        let layout = kind.layout();
        match (self, prepared) {
            (Self::Ours(accel), Prepared::Occlusion(rays, blocked)) => {
                let batches = rays.chunks(BATCH).zip(blocked.chunks_mut(BATCH));
                parallel::for_each(batches, |(rays, blocked)| {
                    accel.occluded_batch(RayBatch { rays, layout }, blocked);
                });
            }
            (Self::Ours(accel), Prepared::Nearest(rays, hits)) => {
                let batches = rays.chunks(BATCH).zip(hits.chunks_mut(BATCH));
                parallel::for_each(batches, |(rays, hits)| {
                    accel.nearest_batch(RayBatch { rays, layout }, hits);
                });
            }
            (Self::Embree1(embree), Prepared::Singles(queries)) => {
                let occlusion = kind.is_occlusion();
                parallel::for_each(queries.chunks_mut(BATCH), |q| embree.trace_single(occlusion, q));
            }
            (Self::Embree16(embree, _), Prepared::Packets(packets)) => {
                let occlusion = kind.is_occlusion();
                let coherence = match kind {
                    RayKind::Primary => Coherence::Coherent,
                    _ => Coherence::Incoherent,
                };
                parallel::for_each(packets.queries.chunks_mut(BATCH / 16), |q| {
                    embree.trace_packets(occlusion, coherence, q);
                });
            }
            _ => unreachable!("a tracer gets what it has prepared"),
        }
    }
}

impl Prepared<'_> {
    /// Returns the hit distance of ray `i`; infinite for a miss, -1 for an occlusion.
    pub fn distance(&self, kind: RayKind, i: usize) -> f32 {
        match self {
            Self::Occlusion(_, blocked) if blocked[i] => -1.0,
            Self::Occlusion(..) => f32::INFINITY,
            Self::Nearest(_, hits) => hits[i].map_or(f32::INFINITY, |h| h.t),
            Self::Singles(queries) => queries[i].distance(kind.is_occlusion()),
            Self::Packets(packets) => {
                let place = packets.places[i] as usize;
                packets.queries[place / 16].distance(place % 16, kind.is_occlusion())
            }
        }
    }
}
