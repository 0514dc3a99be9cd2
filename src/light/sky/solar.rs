//! The position of the sun in the sky.
//!
//! Source: the equations of the Solar Calculator of NOAA's Global Monitoring Laboratory, after Meeus, "Astronomical
//! Algorithms", 1998. They are right within 0.02 degrees from 1900 to 2100.

/// A moment: a day and the hours since its midnight in universal time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub year: i32,
    pub month: u32,
    pub day: u32,
    pub hours: f64,
}

/// A position in the sky, in degrees.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkyPosition {
    /// Above the horizon, where it is seen through the air.
    pub elevation: f64,
    /// Clockwise from north, seen from above.
    pub azimuth: f64,
}

fn sin(degrees: f64) -> f64 {
    libm::sin(degrees.to_radians())
}

fn cos(degrees: f64) -> f64 {
    libm::cos(degrees.to_radians())
}

impl Moment {
    /// Centuries since noon of 2000-01-01.
    fn centuries(self) -> f64 {
        // Days of the Gregorian calendar, in years that begin in March.
        let (year, month) = match self.month {
            0..3 => (self.year - 1, self.month + 9),
            m => (self.year, m - 3),
        };
        let leaps = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
        let days = 365 * i64::from(year) + i64::from(leaps) + i64::from((153 * month + 2) / 5 + self.day);
        (days as f64 - 730_426.5 + self.hours / 24.0) / 36_525.0
    }

    /// The declination of the sun in degrees, and the equation of time in minutes.
    fn declination_and_equation(self) -> (f64, f64) {
        let t = self.centuries();
        let longitude = 280.46646 + t * (36_000.769_83 + t * 0.0003032);
        let anomaly = 357.52911 + t * (35_999.050_29 - 0.0001537 * t);
        let eccentricity = 0.016708634 - t * (0.000042037 + 0.0000001267 * t);
        let center = sin(anomaly) * (1.914602 - t * (0.004817 + 0.000014 * t))
            + sin(2.0 * anomaly) * (0.019993 - 0.000101 * t)
            + sin(3.0 * anomaly) * 0.000289;
        let node = 125.04 - 1934.136 * t;
        let apparent = longitude + center - 0.00569 - 0.00478 * sin(node);
        let mean_obliquity = 23.0 + (26.0 + (21.448 - t * (46.815 + t * (0.00059 - t * 0.001813))) / 60.0) / 60.0;
        let obliquity = mean_obliquity + 0.00256 * cos(node);
        let declination = libm::asin(sin(obliquity) * sin(apparent)).to_degrees();
        let tan = sin(0.5 * obliquity) / cos(0.5 * obliquity);
        let (y, e) = (tan * tan, eccentricity);
        let equation = y * sin(2.0 * longitude) - 2.0 * e * sin(anomaly)
            + 4.0 * e * y * sin(anomaly) * cos(2.0 * longitude)
            - 0.5 * y * y * sin(4.0 * longitude)
            - 1.25 * e * e * sin(2.0 * anomaly);
        (declination, 4.0 * equation.to_degrees())
    }

    /// The position of the sun at a latitude (north is positive) and a longitude (east is positive), in degrees.
    pub fn sun(self, latitude: f64, longitude: f64) -> SkyPosition {
        let (declination, equation) = self.declination_and_equation();
        let hour_angle = 15.0 * self.hours + 0.25 * equation + longitude - 180.0;
        let up = sin(latitude) * sin(declination) + cos(latitude) * cos(declination) * cos(hour_angle);
        let east = -cos(declination) * sin(hour_angle);
        let north = cos(latitude) * sin(declination) - sin(latitude) * cos(declination) * cos(hour_angle);
        let elevation = libm::atan2(up, (east * east + north * north).sqrt()).to_degrees();
        SkyPosition {
            elevation: elevation + refraction(elevation),
            azimuth: libm::atan2(east, north).to_degrees().rem_euclid(360.0),
        }
    }
}

/// The degrees by which air lifts what is at an elevation in degrees.
fn refraction(elevation: f64) -> f64 {
    let tan = || sin(elevation) / cos(elevation);
    let seconds = match elevation {
        e if e > 85.0 => 0.0,
        e if e > 5.0 => {
            let t = tan();
            58.1 / t - 0.07 / (t * t * t) + 0.000086 / (t * t * t * t * t)
        }
        e if e > -0.575 => 1735.0 + e * (-518.2 + e * (103.4 + e * (-12.79 + e * 0.711))),
        _ => -20.772 / tan(),
    };
    seconds / 3600.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(year: i32, month: u32, day: u32, hours: f64) -> Moment {
        Moment {
            year,
            month,
            day,
            hours,
        }
    }

    #[test]
    fn days_are_those_of_the_julian_calendar_of_astronomers() {
        // Meeus, table 7.a.
        for (year, month, day, hours, julian) in [
            (2000, 1, 1, 12.0, 2_451_545.0),
            (1999, 1, 1, 0.0, 2_451_179.5),
            (1987, 6, 19, 12.0, 2_446_966.0),
            (1900, 1, 1, 0.0, 2_415_020.5),
            (1600, 12, 31, 0.0, 2_305_812.5),
        ] {
            let own = moment(year, month, day, hours).centuries() * 36_525.0 + 2_451_545.0;
            assert!((own - julian).abs() < 1e-6, "{year}-{month}-{day}: {own}");
        }
    }

    #[test]
    fn declination_and_equation_of_time_are_those_of_meeus() {
        // Examples 25.a and 28.a: 1992 October 13 at 0 h.
        let (declination, equation) = moment(1992, 10, 13, 0.0).declination_and_equation();
        assert!((declination + 7.78507).abs() < 2e-3, "{declination}");
        assert!((equation - (13.0 + 42.6 / 60.0)).abs() < 0.03, "{equation}");
    }

    #[test]
    fn the_sun_stands_where_the_algorithm_of_nrel_has_it() {
        // Reda and Andreas, "Solar Position Algorithm for Solar Radiation Applications", NREL/TP-560-34302, 2008, table A5.1:
        // Golden, Colorado, at 12:30:30, 7 hours behind universal time.
        let sun = moment(2003, 10, 17, 19.0 + 30.5 / 60.0).sun(39.742476, -105.1786);
        assert!((sun.elevation - (90.0 - 50.11162)).abs() < 0.02, "{sun:?}");
        assert!((sun.azimuth - 194.34024).abs() < 0.02, "{sun:?}");
    }

    #[test]
    fn equinoxes_and_solstices_are_those_of_the_almanac() {
        // 2024: March 20 at 3:06, June 20 at 20:51, December 21 at 9:21, with an obliquity of 23.4362 and a nutation of 8.9
        // seconds.
        for (month, day, hours, expected) in [(3, 20, 3.1, 0.0), (6, 20, 20.85, 23.4386), (12, 21, 9.35, -23.4386)] {
            let (declination, _) = moment(2024, month, day, hours).declination_and_equation();
            assert!((declination - expected).abs() < 2e-3, "{month}: {declination}");
        }
        // At noon of an equinox the sun is in the zenith of the equator: 12 h and 7.5 minutes at longitude 0.
        let sun = moment(2024, 3, 20, 12.0 + 7.5 / 60.0).sun(0.0, 0.0);
        assert!(sun.elevation > 89.8, "{sun:?}");
        let sun = moment(2024, 3, 20, 12.0 + 7.5 / 60.0).sun(50.0, 0.0);
        assert!(
            (sun.elevation - 40.15).abs() < 0.05 && (sun.azimuth - 180.0).abs() < 0.1,
            "{sun:?}"
        );
    }
}
