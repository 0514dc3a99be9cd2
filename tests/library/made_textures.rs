//! Textures and mixtures of scene files: names, nesting and displacements.

use std::fmt::Write;

use batch_render::{
    batch::{Job, Request},
    describe::{self, Source},
    film::Film,
    render::Control,
};

/// The depths and colours of a small picture of a displaced square, whose height is this value.
fn displaced(height: &str, textures: &str) -> Film {
    let folder = tempfile::tempdir().expect("a folder");
    let square = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    std::fs::write(folder.path().join("square.obj"), square).expect("a file");
    let scene = format!(
        "{textures}
        [[object]]
        shape.mesh = {{ file = 'square.obj', subdivide = 3, subdivision = 'linear', displacement = {{ height = {height}, scale = 0.5 }} }}"
    );
    let job = open(folder.path(), &scene).expect("a scene");
    let scene = job.compile().expect("a scene");
    job.render_frame(&mut job.scenes(scene), 0, &Control::default())
        .expect("a film")
}

fn open(folder: &std::path::Path, scene: &str) -> Result<Job, String> {
    let text = format!(
        "[render]
        width = 16
        height = 16
        samples = 2
        [output]
        aovs = ['depth']
        [camera]
        perspective = {{ eye = [0.5, 1, 4], target = [0, 0, 0], fov = 40 }}
        [background]
        color = 0.5
        {scene}"
    );
    let source = Source::new(folder.join("scene.toml"), text);
    let desc = describe::parse(source).map_err(|e| e.to_string())?;
    Job::new(desc, &Request::default()).map_err(|e| e.to_string())
}

fn depths(film: &Film) -> Vec<f32> {
    film.plane("depth").expect("a plane").values.clone()
}

#[test]
fn a_displacement_has_the_factor_and_the_warp_of_its_texture() {
    let number = displaced("0.25", "");
    let factor = "[texture.a]\nconstant = { color = 0.5 }\nfactor = 0.5\n";
    assert_eq!(depths(&number), depths(&displaced("'texture.a'", factor)));
    let slope = "[texture.a]\ngradient = { along = 'linear' }\n";
    let moved = "transform = { offset = [0.5, 0] }";
    // A channel of 0.75 moves s by the amount.
    let warped = "warp = { by = 0.75, amount = 1 }";
    let [plain, moved, warped] = ["", moved, warped].map(|key| displaced("'texture.a'", &format!("{slope}{key}\n")));
    assert_ne!(depths(&plain), depths(&moved));
    assert_eq!(depths(&moved), depths(&warped));
}

/// What is said of a chain of so many textures, each made of the next or, if they are `reversed`, of the one before it.
fn chain(count: usize, is_reversed: bool) -> Result<(), String> {
    let mut text = String::new();
    for i in 0..count {
        let source = if is_reversed { i.checked_sub(1) } else { Some(i + 1) };
        let source = source.filter(|i| *i < count);
        let source = source.map_or_else(|| "0.2".to_owned(), |i| format!("'texture.t{i}'"));
        writeln!(text, "[texture.t{i}]\ninvert = {{ input = {source} }}").expect("a text");
    }
    let end = if is_reversed { count - 1 } else { 0 };
    write!(text, "[material.m]\nmatte = {{ albedo = 'texture.t{end}' }}\n").expect("a text");
    let folder = tempfile::tempdir().expect("a folder");
    let job = open(folder.path(), &text)?;
    job.compile().map(drop).map_err(|e| e.to_string())
}

#[test]
fn a_long_chain_of_textures_is_refused_and_a_short_one_is_not() {
    for is_reversed in [false, true] {
        assert_eq!(chain(64, is_reversed), Ok(()));
        for count in [65, 100_000] {
            let message = chain(count, is_reversed).expect_err("a fault");
            assert!(
                message.contains("more than 64 textures, each made of the next"),
                "{message}"
            );
        }
    }
}

/// A chain of so many materials, each the mixture of the next with itself, and a ball of the first.
fn mixtures(count: usize) -> String {
    let mut text = String::new();
    for i in 1..count {
        writeln!(text, "[material.m{i}]\nmix = {{ a = 'm{0}', b = 'm{0}' }}", i + 1).expect("a text");
    }
    text + &format!(
        "[material.m{count}]\nmatte = {{ albedo = [0.7, 0.4, 0.2] }}\n[[object]]\nmaterial = 'm1'\nshape.sphere = {{ radius = 1 }}\n"
    )
}

#[test]
fn mixtures_of_mixtures_have_a_limit_and_cost_no_more_than_their_number() {
    let picture = |count: usize| {
        let job = open(std::path::Path::new("."), &mixtures(count))?;
        let scene = job.compile().map_err(|e| e.to_string())?;
        let film = job.render_frame(&mut job.scenes(scene), 0, &Control::default());
        Ok(film.expect("a film").beauty().to_vec())
    };
    let plain = picture(1).expect("a picture");
    assert!(plain.iter().any(|pixel| pixel[0] != pixel[2]));
    assert_eq!(picture(64), Ok(plain));
    for count in [65, 20_000] {
        let message: String = picture(count).expect_err("a fault");
        assert!(
            message.contains("more than 64 materials, each made of the next"),
            "{message}"
        );
    }
}
