//! Textures and the colours of vertices.

use std::path::Path;

use libtest_mimic::Failed;

use super::{
    BLUE, GREEN, RED, SAME, must,
    view::{View, difference, is_hue},
};

pub fn texture_coordinates(assets: &Path) -> Result<(), Failed> {
    let model = "TextureCoordinateTest/glTF/TextureCoordinateTest.gltf";
    let picture = View::front(model, [0.0, 0.0], [2.6, 2.6]).render(assets);
    let quads = [
        ("top left", [-0.7, 0.7], [1.0, 1.0, 0.0]),
        ("top right", [0.7, 0.7], [1.0, 0.1, 0.0]),
        ("bottom left", [-0.7, -0.7], [0.0, 0.2, 1.0]),
        ("bottom right", [0.7, -0.7], GREEN),
    ];
    for (what, center, hue) in quads {
        // The corner that is farthest from the middle of the picture has a pattern.
        let at = |k: f64| center.map(|c: f64| c + k * c.signum());
        let plain = picture.mean(at(-0.3), [0.05, 0.05]);
        must(is_hue(plain, hue, 0.25), format!("{what} is {plain:?}"))?;
        let dark = |p: [f32; 3]| p.into_iter().fold(0.0, f32::max) < 0.3;
        let pattern = picture.share(at(0.42), [0.06, 0.06], dark);
        must(
            (0.2..0.8).contains(&pattern),
            format!("{what} has {pattern} of a pattern"),
        )?;
    }
    Ok(())
}

pub fn texture_encoding(assets: &Path) -> Result<(), Failed> {
    let model = "TextureEncodingTest/glTF/TextureEncodingTest.gltf";
    let picture = View::front(model, [1.5, -0.5], [12.5, 12.5]).render(assets);
    for (row, what) in [(2.0, "base colour"), (-1.0, "emission"), (-4.0, "metal and roughness")] {
        for column in [0.25, 3.25, 6.25] {
            let off = picture.difference([column, row], [-2.75, row], [0.5, 0.5]);
            must(
                off < SAME,
                format!("{what} at {column} differs by {off} from the real factors"),
            )?;
        }
    }
    Ok(())
}

pub fn linear_interpolation(assets: &Path) -> Result<(), Failed> {
    let model = "TextureLinearInterpolationTest/glTF/TextureLinearInterpolationTest.gltf";
    let picture = View::front(model, [0.0, -1.0], [5.4, 2.4]).render(assets);
    let off = picture.difference([1.5, -1.0], [-1.5, -1.0], [0.5, 0.5]);
    must(off < SAME, format!("the texture differs by {off} from the factors"))
}

pub fn texture_settings(assets: &Path) -> Result<(), Failed> {
    let model = "TextureSettingsTest/glTF/TextureSettingsTest.gltf";
    let picture = View::front(model, [0.0, -0.6], [10.5, 10.5]).render(assets);
    // The first row, of surfaces with one side, shows a cross: a path tracer's surfaces are seen from both sides.
    let rows = [
        (1.52, "double-sided"),
        (0.467, "clamp s"),
        (-0.57, "clamp t"),
        (-1.604, "repeat s"),
        (-2.641, "repeat t"),
        (-3.678, "mirror s"),
        (-4.715, "mirror t"),
    ];
    for (row, what) in rows {
        let off = picture.difference([0.455, row], [2.601, row], [0.38, 0.38]);
        must(off < SAME, format!("{what}: the test differs from the sample by {off}"))?;
        let [green, red] = [GREEN, RED].map(|hue| picture.share([0.455, row], [0.38; 2], |p| is_hue(p, hue, 0.4)));
        must(green > 0.08 && red < 0.01, format!("{what}: {green} green, {red} red"))?;
    }
    Ok(())
}

pub fn texture_transform(assets: &Path) -> Result<(), Failed> {
    let model = "TextureTransformTest/glTF/TextureTransformTest.gltf";
    let picture = View::front(model, [0.0, -0.05], [3.6, 2.4]).render(assets);
    for (x, hue, what) in [(-1.1, GREEN, "u"), (0.0, BLUE, "v"), (1.1, [0.0, 1.0, 1.0], "u and v")] {
        let share = |test: &dyn Fn([f32; 3]) -> bool| picture.share([x, 0.55], [0.4, 0.4], test);
        let (ground, tick) = (
            share(&|p| is_hue(p, hue, 0.3)),
            share(&|p| p.into_iter().fold(1.0, f32::min) > 0.7),
        );
        must(
            ground > 0.6 && tick > 0.05,
            format!("offset {what}: {ground} ground, {tick} tick"),
        )?;
    }
    let dark = |at: [f64; 2], half: f64| picture.share(at, [half; 2], |p| p.into_iter().fold(0.0, f32::max) < 0.25);
    let arrows = [
        ("rotation", [-1.179, -1.066], [-0.056, 0.15], Some([-0.822, -0.828])),
        ("scale", [0.019, -0.569], [-0.07, 0.075], Some([0.278, -0.828])),
        ("all", [1.03, -0.8], [-0.035, 0.095], None),
    ];
    for (what, right, to_tip, wrong) in arrows {
        let tip = dark([right[0] + to_tip[0], right[1] + to_tip[1]], 0.03);
        must(
            tip > 0.15,
            format!("{what}: {tip} of the arrow's tip is at the right mark"),
        )?;
        if let Some(wrong) = wrong {
            let there = dark(wrong, 0.13);
            must(
                there < 0.02,
                format!("{what}: {there} of an arrow is at the wrong mark"),
            )?;
        }
    }
    Ok(())
}

pub fn multi_uv(assets: &Path) -> Result<(), Failed> {
    let model = "MultiUVTest/glTF/MultiUVTest.gltf";
    let picture = View::front(model, [0.0, 0.0], [2.2, 2.2]).render(assets);
    // One set lays a plain part of the first texture over a face; the other set, all of the second, with letters.
    let plain = picture.mean([0.8, 0.8], [0.1, 0.1]);
    must(is_hue(plain, [1.0, 0.85, 0.2], 0.2), format!("the face is {plain:?}"))?;
    for corner in [[-0.8, 0.8], [-0.8, -0.8], [0.8, -0.8]] {
        let other = picture.mean(corner, [0.1, 0.1]);
        must(
            difference(&[other], &[plain]) < SAME,
            format!("{corner:?} is {other:?}, not {plain:?}"),
        )?;
    }
    let letters = picture.share([0.0, 0.0], [0.6, 0.35], |p| difference(&[p], &[plain]) > 0.07);
    must((0.15..0.7).contains(&letters), format!("letters cover {letters}"))
}

pub fn vertex_colors(assets: &Path) -> Result<(), Failed> {
    let model = "VertexColorTest/glTF/VertexColorTest.gltf";
    let picture = View::front(model, [0.0, 0.0], [2.2, 2.2]).render(assets);
    for (x, hue) in [(-0.551, RED), (-0.003, GREEN), (0.591, BLUE)] {
        let off = picture.difference([x, 0.338], [x, -0.527], [0.19, 0.19]);
        must(
            off < SAME,
            format!("{hue:?}: the test differs from the sample by {off}"),
        )?;
        let tick = picture.share([x, 0.338], [0.19, 0.19], |p| is_hue(p, hue, 0.3));
        must(tick > 0.1, format!("{hue:?}: {tick} of a tick"))?;
    }
    Ok(())
}
