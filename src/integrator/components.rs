//! Light sorted by the way that it came and by the lights that it came from, where somebody asks for that.
//!
//! The components of a picture sum up to it, and so do its groups of lights. What a path finds is sorted by the lobe by which it
//! left the first surface: a direction that several lobes could have chosen counts for each by what it weighs there.

use crate::{math::Rgb, scene::LightGroup};

/// A way that light came to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// By a diffuse lobe of the first surface, from a light or by way of more surfaces.
    DiffuseDirect,
    DiffuseIndirect,
    /// By another lobe that reflects.
    SpecularDirect,
    SpecularIndirect,
    /// Through the first surface.
    Transmission,
    /// Of what the camera sees shine, and of the background that it sees.
    Emission,
}

impl Component {
    /// All, in the order in which a film has them.
    pub const ALL: [Self; 6] = [
        Self::DiffuseDirect,
        Self::DiffuseIndirect,
        Self::SpecularDirect,
        Self::SpecularIndirect,
        Self::Transmission,
        Self::Emission,
    ];

    /// What files call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::DiffuseDirect => "diffuse_direct",
            Self::DiffuseIndirect => "diffuse_indirect",
            Self::SpecularDirect => "specular_direct",
            Self::SpecularIndirect => "specular_indirect",
            Self::Transmission => "transmission",
            Self::Emission => "emission",
        }
    }
}

/// Which lobes of a surface light took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobes {
    /// Those that reflect: the part of each colour that is of diffuse ones.
    Above { diffuse: Rgb },
    /// Those that let light pass.
    Through,
}

impl Lobes {
    /// Of light of which `diffuse` is that of diffuse lobes.
    #[cold]
    pub fn above(all: Rgb, diffuse: Rgb) -> Self {
        let part = |d: f32, a: f32| if a > 0.0 { (d / a).clamp(0.0, 1.0) } else { 0.0 };
        Self::Above {
            diffuse: Rgb::new(part(diffuse.r, all.r), part(diffuse.g, all.g), part(diffuse.b, all.b)),
        }
    }
}

/// Where light comes from, and by which lobes of the surface that asks for it.
#[derive(Clone, Copy, Debug)]
pub struct Tag {
    pub group: LightGroup,
    pub lobes: Lobes,
}

/// The sorted light of a wave.
#[derive(Debug)]
pub(crate) struct Sorted {
    /// How many layers there are: the components, then the groups.
    layers: usize,
    /// Of each sample, layer by layer.
    radiance: Vec<Rgb>,
    /// The lobes of the first surface, of each sample whose path has left it.
    first: Vec<Lobes>,
    /// What each shadow ray brings.
    shadows: Vec<Shadow>,
}

#[derive(Clone, Copy, Debug)]
struct Shadow {
    slot: u32,
    parts: Parts,
    group: LightGroup,
}

/// Light in two components at the most.
type Parts = [(Component, Rgb); 2];

impl Sorted {
    pub fn new(groups: usize) -> Self {
        Self {
            layers: Component::ALL.len() + groups,
            radiance: Vec::new(),
            first: Vec::new(),
            shadows: Vec::new(),
        }
    }

    pub fn start(&mut self, samples: usize) {
        self.radiance.clear();
        self.radiance.resize(samples * self.layers, Rgb::BLACK);
        self.first.clear();
        self.first.resize(samples, Lobes::Above { diffuse: Rgb::WHITE });
        self.shadows.clear();
    }

    pub fn forget_shadows(&mut self) {
        self.shadows.clear();
    }

    /// The layers of sample `slot`.
    pub fn of_sample(&self, slot: usize) -> &[Rgb] {
        &self.radiance[slot * self.layers..][..self.layers]
    }

    #[cold]
    #[inline(never)]
    pub fn set_first(&mut self, slot: u32, lobes: Lobes) {
        self.first[slot as usize] = lobes;
    }

    /// `l`, brought by a path of so many segments, by components.
    fn parts(&self, slot: u32, segments: u32, own: Option<Lobes>, l: Rgb) -> Parts {
        let nothing = (Component::Emission, Rgb::BLACK);
        if segments == 1 {
            return [(Component::Emission, l), nothing];
        }
        match own.unwrap_or(self.first[slot as usize]) {
            Lobes::Through => [(Component::Transmission, l), nothing],
            Lobes::Above { diffuse } => {
                let part = l * diffuse;
                let [d, s] = if segments == 2 {
                    [Component::DiffuseDirect, Component::SpecularDirect]
                } else {
                    [Component::DiffuseIndirect, Component::SpecularIndirect]
                };
                [(d, part), (s, l - part)]
            }
        }
    }

    fn put(&mut self, slot: u32, parts: Parts, group: LightGroup, arrives: f32) {
        let layers = &mut self.radiance[slot as usize * self.layers..][..self.layers];
        let mut all = Rgb::BLACK;
        for (component, l) in parts {
            layers[component as usize] += l * arrives;
            all += l * arrives;
        }
        layers[Component::ALL.len() + usize::from(group.0)] += all;
    }

    /// Light of a vertex at the end of a path of so many segments.
    #[cold]
    #[inline(never)]
    pub fn add(&mut self, slot: u32, segments: u32, l: Rgb, group: LightGroup) {
        let parts = self.parts(slot, segments, None, l);
        self.put(slot, parts, group, 1.0);
    }

    /// Light that a shadow ray from the end of a path of so many segments brings, if it does.
    #[cold]
    #[inline(never)]
    pub fn shadow(&mut self, slot: u32, segments: u32, l: Rgb, tag: Tag) {
        let own = (segments == 1).then_some(tag.lobes);
        let parts = self.parts(slot, segments + 1, own, l);
        self.shadows.push(Shadow {
            slot,
            parts,
            group: tag.group,
        });
    }

    /// The part `arrives` of the light of the `ray`th shadow ray has come.
    pub fn arrive(&mut self, ray: usize, arrives: f32) {
        let Shadow { slot, parts, group } = self.shadows[ray];
        self.put(slot, parts, group, arrives);
    }
}
