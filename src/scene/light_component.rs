//! The ways by which light reaches the camera, and the order of the layers that light is sorted into.

use super::{LightGroup, LightGroups};

/// A way by which light reaches the camera. The components of a picture sum to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// Straight from a light, by a diffuse lobe of the first surface.
    DiffuseDirect,
    /// By a diffuse lobe of the first surface, from other surfaces.
    DiffuseIndirect,
    /// Straight from a light, by another reflecting lobe of the first surface.
    SpecularDirect,
    /// By another reflecting lobe of the first surface, from other surfaces.
    SpecularIndirect,
    /// Through the first surface.
    Transmission,
    /// From surfaces that shine and from the background, where the camera sees them.
    Emission,
}

impl Component {
    /// All components, in the order of their layers.
    pub const ALL: [Self; 6] = [
        Self::DiffuseDirect,
        Self::DiffuseIndirect,
        Self::SpecularDirect,
        Self::SpecularIndirect,
        Self::Transmission,
        Self::Emission,
    ];

    /// The index of its layer among all layers of light.
    #[inline]
    pub fn layer(self) -> usize {
        self as usize
    }
}

impl LightGroup {
    /// The index of its layer among all layers of light: the components come first.
    #[inline]
    pub fn layer(self) -> usize {
        Component::ALL.len() + usize::from(self.0)
    }
}

impl LightGroups {
    /// The number of layers that light is sorted into: one for each component and each group.
    pub fn layer_count(&self) -> usize {
        Component::ALL.len() + self.names().len()
    }
}
