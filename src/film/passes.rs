//! The passes (AOVs): everything that a film can hold of a frame, one row each.
//!
//! Scene files (`[output] aovs`, `show`), the command line (`--aovs`, `--show`), the film, the writers and the documentation
//! read this table. A new pass is one row; a pass of what the camera meets first is a function from [`FirstHit`] to numbers.

use super::motion;
use crate::{
    camera::{Camera, Neighbours},
    geometry::InstanceId,
    math::Rgb,
    scene::{Component, FirstHit, MatteKind, Scene},
};

/// One pass.
#[derive(Debug)]
pub struct PassSpec {
    /// Its name in scene files and on the command line, and the layer's name in EXR files.
    pub name: &'static str,
    /// The names of its channels; EXR files put the pass's name and a dot before them, but for the beauty.
    pub channels: &'static [&'static str],
    pub pixel: PixelType,
    pub combine: Combine,
    /// The value of all channels where no sample meets anything.
    pub background: f32,
    pub display: Display,
    pub source: PassSource,
    /// One line for the manual: what it holds, with its unit.
    pub about: &'static str,
}

/// The type that EXR files store a pass as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelType {
    Half,
    Float,
    /// 32-bit whole numbers; films hold their bits as those of an `f32`.
    Uint,
}

/// The rule that makes a pixel's value of its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combine {
    /// The mean, weighted by the pixel filter.
    Filtered,
    /// The sample nearest to the pixel's centre; of equally near ones the first.
    Nearest,
    /// A figure about all samples, of which each counts once.
    Counted,
    /// The mattes that cover the pixel and the coverage of each by the pixel filter, from the most to the least.
    Ranked,
}

/// The display of a pass in an 8-bit picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Display {
    /// Light, by the scene's view and exposure.
    Light,
    /// The sum of the first two channels as a colour from dark blue (0) over green (31) to red (1023 and more), by the
    /// logarithm.
    Heat,
    /// Half of the values plus one half: -1 is black, 1 is white.
    Signed,
    /// The first channel as gray, from white (0) to black (1023 m and more), a tenth darker for every doubling of 1 + z.
    Near,
    /// The fractions of the values.
    Fraction,
    /// A colour for each whole number; 0 is black.
    Id,
}

/// The origin of a pass's values.
#[derive(Clone, Copy, Debug)]
pub enum PassSource {
    /// The output of the integrator: light, or the cost of tracing.
    Integrator,
    /// A part of that light.
    Light(Component),
    /// The light of one group; the film has such a pass for each.
    LightGroup,
    /// The mattes of this kind that the first hits are in: Cryptomatte. Two ranks share the channels of a layer, as many layers
    /// have the pass's name and a number.
    Matte(MatteKind),
    /// The first hit of the sample's camera ray that lies nearest to the pixel's centre.
    FirstHit(fn(&FirstHit, &PassContext<'_>) -> [f32; 3]),
    /// A colour of the first hits of all samples.
    Color(fn(&FirstHit) -> Rgb),
    /// A figure about the samples of the beauty.
    Statistic(Statistic),
}

/// A figure about the samples of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    Count,
    /// The variance of the pixel's value.
    Variance,
}

/// The data that a pass may read beside the first hit.
#[derive(Clone, Copy)]
pub struct PassContext<'a> {
    /// The camera when the shutter opens, and those of the frames before and after.
    pub camera: &'a Camera,
    pub neighbours: &'a Neighbours,
    pub scene: &'a Scene,
}

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

/// The light that the integrator computes, premultiplied, with its coverage.
pub const BEAUTY: &PassSpec = &PASSES[0];

/// The output of the integrator `cost`, in place of light.
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
        source: PassSource::Color(|hit| hit.albedo),
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
        about: "unit shading normal in world space, as authored: a face that points away from the camera shows it",
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
        source: PassSource::FirstHit(|hit, context| {
            let along_axis = |axis| hit.distance * axis;
            let cos = context.camera.axis().map(|axis| -hit.wo.dot(axis));
            [cos.map_or(hit.distance, along_axis), 0.0, 0.0]
        }),
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
            motion::between(hit.p, Some(context.camera), context.neighbours.next.as_ref())
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
            motion::between(hit.p, context.neighbours.previous.as_ref(), Some(context.camera))
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
        source: PassSource::FirstHit(|hit, _| id(Some(hit.object.0))),
        about: "number of the object, 1 for the first of the scene file",
    },
    PassSpec {
        name: "instanceId",
        channels: &["Y"],
        pixel: PixelType::Uint,
        combine: Combine::Nearest,
        background: 0.0,
        display: Display::Id,
        source: PassSource::FirstHit(|hit, _| id((hit.instance != InstanceId::NONE).then_some(hit.instance.0))),
        about: "number of the instance, from 1; 0 for what is no instance",
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
    PassSpec {
        name: "variance",
        channels: &["R", "G", "B"],
        pixel: PixelType::Float,
        combine: Combine::Counted,
        background: 0.0,
        display: Display::Heat,
        source: PassSource::Statistic(Statistic::Variance),
        about: "variance of the beauty of the pixel, as if its samples were independent; 0 for a single sample",
    },
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

/// The name that lights without a group go by.
pub const DEFAULT_GROUP: &str = "default";

/// The beginning of the names of their passes.
pub(super) const GROUP_PREFIX: &str = "lightgroup_";

impl PassSpec {
    /// Whether it depends on the cameras of the frames before and after.
    pub fn follows_motion(&self) -> bool {
        matches!(self.name, "forward" | "backward")
    }

    /// Whether its values are light, with a colour space, and not data.
    pub fn is_light(&self) -> bool {
        self.display == Display::Light
    }

    /// Whether it is made of first hits.
    pub fn reads_first_hits(&self) -> bool {
        use PassSource::{Color, FirstHit, Matte};
        matches!(self.source, FirstHit(_) | Matte(_) | Color(_))
    }

    /// Whether `--aovs` may ask for it: not what stands in place of the beauty.
    pub(super) fn is_requestable(&self) -> bool {
        !matches!(self.source, PassSource::Integrator) || self.name == BEAUTY.name
    }
}

impl PartialEq for PassSpec {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

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
            assert_eq!(spec.is_light(), filtered, "{}", spec.name);
            use PassSource::{FirstHit, Matte, Statistic};
            let is_data = matches!(spec.source, FirstHit(_) | Matte(_) | Statistic(_));
            assert_eq!(!filtered, is_data, "{}", spec.name);
        }
    }
}
