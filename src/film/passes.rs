//! The table of passes (AOVs): everything that a film can hold of a frame, one row each.
//!
//! Scene files (`[output] aovs`, `show`), the command line (`--aovs`, `--show`), the film, the writers and the documentation
//! read this table. A new pass is one row; a pass of first hits is a function from [`FirstHit`](crate::scene::FirstHit) to
//! numbers.

use super::{
    features,
    motion::{self, PictureTime},
};
use crate::scene::{Component, MatteKind};

pub use super::pass_spec::{Combine, Display, Feature, PassContext, PassSource, PassSpec, PixelType, Statistic};

const fn light(name: &'static str, component: Component, about: &'static str) -> PassSpec {
    PassSpec {
        name,
        channels: &["R", "G", "B"],
        pixel: PixelType::Half,
        combine: Combine::Filtered,
        background: 0.0,
        display: Display::Light,
        source: PassSource::Light(component),
        about,
    }
}

const fn matte(name: &'static str, kind: MatteKind, about: &'static str) -> PassSpec {
    PassSpec {
        name,
        channels: &["R", "G", "B", "A"],
        pixel: PixelType::Float,
        combine: Combine::Ranked,
        background: 0.0,
        display: Display::Id,
        source: PassSource::Matte(kind),
        about,
    }
}

const fn half(name: &'static str, half: usize, about: &'static str) -> PassSpec {
    PassSpec {
        name,
        channels: &["R", "G", "B"],
        pixel: PixelType::Half,
        combine: Combine::Filtered,
        background: 0.0,
        display: Display::Light,
        source: PassSource::Half(half),
        about,
    }
}

const fn variance(
    name: &'static str,
    channels: &'static [&'static str],
    source: PassSource,
    about: &'static str,
) -> PassSpec {
    PassSpec {
        name,
        channels,
        pixel: PixelType::Float,
        combine: Combine::Counted,
        background: 0.0,
        display: Display::Heat,
        source,
        about,
    }
}

/// The light that the integrator computes, premultiplied, with its coverage.
pub const BEAUTY: &PassSpec = &PASSES[0];

/// The output of the integrator `cost`, instead of light.
pub const COST: &PassSpec = &PASSES[1];

