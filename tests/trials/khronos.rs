//! The test models of Khronos show what their authors say they show: each is a picture that is its own check.
//!
//! The models are in the folder `gltf/khronos` of the one that `BATCH_RENDER_ASSETS` names, each as its repository
//! has it; without a model its test is ignored. Places are in metres of the model, as its `README.md` and its nodes
//! give them.

mod textures;
mod view;

use std::path::Path;

use libtest_mimic::{Failed, Trial};
use view::{DARK, View, difference, is_hue, mean, saturation};

/// The difference of two pictures of the same thing by noise and by the places of pixels.
const SAME: f32 = 0.1;

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const GREEN: [f32; 3] = [0.0, 1.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

/// An environment with a horizon, which reflections show the right way up.
const SUNSET: &str = "env/venice_sunset_1k.hdr";

type Check = fn(&Path) -> Result<(), Failed>;

/// The trials: model, what is true of it, and its check.
const TRIALS: &[(&str, &str, Check)] = &[
    (
        "AlphaBlendModeTest/glTF-Binary/AlphaBlendModeTest.glb",
        "opacity cuts, blends or does nothing",
        alpha_modes,
    ),
    (
        "ClearCoatTest/glTF/ClearCoatTest.gltf",
        "what is coated is its base below its coat",
        clear_coats,
    ),
    (
        "EmissiveStrengthTest/glTF/EmissiveStrengthTest.gltf",
        "emission is multiplied by its strength",
        emissive_strength,
    ),
    (
        "MorphPrimitivesTest/glTF/MorphPrimitivesTest.gltf",
        "all primitives take the shape of the weights",
        morph_primitives,
    ),
    (
        "MultiUVTest/glTF/MultiUVTest.gltf",
        "each texture reads its own coordinates",
        textures::multi_uv,
    ),
    (
        "NegativeScaleTest/glTF/NegativeScaleTest.gltf",
        "a mirrored node looks like its mirror image",
        negative_scale,
    ),
    (
        "NormalTangentTest/glTF-Binary/NormalTangentTest.glb",
        "normal maps without tangents look like geometry",
        normal_tangents,
    ),
    (
        "NormalTangentMirrorTest/glTF-Binary/NormalTangentMirrorTest.glb",
        "normal maps with mirrored tangents look like geometry",
        mirrored_tangents,
    ),
    (
        "OrientationTest/glTF/OrientationTest.gltf",
        "every arrow points to its target",
        orientation,
    ),
    (
        "SpecularTest/glTF/SpecularTest.gltf",
        "specular textures equal specular factors",
        specular,
    ),
    (
        "TextureCoordinateTest/glTF/TextureCoordinateTest.gltf",
        "every corner of a texture is where it belongs",
        textures::texture_coordinates,
    ),
    (
        "TextureEncodingTest/glTF/TextureEncodingTest.gltf",
        "textures are decoded by what they hold, not by what their files say",
        textures::texture_encoding,
    ),
    (
        "TextureLinearInterpolationTest/glTF/TextureLinearInterpolationTest.gltf",
        "texels are interpolated as linear light",
        textures::linear_interpolation,
    ),
    (
        "TextureSettingsTest/glTF/TextureSettingsTest.gltf",
        "samplers repeat, clamp and mirror",
        textures::texture_settings,
    ),
    (
        "TextureTransformTest/glTF/TextureTransformTest.gltf",
        "textures are moved, turned and scaled",
        textures::texture_transform,
    ),
    (
        "UnlitTest/glTF/UnlitTest.gltf",
        "unlit colours are as they are given",
        unlit,
    ),
    (
        "VertexColorTest/glTF/VertexColorTest.gltf",
        "colours of vertices multiply textures",
        textures::vertex_colors,
    ),
];

pub fn trials() -> Vec<Trial> {
    let trial = |(model, truth, check): &(&str, &str, Check)| -> Trial {
        let name = model.split('/').next().unwrap_or_default();
        let file = format!("gltf/khronos/{model}");
        asset_trial!(format!("{name}: {truth}"), &[&file, SUNSET], *check)
    };
    TRIALS.iter().map(trial).collect()
}

fn must(holds: bool, otherwise: impl Into<String>) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(otherwise.into().into()) }
}

