//! Displacement against closed forms.

use std::path::PathBuf;

use glam::DVec3;

use super::{super::subdivide, of_model::model};
use crate::{
    assets::{
        Files, MemoryBudget,
        displacement::{Displacement, HeightTexture, Heights},
        model::{Model, Subdivision},
    },
    math::Rgb,
    shape::mesh::{Bits, Scheme},
    texture::{
        BitmapId, Mapping, Pattern, Texture,
        bitmap::ColorSpace,
        image::{ImagePattern, TextureFilter, Wrap},
        mapping::Ramp,
        stripes::Stripes,
    },
    value::Channel,
};

const LEVELS: u32 = 5;
/// The vertices along a side of a square of so many levels.
const SIDE: u32 = (1 << LEVELS) + 1;

fn displaced(text: &str, how: &Subdivision, displacement: &Displacement) -> Result<Model, String> {
    let mut model = model(text);
    let loaded = displacement.load(&Files::default()).expect("its picture");
    subdivide(&mut model, how, Some(&loaded), true, &MemoryBudget::default()).map_err(|e| e.to_string())?;
    Ok(model)
}

fn linear(levels: u32) -> Subdivision {
    Subdivision {
        scheme: Some(Scheme::Linear),
        ..Subdivision::of_levels(levels)
    }
}

fn by(heights: Heights, scale: f32, midlevel: f32) -> Displacement {
    let [scale, midlevel] = [scale, midlevel].map(Bits::new);
    Displacement {
        heights,
        scale,
        midlevel,
    }
}

fn texture(pattern: Pattern, image: Option<PathBuf>) -> Heights {
    let texture = Texture::new(Mapping::Uv, pattern);
    let image = image.map(|path| (path, ColorSpace::Raw));
    Heights::Texture(Box::new(HeightTexture::new(texture, Channel::R, image)))
}

/// A square of two metres in the xz plane that looks up, with a texel of a picture of `SIDE` for each vertex.
fn square() -> String {
    let (low, high) = (0.5 / f64::from(SIDE), 1.0 - 0.5 / f64::from(SIDE));
    format!(
        "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nvt {low} {low}\nvt {low} {high}\nvt {high} {high}\nvt {high} {low}\n\
         f 1/1 2/2 3/3 4/4\n"
    )
}

/// A hill, and its slope along x and along z, over a square from -1 to 1.
fn hill(x: f64, z: f64) -> (f64, [f64; 2]) {
    let (a, b) = (1.0 - x * x, 1.0 - z * z);
    (a * a * b * b, [-4.0 * x * a * b * b, -4.0 * z * b * a * a])
}

#[test]
fn displaced_square_is_the_field_of_heights_with_its_normals() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("hill.png");
    let place = |i: u32| f64::from(i) / f64::from(SIDE - 1) * 2.0 - 1.0;
    let picture = ::image::ImageBuffer::from_fn(SIDE, SIDE, |i, j| {
        // The first row of a picture is the top one, at v = 1.
        let (height, _) = hill(place(i), place(SIDE - 1 - j));
        ::image::Luma([(height * 65535.0).round() as u16])
    });
    picture.save(&path).expect("written");
    let pattern = Pattern::Image(ImagePattern {
        bitmap: BitmapId(0),
        filter: TextureFilter::Linear,
        wrap: [Wrap::Clamp; 2],
    });
    let heights = texture(pattern, Some(path));
    let model = displaced(&square(), &linear(LEVELS), &by(heights, 0.4, 0.25)).expect("displaced");
    let mesh = &model.meshes[0];
    assert_eq!(mesh.positions.len(), (SIDE * SIDE) as usize);
    for (p, normal) in mesh.positions.iter().zip(&mesh.normals) {
        let p = p.as_dvec3();
        let (height, [along_x, along_z]) = hill(p.x, p.z);
        let expected = 0.4 * (height - 0.25);
        assert!((p.y - expected).abs() < 0.4 / 65535.0, "{p}, not {expected}");
        let is_within = p.x.abs().max(p.z.abs()) < 1.0;
        let slope = DVec3::new(-0.4 * along_x, 1.0, -0.4 * along_z).normalize();
        // Steps are 1/16 m. On the boundary a slope is off by half a step times the largest curvature, 0.4 * 8 m^-1;
        // within, by less than a tenth of it.
        let bound: f64 = if is_within { 0.01 } else { 0.1 };
        assert!(
            normal.as_dvec3().distance(slope) < bound,
            "{normal}, not {slope} at {p}"
        );
    }
}

