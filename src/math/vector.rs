//! Loops that run on vectors where the processor has them.

/// A loop over arrays that the compiler can turn into vectors: no branches, no calls that are not
/// inlined.
pub trait VectorLoop {
    /// Must be `#[inline(always)]`, or it is compiled for the least processor alone.
    fn run(self);
}

/// A level of vectors that runs loops. All give the same results: the compiler neither fuses nor reorders what rounds.
pub trait Dispatch: Copy {
    fn dispatch(self, task: impl VectorLoop);
}

/// Runs loops as they are.
#[cfg(test)]
#[derive(Clone, Copy)]
pub struct Plain;

#[cfg(test)]
impl Dispatch for Plain {
    fn dispatch(self, task: impl VectorLoop) {
        task.run();
    }
}
