//! The shadow rays of a wave.

use super::Wave;
use crate::{
    accel::{self, BatchLayout},
    integrator::ShadingOutput,
    math::Rgb,
    render::{
        context::RenderContext,
        transparency::{PassingShadowRays, transmittance},
    },
};

impl Wave {
    /// Traces the shadow rays and adds their light. Returns the number of traced rays.
    pub(super) fn resolve_shadow_rays(&mut self, context: &RenderContext<'_>, layout: BatchLayout) -> u64 {
        let ShadingOutput {
            shadow_rays,
            shadow_light,
            shadow_passages,
            radiance,
            ..
        } = &mut self.out;
        self.blocked.clear();
        self.blocked.resize(shadow_rays.len(), false);
        let batch = accel::RayBatch {
            rays: shadow_rays,
            layout,
        };
        context.scene.geometry.accel.occluded_batch(batch, &mut self.blocked);
        let traced = shadow_rays.len() as u64;
        if !context.shadow_rays_pass {
            for (&(sample, l), _) in shadow_light.iter().zip(&self.blocked).filter(|(_, blocked)| !**blocked) {
                radiance[sample as usize] += l;
            }
            self.resolve_layers(|wave, ray| if wave.blocked[ray] { Rgb::BLACK } else { Rgb::WHITE });
            return traced;
        }
        let visible = &mut self.visible;
        let shadow = PassingShadowRays {
            rays: shadow_rays,
            light: shadow_light,
            passages: shadow_passages,
            blocked: &self.blocked,
            samples: self.weights.len() as u32,
        };
        let more = transmittance(context.scene, shadow, visible, &mut self.passing);
        for (&(sample, l), &visible) in shadow_light.iter().zip(&*visible).filter(|(_, v)| !v.is_black()) {
            radiance[sample as usize] += l * visible;
        }
        self.resolve_layers(|wave, ray| wave.visible[ray]);
        traced + more
    }

    /// Adds the light of the shadow rays to its layers, if there are any; `visible` returns the transmittance.
    fn resolve_layers(&mut self, visible: impl Fn(&Self, usize) -> Rgb) {
        let Some(mut layers) = self.out.layers.take() else {
            return;
        };
        for ray in 0..self.blocked.len() {
            let visible = visible(self, ray);
            if !visible.is_black() {
                layers.resolve_shadow(ray, visible);
            }
        }
        self.out.layers = Some(layers);
    }
}