/// Every pass.
pub const PASSES: &[PassSpec] = &[
    PassSpec {
        name: "beauty",
        channels: &["R", "G", "B", "A"],
        pixel: PixelType::Half,
        combine: Combine::Filtered,
        background: 0.0,
        display: Display::Light,
        source: PassSource::Integrator,
        about: "the picture: premultiplied light, W m^-2 sr^-1, and alpha; always there",
    },
    PassSpec {
        name: "cost",
        channels: &["nodes", "primitives"],
        pixel: PixelType::Float,
        combine: Combine::Filtered,
        background: 0.0,
        display: Display::Heat,
        source: PassSource::Integrator,
        about: "nodes and primitives that a camera ray tests; in place of the beauty of the integrator `cost`",
    },
    light(
        "diffuse_direct",
        Component::DiffuseDirect,
        "light that comes straight from lights by diffuse lobes of the first surface",
    ),
    light(
        "diffuse_indirect",
        Component::DiffuseIndirect,
        "light from other surfaces by diffuse lobes of the first surface",
    ),
    light(
        "specular_direct",
        Component::SpecularDirect,
        "light that comes straight from lights by the other reflecting lobes of the first surface",
    ),
    light(
        "specular_indirect",
        Component::SpecularIndirect,
        "light from other surfaces by the other reflecting lobes of the first surface",
    ),
    light(
        "transmission",
        Component::Transmission,
        "light that comes through the first surface",
    ),
    light(
        "emission",
        Component::Emission,
        "light of emitters and of the background where the camera sees them",
    ),
    PassSpec {
        name: "lightgroup",
        channels: &["R", "G", "B"],
        pixel: PixelType::Half,
        combine: Combine::Filtered,
        background: 0.0,
        display: Display::Light,
        source: PassSource::LightGroup,
        about: "light of each group, as `lightgroup_NAME`; lights without a group are in `lightgroup_default`",
    },
    PassSpec {
        name: "albedo",
        channels: &["R", "G", "B"],
        pixel: PixelType::Half,
        combine: Combine::Filtered,
        background: 0.0,
        display: Display::Light,
        source: PassSource::Mean(Feature::Albedo),
        about: "the part of white light from all around that the first surface reflects or lets through to the camera",
    },
    PassSpec {
        name: "N",
        channels: &["X", "Y", "Z"],
        pixel: PixelType::Half,
        combine: Combine::Nearest,
        background: 0.0,
        display: Display::Signed,
        source: PassSource::FirstHit(|hit, _| hit.ns.to_array()),
        about: "unit shading normal in world space, as authored, without normal maps: a face that points away from the camera shows it",
    },
    PassSpec {
        name: "P",
        channels: &["X", "Y", "Z"],
        pixel: PixelType::Float,
        combine: Combine::Nearest,
        background: 0.0,
        display: Display::Fraction,
        source: PassSource::FirstHit(|hit, context| (context.scene.origin + hit.p.as_dvec3()).as_vec3().to_array()),
        about: "place of the surface in world space, in metres",
    },
    PassSpec {
        name: "depth",
        channels: &["Z"],
        pixel: PixelType::Float,
        combine: Combine::Nearest,
        background: 1e10,
        display: Display::Near,
        source: PassSource::FirstHit(|hit, context| [features::depth(hit, context), 0.0, 0.0]),
        about: "distance along the camera's line of sight, in metres; a panorama has the distance along the ray",
    },
    PassSpec {
        name: "distance",
        channels: &["Y"],
        pixel: PixelType::Float,
        combine: Combine::Nearest,
        background: 1e10,
        display: Display::Near,
        source: PassSource::FirstHit(|hit, _| [hit.distance, 0.0, 0.0]),
        about: "distance along the ray, in metres",
    },
    PassSpec {
        name: "UV",
        channels: &["U", "V"],
        pixel: PixelType::Float,
        combine: Combine::Nearest,
        background: 0.0,
        display: Display::Fraction,
        source: PassSource::FirstHit(|hit, _| [hit.uv.x, hit.uv.y, 0.0]),
        about: "surface parameters, which `mapping = \"uv\"` textures read",
    },
    PassSpec {
        name: "forward",
        channels: &["u", "v", "z"],
        pixel: PixelType::Float,
        combine: Combine::Nearest,
        background: 0.0,
        display: Display::Signed,
        source: PassSource::FirstHit(|hit, context| {
            let points = context.motion_of(hit);
            motion::between(context, &points, [PictureTime::Now, PictureTime::After])
        }),
        about: "motion of the surface to its place in the next frame: pixels to the right, pixels upwards, and metres of depth",
    },
    PassSpec {
        name: "backward",
        channels: &["u", "v", "z"],
        pixel: PixelType::Float,
        combine: Combine::Nearest,
        background: 0.0,
        display: Display::Signed,
        source: PassSource::FirstHit(|hit, context| {
            let points = context.motion_of(hit);
            motion::between(context, &points, [PictureTime::Before, PictureTime::Now])
        }),
        about: "the same from its place in the frame before to that in this one; 0 over a cut and where there is no such frame",
    },
    PassSpec {
        name: "objectId",
        channels: &["Y"],
        pixel: PixelType::Uint,
        combine: Combine::Nearest,
        background: 0.0,
        display: Display::Id,
        source: PassSource::FirstHit(|hit, context| id(Some(context.scene.mattes().part(context.scene, hit)))),
        about: "number of the object, 1 for the first of the scene file; the nodes of a glTF file, and the objects and groups of an OBJ file, have numbers of their own, as in CryptoObject",
    },
    PassSpec {
        name: "instanceId",
        channels: &["Y"],
        pixel: PixelType::Uint,
        combine: Combine::Nearest,
        background: 0.0,
        display: Display::Id,
        source: PassSource::FirstHit(|hit, context| id(context.scene.copy(hit))),
        about: "number of the copy of a mesh that the scene shows several times, from 1, however many triangles it has; 0 for others",
    },
    PassSpec {
        name: "materialId",
        channels: &["Y"],
        pixel: PixelType::Uint,
        combine: Combine::Nearest,
        background: 0.0,
        display: Display::Id,
        source: PassSource::FirstHit(|hit, _| id(Some(hit.material.0))),
        about: "number of the material, from 1",
    },
    variance(
        "variance",
        &["R", "G", "B"],
        PassSource::Statistic(Statistic::Variance),
        "variance of the beauty, as if the samples of a pixel were independent; 0 for a single sample",
    ),
    PassSpec {
        name: "sampleCount",
        channels: &["Y"],
        pixel: PixelType::Float,
        combine: Combine::Counted,
        background: 0.0,
        display: Display::Heat,
        source: PassSource::Statistic(Statistic::Count),
        about: "number of the samples of the beauty, without those that were not finite",
    },
    half(
        "beauty_a",
        0,
        "the beauty of the first half of the samples, with the smaller number where it is odd; with adaptive sampling of those before the last doubling",
    ),
    half(
        "beauty_b",
        1,
        "the beauty of the second half; the same as of the first for a single sample",
    ),
    PassSpec {
        name: "alpha_halves",
        channels: &["A", "B"],
        pixel: PixelType::Half,
        combine: Combine::Filtered,
        background: 0.0,
        display: Display::Signed,
        source: PassSource::AlphaHalves,
        about: "the alpha of `beauty_a` and that of `beauty_b`",
    },
    PassSpec {
        name: COVERAGE,
        channels: &["A"],
        pixel: PixelType::Half,
        combine: Combine::Filtered,
        background: 0.0,
        display: Display::Share,
        source: PassSource::Coverage,
        about: "the alpha with shadow catchers as ordinary surfaces, by which the light of such scenes is divided before it is denoised",
    },
    variance(
        "albedo_variance",
        &["R", "G", "B"],
        PassSource::MeanVariance(Feature::Albedo),
        "variance of `albedo`, by the halves of the samples: ((a - b) / 2)^2",
    ),
    PassSpec {
        name: "N_mean",
        channels: &["X", "Y", "Z"],
        pixel: PixelType::Half,
        combine: Combine::Filtered,
        background: 0.0,
        display: Display::Signed,
        source: PassSource::Mean(Feature::Normal),
        about: "mean of `N` over the samples, shorter than 1 at edges",
    },
    variance(
        "N_variance",
        &["X", "Y", "Z"],
        PassSource::MeanVariance(Feature::Normal),
        "variance of `N_mean`, in the same way",
    ),
    PassSpec {
        name: "depth_mean",
        channels: &["Z"],
        pixel: PixelType::Float,
        combine: Combine::Filtered,
        background: 1e10,
        display: Display::Near,
        source: PassSource::Mean(Feature::Depth),
        about: "mean of `depth` over the samples that meet a surface, in metres",
    },
    variance(
        "depth_variance",
        &["Z"],
        PassSource::MeanVariance(Feature::Depth),
        "variance of `depth_mean`, in m^2, in the same way",
    ),
    matte(
        "CryptoObject",
        MatteKind::Object,
        "Cryptomatte of the objects; the nodes of a glTF file, and the objects and groups of an OBJ file, are mattes of their own",
    ),
    matte("CryptoMaterial", MatteKind::Material, "Cryptomatte of the materials"),
    matte(
        "CryptoAsset",
        MatteKind::Asset,
        "Cryptomatte of the model files, and of objects that come from none",
    ),
];

