//! The attributes of a file, beside its pixels: typed values under names.

use std::fmt;

use crate::film::Window;

/// A named value of a file's header.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    pub name: String,
    pub value: Value,
}

impl Attribute {
    pub fn new(name: impl Into<String>, value: impl Into<Value>) -> Self {
        Self {
            name: name.into(),
            value: value.into(),
        }
    }
}

/// A value of one of the types that EXR knows.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// UTF-8.
    String(String),
    Int(i32),
    Float(f32),
    Double(f64),
    V2f([f32; 2]),
    /// Row-major.
    M44f([f32; 16]),
    /// x and y of red, green, blue and white.
    Chromaticities([f32; 8]),
    Rational {
        numerator: i32,
        denominator: u32,
    },
    /// SMPTE 12M: the packed time and flags, and the user's data.
    TimeCode {
        time: u32,
        user: u32,
    },
    Box2i(Window),
    Strings(Vec<String>),
}

impl From<&str> for Value {
    fn from(v: &str) -> Self {
        Self::String(v.to_owned())
    }
}

impl From<String> for Value {
    fn from(v: String) -> Self {
        Self::String(v)
    }
}

impl From<i32> for Value {
    fn from(v: i32) -> Self {
        Self::Int(v)
    }
}

impl From<f32> for Value {
    fn from(v: f32) -> Self {
        Self::Float(v)
    }
}

impl From<f64> for Value {
    fn from(v: f64) -> Self {
        Self::Double(v)
    }
}

/// As formats with nothing but text write it.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let numbers = |f: &mut fmt::Formatter, v: &[f32]| {
            for (i, v) in v.iter().enumerate() {
                write!(f, "{}{v}", if i == 0 { "" } else { " " })?;
            }
            Ok(())
        };
        match self {
            Self::String(v) => f.write_str(v),
            Self::Int(v) => write!(f, "{v}"),
            Self::Float(v) => write!(f, "{v}"),
            Self::Double(v) => write!(f, "{v}"),
            Self::V2f(v) => numbers(f, v),
            Self::M44f(v) => numbers(f, v),
            Self::Chromaticities(v) => numbers(f, v),
            Self::Rational { numerator, denominator } => write!(f, "{numerator}/{denominator}"),
            Self::TimeCode { time, .. } => {
                // Binary coded decimals, with flags in the upper bits of each pair.
                let pair = |shift: u32, mask: u32| (time >> shift) & mask;
                let (h, m, s, fr) = (pair(24, 0x3f), pair(16, 0x7f), pair(8, 0x7f), pair(0, 0x3f));
                write!(f, "{h:02x}:{m:02x}:{s:02x}:{fr:02x}")
            }
            Self::Box2i(w) => write!(f, "{}x{}{:+}{:+}", w.width(), w.height(), w.x0, w.y0),
            Self::Strings(v) => f.write_str(&v.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_read_as_text() {
        let fps = Value::Rational {
            numerator: 24000,
            denominator: 1001,
        };
        let window = Value::Box2i(Window::sized([-1, 2], [3, 4]));
        assert_eq!(fps.to_string(), "24000/1001");
        assert_eq!(window.to_string(), "3x4-1+2");
        assert_eq!(Value::V2f([0.5, -1.0]).to_string(), "0.5 -1");
        assert_eq!(
            Value::TimeCode {
                time: 0x0102_0324,
                user: 0
            }
            .to_string(),
            "01:02:03:24"
        );
    }
}
