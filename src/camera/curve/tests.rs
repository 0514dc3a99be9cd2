use super::*;
use crate::math::track::{Interp, Track};

#[test]
fn a_zoom_is_the_same_in_angles_and_in_focal_lengths() {
    let angle = |mm: f64| 2.0 * libm::atan(12.0 / mm).to_degrees();
    let track = |keys: [(f64, FieldOfView); 2]| Track::new(keys.map(|(time, view)| (time, Some(view), Interp::Smooth)));
    let at = |track: &Track<FieldOfView>, time| track.at(time).expect("a key");
    let mm = track([
        (0.0, FieldOfView::FocalLength(20.0)),
        (10.0, FieldOfView::FocalLength(100.0)),
    ]);
    let degrees = track([
        (0.0, FieldOfView::Vertical(angle(20.0))),
        (10.0, FieldOfView::Vertical(angle(100.0))),
    ]);
    let FieldOfView::FocalLength(f) = at(&mm, 5.0) else {
        panic!("a focal length")
    };
    let FieldOfView::Vertical(v) = at(&degrees, 5.0) else {
        panic!("an angle")
    };
    assert_eq!(f, 60.0);
    assert!((v - angle(60.0)).abs() < 1e-12);
    assert_eq!(at(&degrees, 10.0), FieldOfView::Vertical(angle(100.0)));
}
