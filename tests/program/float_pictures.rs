//! EXR files as textures: their colours, their data, and the working space.

use crate::common::{Folder, pixels, stderr};

/// A wall that is seen face on and emits a colour or a texture.
fn wall(space: &str, texture: &str, radiance: &str) -> String {
    format!(
        "[render]\nwidth = 4\nheight = 4\nsamples = 1\nworking_space = '{space}'\n\
         [camera]\northographic = {{ eye = [0, 0, 4], target = [0, 0, 0], height = 2 }}\n\
         {texture}[material.m]\nemitter = {{ radiance = {radiance} }}\n[[object]]\nmaterial = 'm'\n\
         shape.quad = {{ corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]] }}\n"
    )
}

fn image(file: &str, rest: &str) -> String {
    format!("[texture.t]\nimage = {{ file = '{file}'{rest} }}\n")
}

fn render(folder: &Folder, scene: &str, picture: &str) -> [f32; 3] {
    folder.write("s.toml", scene);
    folder.succeed(&["s.toml", "--progress", "none", "--exr-type", "float", "-o", picture]);
    pixels(&folder.path(picture)).1[5]
}

fn close(found: [f32; 3], expected: [f32; 3]) {
    let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(near, "{found:?} instead of {expected:?}");
}

#[test]
fn our_own_files_read_back_as_the_colours_that_they_hold() {
    let folder = Folder::new();
    let color = [0.9, 0.2, 0.4];
    let aces = render(&folder, &wall("acescg", "", "[0.9, 0.2, 0.4]"), "aces.exr");
    assert!((aces[0] - 0.9).abs() > 0.1);
    let again = wall("acescg", &image("aces.exr", ""), "'texture.t'");
    assert_eq!(render(&folder, &again, "a.exr"), aces);
    close(
        render(&folder, &wall("rec709", &image("aces.exr", ""), "'texture.t'"), "b.exr"),
        color,
    );
    // Data and light that is taken as it is.
    let raw = wall("rec709", &image("aces.exr", ", color_space = 'raw'"), "'texture.t'");
    assert_eq!(render(&folder, &raw, "c.exr"), aces);
    let sky = |space: &str| {
        format!(
            "[render]\nwidth = 4\nheight = 4\nsamples = 1\nworking_space = '{space}'\n\
             [camera]\nperspective = {{ eye = [0, 0, 0], target = [0, 0, -1] }}\n\
             [background]\nenvironment = {{ file = 'aces.exr' }}\n"
        )
    };
    close(render(&folder, &sky("rec709"), "d.exr"), color);
    assert_eq!(render(&folder, &sky("acescg"), "e.exr"), aces);
}

#[test]
fn data_in_float_pictures_are_no_colours() {
    let folder = Folder::new();
    // A normal of (0.6, 0, 0.8), and parts of it as roughness.
    render(&folder, &wall("rec709", "", "[0.8, 0.5, 0.9]"), "n.exr");
    let lit = |rest: &str| {
        format!(
            "[render]\nwidth = 4\nheight = 4\nsamples = 1\nworking_space = 'acescg'\n\
             [camera]\northographic = {{ eye = [0, 0, 4], target = [0, 0, 0], height = 2 }}\n{}\
             [material.m]\nprincipled = {{ base_color = 0.8, normal = 'texture.t', roughness = 'texture.t' }}\n\
             [[object]]\nmaterial = 'm'\nshape.quad = {{ corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]] }}\n\
             [[light]]\nsun = {{ direction = [-0.6, 0, -0.8], irradiance = 3 }}\n",
            image("n.exr", rest)
        )
    };
    let color = render(&folder, &lit(""), "a.exr");
    assert_eq!(color, render(&folder, &lit(", color_space = 'raw'"), "b.exr"));
    assert!(color[0] > 0.5, "{color:?}");
}

#[test]
fn numbers_below_0_are_no_light() {
    let folder = Folder::new();
    let channels = exr::prelude::SpecificChannels::rgb(|_| (-0.5f32, 0.25f32, 0.5f32));
    use exr::prelude::WritableImage;
    let picture = exr::prelude::Image::from_channels((2, 2), channels);
    picture.write().to_file(folder.path("neg.exr")).expect("written");
    folder.write("s.toml", &wall("rec709", &image("neg.exr", ""), "'texture.t'"));
    let output = folder.run(&["s.toml", "--progress", "none", "-o", "a.exr"]);
    assert!(output.status.success());
    assert!(stderr(&output).contains("4 numbers below 0 became 0, where they are colours"));
    close(pixels(&folder.path("a.exr")).1[5], [0.0, 0.25, 0.5]);
}
