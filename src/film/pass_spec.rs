//! The description of a pass (AOV): a row of the pass table.

use crate::{
    camera::{Camera, FilmSize, FrameCamera},
    scene::{Component, FirstHit, MatteKind, PointMotion, Scene, SceneMotion},
};

/// One pass.
#[derive(Debug)]
pub struct PassSpec {
    /// Its name in scene files and on the command line, and the layer's name in EXR files.
    pub name: &'static str,
    /// The names of its channels. In EXR files the pass's name and a dot precede them, except for the beauty.
    pub channels: &'static [&'static str],
    pub pixel: PixelType,
    pub combine: Combine,
    /// The value of all channels of pixels without a hit.
    pub background: f32,
    pub display: Display,
    pub source: PassSource,
    /// The content with its unit, a line for the manual.
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

/// The rule by which a pixel's value is computed from its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combine {
    /// The mean, weighted by the pixel filter.
    Filtered,
    /// The sample nearest to the pixel's centre; of equally near ones the first.
    Nearest,
    /// A statistic of all samples, unweighted.
    Counted,
    /// The mattes of the pixel with their coverage by the pixel filter, in descending order.
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
    /// The first channel as gray, from black (0) to white (1).
    Share,
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
    /// The mattes of this kind at the first hits (Cryptomatte). A layer holds two ranks; layers are named by the pass and a
    /// number.
    Matte(MatteKind),
    /// The first hit of the sample nearest to the pixel's centre.
    FirstHit(fn(&FirstHit, &PassContext<'_>) -> [f32; 3]),
    /// The mean of a feature of the first hits.
    Mean(Feature),
    /// The variance of this mean, by the halves of the samples.
    MeanVariance(Feature),
    /// The beauty of the first (0) or the second half (1) of the samples.
    Half(usize),
    /// The alpha of both halves of the samples.
    AlphaHalves,
    /// The alpha with shadow catchers as ordinary surfaces.
    Coverage,
    /// A statistic of the samples of the beauty.
    Statistic(Statistic),
}

/// A statistic of the samples of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    Count,
    /// The variance of the pixel's value.
    Variance,
}

/// A property of first hits whose mean helps denoisers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    Albedo,
    Normal,
    Depth,
}

/// The data that a pass may read beside the first hit.
#[derive(Clone, Copy)]
pub struct PassContext<'a> {
    /// The camera when the shutter opens for the pixel.
    pub camera: &'a Camera,
    /// The camera of the frame, with those of the frames before and after.
    pub frame_camera: &'a FrameCamera,
    /// The size of the whole picture.
    pub film: FilmSize,
    /// The scene at the time of the sample.
    pub scene: &'a Scene,
    /// The motion of the scene's surfaces; `None` if nothing moves.
    pub motion: Option<&'a SceneMotion>,
}

impl<'a> PassContext<'a> {
    /// The same data with the camera of a pixel, if it has one of its own.
    #[inline]
    pub fn with_camera(&self, own: Option<&'a Camera>) -> Self {
        Self {
            camera: own.unwrap_or(self.camera),
            ..*self
        }
    }

    /// The motion of the point of a first hit.
    pub(super) fn motion_of(&self, hit: &FirstHit) -> PointMotion {
        let resting = PointMotion {
            before: hit.p,
            now: hit.p,
            after: hit.p,
        };
        self.motion.map_or(resting, |motion| motion.of(self.scene, hit))
    }
}

impl PassSpec {
    /// Whether it depends on the cameras of the frames before and after, and on what moves between them.
    pub fn follows_motion(&self) -> bool {
        matches!(self.name, "forward" | "backward")
    }

    /// Whether its values are light with a colour space, rather than data.
    pub fn is_light(&self) -> bool {
        self.display == Display::Light
    }

    /// Whether it is made of first hits.
    pub fn reads_first_hits(&self) -> bool {
        use PassSource::{FirstHit, Matte};
        matches!(self.source, FirstHit(_) | Matte(_)) || self.feature().is_some()
    }

    /// The feature whose mean, or the variance of whose mean, it shows.
    pub fn feature(&self) -> Option<Feature> {
        match self.source {
            PassSource::Mean(feature) | PassSource::MeanVariance(feature) => Some(feature),
            _ => None,
        }
    }

    /// Whether it needs the halves of a pixel's samples, and so their number in advance.
    pub fn is_by_halves(&self) -> bool {
        matches!(
            self.source,
            PassSource::Half(_) | PassSource::AlphaHalves | PassSource::MeanVariance(_)
        )
    }

    /// Whether denoisers read it, so that the name `denoise` includes it. Jobs add those that follow motion where objects move, and
    /// `coverage` where shadow catchers are.
    pub fn serves_denoisers(&self) -> bool {
        self.is_by_halves() || self.feature().is_some() || self.name == "objectId"
    }
}

impl PartialEq for PassSpec {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}
