//! A room without openings is black, however bright the world around it is.

use crate::common::Folder;

/// The walls of a room in a bright world.
const ROOM: &str = "[background]\ncolor = [1000, 1000, 1000]\n[material.m]\nmatte = { albedo = 0.9 }\n\
    [material.g]\nglass = { ior = 1.5 }\n[material.k]\nmirror = { reflectance = 1 }\n\
    [[object]]\nmaterial = 'm'\nshape.quad = { corners = [[-1,0,1],[1,0,1],[1,0,-1],[-1,0,-1]] }\n\
    [[object]]\nmaterial = 'm'\nshape.quad = { corners = [[-1,2,1],[1,2,1],[1,2,-1],[-1,2,-1]] }\n\
    [[object]]\nmaterial = 'm'\nshape.quad = { corners = [[-1,0,-1],[1,0,-1],[1,2,-1],[-1,2,-1]] }\n\
    [[object]]\nmaterial = 'm'\nshape.quad = { corners = [[-1,0,1],[1,0,1],[1,2,1],[-1,2,1]] }\n\
    [[object]]\nmaterial = 'm'\nshape.quad = { corners = [[-1,0,-1],[-1,0,1],[-1,2,1],[-1,2,-1]] }\n\
    [[object]]\nmaterial = 'm'\nshape.quad = { corners = [[1,0,-1],[1,0,1],[1,2,1],[1,2,-1]] }\n";

/// The light in the room with this ball, seen through a small window of `fov` degrees around the point where it touches a wall.
fn light(integrator: &str, ball: &str, eye: &str, target: &str, fov: f64) -> f32 {
    let pixels = Folder::new().render(&format!(
        "[render]\nwidth = 64\nheight = 64\nsamples = 4\nintegrator.{integrator} = {{ max_depth = 8 }}\n\
         [camera]\nperspective = {{ eye = {eye}, target = {target}, fov = {fov} }}\n{ROOM}[[object]]\n{ball}"
    ));
    pixels.iter().flatten().sum()
}

#[test]
fn a_ball_that_touches_a_wall_of_a_closed_room_leaks_no_light() {
    for integrator in ["path", "whitted"] {
        for (material, transform) in [
            ("g", "shape.sphere = { center = [0.5, 0.5, -0.3], radius = 0.5 }"),
            ("k", "shape.sphere = { center = [0.5, 0.5, -0.3], radius = 0.5 }"),
        ] {
            let ball = format!("material = '{material}'\n{transform}\n");
            // From within the ball, along its axis and from the side, and from outside, into the gap.
            for (eye, target) in [
                ("[0.5, 0.5, -0.3]", "[1, 0.5, -0.3]"),
                ("[0.6, 0.6, -0.6]", "[1, 0.5, -0.3]"),
                ("[0.5, 0.5, -0.3]", "[0.5, 0, -0.3]"),
                ("[0.999, 0.5, 0.5]", "[1, 0.5, -0.3]"),
            ] {
                let found = light(integrator, &ball, eye, target, 0.2);
                assert_eq!(found, 0.0, "{integrator} {ball} {eye}");
            }
        }
    }
}
