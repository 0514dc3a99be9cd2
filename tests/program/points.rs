//! Clouds of points are spheres.

use crate::common::{Folder, pixels};

/// Three points in display colours.
const CLOUD: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                     property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n\
                     -0.5 0 0 255 0 0\n0 0.25 0.125 0 255 0\n0.5 0 -0.25 255 255 255\n";

const HEAD: &str = "[render]\nwidth = 64\nheight = 48\nsamples = 16\nintegrator.path = { max_depth = 4 }\n\
                    [background]\ncolor = 0.5\n[camera]\nperspective = { eye = [0, 0.5, 3], target = [0, 0, 0], fov = 40 }\n\
                    [[light]]\nsun = { direction = [-1, -2, -1], irradiance = 2 }\n";

/// The points as objects of their own.
fn spheres(transform: &str) -> String {
    let sphere = |(place, color): (&str, &str)| {
        format!(
            "[[object]]\nmaterial = \"{color}\"\nshape.sphere = {{ center = {place}, radius = 0.25 }}\n{transform}\
             [material.{color}]\nmatte = {{ albedo = {} }}\n",
            match color {
                "red" => "[1, 0, 0]",
                "green" => "[0, 1, 0]",
                _ => "1",
            }
        )
    };
    [
        ("[-0.5, 0, 0]", "red"),
        ("[0, 0.25, 0.125]", "green"),
        ("[0.5, 0, -0.25]", "white"),
    ]
    .map(sphere)
    .concat()
}

fn cloud(transform: &str) -> String {
    format!("[[object]]\nshape.mesh = {{ file = \"cloud.ply\", radius = 0.25 }}\n{transform}")
}

#[test]
fn a_cloud_looks_like_a_sphere_for_each_of_its_points() {
    for transform in [
        "",
        "transform = { translate = [0.1, 0, 0], rotate = [0, 40, 0], scale = 1.25 }\n",
        "transform = { rotate = [10, 20, 30], scale = [1, 0.5, 1] }\n",
    ] {
        let folder = Folder::new();
        folder.write("cloud.ply", CLOUD);
        let expected = folder.render(&format!("{HEAD}{}", spheres(transform)));
        let found = folder.render(&format!("{HEAD}{}", cloud(transform)));
        let differ = expected.iter().zip(&found).filter(|(a, b)| {
            let channels = a.iter().zip(b.iter());
            channels.fold(0.0, |most: f32, (a, b)| most.max((a - b).abs())) > 1e-3
        });
        // Baked spheres round otherwise than those under a transform: a sample on an edge may fall to either side.
        let count = differ.count();
        assert!(count <= 6, "{transform}: {count} pixels differ");
        let greens = found.iter().filter(|p| p[1] > 2.0 * p[0]).count();
        assert!(greens > 30, "{transform}: {greens}");
    }
}

#[test]
fn a_cloud_is_a_scene_whose_points_have_the_radius_of_the_command_line() {
    let folder = Folder::new();
    folder.write("cloud.ply", CLOUD);
    let covered = |radius: &[&str], name: &str| {
        let args = [
            "cloud.ply",
            "--samples",
            "4",
            "--resolution",
            "160x90",
            "--progress",
            "none",
            "-o",
            name,
        ];
        folder.succeed(&[&args[..], radius].concat());
        let (_, picture) = pixels(&folder.path(name));
        let background = picture[0];
        picture.iter().filter(|p| **p != background).count()
    };
    let (small, large) = (
        covered(&["--point-radius", "0.05"], "a.exr"),
        covered(&["--point-radius", "0.2"], "b.exr"),
    );
    assert!(small > 10 && large > 4 * small, "{small} and {large} pixels");
}

#[test]
fn a_radius_without_points_is_told() {
    let folder = Folder::new();
    folder.write("cloud.ply", CLOUD);
    folder.write("s.toml", &format!("{HEAD}{}", cloud("")));
    let text = folder.fail(2, &["s.toml", "--point-radius", "1"]);
    assert!(text.contains("--point-radius") && text.contains("`radius`"), "{text}");
    assert!(
        folder
            .fail(2, &["cloud.ply", "--point-radius", "0"])
            .contains("above 0")
    );

    folder.write("face.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write(
        "t.toml",
        &format!("{HEAD}[[object]]\nshape.mesh = {{ file = \"face.obj\", radius = 1 }}\n"),
    );
    let output = folder.run(&["check", "t.toml"]);
    assert!(crate::common::stderr(&output).contains("the radius of points is not used"));
}
