//! The rays of a batch that a kernel traces.

/// All rays of a batch, or some of them by index.
#[derive(Clone, Copy)]
pub enum RaySelection<'a> {
    All,
    Some(&'a [u32]),
}

/// The number of rays by which prefetching runs ahead.
pub const PREFETCH_DISTANCE: usize = 16;
