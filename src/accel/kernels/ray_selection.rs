//! Which rays of a batch a kernel traces.

/// The rays of a batch that are asked for: all, or some of them by number; those that follow one another may begin together.
#[derive(Clone, Copy)]
pub enum RaySelection<'a> {
    All,
    Some(&'a [u32]),
    Together(&'a [u32]),
}

/// How many rays before its turn one is fetched.
pub const PREFETCH_DISTANCE: usize = 16;
