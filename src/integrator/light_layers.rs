//! Layers of light, by component and by light group, for passes that show a part of the picture's light.
//!
//! The components sum to the picture, and so do the light groups. The component of a path follows from the lobe that
//! scattered it at the first surface. If several lobes contribute to that direction, the light is split in proportion.

use super::PathState;
use crate::{
    math::Rgb,
    scene::{Component, LightGroup},
};

/// The lobes that scattered light at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobes {
    /// Reflecting lobes, with the share of the diffuse ones in each channel.
    Reflected { diffuse: Rgb },
    /// Transmitting lobes.
    Transmitted,
}

impl Lobes {
    /// Lobes that reflect `all`, of which diffuse lobes reflect `diffuse`.
    #[cold]
    pub fn reflected(all: Rgb, diffuse: Rgb) -> Self {
        let share = |d: f32, a: f32| if a > 0.0 { (d / a).clamp(0.0, 1.0) } else { 0.0 };
        Self::Reflected {
            diffuse: Rgb::new(
                share(diffuse.r, all.r),
                share(diffuse.g, all.g),
                share(diffuse.b, all.b),
            ),
        }
    }
}

/// The lobe that scattered a path at its first surface, for integrators with several paths per sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FirstLobe {
    /// The lobes that were set for all paths of the sample by
    /// [`ShadingOutput::set_first_lobes`](super::ShadingOutput::set_first_lobes).
    #[default]
    OfSample,
    /// A mirror.
    Reflected,
    /// Transmission.
    Transmitted,
}

/// The light group of light, and the lobes of the surface that receives it.
#[derive(Clone, Copy, Debug)]
pub struct Tag {
    pub group: LightGroup,
    pub lobes: Lobes,
}

/// The sorted light of a wave.
#[derive(Debug)]
pub(crate) struct LightLayers {
    /// The number of layers: the components, followed by the groups.
    layer_count: usize,
    /// The layers of all samples, concatenated.
    radiance: Vec<Rgb>,
    /// The lobes of each sample at its first surface, once its path has left that.
    first: Vec<Lobes>,
    /// The light of each shadow ray.
    shadows: Vec<Shadow>,
}

#[derive(Clone, Copy, Debug)]
struct Shadow {
    sample: u32,
    split: ComponentSplit,
    group: LightGroup,
}

/// Light, split into at most two components.
type ComponentSplit = [(Component, Rgb); 2];

/// The vertex where light enters a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival {
    pub sample: u32,
    /// The number of segments between the light and the camera. Surfaces that the path crossed without refraction do not
    /// count, except the first.
    pub segments: u32,
    pub first: FirstLobe,
}

impl Arrival {
    /// Light of the vertex at the end of `path`.
    #[inline(always)]
    pub fn at_vertex(path: &PathState) -> Self {
        Self {
            sample: path.sample,
            segments: path.depth - u32::from(path.last.bounces.straight),
            first: path.last.first,
        }
    }
}

impl LightLayers {
    pub fn new(layer_count: usize) -> Self {
        Self {
            layer_count,
            radiance: Vec::new(),
            first: Vec::new(),
            shadows: Vec::new(),
        }
    }

    pub fn layer_count(&self) -> usize {
        self.layer_count
    }

    pub fn start(&mut self, samples: usize) {
        self.radiance.clear();
        self.radiance.resize(samples * self.layer_count, Rgb::BLACK);
        self.first.clear();
        self.first.resize(samples, Lobes::Reflected { diffuse: Rgb::WHITE });
        self.shadows.clear();
    }

    pub fn clear_shadows(&mut self) {
        self.shadows.clear();
    }

    /// The layers of a sample.
    pub fn of_sample(&self, sample: usize) -> &[Rgb] {
        &self.radiance[sample * self.layer_count..][..self.layer_count]
    }

    #[cold]
    #[inline(never)]
    pub fn set_first(&mut self, sample: u32, lobes: Lobes) {
        self.first[sample as usize] = lobes;
    }

    /// Splits `l` into components; `own` are the lobes of the first surface, for light that reaches it directly.
    fn split(&self, from: Arrival, own: Option<Lobes>, l: Rgb) -> ComponentSplit {
        let nothing = (Component::Emission, Rgb::BLACK);
        if from.segments == 1 {
            return [(Component::Emission, l), nothing];
        }
        let first = match from.first {
            FirstLobe::OfSample => self.first[from.sample as usize],
            FirstLobe::Reflected => Lobes::Reflected { diffuse: Rgb::BLACK },
            FirstLobe::Transmitted => Lobes::Transmitted,
        };
        match own.unwrap_or(first) {
            Lobes::Transmitted => [(Component::Transmission, l), nothing],
            Lobes::Reflected { diffuse } => {
                let share = l * diffuse;
                let [d, s] = if from.segments == 2 {
                    [Component::DiffuseDirect, Component::SpecularDirect]
                } else {
                    [Component::DiffuseIndirect, Component::SpecularIndirect]
                };
                [(d, share), (s, l - share)]
            }
        }
    }

    fn accumulate(&mut self, sample: u32, split: ComponentSplit, group: LightGroup, visible: Rgb) {
        let layers = &mut self.radiance[sample as usize * self.layer_count..][..self.layer_count];
        let mut all = Rgb::BLACK;
        for (component, l) in split {
            layers[component.layer()] += l * visible;
            all += l * visible;
        }
        layers[group.layer()] += all;
    }

    /// Adds light of `group` that leaves the vertex at the end of a path.
    #[cold]
    #[inline(never)]
    pub fn add(&mut self, from: Arrival, l: Rgb, group: LightGroup) {
        let split = self.split(from, None, l);
        self.accumulate(from.sample, split, group, Rgb::WHITE);
    }

    /// Adds light that the vertex at the end of a path reflects and that has travelled `further` more segments.
    #[cold]
    #[inline(never)]
    pub fn add_reflected(&mut self, from: Arrival, further: u32, l: Rgb, tag: Tag) {
        let split = self.split_reflected(from, further, l, tag);
        self.accumulate(from.sample, split, tag.group, Rgb::WHITE);
    }

    /// Records the light of a shadow ray from the end of a path.
    #[cold]
    #[inline(never)]
    pub fn add_shadow(&mut self, from: Arrival, l: Rgb, tag: Tag) {
        let split = self.split_reflected(from, 1, l, tag);
        self.shadows.push(Shadow {
            sample: from.sample,
            split,
            group: tag.group,
        });
    }

    fn split_reflected(&self, from: Arrival, further: u32, l: Rgb, tag: Tag) -> ComponentSplit {
        let own = (from.segments == 1).then_some(tag.lobes);
        let longer = Arrival {
            segments: from.segments + further,
            ..from
        };
        self.split(longer, own, l)
    }

    /// Adds the light of the shadow ray with this index, times `visible`.
    pub fn resolve_shadow(&mut self, ray: usize, visible: Rgb) {
        let Shadow { sample, split, group } = self.shadows[ray];
        self.accumulate(sample, split, group, visible);
    }
}
