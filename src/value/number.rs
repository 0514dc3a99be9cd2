//! Numbers, points and directions.

use std::{fmt, marker::PhantomData};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Deserializer, de};

use super::{hex::in_hex, list::List};
use crate::math::origin::FAR;

/// Deserializes an integer or a floating-point number.
pub fn number<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    struct NumberVisitor;
    impl de::Visitor<'_> for NumberVisitor {
        type Value = f64;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a number")
        }
        fn visit_str<E: de::Error>(self, v: &str) -> Result<f64, E> {
            let dotted = v.trim().replace(',', ".");
            Err(match dotted.parse::<f64>() {
                Ok(_) => E::custom(format_args!(
                    "expected a number, found the text \"{v}\": write {dotted}"
                )),
                Err(_) => E::invalid_type(de::Unexpected::Str(v), &self),
            })
        }
        fn visit_f64<E: de::Error>(self, v: f64) -> Result<f64, E> {
            Ok(v)
        }
        fn visit_i64<E: de::Error>(self, v: i64) -> Result<f64, E> {
            Ok(v as f64)
        }
    }
    d.deserialize_any(NumberVisitor)
}

/// A whole number from 0 to 2^32 - 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Count(pub u32);

impl<'de> Deserialize<'de> for Count {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct CountVisitor;
        impl de::Visitor<'_> for CountVisitor {
            type Value = Count;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a whole number from 0 to {}", u32::MAX)
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<Count, E> {
                let whole = u32::try_from(v).map_err(|_| E::invalid_value(de::Unexpected::Signed(v), &self))?;
                Ok(Count(whole))
            }
        }
        d.deserialize_any(CountVisitor)
    }
}

pub(super) fn finite<E: de::Error>(v: f64) -> Result<f32, E> {
    let single = v as f32;
    if single.is_finite() {
        Ok(single)
    } else if v.is_finite() {
        Err(E::custom(format_args!("{v:e} is too large")))
    } else {
        Err(E::custom(format_args!("expected a finite number, found {v}")))
    }
}

macro_rules! number {
    ($(#[$meta:meta])* $Name:ident, $what:literal, $ok:expr) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
        pub struct $Name(pub f32);

        impl $Name {
            pub fn one() -> Self {
                Self(1.0)
            }
        }

        impl<'de> Deserialize<'de> for $Name {
            fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                let v = finite::<D::Error>(number(d)?)?;
                let ok: fn(f32) -> bool = $ok;
                if ok(v) {
                    Ok(Self(v))
                } else {
                    Err(de::Error::custom(format_args!(concat!("expected ", $what, ", found {}"), v)))
                }
            }
        }

        impl From<$Name> for f32 {
            fn from(v: $Name) -> f32 {
                v.0
            }
        }
    };
}

number!(
    /// Any finite number.
    Finite,
    "a finite number",
    |_| true
);
number!(
    /// A finite number other than 0.
    Scale,
    "a number other than 0",
    |v| v != 0.0
);
number!(
    /// A finite number above 0: a radius, a height, a width.
    Positive,
    "a number above 0",
    |v| v > 0.0
);
number!(
    /// A finite number of at least 0.
    NonNegative,
    "a number of at least 0",
    |v| v >= 0.0
);
number!(
    /// A number of stops, of which 100 are far more than there is use for, and whose factor is finite.
    Stops,
    "a number of stops from -100 to 100",
    |v| (-100.0..=100.0).contains(&v)
);
number!(
    /// A finite number from 0 to 1.
    UnitInterval,
    "a number from 0 to 1",
    |v| (0.0..=1.0).contains(&v)
);

/// A finite number in double precision, in the range of single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precise(pub f64);

impl<'de> Deserialize<'de> for Precise {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let v = number(d)?;
        finite::<D::Error>(v)?;
        Ok(Self(v))
    }
}

/// A finite number above 0 in double precision, in the range of single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrecisePositive(pub f64);