fn alpha_modes(assets: &Path) -> Result<(), Failed> {
    let model = "AlphaBlendModeTest/glTF-Binary/AlphaBlendModeTest.glb";
    let picture = View::front(model, [0.0, 0.95], [7.4, 2.1]).render(assets);
    // A scale from 0 at the top to 1 at the bottom stands beside each pane, which has coloured stripes.
    let height = |alpha: f64| 1.865 - 1.585 * alpha;
    let stripes = |pane: f64, alpha: f64| picture.share([pane, height(alpha)], [0.3, 0.015], |p| saturation(p) > 0.6);
    for (pane, cutoff) in [(0.13, 0.25), (1.63, 0.5), (3.13, 0.75)] {
        let (above, below) = (stripes(pane, cutoff - 0.03), stripes(pane, cutoff + 0.03));
        must(
            above < 0.1 && below > 0.7,
            format!("cutoff {cutoff}: {above} above, {below} below"),
        )?;
    }
    let (opaque, blend) = (-2.87, -1.37);
    for alpha in [0.05, 0.5, 0.95] {
        let share = stripes(opaque, alpha);
        must(
            share > 0.7,
            format!("the opaque pane has {share} of its stripes at {alpha}"),
        )?;
    }
    let strength = |alpha: f64| {
        let block = picture.block([blend, height(alpha)], [0.3, 0.015]);
        block.iter().map(|p| saturation(*p)).sum::<f32>() / block.len() as f32
    };
    let [weak, half, strong] = [0.1, 0.5, 0.9].map(strength);
    let rises = weak + 0.1 < half && half + 0.1 < strong;
    must(
        rises,
        format!("the stripes of the blended pane are {weak}, {half} and {strong} strong"),
    )?;
    for label in [-2.6, -1.1] {
        let marks = |hue| picture.share([label, 0.0], [0.12, 0.05], |p| is_hue(p, hue, 0.45));
        let (ticks, crosses) = (marks(GREEN), marks(RED));
        must(
            ticks > 0.04 && crosses < 0.01,
            format!("label at {label}: {ticks} green, {crosses} red"),
        )?;
    }
    Ok(())
}

fn clear_coats(assets: &Path) -> Result<(), Failed> {
    let model = "ClearCoatTest/glTF/ClearCoatTest.gltf";
    let sunset = format!(
        "environment = {{ file = {:?} }}",
        assets.join(SUNSET).display().to_string()
    );
    let view = View {
        background: &sunset,
        samples: 40,
        ..View::front(model, [0.0, 0.0], [6.4, 12.6])
    };
    let picture = view.render(assets);
    let half = [0.4, 0.4];
    // To the left the base alone, to the right a black body with the shine of the coat, which takes 4 % from the base.
    for (row, what) in [
        (5.25, "simple"),
        (1.05, "rough"),
        (-1.05, "normals of the base"),
        (-3.15, "shared normals"),
        (-5.25, "normals of the coat"),
    ] {
        let at = |column: f64| picture.blurred([column, row], half);
        let (base, coated, coat) = (at(-2.1), at(0.0), at(2.1));
        let sum: Vec<[f32; 3]> = base
            .iter()
            .zip(&coat)
            .map(|(base, coat)| [0, 1, 2].map(|k| 0.96 * base[k] + coat[k]))
            .collect();
        let (off, bare) = (difference(&coated, &sum), difference(&coated, &base));
        must(
            off < 0.25 && off < 0.75 * bare,
            format!("{what}: differs by {off} from base and coat, by {bare} from the base"),
        )?;
    }
    Ok(())
}

