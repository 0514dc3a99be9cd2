//! The output of shading: radiance for samples, shadow rays, and rays that continue paths.

use super::{
    BounceState, Lobes, PathState, Tag,
    light_layers::{Arrival, LightLayers},
    stages::StageClock,
};
use crate::{
    math::{Ray, RayCone, Rgb, Vec3},
    scene::{LightGroup, MediumStack, SurfaceInteraction, contacts::Contact},
};

/// The output of an integrator for all vertices of a wave, in order.
///
/// Integrators give radiance and weights at the vertex; this type applies the throughput of its path.
#[derive(Debug, Default)]
pub struct ShadingOutput {
    /// Radiance of each sample of the wave, in W m^-2 sr^-1.
    pub(crate) radiance: Vec<Rgb>,
    pub(crate) shadow_rays: Vec<Ray>,
    /// The sample of each shadow ray, and its light if nothing blocks it.
    pub(crate) shadow_light: Vec<(u32, Rgb)>,
    /// The passage of each shadow ray, in scenes where shadow rays may pass surfaces.
    pub(crate) shadow_passages: Vec<ShadowPassage>,
    records_passages: bool,
    pub(crate) rays: Vec<Ray>,
    pub(crate) paths: Vec<PathState>,
    /// The same light by components and groups, if a pass needs them.
    pub(crate) layers: Option<LightLayers>,
    vertex: CurrentVertex,
    pub(crate) clock: StageClock,
    has_cones: bool,
    /// The surface of the current vertex, if paths have cones.
    mirror: Mirror,
    /// The contact of the current vertex with another surface.
    contact: Option<Contact>,
}

/// The surfaces that a shadow ray may pass in addition to those with opacity below 1, and its media.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShadowPassage {
    /// The media at its origin.
    pub media: MediumStack,
    /// The number of surfaces that it may cross without refraction.
    pub surfaces: u32,
}

/// The state of the path at the current vertex.
#[derive(Clone, Copy, Debug)]
struct CurrentVertex {
    throughput: Rgb,
    cone: RayCone,
    depth: u32,
    arrival: Arrival,
}

impl Default for CurrentVertex {
    fn default() -> Self {
        Self::of(&PathState::start(0))
    }
}

impl CurrentVertex {
    #[inline(always)]
    fn of(path: &PathState) -> Self {
        Self {
            throughput: path.throughput,
            cone: path.cone,
            depth: path.depth,
            arrival: Arrival::at_vertex(path),
        }
    }
}

/// The effect of a surface on the cones of reflected rays.
#[derive(Clone, Copy, Debug, Default)]
struct Mirror {
    /// The normal on the viewer's side.
    n: Vec3,
    /// See [`SurfaceInteraction::signed_curvature`].
    bend: f32,
}

impl ShadingOutput {
    /// Starts a wave of `samples` samples; `has_cones` tells whether paths have cones, `records_passages` whether shadow rays may
    /// pass surfaces.
    pub(crate) fn start(&mut self, samples: usize, has_cones: bool, records_passages: bool) {
        self.has_cones = has_cones;
        self.records_passages = records_passages;
        self.radiance.clear();
        self.radiance.resize(samples, Rgb::BLACK);
        if let Some(layers) = &mut self.layers {
            layers.start(samples);
        }
        self.clear_rays();
    }

    /// Removes the rays and keeps the radiance.
    pub(crate) fn clear_rays(&mut self) {
        self.shadow_rays.clear();
        self.shadow_light.clear();
        self.shadow_passages.clear();
        self.rays.clear();
        self.paths.clear();
        if let Some(layers) = &mut self.layers {
            layers.clear_shadows();
        }
    }

    /// Starts the vertex at the end of `path`.
    #[inline]
    pub(crate) fn begin_vertex(&mut self, path: &PathState) {
        self.vertex = CurrentVertex::of(path);
        self.contact = None;
    }

    /// Starts the vertex at the end of `path` on `surface`.
    #[inline(always)]
    pub(crate) fn begin_surface_vertex(&mut self, path: &PathState, surface: &SurfaceInteraction) {
        self.begin_vertex(path);
        if self.has_cones {
            self.set_mirror(surface);
        }
    }

    /// Lets the rays of the current vertex start at a contact.
    #[cold]
    #[inline(never)]
    pub(crate) fn set_contact(&mut self, contact: Contact) {
        self.contact = Some(contact);
    }

    #[inline]
    fn set_mirror(&mut self, surface: &SurfaceInteraction) {
        self.mirror = Mirror {
            n: if surface.ng.dot(surface.wo) < 0.0 {
                -surface.ng
            } else {
                surface.ng
            },
            bend: surface.signed_curvature(),
        };
    }

    /// Scales all that the vertex adds from here on by the transmittance of a medium.
    #[inline(always)]
    pub fn attenuate(&mut self, weight: Rgb) {
        self.vertex.throughput *= weight;
    }

