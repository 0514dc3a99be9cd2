//! The sides of a surface.

/// The sides of a surface that emit light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sidedness {
    /// The side that the geometric normal points to.
    Front,
    Both,
}
