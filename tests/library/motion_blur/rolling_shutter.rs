//! Rolling shutters: each line of a picture is that of its own time.

use super::{ROOM, SIDE, SQUARE, Stage, passes};
use batch_render::{
    camera::{FrameCamera, Neighbours, PictureCamera, Readout, ReadoutDirection, Shutter, Timing},
    film::Film,
    math::{DVec3, Transform},
    render::{Content, RenderError},
    scene::ObjectId,
};

fn rolling(direction: ReadoutDirection) -> Timing {
    Timing {
        shutter: Shutter { open: 0.0, close: 0.0 },
        readout: Readout { time: 1.0, direction },
    }
}

fn pixel(film: &Film, [x, y]: [u32; 2]) -> [u32; 4] {
    film.beauty()[(y * SIDE + x) as usize].map(f32::to_bits)
}

#[test]
fn a_line_of_a_moving_camera_is_that_of_a_picture_at_its_time() {
    let still = |_: f64| vec![];
    for direction in [ReadoutDirection::TopToBottom, ReadoutDirection::RightToLeft] {
        let mut stage = Stage::new(ROOM, 2, &still);
        stage.is_still = true;
        let camera = stage.camera.camera(0.0);
        let carried = |u: f64| Ok::<_, RenderError>(camera.moved(DVec3::new(0.7 * u, 0.2 * u, 0.0)));
        let moving = PictureCamera::moving(carried).expect("a camera");
        stage.camera = FrameCamera::from(moving.clone()).with_timing(rolling(direction));
        let film = stage.render();
        for line in [0, 13, 40, SIDE - 1] {
            let time = (f64::from(line) + 0.5) / f64::from(SIDE);
            stage.camera = FrameCamera::from(moving.at(time));
            let whole = stage.render();
            for along in 0..SIDE {
                let at = match direction {
                    ReadoutDirection::TopToBottom => [along, line],
                    _ => [SIDE - 1 - line, along],
                };
                assert_eq!(pixel(&film, at), pixel(&whole, at), "{direction:?} {at:?}");
            }
        }
    }
}

#[test]
fn an_edge_that_moves_sideways_slants() {
    // A square from 0 to 1 m on both axes that moves to the left by 1.5 m a frame.
    let motion = |t: f64| {
        let place = Transform::from_parts(DVec3::new(-1.5 * t, 0.0, 0.0), DVec3::ZERO, DVec3::ONE);
        vec![(ObjectId(0), place.expect("a transform"))]
    };
    let mut stage = Stage::new(SQUARE, 16, &motion);
    stage.camera = stage.camera.with_timing(rolling(ReadoutDirection::TopToBottom));
    let film = stage.render();
    let side = f64::from(SIDE);
    for y in 17..31 {
        let read = (f64::from(y) + 0.5) / side;
        // 16 pixels are a metre, and the square is 16 pixels wide.
        let left = 0.5 * side - 16.0 * 1.5 * read;
        let row = film.beauty()[(y * SIDE) as usize..][..SIDE as usize].iter();
        let covered: f64 = row.clone().map(|pixel| f64::from(pixel[3])).sum();
        let center: f64 = (0..)
            .zip(row)
            .map(|(x, pixel)| (f64::from(x) + 0.5) * f64::from(pixel[3]))
            .sum();
        assert!((covered - 16.0).abs() < 0.3, "{y}: {covered}");
        assert!(
            (center / covered - left - 8.0).abs() < 0.1,
            "{y}: {} is not {}",
            center / covered,
            left + 8.0
        );
    }
}

#[test]
fn motion_vectors_lead_to_the_line_that_sees_the_point_in_the_next_frame() {
    let still = |_: f64| vec![];
    let mut stage = Stage::new(ROOM, 1, &still);
    stage.is_still = true;
    stage.settings.passes = passes("forward backward P");
    // Through the centres of the pixels.
    stage.settings.content = Content::FirstHits;
    let camera = stage.camera.camera(0.0);
    let at = |t: f64| camera.moved(DVec3::new(0.5 * t, 0.1 * t * t, -0.3 * t));
    let of = |frame: f64| PictureCamera::moving(|u| Ok::<_, RenderError>(at(frame + u))).expect("a camera");
    let timing = rolling(ReadoutDirection::TopToBottom);
    let films = [0.0, 1.0].map(|frame| {
        let neighbours = Neighbours {
            previous: Some(of(frame - 1.0)),
            next: Some(of(frame + 1.0)),
        };
        stage.camera = FrameCamera::from(of(frame))
            .with_timing(timing)
            .with_neighbours(neighbours);
        stage.render()
    });
    let value = |film: &Film, name: &str, [x, y]: [usize; 2]| {
        let at = 3 * (y * SIDE as usize + x);
        let values = &film.plane(name).expect("a plane").values[at..at + 3];
        DVec3::new(f64::from(values[0]), f64::from(values[1]), f64::from(values[2]))
    };
    let mut seen = 0;
    for (x, y) in (40..SIDE as usize).flat_map(|y| (0..SIDE as usize).map(move |x| (x, y))) {
        let (p, motion) = (value(&films[0], "P", [x, y]), value(&films[0], "forward", [x, y]));
        // The floor, where points between pixels lie between theirs.
        let [tx, ty] = [x as f64 + motion.x, y as f64 - motion.y];
        if p.y.abs() > 1e-4 || !(1.0..62.0).contains(&tx) || !(41.0..62.0).contains(&ty) {
            continue;
        }
        let (left, top) = (tx as usize, ty as usize);
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| value(&films[1], "P", [left + i, top + j]));
        if corners.iter().any(|corner| corner.y.abs() > 1e-4) {
            continue;
        }
        let (u, v) = (tx.fract(), ty.fract());
        let found = corners[0].lerp(corners[1], u).lerp(corners[2].lerp(corners[3], u), v);
        assert!(found.distance(p) < 0.01, "{x} {y}: {found} is not {p}");
        let back = value(&films[1], "backward", [left, top]);
        assert!((back - motion).truncate().length() < 0.5, "{x} {y}: {back} {motion}");
        seen += 1;
    }
    assert!(seen > 500, "{seen}");
}
