use super::{surface::GRAY, *};
use crate::{
    assets::{
        model::{FaceUse, Treatment},
        obj,
    },
    bsdf::layered::Boundary,
    material::{
        HeightMap,
        principled::{AlphaMode, Principled},
    },
    math::{Rgb, Vec2},
    texture::{Color, Scalar, StTransform, TextureId, bitmap::ColorSpace},
    value::Channel,
    warnings::Warnings,
};

/// A folder with pictures: `rgb.png`, `alpha.png`, `normals.png`.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let save = |name: &str, color| {
        let picture = ::image::DynamicImage::new(2, 2, color);
        picture.save(folder.path().join(name)).expect("written");
    };
    save("rgb.png", ::image::ColorType::Rgb8);
    save("alpha.png", ::image::ColorType::Rgba8);
    let normals = ::image::RgbImage::from_pixel(2, 2, ::image::Rgb([128, 128, 255]));
    normals.save(folder.path().join("normals.png")).expect("written");
    folder
}

/// A model of a triangle with the material `m`, which these statements describe.
fn model_of(statements: &[u8]) -> Model {
    let folder = folder();
    let text = [b"newmtl m\n", statements].concat();
    std::fs::write(folder.path().join("m.mtl"), text).expect("written");
    let text = b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    obj::parse(
        text,
        &folder.path().join("a.obj"),
        FaceUse::Triangles,
        &Files::default(),
    )
    .expect("a model")
}

fn surface(statements: &str) -> Principled {
    model_of(statements.as_bytes()).materials[0].surface
}

fn constant(color: Color) -> Rgb {
    match color {
        Color::Constant(c) => c,
        _ => panic!("a texture: {color:?}"),
    }
}

#[test]
fn what_has_a_colour_only_is_matte() {
    let kd = Color::Constant(Rgb::new(0.1, 0.2, 0.3));
    for statements in [
        "Kd 0.1 0.2 0.3\n",
        "Kd 0.1 0.2 0.3\nKs 0 0 0\nKe 0 0 0\nNs 250\nNi 1.45\nd 1\nTr 0\nillum 2\n",
        "Kd 0.1 0.2 0.3\nKs 0.5 0.5 0.5\nNs 250\nillum 1\n",
        "Kd 0.1 0.2 0.3\nTf 1 1 1\nNi 1.00\nillum 4\n",
    ] {
        let surface = surface(statements);
        assert_eq!(surface.matte_color(), Some(kd), "{statements}");
        assert_eq!(format!("{surface:?}"), format!("{:?}", Principled::matte(kd)));
    }
    let textured = surface("Kd 0 0 0\nmap_Kd rgb.png\n");
    assert_eq!(textured.matte_color(), Some(Color::Tinted(TextureId(0), Rgb::WHITE)));
    assert_eq!(surface("").matte_color(), Some(Color::Constant(Rgb::gray(GRAY))));
}

#[test]
fn exponents_become_roughness_and_colours_tint_the_reflection() {
    let glossy = surface("Kd 0.5\nKs 0.4 0.5 2\nNs 198\nNi 1.6\n");
    assert_eq!(constant(glossy.specular_color), Rgb::new(0.4, 0.5, 1.0));
    // alpha = sqrt(2 / 200) = 0.1.
    let Scalar::Constant(roughness) = glossy.roughness else {
        panic!()
    };
    assert!((roughness * roughness - 0.1).abs() < 1e-6, "{roughness}");
    assert_eq!((glossy.ior, glossy.specular), (1.6, Scalar::Constant(1.0)));
    assert_eq!(surface("Ks 0.5\nNi 1\nillum 2\n").ior, 1.5);
    // Mirrors reflect `Ks` from everywhere.
    assert!(surface("Ks 0.9\nillum 3\n").ior > 1000.0);
}

#[test]
fn dissolving_is_opacity_and_d_wins_over_tr() {
    for (statements, opacity) in [
        ("d 0.25\n", 0.25),
        ("Tr 0.75\n", 0.25),
        ("d 1\nTr 1\n", 1.0),
        ("d 7\n", 1.0),
        ("d -halo 0.5\n", 0.5),
    ] {
        let surface = surface(statements);
        assert_eq!(surface.opacity, Scalar::Constant(opacity), "{statements}");
        assert_eq!(surface.alpha_mode, AlphaMode::Blend);
    }
}

