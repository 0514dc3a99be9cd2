//! The components of light, and the order of the layers into which light is sorted.

use super::{LightGroup, LightGroups};

/// A component of the light that reaches the camera. The components of a picture sum to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// Light that a diffuse lobe of the first surface reflects directly from a light source.
    DiffuseDirect,
    /// Light that a diffuse lobe of the first surface reflects from other surfaces.
    DiffuseIndirect,
    /// Light that another reflecting lobe of the first surface reflects directly from a light source.
    SpecularDirect,
    /// Light that another reflecting lobe of the first surface reflects from other surfaces.
    SpecularIndirect,
    /// Light that the first surface transmits.
    Transmission,
    /// Light of emitting surfaces and of the background that the camera sees.
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

    /// The index of its layer.
    #[inline]
    pub fn layer(self) -> usize {
        self as usize
    }
}

impl LightGroup {
    /// The index of its layer; the components come first.
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
