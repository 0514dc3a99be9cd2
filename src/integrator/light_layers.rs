//! Light sorted by the way it came and by the lights it came from, for passes that show a part of the picture's light.
//!
//! The components of a picture sum to it, and so do its light groups. What a path finds is sorted by the lobe by which it left
//! the first surface: a direction that several lobes could have chosen counts for each by its share there.

use super::PathState;
use crate::{
    math::Rgb,
    scene::{Component, LightGroup},
};

/// The lobes of a surface that light took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobes {
    /// Reflecting lobes, with the share of the diffuse ones in each channel.
    Reflected { diffuse: Rgb },
    /// Lobes that let light pass.
    Transmitted,
}

impl Lobes {
    /// Reflected light `all`, of which `diffuse` came by diffuse lobes.
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

/// The lobe by which a path left its first surface, in integrators that follow several paths of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FirstLobe {
    /// All paths of the sample left by the lobes that [`ShadingOutput::set_first_lobes`](super::ShadingOutput::set_first_lobes) was
    /// given.
    #[default]
    OfSample,
    /// By a mirror.
    Reflected,
    /// Through the surface.
    Transmitted,
}

/// The light group that light comes from, and the lobes of the surface that receives it.
#[derive(Clone, Copy, Debug)]
pub struct Tag {
    pub group: LightGroup,
    pub lobes: Lobes,
}

/// The sorted light of a wave.
#[derive(Debug)]
pub(crate) struct LightLayers {
    /// The number of layers: the components, then the groups.
    layer_count: usize,
    /// The layers of each sample, one after the other.
    radiance: Vec<Rgb>,
    /// The lobes of the first surface, of each sample whose path has left it.
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

/// Light in two components at most.
type ComponentSplit = [(Component, Rgb); 2];

/// The end of a path where light enters it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival {
    pub sample: u32,
    /// The number of segments between the light and the camera, without those behind surfaces that it passed unbent; the
    /// first surface always counts.
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

    /// `l` by components; `own` are the lobes of the first surface where light reaches it straight.
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

    /// Adds light that the vertex at the end of a path reflects, and that came by way of `further` segments more.
    #[cold]
    #[inline(never)]
    pub fn add_reflected(&mut self, from: Arrival, further: u32, l: Rgb, tag: Tag) {
        let split = self.split_reflected(from, further, l, tag);
        self.accumulate(from.sample, split, tag.group, Rgb::WHITE);
    }

    /// Notes light that a shadow ray from the end of a path brings, if it arrives.
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

    /// Adds the part `visible` of the light of the shadow ray with this index.
    pub fn resolve_shadow(&mut self, ray: usize, visible: Rgb) {
        let Shadow { sample, split, group } = self.shadows[ray];
        self.accumulate(sample, split, group, visible);
    }
}