#[test]
fn only_illum_4_6_7_and_9_make_glass() {
    let glass = surface("Kd 0\nTf 1 1 1\nNi 1.5\nillum 7\nd 0.1\n");
    assert_eq!(
        (glass.transmission, glass.boundary),
        (Scalar::Constant(1.0), Boundary::Solid)
    );
    assert_eq!(
        (glass.opacity, glass.roughness),
        (Scalar::Constant(1.0), Scalar::Constant(0.0))
    );
    assert_eq!(constant(glass.base_color), Rgb::WHITE);
    let pane = surface("Kd 0\nTf 0.5 1 0.5\nillum 4\n");
    assert_eq!(pane.boundary, Boundary::ThinWalled);
    assert_eq!(constant(pane.base_color), Rgb::new(0.5, 1.0, 0.5));
    let part = surface("Kd 0.5\nNi 1.5\nillum 6\nd 0.75\n");
    assert_eq!(
        (part.transmission, part.opacity),
        (Scalar::Constant(0.25), Scalar::Constant(1.0))
    );
    for statements in ["Tf 0.5\nNi 1.5\nillum 5\n", "Tf 0.5\n", "Tf 0 0 0\nNi 1.5\nillum 7\n"] {
        assert_eq!(surface(statements).transmission, Scalar::Constant(0.0), "{statements}");
    }
}

#[test]
fn opacity_is_the_alpha_of_a_picture_or_its_first_channel() {
    let model = model_of(b"map_Kd alpha.png\nmap_d alpha.png\nd 0.5\n");
    assert_eq!(
        model.materials[0].surface.opacity,
        Scalar::Texture(TextureId(1), Channel::A, 0.5)
    );
    // One picture, decoded once.
    assert_eq!(model.images.len(), 1);
    assert_eq!(model.textures[0].color_space, model.textures[1].color_space);
    let model = model_of(b"map_d rgb.png\n");
    assert_eq!(
        model.materials[0].surface.opacity,
        Scalar::Texture(TextureId(0), Channel::R, 1.0)
    );
    assert_eq!(model.textures[0].color_space, ColorSpace::Raw);
    let green = surface("map_d -imfchan g alpha.png\n");
    assert_eq!(green.opacity, Scalar::Texture(TextureId(0), Channel::G, 1.0));
}

#[test]
fn options_of_textures_change_them() {
    let model = model_of(b"Kd 1\nmap_Kd -s 4 2 1 -o 0.5 0 0 -mm 0.1 0.5 rgb.png\n");
    let expected = StTransform::new(Vec2::new(0.5, 0.0), 0.0, Vec2::new(4.0, 2.0));
    assert_eq!(model.textures[0].transform, expected);
    assert_eq!(
        model.materials[0].surface.base_color,
        Color::Tinted(TextureId(0), Rgb::gray(0.5))
    );
    let loss = model.features[0].loss().expect("a loss");
    assert!(loss.contains("-mm, used by 1 texture"), "{loss}");
}

#[test]
fn physically_based_materials_take_their_own_statements() {
    let metal =
        surface("Kd 0.9 0.6 0.2\nKs 0.5\nNs 10\nPr 0.3\nPm 1\nPc 0.4\nPcr 0.1\nPs 0.2\naniso -0.5\nanisor 0.5\n");
    assert_eq!(
        (metal.roughness, metal.metallic),
        (Scalar::Constant(0.3), Scalar::Constant(1.0))
    );
    assert_eq!(constant(metal.specular_color), Rgb::WHITE);
    assert_eq!(
        (metal.clearcoat, metal.clearcoat_roughness),
        (Scalar::Constant(0.4), Scalar::Constant(0.1))
    );
    assert_eq!(
        (constant(metal.sheen_color), metal.anisotropy),
        (Rgb::gray(0.2), Scalar::Constant(0.5))
    );
    assert!((metal.anisotropy_rotation.to_degrees() - 270.0).abs() < 1e-3);
    let textured = model_of(b"Pr 0\nPm 0\nmap_Pr rgb.png\nmap_Pm -imfchan b rgb.png\nnorm -bm 0.5 rgb.png\n");
    let surface = textured.materials[0].surface;
    assert_eq!(surface.roughness, Scalar::Texture(TextureId(0), Channel::R, 1.0));
    assert_eq!(surface.metallic, Scalar::Texture(TextureId(1), Channel::B, 1.0));
    assert_eq!(
        (surface.normal, surface.normal_scale),
        (Some(Color::Texture(TextureId(2))), 0.5)
    );
    assert_eq!(textured.images.len(), 1);
}

#[test]
fn emission_takes_its_colour_or_its_texture() {
    assert_eq!(constant(surface("Ke 17 12 4\n").emissive), Rgb::new(17.0, 12.0, 4.0));
    let textured = surface("Ke 0 0 0\nmap_Ke rgb.png\n");
    assert_eq!(textured.emissive, Color::Tinted(TextureId(0), Rgb::WHITE));
}