fn emissive_strength(assets: &Path) -> Result<(), Failed> {
    let model = "EmissiveStrengthTest/glTF/EmissiveStrengthTest.gltf";
    let view = View {
        background: DARK,
        ..View::front(model, [0.0, 0.0], [14.0, 8.0])
    };
    let picture = view.render(assets);
    for (k, strength) in [1.0, 2.0, 4.0, 8.0, 16.0].into_iter().enumerate() {
        let seen = picture.mean([3.0 * k as f64 - 6.0, 0.0], [0.3, 0.3]);
        let given = [0.1, 0.5, 0.9].map(|v| v * strength);
        // A black cube reflects a little of what its neighbours send to the walls.
        let is_right = (0..3).all(|k| (seen[k] / given[k] - 1.0).abs() < 0.05);
        must(is_right, format!("strength {strength}: {seen:?} instead of {given:?}"))?;
    }
    Ok(())
}

fn morph_primitives(assets: &Path) -> Result<(), Failed> {
    let model = "MorphPrimitivesTest/glTF/MorphPrimitivesTest.gltf";
    // The second primitive is at x > 0, z < 0: seen from behind it is to the left. Half of a target of 0.2 m is seen.
    let front = View::front(model, [0.0, 0.05], [1.2, 0.3]);
    let views = [
        (front, -0.2, RED),
        (
            View {
                back: [0.0, 0.0, -1.0],
                ..View::front(model, [0.0, 0.05], [1.2, 0.3])
            },
            -0.2,
            GREEN,
        ),
    ];
    for (view, x, hue) in views {
        let picture = view.render(assets);
        let colored = |y: f64| picture.share([x, y], [0.05, 0.003], |p| is_hue(p, hue, 0.3));
        let (below, above) = (colored(0.092), colored(0.106));
        must(
            below > 0.9 && above < 0.01,
            format!("{hue:?}: {below} below the ridge, {above} above"),
        )?;
    }
    Ok(())
}

fn negative_scale(assets: &Path) -> Result<(), Failed> {
    let model = "NegativeScaleTest/glTF/NegativeScaleTest.gltf";
    let picture = View::front(model, [0.0, 0.0], [10.4, 9.0]).render(assets);
    // Of a path tracer's surfaces both sides are seen, so the column `back` in between shows crosses.
    for (row, what) in [(2.68, "scale 1"), (1.52, "scale -1")] {
        let off = picture.difference([0.007, row], [3.828, row], [0.35, 0.35]);
        must(off < SAME, format!("{what}: the test differs from the sample by {off}"))?;
    }
    let sunset = format!(
        "environment = {{ file = {:?} }}",
        assets.join(SUNSET).display().to_string()
    );
    let view = View {
        background: &sunset,
        ..View::front(model, [2.0, -2.25], [4.0, 4.0])
    };
    let picture = view.render(assets);
    for (row, what) in [(-1.0, "white"), (-2.25, "dark"), (-3.5, "metal")] {
        let off = picture.difference([3.0, row], [1.0, row], [0.3, 0.3]);
        must(off < 0.12, format!("{what}: the sphere of scale -1 differs by {off}"))?;
    }
    Ok(())
}

/// Compares bumps of a normal map, beside each other, with those of geometry to the left.
fn bumps(assets: &Path, model: &str, groups: &[(&str, f32, f64, &[f64])]) -> Result<(), Failed> {
    let sunset = format!(
        "environment = {{ file = {:?} }}",
        assets.join(SUNSET).display().to_string()
    );
    let view = View {
        background: &sunset,
        samples: 40,
        ..View::front(model, [0.0, 0.0], [2.9, 2.2])
    };
    let picture = view.render(assets);
    let half = [0.07, 0.07];
    for (what, tolerance, geometry, maps) in groups {
        for row in [0.8, 0.4, 0.0, -0.4, -0.8] {
            for map in *maps {
                let off = picture.difference([*map, row], [*geometry, row], half);
                let mirrored = difference(
                    &picture.mirrored([*map, row], half),
                    &picture.blurred([*geometry, row], half),
                );
                must(
                    off < *tolerance && off < 0.8 * mirrored,
                    format!("{what} in row {row} at {map}: differs by {off}, mirrored by {mirrored}"),
                )?;
            }
        }
    }
    Ok(())
}

