//! Stereo: the cameras of two eyes beside each other.
//!
//! The eyes of a camera lie on its own horizontal axis, the distance between them (`ipd`) apart, and look in the same direction. With
//! a convergence distance their pictures are shifted against each other, so that points at that distance are at the same place in
//! both: off-axis stereo without the distortions of cameras that are turned towards each other.
//!
//! A panorama is omnidirectional stereo: each column of the picture has an eye of its own on a circle of the diameter `ipd`, which looks
//! along the circle's tangent (Ishiguro, Yamamoto and Tsuji, "Omni-Directional Stereo", 1992; Google, "Rendering Omni-directional Stereo
//! Content", 2015).

use std::{fmt, str::FromStr};

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
}

/// The place of an eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StereoEye {
    /// To the right of the camera, in m.
    pub offset: f64,
    /// See [`Stereo::convergence`].
    pub convergence: Option<f64>,
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

impl Stereo {
    /// The wanted eyes.
    pub fn sides(&self) -> Vec<Side> {
        self.side
            .map_or_else(|| vec![Side::Left, Side::Right], |side| vec![side])
    }

    /// The wanted eye, if it is one.
    pub fn eye(&self) -> Option<StereoEye> {
        let half = 0.5 * self.ipd;
        self.side.map(|side| StereoEye {
            offset: if side == Side::Left { -half } else { half },
            convergence: self.convergence,
        })
    }
}

/// The text that [`FromStr`] reads.
impl fmt::Display for Stereo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ipd={}", self.ipd)?;
        if let Some(convergence) = self.convergence {
            write!(f, ",convergence={convergence}")?;
        }
        self.side.map_or(Ok(()), |side| write!(f, ",eye={}", side.name()))
    }
}

impl FromStr for Stereo {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (mut ipd, mut convergence, mut side) = (None, None, None);
        for part in text.split(',') {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let (key, value) = (key.trim(), value.trim());
            let metres = || {
                let number = value.parse().ok().filter(|m: &f64| *m > 0.0 && m.is_finite());
                number.ok_or_else(|| format!("`{key}` is a distance in metres above 0, such as {key}=0.063"))
            };
            match key {
                "ipd" => ipd = Some(metres()?),
                "convergence" => convergence = Some(metres()?),
                "eye" => {
                    let named = [Side::Left, Side::Right].into_iter().find(|side| side.name() == value);
                    side = Some(named.ok_or("`eye` is left or right")?);
                }
                _ => {
                    return Err(
                        "expected ipd=METRES, convergence=METRES or eye=left|right, with commas between".to_owned(),
                    );
                }
            }
        }
        let ipd = ipd.ok_or("the distance between the eyes is missing: ipd=0.063")?;
        Ok(Self { ipd, convergence, side })
    }
}

#[cfg(test)]
mod tests;
