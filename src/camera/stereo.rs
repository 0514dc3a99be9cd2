//! Stereo: the cameras of two eyes beside each other.
//!
//! The eyes of a camera lie on its own horizontal axis, the distance between them (`ipd`) apart, and look in the same direction.
//! With a convergence distance their pictures are shifted against each other, so that points at that distance are at the same place
//! in both: off-axis stereo without the distortions of cameras that are turned towards each other.
//!
//! A panorama is omnidirectional stereo: each column of the picture has an eye of its own on a circle of the diameter `ipd`, which
//! looks along the circle's tangent (Ishiguro, Yamamoto and Tsuji, "Omni-Directional Stereo", 1992; Google, "Rendering
//! Omni-directional Stereo Content", 2015).

use std::{fmt, str::FromStr};

use serde::Serialize;

use crate::kind::named;

named! {
    /// The arrangement of the pictures of both eyes in one.
    pub enum EyeLayout: "layout" {
        /// The left eye's is the left half.
        SideBySide = "side-by-side",
        /// The left eye's is the upper half.
        TopBottom = "top-bottom",
    }
}

/// One of the two eyes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
}

/// The distances of two eyes, and those of them that are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stereo {
    /// The distance between the eyes, in m, above 0.
    pub ipd: f64,
    /// The distance at which both pictures show the same, in m, above 0; `None` is infinity.
    pub convergence: Option<f64>,
    /// `None` for both.
    pub side: Option<Side>,
    /// The arrangement of both in one picture; `None` where each has a picture of its own.
    pub layout: Option<EyeLayout>,
}

/// The place of an eye.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StereoEye {
    /// To the right of the camera, in m.
    pub offset: f64,
    /// See [`Stereo::convergence`].
    pub convergence: Option<f64>,
}

/// The second eye of a picture of both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SecondEye {
    pub layout: EyeLayout,
    pub eye: StereoEye,
}

impl EyeLayout {
    /// The factors of the width and the height of a picture of both eyes.
    pub fn factors(self) -> [u32; 2] {
        match self {
            Self::SideBySide => [2, 1],
            Self::TopBottom => [1, 2],
        }
    }
}

impl Side {
    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

impl StereoEye {
    /// The eye that it is.
    pub fn side(&self) -> Side {
        if self.offset < 0.0 { Side::Left } else { Side::Right }
    }
}

impl Stereo {
    /// The eyes of the wanted pictures: `None` is that of both.
    pub fn pictures(&self) -> Vec<Option<Side>> {
        match (self.side, self.layout) {
            (None, None) => vec![Some(Side::Left), Some(Side::Right)],
            (side, _) => vec![side],
        }
    }

    /// The eye of a picture, of that of both the left one; `None` if each has a picture of its own.
    pub fn eye(&self) -> Option<StereoEye> {
        let side = self.side.or(self.layout.map(|_| Side::Left));
        side.map(|side| self.eye_of(side))
    }

    /// The second eye of a picture of both.
    pub fn second(&self) -> Option<SecondEye> {
        self.layout.map(|layout| SecondEye {
            layout,
            eye: self.eye_of(Side::Right),
        })
    }

    fn eye_of(&self, side: Side) -> StereoEye {
        let half = 0.5 * self.ipd;
        StereoEye {
            offset: if side == Side::Left { -half } else { half },
            convergence: self.convergence,
        }
    }
}

/// The text that [`FromStr`] reads.
impl fmt::Display for Stereo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ipd={}", self.ipd)?;
        if let Some(convergence) = self.convergence {
            write!(f, ",convergence={convergence}")?;
        }
        if let Some(side) = self.side {
            write!(f, ",eye={}", side.name())?;
        }
        self.layout.map_or(Ok(()), |layout| write!(f, ",layout={layout}"))
    }
}

impl FromStr for Stereo {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (mut ipd, mut convergence, mut side, mut layout) = (None, None, None, None);
        for part in text.split(',') {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let (key, value) = (key.trim(), value.trim());
            let metres = |example: &str| {
                let number = value.parse().ok().filter(|m: &f64| *m > 0.0 && m.is_finite());
                number.ok_or_else(|| format!("`{key}` is a distance in metres above 0, such as {key}={example}"))
            };
            let is_given = match key {
                "ipd" => ipd.is_some(),
                "convergence" => convergence.is_some(),
                "layout" => layout.is_some(),
                _ => key == "eye" && side.is_some(),
            };
            if is_given {
                return Err(format!("`{key}` is given twice"));
            }
            match key {
                "ipd" => ipd = Some(metres("0.063")?),
                "convergence" => convergence = Some(metres("2")?),
                "eye" => {
                    let named = [Side::Left, Side::Right].into_iter().find(|side| side.name() == value);
                    side = Some(named.ok_or("`eye` is left or right")?);
                }
                "layout" => layout = Some(value.parse::<EyeLayout>().map_err(|unknown| unknown.to_string())?),
                _ => {
                    let message = "expected ipd=METRES, convergence=METRES, eye=left|right or layout=side-by-side|top-bottom, \
                                   with commas between";
                    return Err(message.to_owned());
                }
            }
        }
        let ipd = ipd.ok_or("the distance between the eyes is missing: ipd=0.063")?;
        if side.is_some() && layout.is_some() {
            return Err("`layout` puts both eyes into one picture: leave out `eye`, or `layout`".to_owned());
        }
        Ok(Self {
            ipd,
            convergence,
            side,
            layout,
        })
    }
}

#[cfg(test)]
mod tests;