fn normal_tangents(assets: &Path) -> Result<(), Failed> {
    let model = "NormalTangentTest/glTF-Binary/NormalTangentTest.glb";
    bumps(
        assets,
        model,
        &[
            ("skin", 0.07, -0.95, &[-0.63]),
            ("plastic", 0.07, -0.15, &[0.16]),
            ("metal", 0.15, 0.64, &[0.96]),
        ],
    )
}

fn mirrored_tangents(assets: &Path) -> Result<(), Failed> {
    let model = "NormalTangentMirrorTest/glTF-Binary/NormalTangentMirrorTest.glb";
    bumps(
        assets,
        model,
        &[
            ("plastic", 0.07, -1.272, &[-0.949, -0.644, -0.29]),
            ("metal", 0.15, 0.31, &[0.624, 0.948, 1.27]),
        ],
    )
}

fn orientation(assets: &Path) -> Result<(), Failed> {
    let model = "OrientationTest/glTF/OrientationTest.gltf";
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let minus = |v: [f64; 3]| v.map(|c| 0.0 - c);
    // Each face with what is up in its picture, and its target there.
    let faces = [
        (x, y, [2.138, 2.946]),
        (minus(x), y, [0.344, 3.515]),
        (y, minus(z), [3.343, 1.347]),
        (minus(y), z, [-0.819, 3.464]),
        (z, y, [-1.02, 3.427]),
        (minus(z), y, [-1.152, 3.396]),
    ];
    for (back, up, target) in faces {
        let view = View {
            back,
            up,
            ..View::front(model, [0.0, 0.0], [10.0, 10.0])
        };
        let picture = view.render(assets);
        let color = mean(&picture.block(target, [0.1, 0.1]));
        let most = color.into_iter().fold(0.0, f32::max);
        let hue = color.map(|v| v / most);
        let steps: Vec<f64> = (0..=50).map(|k| f64::from(k) / 50.0).collect();
        let is_arrow = |t: &&f64| {
            let at = target.map(|v| v * **t);
            is_hue(picture.mean(at, [0.03, 0.03]), hue, 0.2)
        };
        let along = steps.iter().filter(is_arrow).count() as f64 / steps.len() as f64;
        must(
            along > 0.8,
            format!("face {back:?}: {along} of the way to the target is arrow"),
        )?;
        must(
            saturation(color) > 0.8,
            format!("face {back:?}: the target is {color:?}"),
        )?;
    }
    Ok(())
}

fn specular(assets: &Path) -> Result<(), Failed> {
    let model = "SpecularTest/glTF/SpecularTest.gltf";
    let picture = View::front(model, [0.105, 0.0], [0.6, 0.8]).render(assets);
    for (factor, texture) in [(0.33, 0.22), (0.11, 0.0), (-0.11, -0.22)] {
        let mut last = 0.0;
        for x in [-0.115, -0.005, 0.105, 0.215, 0.325] {
            // The centre reflects as much as at normal incidence.
            let half = [0.012; 2];
            let [a, b] = [factor, texture].map(|y| picture.mean([x, y], half));
            let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            must(
                off < 0.004,
                format!("row {factor}, {x}: {a:?} by factor, {b:?} by texture"),
            )?;
            must(a[0] >= last, format!("row {factor}, {x}: {} after {last}", a[0]))?;
            last = a[0];
        }
        must(last > 0.03, format!("row {factor} ends with {last}"))?;
    }
    Ok(())
}

fn unlit(assets: &Path) -> Result<(), Failed> {
    let model = "UnlitTest/glTF/UnlitTest.gltf";
    for background in [DARK, view::WHITE_SKY] {
        let view = View {
            background,
            ..View::front(model, [0.0, 0.0], [4.6, 2.2])
        };
        let picture = view.render(assets);
        for (x, given) in [(-1.2, [1.0, 0.217_637_6, 0.0]), (1.2, [0.0, 0.217_637_6, 1.0])] {
            let seen = picture.mean([x, 0.0], [0.5, 0.5]);
            let is_right = (0..3).all(|k| (seen[k] - given[k]).abs() < 2e-3);
            must(is_right, format!("at {x}: {seen:?} instead of {given:?}"))?;
        }
    }
    Ok(())
}
