//! Tests of the library and of its source, which need no program and no feature.

mod accelerators;
mod architecture;
mod back_faces;
mod light_links;
mod lights;
mod made_textures;
mod measures;
mod model_parts;
mod motion_blur;
mod overrides;
mod ray_visibility;
mod shadow_catcher;
mod strategies;