#[test]
fn what_is_not_rendered_is_reported() {
    let model = model_of(b"refl -type sphere rgb.png\ndisp rgb.png\ndecal rgb.png\n");
    let names: Vec<_> = model
        .features
        .iter()
        .map(|f| (f.name.as_str(), f.count, f.treatment))
        .collect();
    let without = |name| (name, 1, Treatment::Without(""));
    assert_eq!(names, ["refl", "disp", "decal"].map(without));
    assert!(model.textures.is_empty());
}

#[test]
fn a_bump_is_heights_unless_it_holds_normals_or_stands_beside_some() {
    let bumped = surface("map_Bump -bm 0.3 -mm 0 2 -imfchan g rgb.png\n");
    let (texture, channel) = (TextureId(0), Some(Channel::G));
    let heights = HeightMap {
        texture,
        channel,
        scale: 0.6,
    };
    assert_eq!((bumped.heights, bumped.normal), (Some(heights), None));
    let turned = surface("bump -bm 0.3 normals.png\n");
    assert_eq!(
        (turned.heights, turned.normal),
        (None, Some(Color::Texture(TextureId(0))))
    );
    assert_eq!(turned.normal_scale, 0.3);
    let both = model_of(b"bump rgb.png\nnorm normals.png\n");
    let surface = both.materials[0].surface;
    assert_eq!(
        (surface.heights, surface.normal),
        (None, Some(Color::Texture(TextureId(0))))
    );
    assert_eq!(both.features[0].name, "bump");
    assert!(matches!(both.features[0].treatment, Treatment::Without(_)));
}

#[test]
fn a_texture_that_is_not_there_is_left_out() {
    let statements = b"Kd 0 0 0\nKs 0.5\nd 0.5\nmap_Kd no.png\nmap_d no.png\nmap_Ks no.png\nmap_Ke no.png\nnorm no.png\nmap_Pr no.png\n";
    let model = model_of(statements);
    assert!(model.textures.is_empty() && model.images.is_empty());
    let surface = model.materials[0].surface;
    assert_eq!(constant(surface.base_color), Rgb::gray(GRAY));
    assert_eq!(surface.opacity, Scalar::Constant(0.5));
    assert!(surface.normal.is_none());
}

#[test]
fn names_are_one_only_where_their_bytes_are() {
    let folder = folder();
    std::fs::write(
        folder.path().join("m.mtl"),
        b"newmtl W\xe4\nKd 1 0 0\nnewmtl W\xf6\nKd 0 0 1\nnewmtl \x83\\\nKd 0 1 0\n",
    )
    .expect("written");
    let text = b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl W\xe4\nf 1 2 3\nusemtl W\xf6\nf 1 2 3\nusemtl \x83\\\nf 1 2 3\n";
    let model = obj::parse(
        text,
        &folder.path().join("a.obj"),
        FaceUse::Triangles,
        &Files::default(),
    )
    .expect("a model");
    let found: Vec<_> = model
        .materials
        .iter()
        .map(|m| (m.name.as_str(), constant(m.surface.base_color)))
        .collect();
    assert_eq!(
        found,
        [
            (r"W\xE4", Rgb::new(1.0, 0.0, 0.0)),
            (r"W\xF6", Rgb::new(0.0, 0.0, 1.0)),
            (r"\x83\", Rgb::new(0.0, 1.0, 0.0))
        ]
    );
}

#[test]
fn cut_and_flipped_bytes_of_a_library_never_panic() {
    let whole = b"newmtl a b\nKd 0.1 0.2 0.3\nmap_Kd -s 1 1 -mm 0 1 -clamp on x y.png\nd -halo 0.5\nillum 7\nTf 1 1 1\nnorm n.png\n";
    for i in 0..whole.len() {
        let _ = statements::read(&whole[..i], Path::new("a.mtl"), &Warnings::default());
        for byte in [b'\n', b'-', b'9', b'/', b' ', b'\\', 0, 0xff] {
            let mut changed = whole.to_vec();
            changed[i] = byte;
            let _ = statements::read(&changed, Path::new("a.mtl"), &Warnings::default());
        }
    }
}

#[test]
fn tr_of_one_that_would_hide_a_whole_textured_model_is_opaque() {
    let opacity = |statements: &str| surface(statements).opacity;
    let textured = "map_Kd rgb.png\nTr 1.000000\n";
    assert_eq!(opacity(textured), Scalar::Constant(1.0));
    // Where something else tells what is meant, it is 1 - d.
    assert_eq!(opacity("Tr 1\n"), Scalar::Constant(0.0));
    assert_eq!(opacity("map_Kd rgb.png\nTr 0.75\n"), Scalar::Constant(0.25));
    assert_eq!(opacity(&format!("{textured}d 0\n")), Scalar::Constant(0.0));
    assert_eq!(
        opacity(&format!("{textured}newmtl other\nTr 0\n")),
        Scalar::Constant(0.0)
    );
}
