//! Views: sets of directions from which a job sees a scene.

use std::{ops::RangeInclusive, str::FromStr};

use crate::math::{DVec3, transform::axis_rotation};

/// The first frame, in which the scene is measured.
pub(super) const FIRST: i64 = 1;
/// The most views of a set.
const MOST_VIEWS: u32 = 1_000_000;

/// The views of a job.
#[derive(Clone, Debug)]
pub struct Views {
    /// The frames are numbered from 1 through all sets in this order.
    pub sets: Vec<ViewSet>,
    /// The share of the picture that the scene may fill, from its middle to its edges: above 0, at most 1.
    pub fit: f64,
}

/// Cameras in directions that follow one rule.
#[derive(Clone, Copy, Debug)]
pub struct ViewSet {
    rule: &'static Rule,
    views: u32,
    /// In degrees above the horizon.
    elevation: f64,
}

/// A rule for the directions of a set.
#[derive(Debug)]
struct Rule {
    name: &'static str,
    /// The number of its views; `None` where the user gives it.
    views: Option<u32>,
    has_elevation: bool,
    direction: fn(View) -> DVec3,
}

const RULES: [Rule; 4] = [
    Rule {
        name: "orbit",
        views: None,
        has_elevation: true,
        direction: orbit,
    },
    Rule {
        name: "hemisphere",
        views: None,
        has_elevation: false,
        direction: |view| lattice(view, 1.0),
    },
    Rule {
        name: "sphere",
        views: None,
        has_elevation: false,
        direction: |view| lattice(view, 2.0),
    },
    Rule {
        name: "cube",
        views: Some(6),
        has_elevation: false,
        direction: axis,
    },
];

/// One view of a set.
#[derive(Clone, Copy)]
struct View {
    set: ViewSet,
    /// Counted from 0.
    index: u32,
    /// The horizontal unit vector from the middle towards the scene's own camera.
    start: DVec3,
}

/// Equal steps around the vertical axis from the start, counterclockwise as seen from above.
fn orbit(view: View) -> DVec3 {
    let ViewSet { views, elevation, .. } = view.set;
    let turn = axis_rotation(1, 360.0 * f64::from(view.index) / f64::from(views));
    // The columns of this rotation are (1, 0, 0), (0, cos, sin) and (0, -sin, cos).
    let tilt = axis_rotation(0, elevation).y_axis;
    turn * (view.start * tilt.y) + DVec3::Y * tilt.z
}

/// The Fibonacci lattice from the top down over this height of the unit sphere: points of equal areas, each a
/// golden angle after the one before.
///
/// Source: Gonzalez, "Measurement of Areas on a Sphere Using Fibonacci and Latitude-Longitude Lattices", Mathematical Geosciences
/// 42, 2010, doi:10.1007/s11004-009-9257-x, equation 1, for any number of points.
fn lattice(view: View, height: f64) -> DVec3 {
    let y = 1.0 - height * (f64::from(view.index) + 0.5) / f64::from(view.set.views);
    let golden = 180.0 * (3.0 - 5.0_f64.sqrt());
    axis_rotation(1, golden * f64::from(view.index)) * DVec3::new(0.0, y, (1.0 - y * y).sqrt())
}

/// +x, -x, +y, -y, +z and -z.
fn axis(view: View) -> DVec3 {
    let sign = if view.index.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * DVec3::AXES[(view.index / 2) as usize % 3]
}

impl FromStr for ViewSet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || {
            format!(
                "expected orbit:N, orbit:N@ELEVATION, hemisphere:N, sphere:N or cube, with N from 1 to {MOST_VIEWS}"
            )
        };
        let (form, elevation) = text.split_once('@').map_or((text, None), |(form, e)| (form, Some(e)));
        let (name, views) = form.split_once(':').map_or((form, None), |(name, n)| (name, Some(n)));
        let rule = RULES.iter().find(|rule| rule.name == name.trim()).ok_or_else(unknown)?;
        let given = views.map(|n| n.trim().parse().ok().filter(|n| (1..=MOST_VIEWS).contains(n)));
        let views = match (rule.views, given) {
            (None, Some(given)) => given,
            (own, None) => own,
            (Some(_), Some(_)) => None,
        };
        let elevation = match elevation {
            None => 0.0,
            Some(_) if !rule.has_elevation => return Err(unknown()),
            Some(e) => {
                let degrees = e.trim().parse().ok().filter(|e: &f64| e.abs() < 90.0);
                degrees.ok_or("expected degrees above -90 and below 90 after @, such as orbit:24@30")?
            }
        };
        let views = views.ok_or_else(unknown)?;
        Ok(Self { rule, views, elevation })
    }
}

