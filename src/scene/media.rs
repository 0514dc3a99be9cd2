//! Media inside of bodies, and the media that surround a path.
//!
//! A body is a closed surface whose material lets light into it. Bodies may be nested, such as a bubble in a liquid in a glass,
//! and they may overlap: there the medium is that of the body with the highest priority, and of several with the same
//! priority, of the one that the path entered last. A surface inside of a body with a higher priority is ignored.
//!
//! Source: Schmidt and Budge, "Simple Nested Dielectrics in Ray Traced Images", Journal of Graphics Tools 7(2), 2002,
//! doi:10.1080/10867651.2002.10487555.

use std::borrow::Cow;

use super::{Scene, SurfaceInteraction, shading_frame::shading_frame};
use crate::{
    bsdf::{Bsdf, BsdfKind, HeroChannel, is_equal_ior},
    geometry::Hit,
    material::{Material, MaterialId, Medium},
    math::{Ray, Rgb, Vec3, exponential},
};

/// The most surfaces that the search for the media around a point crosses.
const MAX_CROSSINGS: usize = 256;

/// An index into the scene's media.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MediumId(u16);

/// The media inside of a scene's bodies.
#[derive(Clone, Debug, Default)]
pub struct Media {
    media: Vec<Medium>,
    of_material: Vec<Option<MediumId>>,
    lets_shadow_rays_through: bool,
    has_priorities: bool,
}

impl Media {
    /// Collects the media of all materials. Equal ones are one medium.
    ///
    /// Media beyond the 65,535th are replaced by the last one.
    pub fn new(materials: &[Material]) -> Self {
        let mut media = Vec::<Medium>::new();
        let of_material = materials
            .iter()
            .map(|material| {
                let medium = material.medium()?;
                let index = media.iter().position(|m| *m == medium).unwrap_or_else(|| {
                    media.push(medium);
                    media.len() - 1
                });
                Some(MediumId(index.min(usize::from(u16::MAX) - 1) as u16))
            })
            .collect();
        let same_ior = |i: usize| media[..i].iter().any(|m| is_equal_ior(m.ior, media[i].ior));
        Self {
            lets_shadow_rays_through: materials.iter().any(Material::may_transmit_straight)
                || media.iter().any(|m| !m.absorption.is_black())
                || (1..media.len()).any(same_ior),
            has_priorities: media.windows(2).any(|pair| pair[0].priority != pair[1].priority),
            media,
            of_material,
        }
    }

    /// Whether shadow rays pass surfaces of clear materials, or are absorbed on their way.
    pub fn lets_shadow_rays_through(&self) -> bool {
        self.lets_shadow_rays_through || self.has_priorities
    }

    /// Whether surfaces may be ignored because a body of a higher priority fills the space.
    pub fn has_priorities(&self) -> bool {
        self.has_priorities
    }

    /// The medium behind the surface of `material`.
    #[inline]
    pub fn of_material(&self, material: MaterialId) -> Option<MediumId> {
        self.of_material.get(material.0 as usize).copied().flatten()
    }

    fn get(&self, id: MediumId) -> &Medium {
        &self.media[usize::from(id.0)]
    }
}

/// The media of the bodies around a path, in ascending order of priority and then of entry.
///
/// It holds six; of more, the outermost are dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MediumStack([u16; 6]);

