//! Motion vectors of objects that move.

use super::{SQUARE, Stage, passes, shutter};
use batch_render::{
    camera::{FrameCamera, Neighbours},
    math::{DVec3, Transform},
    scene::ObjectId,
};

#[test]
fn motion_vectors_of_what_moves_lead_to_its_places_in_the_neighbouring_frames() {
    // A turn, a shift and a change of size about the eye's axis; time 0 is this frame, as its shutter opens.
    let place = |t: f64| {
        let (shift, turn) = (DVec3::new(0.4 * t, 0.1 * t, -0.3 * t), DVec3::new(0.0, 0.0, 20.0 * t));
        Transform::from_parts(shift, turn, DVec3::splat(1.0 + 0.2 * t)).expect("a transform")
    };
    let motion = move |t: f64| vec![(ObjectId(0), place(t))];
    for exposure in [0.0, 1.0] {
        let mut stage = Stage::new(
            &SQUARE.replace(
                "orthographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 4 }",
                "perspective = { eye = [0, 0, 5], target = [0, 0, 0], fov = 40 }",
            ),
            4,
            &motion,
        );
        stage.settings.passes = passes("forward backward P");
        let camera = stage.camera.camera(0.0);
        let neighbours = Neighbours {
            previous: Some(camera.into()),
            next: Some(camera.into()),
        };
        stage.camera = FrameCamera::from(camera)
            .with_neighbours(neighbours)
            .with_timing(shutter(exposure));
        let film = stage.render();
        let plane = |name| &film.plane(name).expect("a plane").values;
        let mut seen = 0;
        for (i, pixel) in plane("P").chunks_exact(3).enumerate() {
            if film.beauty()[i][3] == 0.0 || pixel == [0.0; 3] {
                continue;
            }
            // The height says at which time the point was met.
            let p = DVec3::new(f64::from(pixel[0]), f64::from(pixel[1]), f64::from(pixel[2]));
            let time = p.z / -0.3;
            assert!((-1e-3..=exposure.max(1e-3)).contains(&time), "{time}");
            let local = place(time).widened().inverse().transform_point3(p);
            let at = |t: f64| {
                camera
                    .project(place(t).widened().transform_point3(local))
                    .expect("it is seen")
            };
            for (name, from, to) in [("forward", at(0.0), at(1.0)), ("backward", at(-1.0), at(0.0))] {
                let found = &plane(name)[3 * i..][..3];
                let expected = [to.x - from.x, from.y - to.y, to.z - from.z];
                let error = (0..3)
                    .map(|c| (f64::from(found[c]) - expected[c]).abs())
                    .fold(0.0, f64::max);
                assert!(error < 0.01, "{name}: {found:?} is not {expected:?}");
            }
            seen += 1;
        }
        assert!(seen > 100);
    }
}
