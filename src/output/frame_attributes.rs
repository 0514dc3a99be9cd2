//! The attributes of a frame's files, under the names that EXR files give them.

use super::{Attribute, DisplayTransform, FrameImage, Value, seal};
use crate::math::WorkingSpace;

/// The words of a format in the conventions of its numbers.
pub(super) struct Conventions {
    /// The places of pixels.
    pub pixels: &'static str,
    /// The rectangle of the whole picture.
    pub picture: &'static str,
    /// The names of the passes of depth, each as the beginning of a phrase.
    pub depth: &'static str,
    pub distance: &'static str,
}

const OF_CHANNELS: Conventions = Conventions {
    pixels: "pixel centres are at .5 from the upper left corner of the display window",
    picture: "display window",
    depth: "depth.Z",
    distance: "distance.Y the distance",
};

impl Conventions {
    /// The conventions, for readers without the manual.
    pub fn text(&self) -> String {
        let Self {
            pixels,
            picture,
            depth,
            distance,
        } = self;
        format!(
            "{pixels}; the world is right-handed, in metres; worldToCamera and worldToNDC take row vectors; camera space is \
             left-handed: x to the right, y up, z along the line of sight; NDC is 0 0 in the upper left corner of the {picture} and \
             1 1 in the lower right one; {depth} is z in camera space (of a panorama or a fisheye the distance along the ray), \
             {distance} along the ray, both in metres and 1e10 where nothing is met; N and P are in the world; forward and backward \
             are pixels to the right and upwards (u, v) and metres of depth (z)"
        )
    }
}

/// The attributes of a frame, besides those that the EXR format requires.
pub(super) fn attributes(frame: &FrameImage) -> Vec<Attribute> {
    const DISPLAY_VALUES: &str = "the numbers are display values, not scene-linear light";
    let metadata = frame.metadata;
    let version = env!("CARGO_PKG_VERSION");
    let mut list = vec![
        Attribute::new("software", format!("batch-render {version}")),
        Attribute::new("batch-render/version", version),
        Attribute::new(seal::NAME, seal::PLACEHOLDER),
        Attribute::new("batch-render/frame", metadata.frame),
        Attribute::new("batch-render/samples", count(metadata.samples)),
        Attribute::new("batch-render/seed", count(metadata.seed)),
        Attribute::new("batch-render/sampler", metadata.sampler),
        Attribute::new("batch-render/conventions", OF_CHANNELS.text()),
        Attribute::new("imageCounter", metadata.frame),
    ];
    if let Some((numerator, denominator)) = metadata.fps {
        list.push(Attribute::new(
            "framesPerSecond",
            Value::Rational { numerator, denominator },
        ));
        list.extend(time_code(metadata.frame, numerator, denominator).map(|code| Attribute::new("timeCode", code)));
    }
    if frame.has_light() {
        let space = metadata.working_space;
        if metadata.view == DisplayTransform::Raw && space == WorkingSpace::Rec709 {
            list.push(Attribute::new("comments", DISPLAY_VALUES));
        } else {
            let primaries = Value::Chromaticities(space.chromaticities());
            list.push(Attribute::new("chromaticities", primaries));
            list.push(Attribute::new("colorInteropID", space.interop_id()));
        }
    }
    for given in &metadata.attributes {
        match list.iter_mut().find(|a| a.name == given.name) {
            Some(own) if own.name == "comments" => {
                let given = given.value.to_string();
                // The attributes of a file that the renderer wrote have it already.
                let is_said = given.lines().any(|line| line == DISPLAY_VALUES);
                own.value = if is_said {
                    given
                } else {
                    format!("{given}\n{DISPLAY_VALUES}")
                }
                .into();
            }
            Some(own) => own.value = given.value.clone(),
            None => list.push(given.clone()),
        }
    }
    list
}

/// The non-drop time code of a frame; `None` before frame 0, after a day, and at frame rates beyond the format's digits.
fn time_code(frame: i32, numerator: i32, denominator: u32) -> Option<Value> {
    const MAX_RATE: u32 = 30;
    let frame = u32::try_from(frame).ok()?;
    let rate = (f64::from(numerator) / f64::from(denominator)).round() as u32;
    let seconds = frame.checked_div(rate).filter(|_| rate <= MAX_RATE)?;
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    let digits = |n: u32| ((n / 10) << 4) | (n % 10);
    let pairs = [hours, minutes, seconds % 60, frame % rate];
    let time = pairs.into_iter().fold(0, |time, pair| time << 8 | digits(pair));
    (hours < 24).then_some(Value::TimeCode { time, user: 0 })
}

/// A whole number as an `int`, or as a string if it is too large.
fn count(n: u32) -> Value {
    i32::try_from(n).map_or_else(|_| n.to_string().into(), Value::Int)
}