impl MediumStack {
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0[0] == 0
    }

    fn len(&self) -> usize {
        self.0.iter().take_while(|&&id| id != 0).count()
    }

    fn ids(&self) -> impl DoubleEndedIterator<Item = MediumId> {
        self.0[..self.len()].iter().map(|id| MediumId(id - 1))
    }

    /// The effective medium; `None` in empty space.
    #[inline]
    fn current(&self) -> Option<MediumId> {
        if self.is_empty() { None } else { self.ids().next_back() }
    }

    /// The stack inside of one more body.
    fn entered(mut self, id: MediumId, media: &Media) -> Self {
        if self.len() == self.0.len() {
            self.0.rotate_left(1);
            self.0[self.0.len() - 1] = 0;
        }
        let priority = media.get(id).priority;
        let at = self
            .ids()
            .position(|other| media.get(other).priority > priority)
            .unwrap_or(self.len());
        self.0[at..].rotate_right(1);
        self.0[at] = id.0 + 1;
        self
    }

    /// The stack outside of the last body with this medium.
    fn left(mut self, id: MediumId) -> Self {
        if let Some(at) = self.0.iter().rposition(|&other| other == id.0 + 1) {
            self.0[at..].rotate_left(1);
            self.0[self.0.len() - 1] = 0;
        }
        self
    }
}

impl Scene {
    /// The index of refraction around a path.
    pub fn ior_of(&self, stack: MediumStack) -> f32 {
        stack.current().map_or(1.0, |id| self.shading.media.get(id).ior)
    }

    /// The index of refraction outside of the surface of `material` for a path in `stack`; `None` in empty space.
    #[inline]
    pub fn ior_outside(&self, stack: MediumStack, material: MaterialId) -> Option<f32> {
        if stack.is_empty() {
            return None;
        }
        let outside = stack.left(self.shading.media.of_material(material)?);
        (!outside.is_empty()).then(|| self.ior_of(outside))
    }