impl<'de> Deserialize<'de> for PrecisePositive {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let Precise(v) = Precise::deserialize(d)?;
        if v >= f64::from(f32::MIN_POSITIVE) {
            Ok(Self(v))
        } else if v > 0.0 {
            Err(de::Error::custom(format_args!("{v:e} is too small")))
        } else {
            Err(de::Error::custom(format_args!("expected a number above 0, found {v}")))
        }
    }
}

/// A finite coordinate or another finite number of a scene file, in double precision where it is far from 0.
///
/// Numbers below [`FAR`] are those of single precision: what is compiled to single precision and what is computed from
/// them in double agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinate(pub f64);

impl Coordinate {
    pub fn new(v: f64) -> Self {
        Self(if v.abs() < FAR { f64::from(v as f32) } else { v })
    }
}

impl<'de> Deserialize<'de> for Coordinate {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let v = number(d)?;
        finite::<D::Error>(v)?;
        Ok(Self::new(v))
    }
}

/// A scale of a coordinate: one that is not 0, also not in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceScale(pub f64);

impl SpaceScale {
    fn new<E: de::Error>(Coordinate(v): Coordinate) -> Result<Self, E> {
        match v as f32 {
            0.0 => Err(E::custom(format_args!("expected a number other than 0, found {v}"))),
            _ => Ok(Self(v)),
        }
    }
}

impl<'de> Deserialize<'de> for SpaceScale {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        Coordinate::deserialize(d).and_then(Self::new)
    }
}

/// A point or an offset: three finite numbers, each a [`Coordinate`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point(pub DVec3);

impl Point {
    pub fn new(p: DVec3) -> Self {
        Self(DVec3::from(p.to_array().map(|v| Coordinate::new(v).0)))
    }

    /// The point as seen from `origin`, in single precision.
    pub fn relative_to(self, origin: DVec3) -> Vec3 {
        (self.0 - origin).as_vec3()
    }
}

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let List([x, y, z]) = List::<Coordinate, 3>::deserialize(d)?;
        Ok(Self(DVec3::new(x.0, y.0, z.0)))
    }
}

/// `N` numbers: one for all, or a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneOrEach<T, const N: usize>(pub [T; N]);

/// A number of a [`OneOrEach`].
pub trait Component: Copy + for<'de> Deserialize<'de> {
    /// The form of the list.
    const LIST: &'static str;

    /// The number that stands for all.
    fn for_all<E: de::Error>(v: f64) -> Result<Self, E> {
        Self::deserialize(de::value::F64Deserializer::new(v))
    }
}

impl Component for Finite {
    const LIST: &'static str = "[s, t]";
}

impl Component for NonNegative {
    const LIST: &'static str = "[r, g, b]";
}

impl Component for Scale {
    const LIST: &'static str = "[s, t]";
}

impl Component for Coordinate {
    const LIST: &'static str = "[x, y, z]";

    /// Keeps its double precision also near 0.
    fn for_all<E: de::Error>(v: f64) -> Result<Self, E> {
        finite::<E>(v).map(|_| Self(v))
    }
}

impl Component for SpaceScale {
    const LIST: &'static str = Coordinate::LIST;

    fn for_all<E: de::Error>(v: f64) -> Result<Self, E> {
        Coordinate::for_all(v).and_then(Self::new)
    }
}

impl<'de, T: Component, const N: usize> Deserialize<'de> for OneOrEach<T, N> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct EachVisitor<T, const N: usize>(PhantomData<T>);
        impl<'de, T: Component, const N: usize> de::Visitor<'de> for EachVisitor<T, N> {
            type Value = OneOrEach<T, N>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a number or {}", T::LIST)
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<Self::Value, E> {
                T::for_all(v).map(|v| OneOrEach([v; N]))
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<Self::Value, E> {
                self.visit_f64(v as f64)
            }
            fn visit_str<E: de::Error>(self, v: &str) -> Result<Self::Value, E> {
                let wrong = || E::invalid_type(de::Unexpected::Str(v), &self);
                Err(in_hex(v).filter(|_| N == 3).unwrap_or_else(wrong))
            }
            fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
                let List(each) = List::deserialize(de::value::SeqAccessDeserializer::new(seq))?;
                Ok(OneOrEach(each))
            }
        }
        d.deserialize_any(EachVisitor(PhantomData))
    }
}