#[test]
fn displacement_of_a_smooth_surface_is_along_its_normals() {
    // A cube of radius 1.
    let cube = "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n\
                f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n";
    let how = Subdivision::of_levels(3);
    let smooth = displaced(cube, &how, &by(Heights::Constant(Bits::new(0.0)), 1.0, 0.0)).expect("displaced");
    let moved = displaced(cube, &how, &by(Heights::Constant(Bits::new(1.5)), 0.2, 0.5)).expect("displaced");
    let (smooth, moved) = (&smooth.meshes[0], &moved.meshes[0]);
    assert_eq!(smooth.triangles, moved.triangles);
    for ((p, n), q) in smooth.positions.iter().zip(&smooth.normals).zip(&moved.positions) {
        assert!((*p + *n * 0.2).distance(*q) < 1e-6);
    }
}

#[test]
fn seams_of_texture_coordinates_do_not_tear() {
    // Two squares whose common edge is at the height 0 in the one and 1 in the other.
    let text = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 2 0 0\nv 2 0 1\nvt 0.5 0\nvt 0.5 1\nvt 1.5 0\nvt 1.5 1\n\
                f 1/1 2/2 3/2 4/1\nf 4/3 3/4 6/4 5/3\n";
    let stripes = Pattern::Stripes(Stripes {
        colors: [0.0, 1.0].map(Rgb::gray),
        width: 1.0,
    });
    let model = displaced(text, &linear(2), &by(texture(stripes, None), 1.0, 0.0)).expect("displaced");
    let mesh = &model.meshes[0];
    let at_seam: Vec<_> = mesh.positions.iter().filter(|p| p.x == 1.0).collect();
    assert_eq!(at_seam.len(), 10, "five places with two texture coordinates each");
    assert!(at_seam.iter().all(|p| p.y == 0.5), "{at_seam:?}");
    assert!(
        mesh.positions
            .iter()
            .all(|p| p.x == 1.0 || p.y == if p.x < 1.0 { 0.0 } else { 1.0 })
    );
}

#[test]
fn triangles_of_the_file_are_displaced_without_subdivision_and_need_texture_coordinates() {
    let heights = || Heights::Constant(Bits::new(1.0));
    let model = displaced(&square(), &linear(0), &by(heights(), 0.5, 0.0)).expect("displaced");
    assert_eq!(model.meshes[0].triangles.len(), 2);
    assert!(model.meshes[0].positions.iter().all(|p| p.y == 0.5));
    let stripes = Pattern::Stripes(Stripes {
        colors: [0.0, 1.0].map(Rgb::gray),
        width: 0.25,
    });
    let bare = "v 0 0 0\nv 0 0 1\nv 1 0 1\nf 1 2 3\n";
    let refused = displaced(bare, &linear(1), &by(texture(stripes, None), 1.0, 0.0)).expect_err("no coordinates");
    assert_eq!(
        refused,
        "a displacement by a texture needs texture coordinates, which a mesh has not"
    );
    // By the place in the model it needs none.
    let axis = |axis| Ramp::new(axis, [0.0, 1.0], DVec3::ZERO);
    let lies = Mapping::Planar { s: axis(0), t: axis(2) };
    let by_place = HeightTexture::new(Texture::new(lies, stripes), Channel::R, None);
    let by_place = Heights::Texture(Box::new(by_place));
    let model = displaced(bare, &linear(2), &by(by_place, 1.0, 0.0)).expect("displaced");
    for p in &model.meshes[0].positions {
        assert_eq!(p.y, (4.0 * p.x) % 2.0, "{p}");
    }
}

#[test]
fn positions_beyond_single_precision_are_refused() {
    let heights = || Heights::Constant(Bits::new(1e38));
    let refused = displaced(&square(), &linear(1), &by(heights(), 10.0, 0.0)).expect_err("too far");
    assert_eq!(
        refused,
        "its displacement moves a vertex to a position that is not finite"
    );
    let model = displaced(&square(), &linear(1), &by(heights(), 2.0, 0.0)).expect("displaced");
    assert!(model.meshes[0].positions.iter().all(|p| p.y == 2e38));
}