impl Views {
    /// The frames of all sets.
    pub(super) fn frames(&self) -> RangeInclusive<i64> {
        let views = self.sets.iter().map(|set| i64::from(set.views));
        FIRST..=views.sum::<i64>()
    }

    /// The unit vector from the middle to the camera of a frame, for the horizontal direction of the scene's own camera; `None` for
    /// a frame that is none of the views'.
    pub(super) fn direction(&self, frame: i64, start: DVec3) -> Option<DVec3> {
        let mut index = u32::try_from(frame - FIRST).ok()?;
        for set in &self.sets {
            if index < set.views {
                return Some((set.rule.direction)(View {
                    set: *set,
                    index,
                    start,
                }));
            }
            index -= set.views;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn views(sets: &[&str], fit: f64) -> Views {
        let sets = sets.iter().map(|text| text.parse().expect("a set"));
        Views {
            sets: sets.collect(),
            fit,
        }
    }

    fn directions(sets: &[&str], start: DVec3) -> Vec<DVec3> {
        let views = views(sets, 1.0);
        let frames = views.frames();
        frames
            .map(|frame| views.direction(frame, start).expect("a frame"))
            .collect()
    }

    #[test]
    fn sets_follow_each_other_and_all_directions_are_unit_vectors() {
        let all = directions(&["orbit:5@30", "hemisphere:40", "sphere:41", "cube"], DVec3::X);
        assert_eq!(all.len(), 5 + 40 + 41 + 6);
        assert!(all.iter().all(|d| (d.length() - 1.0).abs() < 1e-15));
        assert!(all[..5].iter().all(|d| (d.y - 0.5).abs() < 1e-15));
        assert!(all[5..45].iter().all(|d| d.y > 0.0));
        let axes = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
        assert_eq!(all[86..], axes);
        // As the turntable: counterclockwise as seen from above, from the start.
        let quarters = directions(&["orbit:4"], DVec3::X);
        assert_eq!(quarters, [DVec3::X, -DVec3::Z, -DVec3::X, DVec3::Z]);
        let views = views(&["cube"], 1.0);
        assert!(views.direction(0, DVec3::X).is_none() && views.direction(7, DVec3::X).is_none());
    }

    /// The best that any N points can do is a largest hole of about 2.2 / sqrt(N) (Fejes Toth).
    #[test]
    fn the_lattice_leaves_no_large_hole_and_no_two_views_are_close() {
        let probes = directions(&["sphere:20011"], DVec3::X);
        for n in [10_u32, 33, 100, 377, 1000] {
            let points = directions(&[&format!("sphere:{n}")], DVec3::X);
            let nearest = |p: &DVec3| points.iter().map(|q| p.distance(*q)).fold(9.0, f64::min);
            let hole = probes.iter().map(nearest).fold(0.0, f64::max) * f64::from(n).sqrt();
            assert!(hole < 3.0, "{n}: {hole}");
            let pairs = (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
            let gap = pairs.map(|(i, j)| points[i].distance(points[j])).fold(9.0, f64::min);
            assert!(gap * f64::from(n).sqrt() > 2.8, "{n}: {gap}");
            // The mean of an even distribution is its middle.
            let mean = points.iter().sum::<DVec3>() / f64::from(n);
            assert!(mean.length() * f64::from(n) < 2.0, "{n}: {mean}");
            let upper = directions(&[&format!("hemisphere:{n}")], DVec3::X);
            let height = upper.iter().map(|d| d.y).sum::<f64>() / f64::from(n);
            assert!((height - 0.5).abs() < 1e-12, "{n}: {height}");
        }
    }

    #[test]
    fn wrong_sets_are_refused() {
        for text in [
            "orbit",
            "orbit:0",
            "cube:6",
            "sphere:3@20",
            "ring:5",
            "orbit:5@90",
            "orbit:5@x",
            "",
            "orbit:x",
        ] {
            assert!(text.parse::<ViewSet>().is_err(), "{text}");
        }
        assert!("orbit:1000001".parse::<ViewSet>().is_err());
    }
}
