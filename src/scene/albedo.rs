//! The albedo of surfaces: the fraction of uniform white light that they scatter to a viewer.

use std::borrow::Cow;

use super::{MediumStack, Scene, SurfaceInteraction, shading_frame::shading_frame};
use crate::{
    bsdf::{BsdfKind, BsdfVisitor},
    material::Material,
    math::{Rgb, Sample2D},
};

impl Scene {
    /// An estimate of the albedo from one sampled direction, by the uniform numbers of [`BsdfKind::sample`]. Its mean is the
    /// albedo: the integral of `f |cos|` over all directions of reflection and transmission. For Lambert's law and mirrors
    /// the estimate is exact.
    pub fn sample_albedo(
        &self,
        surface: &SurfaceInteraction,
        media: MediumStack,
        numbers: impl FnOnce() -> (f32, Sample2D),
    ) -> Rgb {
        let material = self.material(surface.material);
        let mut bsdf = self.bsdf(surface.material, &surface.texture);
        if let Some(albedo) = bsdf.lambert_albedo() {
            return albedo;
        }
        if let Some(ior) = self.ior_outside(media, surface.material) {
            bsdf = Cow::Owned(bsdf.into_owned().immersed(ior));
        }
        let mut albedo = Rgb::BLACK;
        bsdf.dispatch(SampleAlbedo {
            scene: self,
            surface,
            material,
            numbers: numbers(),
            albedo: &mut albedo,
        });
        albedo
    }
}

struct SampleAlbedo<'a> {
    scene: &'a Scene,
    surface: &'a SurfaceInteraction,
    material: &'a Material,
    numbers: (f32, Sample2D),
    albedo: &'a mut Rgb,
}

impl BsdfVisitor for SampleAlbedo<'_> {
    fn visit(self, bsdf: &impl BsdfKind) {
        let frame = shading_frame(self.scene, self.surface, self.material, bsdf).frame;
        let (uc, u) = self.numbers;
        let sample = bsdf.sample(frame.to_local(self.surface.wo), uc, u);
        let weight = sample.map_or(Rgb::BLACK, |sample| sample.weight);
        *self.albedo = if weight.is_finite() { weight } else { Rgb::BLACK };
    }
}