/// A direction: three finite numbers, not all 0. Held as a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction(pub Vec3);

impl Direction {
    pub fn up() -> Self {
        Self(Vec3::Y)
    }
}

impl<'de> Deserialize<'de> for Direction {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let Point(v) = Point::deserialize(d)?;
        let unit = v.try_normalize();
        unit.map(|u| Self(u.as_vec3()))
            .ok_or_else(|| de::Error::custom("expected a direction, found a vector of length 0"))
    }
}

pub(super) fn not_negative<E: de::Error>(v: f32) -> Result<f32, E> {
    if v >= 0.0 {
        Ok(v)
    } else {
        Err(E::custom(format_args!("expected a number of at least 0, found {v}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::tests::read;

    #[test]
    fn numbers_say_what_they_expect() {
        assert_eq!(read::<Positive>("v = 2"), Ok(Positive(2.0)));
        assert_eq!(
            read::<Positive>("v = -1"),
            Err("expected a number above 0, found -1".into())
        );
        assert_eq!(
            read::<Stops>("v = 2000"),
            Err("expected a number of stops from -100 to 100, found 2000".into())
        );
        assert_eq!(
            read::<Finite>("v = nan"),
            Err("expected a finite number, found NaN".into())
        );
        assert_eq!(
            read::<PrecisePositive>("v = 0"),
            Err("expected a number above 0, found 0".into())
        );
        assert_eq!(read::<PrecisePositive>("v = 1e-200"), Err("1e-200 is too small".into()));
        assert_eq!(read::<PrecisePositive>("v = 1e-38"), Err("1e-38 is too small".into()));
        assert_eq!(read::<Finite>("v = 1e300"), Err("1e300 is too large".into()));
        assert_eq!(read::<Point>("v = [1, 2, 1e300]"), Err("1e300 is too large".into()));
    }

    #[test]
    fn one_number_for_all_is_checked_as_each_of_a_list() {
        for (number, flaw) in [
            ("nan", "expected a finite number, found NaN"),
            ("-inf", "expected a finite number, found -inf"),
            ("1e300", "1e300 is too large"),
        ] {
            for text in [format!("v = {number}"), format!("v = [1, 1, {number}]")] {
                assert_eq!(read::<OneOrEach<Coordinate, 3>>(&text), Err(flaw.into()), "{text}");
                assert_eq!(read::<OneOrEach<SpaceScale, 3>>(&text), Err(flaw.into()), "{text}");
            }
        }
        for text in ["v = 0", "v = [1, 0.0, 1]", "v = 1e-60"] {
            let error = read::<OneOrEach<SpaceScale, 3>>(text).expect_err("no scale");
            assert!(error.starts_with("expected a number other than 0"), "{error}");
        }
        for text in ["v = 0", "v = [1, -0.0]"] {
            let error = read::<OneOrEach<Scale, 2>>(text).expect_err("no scale");
            assert!(error.starts_with("expected a number other than 0"), "{error}");
        }
    }

    #[test]
    fn a_point_a_million_metres_away_keeps_its_millimetres() {
        let Point(p) = read("v = [1000000.001, 0.1, -5649829.6]").expect("a point");
        assert_eq!(p, DVec3::new(1_000_000.001, f64::from(0.1_f32), -5_649_829.6));
        let seen = Point(p).relative_to(DVec3::new(1e6, 0.0, -5_649_829.0));
        assert!((seen - Vec3::new(0.001, 0.1, -0.6)).abs().max_element() < 1e-8);
    }
}
