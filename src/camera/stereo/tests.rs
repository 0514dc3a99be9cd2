use glam::DVec3;
use proptest::prelude::*;

use super::{EyeLayout, Side, Stereo, StereoEye};
use crate::{
    camera::{Camera, Lens, LookAt, Pose, panorama::PanoramaLens, perspective::PerspectiveLens},
    math::Vec2,
};

const FILM: [u32; 2] = [400, 200];

fn mono(lens: Lens) -> Camera {
    let pose = Pose::look_at(DVec3::new(1.0, 2.0, 3.0), &LookAt::new(DVec3::new(1.0, 2.0, -4.0))).expect("a pose");
    Camera::new(&pose, &lens, FILM)
}

fn pair(lens: Lens, ipd: f64, convergence: Option<f64>) -> [Camera; 2] {
    [Side::Left, Side::Right].map(|side| {
        let stereo = Stereo {
            ipd,
            convergence,
            side: Some(side),
            layout: None,
        };
        mono(lens).of_eye(&stereo.eye().expect("an eye")).expect("a camera")
    })
}

#[test]
fn disparities_are_those_of_the_distance_and_0_at_the_convergence() {
    let lens = Lens::Perspective(PerspectiveLens::vertical(40.0));
    let focal = 100.0 / libm::tan(20.0_f64.to_radians());
    for convergence in [None, Some(2.5)] {
        let eyes = pair(lens, 0.063, convergence);
        for depth in [0.5, 2.5, 30.0] {
            let p = DVec3::new(1.1, 1.9, 3.0 - depth);
            let [left, right] = eyes.map(|camera| camera.project(p).expect("it is seen"));
            let expected = focal * 0.063 * (1.0 / depth - convergence.map_or(0.0, f64::recip));
            assert!((left.x - right.x - expected).abs() < 1e-9, "{left} {right}");
            assert!((left.y - right.y).abs() < 1e-9 && (left.z - depth).abs() < 1e-9);
        }
    }
}

#[test]
fn eyes_that_a_lens_does_not_have_are_refused() {
    let eye = |convergence| StereoEye {
        offset: 0.03,
        convergence,
    };
    let panorama = mono(Lens::Panorama(PanoramaLens));
    assert!(panorama.of_eye(&eye(Some(1.0))).is_err());
    assert!(panorama.of_eye(&eye(None)).is_ok());
}

#[test]
fn a_stereo_is_read_as_it_is_written() {
    let of = |text: &str| text.parse::<Stereo>();
    let both = Stereo {
        ipd: 0.063,
        convergence: None,
        side: None,
        layout: None,
    };
    assert_eq!(of("ipd=0.063"), Ok(both));
    assert_eq!(both.pictures(), [Some(Side::Left), Some(Side::Right)]);
    let one = Stereo {
        convergence: Some(2.0),
        side: Some(Side::Right),
        ..both
    };
    assert_eq!(of("ipd=0.063, convergence=2,eye=right"), Ok(one));
    assert_eq!((one.pictures(), one.second()), (vec![Some(Side::Right)], None));
    let joined = Stereo {
        layout: Some(EyeLayout::TopBottom),
        ..both
    };
    assert_eq!(of("ipd=0.063,layout=top-bottom"), Ok(joined));
    assert_eq!(joined.pictures(), [None]);
    let eyes = [joined.eye(), joined.second().map(|second| second.eye)];
    assert_eq!(eyes.map(|eye| eye.map(|eye| eye.offset)), [Some(-0.0315), Some(0.0315)]);
    for wrong in [
        "",
        "ipd",
        "ipd=0",
        "ipd=nan",
        "convergence=1",
        "ipd=1,eye=both",
        "ipd=1,baseline=2",
        "ipd=1,layout=beside",
        "ipd=1,eye=left,layout=side-by-side",
    ] {
        assert!(of(wrong).is_err(), "{wrong}");
    }
    for (key, example) in [("ipd", "ipd=0.063"), ("convergence", "convergence=2")] {
        let message = of(&format!("{key}=0")).expect_err("no distance");
        assert!(message.ends_with(&format!("such as {example}")), "{message}");
    }
}

proptest! {
    #[test]
    fn rays_of_omnidirectional_stereo_touch_the_circle_of_the_eyes_and_project_back(
        x in 0.0_f32..400.0,
        y in 1.0_f32..199.0,
        distance in 0.5_f64..50.0,
    ) {
        for (camera, side) in pair(Lens::Panorama(PanoramaLens), 0.064, None).into_iter().zip([-1.0, 1.0]) {
            let ray = camera.ray(Vec2::new(x, y), Vec2::splat(0.5)).expect("a ray");
            let (o, d) = (ray.o.as_dvec3() - DVec3::new(1.0, 2.0, 3.0), ray.d.as_dvec3());
            // The origin is beside the direction, to the right of it for the right eye.
            prop_assert!((o.length() - 0.032).abs() < 1e-6 && o.y.abs() < 1e-6);
            let level = d.with_y(0.0).normalize();
            prop_assert!((o.dot(level.cross(DVec3::Y)) - side * 0.032).abs() < 1e-5);
            let film = camera.project(ray.o.as_dvec3() + d * distance).expect("it is seen");
            let off = (film.x - f64::from(x)).abs();
            prop_assert!(off.min(400.0 - off) < 0.01 && (film.y - f64::from(y)).abs() < 0.01, "{film} is not {x} {y}");
            prop_assert!((film.z - distance).abs() < 1e-4);
        }
    }
}

#[test]
fn a_text_of_stereo_is_read_as_it_was() {
    for text in [
        "ipd=0.063",
        "ipd=0.1,convergence=2.5",
        "ipd=1,convergence=3,eye=left",
        "ipd=2,eye=right",
    ] {
        let stereo: Stereo = text.parse().expect("stereo");
        assert_eq!(stereo.to_string(), text);
    }
}