/// The bits of a number from 1 for an index from 0, as those of a float; 0 for none.
fn id(index: Option<u32>) -> [f32; 3] {
    [f32::from_bits(index.map_or(0, |i| i.wrapping_add(1))), 0.0, 0.0]
}

/// The name of the group of lights without a group.
pub const DEFAULT_GROUP: &str = "default";

/// The name of the pass of the alpha with shadow catchers as ordinary surfaces.
pub const COVERAGE: &str = "coverage";

/// The names of the passes of light groups begin with this.
pub const GROUP_PREFIX: &str = "lightgroup_";

/// The name of the pass that shows the light of a group.
pub fn group_pass_name(group: &str) -> String {
    let group = if group.is_empty() { DEFAULT_GROUP } else { group };
    format!("{GROUP_PREFIX}{group}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_short_enough_for_every_reader_of_exr() {
        for (i, spec) in PASSES.iter().enumerate() {
            assert!(PASSES[..i].iter().all(|other| other.name != spec.name), "{}", spec.name);
            for channel in spec.channels {
                assert!(spec.name.len() + 1 + channel.len() <= 31, "{}", spec.name);
            }
            assert!((1..=4).contains(&spec.channels.len()) && !spec.about.is_empty());
        }
        assert_eq!((BEAUTY.name, COST.name), ("beauty", "cost"));
    }

    #[test]
    fn data_is_never_filtered_and_light_always_is() {
        for spec in PASSES
            .iter()
            .filter(|spec| !matches!(spec.source, PassSource::Integrator))
        {
            let filtered = spec.combine == Combine::Filtered;
            use PassSource::{AlphaHalves, Coverage, FirstHit, Matte, Mean, MeanVariance, Statistic};
            // The halves of the alpha and the coverage are filtered as the alpha is.
            let is_mean = matches!(spec.source, Mean(_) | AlphaHalves | Coverage);
            assert_eq!(spec.is_light() || is_mean, filtered, "{}", spec.name);
            let is_data = matches!(spec.source, FirstHit(_) | Matte(_) | Statistic(_) | MeanVariance(_));
            assert_eq!(!filtered, is_data, "{}", spec.name);
        }
    }
}