    /// Adds radiance that leaves the vertex along the path, in W m^-2 sr^-1, of lights without a group.
    #[inline(always)]
    pub fn add(&mut self, l: Rgb) {
        self.add_radiance(l, LightGroup::default);
    }

    /// Adds radiance of a light in the group that `group` returns; `group` is called only if a pass needs it.
    #[inline(always)]
    pub fn add_radiance(&mut self, l: Rgb, group: impl FnOnce() -> LightGroup) {
        let l = self.add_to_sample(l);
        if let Some(layers) = &mut self.layers {
            layers.add(self.vertex.arrival, l, group());
        }
    }

    /// Adds reflected radiance of light from other surfaces; `tag` is called only if a pass needs it.
    #[inline(always)]
    pub fn add_indirect(&mut self, l: Rgb, tag: impl FnOnce() -> Tag) {
        let l = self.add_to_sample(l);
        if let Some(layers) = &mut self.layers {
            layers.add_reflected(self.vertex.arrival, 2, l, tag());
        }
    }

    #[inline(always)]
    fn add_to_sample(&mut self, l: Rgb) -> Rgb {
        let l = self.vertex.throughput * l;
        self.radiance[self.vertex.arrival.sample as usize] += l;
        l
    }

    /// Adds radiance that leaves the vertex if nothing blocks `ray`, of lights without a group, reflected by diffuse lobes.
    #[inline(always)]
    pub fn add_shadow(&mut self, ray: Ray, l_if_visible: Rgb) {
        self.add_shadow_ray(ray, l_if_visible, ShadowPassage::default, || Tag {
            group: LightGroup::default(),
            lobes: Lobes::Reflected { diffuse: Rgb::WHITE },
        });
    }

    /// Adds radiance that leaves the vertex if nothing blocks `ray`; `passage` is called only if shadow rays may pass surfaces,
    /// `tag` only if a pass needs it.
    #[inline(always)]
    pub fn add_shadow_ray(
        &mut self,
        ray: Ray,
        l_if_visible: Rgb,
        passage: impl FnOnce() -> ShadowPassage,
        tag: impl FnOnce() -> Tag,
    ) {
        let l = self.vertex.throughput * l_if_visible;
        self.shadow_rays.push(ray);
        if let Some(contact) = &self.contact {
            start_last(&mut self.shadow_rays, contact);
        }
        self.shadow_light.push((self.vertex.arrival.sample, l));
        if self.records_passages {
            self.shadow_passages.push(passage());
        }
        if let Some(layers) = &mut self.layers {
            layers.add_shadow(self.vertex.arrival, l, tag());
        }
    }

    /// Sets the lobes that scatter the path at its first surface, by which later light is split into components. `lobes` is
    /// called only at the first surface, and only if a pass needs it.
    #[inline(always)]
    pub fn set_first_lobes(&mut self, lobes: impl FnOnce() -> Lobes) {
        if let Some(layers) = &mut self.layers
            && self.vertex.depth == 1
        {
            layers.set_first(self.vertex.arrival.sample, lobes());
        }
    }

    /// Continues the path along `ray` with throughput times `weight`; the next vertex reads `last`.
    ///
    /// A mirror changes the path's cone by the surface's curvature, transmission does not change it, and a sampled direction widens
    /// it by its density ([`RayCone::scattered`](crate::math::RayCone)).
    #[inline(always)]
    pub fn spawn_path(&mut self, ray: Ray, weight: Rgb, last: BounceState) {
        let cone = self.vertex.cone;
        let cone = match last.pdf.get() {
            _ if !self.has_cones => cone,
            Some(pdf) => cone.scattered(pdf),
            None if ray.d.dot(self.mirror.n) > 0.0 => cone.mirrored(self.mirror.bend),
            None => cone,
        };
        self.push_path(ray, weight, last, cone);
    }

    /// Continues the path behind a surface without refraction: `ray` differs from the arriving one only by its origin.
    #[inline]
    pub fn pass_straight(&mut self, ray: Ray, weight: Rgb, last: BounceState) {
        self.push_path(ray, weight, last, self.vertex.cone);
    }

    #[inline(always)]
    fn push_path(&mut self, ray: Ray, weight: Rgb, last: BounceState, cone: RayCone) {
        self.rays.push(ray);
        if let Some(contact) = &self.contact {
            start_last(&mut self.rays, contact);
        }
        self.paths.push(PathState {
            sample: self.vertex.arrival.sample,
            depth: self.vertex.depth + 1,
            throughput: self.vertex.throughput * weight,
            last,
            cone,
        });
    }
}

/// Lets the last ray start at a contact. Rays are pushed first, so that the compiler keeps those of other vertices in registers.
#[cold]
#[inline(never)]
fn start_last(rays: &mut [Ray], contact: &Contact) {
    if let Some(ray) = rays.last_mut() {
        *ray = contact.start(*ray);
    }
}