    /// The BSDF of a surface for a path in `stack`: in the medium that surrounds it, and for one channel if it disperses.
    /// The channel is chosen by the path's `throughput` and the uniform number `uc` in `[0, 1)`.
    #[inline(always)]
    pub fn bsdf_for_path(
        &self,
        surface: &SurfaceInteraction,
        stack: MediumStack,
        throughput: Rgb,
        uc: impl FnOnce() -> f32,
    ) -> Cow<'_, Bsdf> {
        let mut bsdf = self.bsdf(surface.material, &surface.texture);
        if bsdf.disperses() {
            let hero = HeroChannel::choose(throughput, uc());
            if let Some(followed) = hero.and_then(|hero| bsdf.for_channel(hero)) {
                bsdf = Cow::Owned(followed);
            }
        }
        if let Some(ior) = self.ior_outside(stack, surface.material) {
            bsdf = Cow::Owned(bsdf.into_owned().immersed(ior));
        }
        bsdf
    }

    /// The media behind a surface of `material` that is crossed inwards or outwards.
    pub fn media_behind(&self, stack: MediumStack, material: MaterialId, inwards: bool) -> MediumStack {
        match self.shading.media.of_material(material) {
            None => stack,
            Some(id) if inwards => stack.entered(id, &self.shading.media),
            Some(id) => stack.left(id),
        }
    }

    /// Whether the surface of `material` is ignored: a medium of higher priority fills the space.
    pub fn is_displaced(&self, stack: MediumStack, material: MaterialId) -> bool {
        let (Some(current), Some(id)) = (stack.current(), self.shading.media.of_material(material)) else {
            return false;
        };
        self.shading.media.get(id).priority < self.shading.media.get(current).priority
    }

    /// The fraction of light in `stack` that crosses the surface at a hit without refraction; see [`BsdfKind::straight`].
    pub fn straight_transmittance(&self, ray: &Ray, hit: &Hit, stack: MediumStack) -> Rgb {
        let material = self.material(self.material_of(hit));
        let outside = self.ior_outside(stack, self.material_of(hit));
        if outside.is_none() && !material.may_transmit_straight() {
            return Rgb::BLACK;
        }
        let surface = self.surface(ray, hit);
        let bsdf = self.bsdf(surface.material, &surface.texture).into_owned();
        let bsdf = outside.map_or(bsdf, |ior| bsdf.immersed(ior));
        let shading_frame = shading_frame(self, &surface, material, &bsdf);
        let bsdf = shading_frame.adapt(&bsdf).unwrap_or(bsdf);
        bsdf.straight(shading_frame.frame.to_local(surface.wo))
    }

    /// The transmittance over `distance` (m, may be infinite) in `stack`, by Beer's law.
    pub fn transmittance(&self, stack: MediumStack, distance: f32) -> Rgb {
        let Some(id) = stack.current() else {
            return Rgb::WHITE;
        };
        let absorption = self.shading.media.get(id).absorption;
        absorption.map(|a| match a > 0.0 {
            true if distance.is_finite() => exponential::exp(-a * distance),
            true => 0.0,
            false => 1.0,
        })
    }

    /// The media of the bodies around a point.
    ///
    /// They are found along one ray to infinity, which leaves the bodies around its origin more often than it enters them.
    pub fn media_around(&self, p: Vec3) -> MediumStack {
        let mut around = Vec::new();
        if self.shading.media.media.is_empty() {
            return MediumStack::default();
        }
        let mut entered = Vec::new();
        // A direction along which models hardly have edges.
        let mut ray = Ray::new(p, Vec3::new(0.267_26, 0.534_52, 0.801_78));
        for _ in 0..MAX_CROSSINGS {
            let mut hits = [None];
            self.geometry.accel.nearest(&[ray], &mut hits);
            let [Some(hit)] = hits else { break };
            let surface = self.surface(&ray, &hit);
            if let Some(id) = self.shading.media.of_material(surface.material) {
                if surface.ng.dot(surface.wo) > 0.0 {
                    entered.push(id);
                } else if let Some(at) = entered.iter().rposition(|other| *other == id) {
                    entered.remove(at);
                } else {
                    around.push(id);
                }
            }
            ray.tmin = hit.t;
        }
        let from_outside = around.into_iter().rev();
        from_outside.fold(MediumStack::default(), |stack, id| {
            stack.entered(id, &self.shading.media)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn media(priorities: &[i32]) -> (Media, Vec<MediumId>) {
        let medium = |&priority| Medium {
            absorption: Rgb::BLACK,
            ior: 1.0,
            priority,
        };
        let media = Media {
            media: priorities.iter().map(medium).collect(),
            ..Media::default()
        };
        (media, (0..priorities.len() as u16).map(MediumId).collect())
    }

    #[test]
    fn the_body_entered_last_fills_the_place_and_leaving_it_brings_the_other_back() {
        let (media, ids) = media(&[0, 0]);
        let empty = MediumStack::default();
        assert_eq!(empty.current(), None);
        let beer = empty.entered(ids[0], &media);
        let bubble = beer.entered(ids[1], &media);
        assert_eq!(bubble.current(), Some(ids[1]));
        assert_eq!(bubble.left(ids[1]), beer);
        // Overlapping bodies are left in any order.
        assert_eq!(bubble.left(ids[0]).current(), Some(ids[1]));
        assert_eq!(beer.left(ids[0]), empty);
        assert_eq!(empty.left(ids[0]), empty);
    }

    #[test]
    fn the_highest_priority_fills_the_place_whatever_was_entered_last() {
        let (media, ids) = media(&[2, -1, 0]);
        let glass = MediumStack::default().entered(ids[0], &media);
        let both = glass.entered(ids[1], &media).entered(ids[2], &media);
        assert_eq!(both.current(), Some(ids[0]));
        assert_eq!(both.left(ids[0]).current(), Some(ids[2]));
        assert_eq!(both.left(ids[0]).left(ids[2]).current(), Some(ids[1]));
    }

    #[test]
    fn beyond_its_depth_the_outermost_bodies_are_forgotten() {
        let (media, ids) = media(&[0; 9]);
        let all = ids
            .iter()
            .fold(MediumStack::default(), |stack, id| stack.entered(*id, &media));
        let innermost: Vec<_> = all.ids().collect();
        assert_eq!(innermost, ids[3..]);
    }
}
