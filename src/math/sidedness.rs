//! The sides of a surface.

/// The sides of a surface that emit light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sidedness {
    /// The side that the geometric normal points to.
    Front,
    Both,
}

impl Sidedness {
    pub fn new(is_two_sided: bool) -> Self {
        if is_two_sided { Self::Both } else { Self::Front }
    }
}
