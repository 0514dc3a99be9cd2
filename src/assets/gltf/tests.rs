use super::*;
use crate::{
    assets::model::{ModelFeature, ModelLightKind},
    math::{DVec3, Rgb, Vec2, Vec4},
    texture::{Color, Scalar, TextureId},
    value::Channel,
};

/// A triangle in the xy plane, as bytes.
const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// A GLB whose binary chunk is `TRIANGLE` and three indices of 16 bits; the JSON has `rest` beside its buffers.
fn glb(rest: &str) -> Vec<u8> {
    let mut binary: Vec<u8> = TRIANGLE.iter().flat_map(|v| v.to_le_bytes()).collect();
    binary.extend([0u16, 1, 2, 0].iter().flat_map(|v| v.to_le_bytes()));
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 44}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": 6.0}}],
        {rest}}}"#
    );
    samples::of_chunks(&json, &binary)
}

const ACCESSORS: &str = r#""accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
    {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}]"#;
const MESH: &str = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]"#;

fn read(rest: &str) -> Result<Model, String> {
    parse(
        &glb(rest),
        Path::new("nowhere/a.glb"),
        &ModelChoice::default(),
        &Files::default(),
    )
    .map_err(|e| e.to_string())
}

fn scene(accessors: &str, mesh: &str, nodes: &str) -> Result<Model, String> {
    read(&format!("{accessors}, {mesh}, {nodes}"))
}

#[test]
fn nested_nodes_place_their_meshes_and_share_them() {
    let nodes = r#""nodes": [{"translation": [1, 0, 0], "children": [1, 2]}, {"mesh": 0, "scale": [-2, 2, 2]}, {"mesh": 0}],
        "scenes": [{"nodes": [0]}]"#;
    let model = scene(ACCESSORS, MESH, nodes).unwrap();
    assert_eq!((model.meshes.len(), model.instances.len()), (1, 2));
    let bounds = model.bounds();
    assert_eq!(
        (bounds.min, bounds.max),
        (DVec3::new(-1.0, 0.0, 0.0), DVec3::new(2.0, 2.0, 0.0))
    );
    assert!(model.instances[0].model_from_mesh.matrix3.determinant() < 0.0);
    let surface = &model.materials[model.instances[0].material].surface;
    assert!(matches!(surface.base_color, Color::Constant(Rgb::WHITE)));
}

#[test]
fn cycles_two_parents_and_wrong_indices_are_refused() {
    let nodes = |nodes: &str| {
        scene(
            ACCESSORS,
            MESH,
            &format!(r#""nodes": [{nodes}], "scenes": [{{"nodes": [0]}}]"#),
        )
    };
    let message = |text: &str| nodes(text).unwrap_err();
    let at = "nowhere/a.glb";
    assert_eq!(
        message(r#"{"children": [1]}, {"children": [2]}, {"children": [1]}"#),
        format!("broken model: node 1 is a child of both node 0 and node 2: {at}")
    );
    assert_eq!(
        message(r#"{}, {"children": [2]}, {"children": [1]}"#),
        format!("broken model: node 2 is its own ancestor: {at}")
    );
    assert_eq!(
        message(r#"{"mesh": 7}"#),
        format!("broken model: nodes[0].mesh names something that is not there: {at}")
    );
    assert!(message(r#"{"children": [9]}"#).contains("nodes[0].children[0] names something"));
    let mesh = MESH.replace("\"POSITION\": 0", "\"POSITION\": 5");
    assert!(
        scene(ACCESSORS, &mesh, r#""nodes": []"#)
            .unwrap_err()
            .contains("attributes[\"POSITION\"]")
    );
    assert!(message(r#"{"matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}"#).contains("not affine"));
}

#[test]
fn arrays_never_reach_past_their_buffers() {
    let message = |from: &str, to: &str| {
        let accessors = ACCESSORS.replace(from, to);
        scene(&accessors, MESH, r#""nodes": [{"mesh": 0}]"#).unwrap_err()
    };
    assert!(
        message(r#""count": 3, "type": "VEC3""#, r#""count": 4, "type": "VEC3""#).contains("accessor 0 reaches past")
    );
    assert!(message(r#""count": 3, "type": "VEC3""#, r#""count": 2, "type": "VEC3""#).contains("names vertex 2"));
    assert!(message("\"VEC3\"", "\"VEC2\"").contains("2 numbers an element instead of 3"));
    assert!(
        message(
            r#""bufferView": 0, "#,
            r#""count": 9, "byteOffset": 18446744073709551615, "bufferView": 0, "#
        )
        .contains("broken")
    );
    let huge = ACCESSORS.replace(
        r#"{"bufferView": 0, "componentType": 5126, "count": 3"#,
        r#"{"componentType": 5126, "count": 99999999999"#,
    );
    assert!(
        scene(&huge, MESH, r#""nodes": [{"mesh": 0}]"#)
            .unwrap_err()
            .contains("no buffer view")
    );
}

#[test]
fn lights_and_cameras_are_found_with_their_place() {
    let model = read(
        r#""extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 2, "color": [1, 0.5, 0],
            "spot": {"outerConeAngle": 0.5}}]}}, "extensionsRequired": ["KHR_lights_punctual"],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 3, 0]}, {"camera": 0}]"#,
    )
    .unwrap();
    let light = model.lights[0];
    assert_eq!(light.strength, Rgb::new(2.0, 1.0, 0.0));
    assert_eq!(
        light.kind,
        super::super::model::ModelLightKind::Spot { inner: 0.0, outer: 0.5 }
    );
    assert_eq!(light.model_from_light.translation.y, 3.0);
    assert_eq!(model.cameras.len(), 1);
    assert!(model.instances.is_empty());
}

#[test]
fn base_colors_and_their_textures_are_read() {
    let rest = format!(
        r#"{ACCESSORS}, "images": [{{"uri": "a%20b.png"}}], "textures": [{{"source": 0, "sampler": 0}}],
        "samplers": [{{"wrapS": 33071, "magFilter": 9728}}],
        "materials": [{{"pbrMetallicRoughness": {{"baseColorFactor": [1, 0.5, 0.25, 1], "baseColorTexture": {{"index": 0}}}}}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 2}}, "material": 0}}]}}],
        "nodes": [{{"mesh": 0}}]"#
    );
    let uvs = r#", {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2"}]"#;
    let rest = rest.replacen(']', uvs, 1);
    let model = read(&rest).unwrap();
    let material = &model.materials[0];
    let tint = Rgb::new(1.0, 0.5, 0.25);
    assert!(matches!(material.surface.base_color, Color::Tinted(TextureId(0), found) if found == tint));
    assert_eq!(
        model.images[0],
        super::super::model::ImageSource::File("nowhere/a b.png".into())
    );
    // v runs downwards in the file.
    assert_eq!(
        model.meshes[0].uvs,
        [Vec2::new(0.0, 1.0), Vec2::new(0.0, 0.0), Vec2::new(0.0, 1.0)]
    );
}

#[test]
fn meshes_with_normal_maps_get_tangents_along_their_coordinates() {
    // Bytes of the positions: (0, 0.5), (0.25, 0) and (0, 0), with v downwards. So u grows along x and against y.
    let model = |material: &str, attributes: &str| {
        let rest = format!(
            r#""accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}},
            {{"bufferView": 0, "byteOffset": 13, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2"}}],
            "images": [{{"uri": "n.png"}}], "textures": [{{"source": 0}}], "materials": [{material}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, {attributes}}}, "material": 0}}]}}], "nodes": [{{"mesh": 0}}]"#
        );
        read(&rest).unwrap()
    };
    let coordinates = r#""TEXCOORD_0": 1"#;
    let mapped = model(r#"{"normalTexture": {"index": 0}}"#, coordinates);
    let mesh = &mapped.meshes[0];
    assert_eq!((mesh.tangents.len(), mesh.validate()), (mesh.positions.len(), Ok(())));
    let expected = Vec4::new(1.0, -1.0, 0.0, 0.0).normalize() + Vec4::W;
    for tangent in &mesh.tangents {
        assert!((*tangent - expected).length() < 1e-5, "{tangent}");
    }
    assert!(model("{}", coordinates).meshes[0].tangents.is_empty());
    let brushed = r#"{"extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 1}}}"#;
    assert!(!model(brushed, coordinates).meshes[0].tangents.is_empty());
    // Tangents of a file without normals belong to none, and without coordinates there are none.
    assert!(
        model(r#"{"normalTexture": {"index": 0, "texCoord": 1}}"#, coordinates).meshes[0]
            .tangents
            .is_empty()
    );
}

#[test]
fn required_extensions_and_other_versions_are_refused_by_name() {
    assert_eq!(
        read(r#""extensionsRequired": ["KHR_lights_punctual", "EXT_x", "KHR_y"]"#).unwrap_err(),
        "unsupported model: it requires the extensions EXT_x, KHR_y: nowhere/a.glb"
    );
    let compressed = read(r#""extensionsRequired": ["EXT_meshopt_compression"]"#).unwrap_err();
    assert!(compressed.contains("EXT_meshopt_compression (decode it: `gltf-transform copy"));
    let old = parse(
        br#"{"asset": {"version": "1.0"}}"#,
        Path::new("a.gltf"),
        &ModelChoice::default(),
        &Files::default(),
    )
    .unwrap_err();
    assert!(old.to_string().contains("version 1.0 of glTF"));
    assert!(
        parse(b"", Path::new("a.gltf"), &ModelChoice::default(), &Files::default()).is_err()
            && parse(b"[]", Path::new("a.gltf"), &ModelChoice::default(), &Files::default()).is_err()
    );
}

#[test]
fn cut_and_flipped_bytes_never_panic() {
    let nodes = r#""nodes": [{"mesh": 0, "children": [1]}, {"rotation": [0, 0, 0, 1], "mesh": 0}]"#;
    let whole = glb(&format!("{ACCESSORS}, {MESH}, {nodes}"));
    for i in 0..whole.len() {
        let _ = parse(
            &whole[..i],
            Path::new("a.glb"),
            &ModelChoice::default(),
            &Files::default(),
        );
        for bits in [1u8, 2, 16, 128, 255] {
            let mut flipped = whole.clone();
            flipped[i] ^= bits;
            let _ = parse(&flipped, Path::new("a.glb"), &ModelChoice::default(), &Files::default());
        }
    }
}

#[test]
fn faults_that_keep_no_picture_from_being_made_are_told() {
    let faults = |rest: &str| read(rest).unwrap().faults;
    let zero_normals = r#""accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
        "max": [1, 1, 0]}, {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1}]}]"#;
    assert_eq!(
        faults(zero_normals),
        ["1 of the 3 normals of primitive 0 of mesh 0 are no unit vectors, 1 of them are zero"]
    );
    let odd = r#""extensionsUsed": ["KHR_materials_ior"], "materials": [{"extensions": {"KHR_materials_ior": "1.4"}}]"#;
    assert_eq!(faults(odd), ["KHR_materials_ior is used, but is no object"]);
    let webp = r#""images": [{"uri": "data:image/webp;base64,UklGRgAAAABXRUJQVlA4IAAAAAA=", "mimeType": "image/webp"}],
        "textures": [{"source": 0}]"#;
    assert_eq!(faults(webp), ["texture 0 shows a WebP image without EXT_texture_webp"]);
}

#[test]
fn animation_channels_may_move_what_an_extension_names() {
    let animations = r#""extensionsUsed": ["KHR_animation_pointer"],
        "accessors": [{"count": 2, "type": "SCALAR", "componentType": 5126, "min": [0], "max": [1]}],
        "animations": [{"channels": [{"sampler": 0, "target": {"path": "pointer", "extensions":
        {"KHR_animation_pointer": {"pointer": "/nodes/0/scale"}}}}], "samplers": [{"input": 0, "output": 0}]}]"#;
    assert!(read(animations).is_ok());
}

#[test]
fn a_variant_gives_each_primitive_its_material_and_others_keep_theirs() {
    let rest = format!(
        r#"{ACCESSORS}, "extensionsUsed": ["KHR_materials_variants"], "extensions": {{"KHR_materials_variants":
        {{"variants": [{{"name": "red"}}, {{"name": "green"}}]}}}},
        "materials": [{{"name": "plain"}}, {{"name": "r"}}, {{"name": "g"}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "material": 0, "extensions":
        {{"KHR_materials_variants": {{"mappings": [{{"material": 1, "variants": [0]}}, {{"material": 2, "variants": [1]}}]}}}}}},
        {{"attributes": {{"POSITION": 0}}, "indices": 1, "material": 0}}]}}], "nodes": [{{"mesh": 0}}]"#
    );
    let materials = |variant: Option<&str>| {
        let choice = ModelChoice {
            variant: variant.map(str::to_owned),
            ..ModelChoice::default()
        };
        let model = parse(&glb(&rest), Path::new("a.glb"), &choice, &Files::default()).map_err(|e| e.to_string())?;
        assert_eq!(model.variants, ["red", "green"]);
        let name = |part: &MeshInstance| model.materials[part.material].name.clone();
        Ok::<_, String>(model.instances.iter().map(name).collect::<Vec<_>>())
    };
    assert_eq!(materials(None).unwrap(), ["plain", "plain"]);
    assert_eq!(materials(Some("red")).unwrap(), ["r", "plain"]);
    assert_eq!(materials(Some("green")).unwrap(), ["g", "plain"]);
    assert_eq!(
        materials(Some("gren")).unwrap_err(),
        "unknown material variant `gren` (did you mean `green`?): a.glb"
    );
}

#[test]
fn extensions_of_materials_are_read_and_leave_nothing_to_warn_of() {
    let rest = format!(
        r#"{ACCESSORS}, "extensionsUsed": ["KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_dispersion",
        "KHR_materials_diffuse_transmission"],
        "images": [{{"uri": "a.png"}}, {{"uri": "b.png"}}], "textures": [{{"source": 0}}, {{"source": 1}}],
        "materials": [{{"extensions": {{
            "KHR_materials_anisotropy": {{"anisotropyStrength": 0.5, "anisotropyRotation": 1, "anisotropyTexture": {{"index": 0}}}},
            "KHR_materials_clearcoat": {{"clearcoatFactor": 1, "clearcoatNormalTexture": {{"index": 1, "scale": 0.25}}}},
            "KHR_materials_dispersion": {{"dispersion": 0.3}},
            "KHR_materials_diffuse_transmission": {{"diffuseTransmissionFactor": 0.75, "diffuseTransmissionTexture": {{"index": 0}},
                "diffuseTransmissionColorFactor": [1, 0.5, 0], "diffuseTransmissionColorTexture": {{"index": 1}}}}}}}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}], "nodes": [{{"mesh": 0}}]"#
    );
    let model = read(&rest).unwrap();
    let surface = &model.materials[0].surface;
    // Of the second image colours and raw numbers are read.
    let (first, raw, colors) = (TextureId(1), TextureId(0), TextureId(2));
    assert_eq!(surface.anisotropy, Scalar::Texture(first, Channel::B, 0.5));
    assert!(matches!(surface.anisotropy_direction, Some(Color::Texture(id)) if id == first));
    let coat = surface.clearcoat_normal.expect("a normal map");
    assert!(matches!(coat.color, Color::Texture(id) if id == raw) && coat.scale == 0.25);
    assert_eq!(surface.dispersion, 0.3);
    assert_eq!(surface.diffuse_transmission, Scalar::Texture(first, Channel::A, 0.75));
    let passed = Rgb::new(1.0, 0.5, 0.0);
    assert!(matches!(surface.diffuse_transmission_color, Color::Tinted(id, tint) if id == colors && tint == passed));
    let losses: Vec<String> = model.features.iter().filter_map(ModelFeature::loss).collect();
    assert!(losses.is_empty(), "{losses:?}");
}

#[test]
fn the_soft_edge_of_a_spot_of_blender_is_a_part_of_the_cosine() {
    let rest = r#""extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 683,
        "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.4}}]}},
        "nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}}]"#;
    let spot = |generator: &str| {
        let text = format!(r#"{{"asset": {{"version": "2.0", "generator": "{generator}"}}, {rest}}}"#);
        let choice = ModelChoice::default();
        let model = parse(text.as_bytes(), Path::new("a.gltf"), &choice, &Files::default()).expect("sound");
        let ModelLightKind::Spot { inner, .. } = model.lights[0].kind else {
            panic!("a spot");
        };
        (model.lights[0].strength.r, inner)
    };
    assert_eq!(spot("another"), (683.0, 0.3));
    let (strength, inner) = spot("Khronos glTF Blender I/O v4.2.0");
    // A blend of 1 - 0.3 / 0.4 of what the cone takes off the cosine.
    let part = (1.0 - libm::cos(inner)) / (1.0 - libm::cos(0.4));
    assert!(strength == 1.0 && (part - 0.25 - 0.5).abs() < 1e-9, "{strength} {part}");
}

/// A file with a triangle whose attribute `name` has these bytes in an accessor.
fn with_attribute(name: &str, accessor: &str, bytes: &[u8]) -> String {
    let base64 = |bytes: &[u8]| {
        const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let group = |chunk: &[u8]| {
            let bits = (0..3).fold(0_u32, |bits, i| bits << 8 | u32::from(*chunk.get(i).unwrap_or(&0)));
            (0..4)
                .map(|i| char::from(LETTERS[(bits >> (18 - 6 * i) & 63) as usize]))
                .take(chunk.len() + 1)
                .collect::<String>()
        };
        bytes.chunks(3).map(group).collect::<String>()
    };
    let positions: Vec<u8> = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .into_iter()
        .flat_map(f32::to_le_bytes)
        .collect();
    let all = [&positions[..], bytes].concat();
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {0}, "uri": "data:;base64,{1}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": {2}}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}},
        {{"bufferView": 1, "count": 3, {accessor}}}], "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "{name}": 1}}}}]}}]}}"#,
        all.len(),
        base64(&all),
        bytes.len()
    )
}

fn parsed(json: &str) -> Result<Model, String> {
    parse(
        json.as_bytes(),
        Path::new("a.gltf"),
        &ModelChoice::default(),
        &Files::default(),
    )
    .map_err(|e| e.to_string())
}

#[test]
fn colors_of_types_that_the_format_forbids_are_read_by_their_type_and_said() {
    let of = |accessor: &str, bytes: &[u8]| {
        let model = parsed(&with_attribute("COLOR_0", accessor, bytes)).unwrap();
        (model.meshes[0].colors[0].x, model.faults)
    };
    let bytes = [255_u8, 0, 0, 255].repeat(3);
    let (red, faults) = of(r#""componentType": 5121, "type": "VEC4""#, &bytes);
    assert_eq!((red, faults.len()), (1.0, 1), "{faults:?}");
    assert!(faults[0].contains("type that the format forbids"), "{faults:?}");
    let (red, faults) = of(r#""componentType": 5121, "normalized": true, "type": "VEC4""#, &bytes);
    assert_eq!((red, faults.len()), (1.0, 0), "{faults:?}");
    let wide: Vec<u8> = [u32::MAX, 0, 0]
        .repeat(3)
        .into_iter()
        .flat_map(u32::to_le_bytes)
        .collect();
    let (red, faults) = of(r#""componentType": 5125, "type": "VEC3""#, &wide);
    assert_eq!((red, faults.len()), (1.0, 1), "{faults:?}");
    let floats = |v: f32| {
        [v, 0.0, 0.0]
            .repeat(3)
            .into_iter()
            .flat_map(f32::to_le_bytes)
            .collect::<Vec<u8>>()
    };
    for (v, shown) in [(-7.0, 0.0), (40.0, 1.0), (f32::NAN, 1.0)] {
        let (red, faults) = of(r#""componentType": 5126, "type": "VEC3""#, &floats(v));
        assert_eq!(red, shown);
        assert!(
            faults.iter().any(|f| f.contains("not between 0 and 1")),
            "{v}: {faults:?}"
        );
    }
    let coordinates: Vec<u8> = [7_u8; 12].to_vec();
    let model = parsed(&with_attribute(
        "TEXCOORD_0",
        r#""componentType": 5121, "type": "VEC2""#,
        &coordinates,
    ));
    assert!(model.is_ok_and(|m| m.faults.iter().any(|f| f.contains("TEXCOORD_0"))));
}

#[test]
fn tangents_and_normals_that_are_none_cost_themselves() {
    let tangents: Vec<u8> = [f32::NAN, 0.0, 0.0, 1.0]
        .repeat(3)
        .into_iter()
        .flat_map(f32::to_le_bytes)
        .collect();
    let json = with_attribute("TANGENT", r#""componentType": 5126, "type": "VEC4""#, &tangents);
    assert_eq!(parsed(&json).unwrap().meshes.len(), 1);
    let normals: Vec<u8> = [f32::NAN; 9].into_iter().flat_map(f32::to_le_bytes).collect();
    let json = with_attribute("NORMAL", r#""componentType": 5126, "type": "VEC3""#, &normals);
    assert_eq!(parsed(&json).unwrap().meshes[0].normals, [crate::math::Vec3::ZERO; 3]);
}

#[test]
fn errors_of_the_json_name_the_place_and_empty_files_are_called_so() {
    let json = r#"{"asset": {"version": "2.0"}, "meshes": [{"primitives": [{"attributes": 7}]}]}"#;
    let message = parsed(json).unwrap_err();
    assert!(message.contains("meshes[0].primitives[0].attributes"), "{message}");
    assert!(parsed("").unwrap_err().contains("the file is empty"));
    assert!(parsed("{").unwrap_err().contains("line 1"));
    assert!(parsed("solid of another format").unwrap_err().contains("header"));
}

#[test]
fn lights_that_cannot_be_are_faults() {
    let faults = |light: &str| {
        let json = format!(
            r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {{"KHR_lights_punctual": {{"lights": [{light}]}}}}}}"#
        );
        parsed(&json).unwrap().faults
    };
    assert!(faults(r#"{"type": "point", "intensity": -1}"#)[0].contains("below 0"));
    assert!(faults(r#"{"type": "spot", "spot": {"innerConeAngle": 0.6, "outerConeAngle": 0.2}}"#)[0].contains("cone"));
    assert!(faults(r#"{"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}}"#).is_empty());
    let unknown = faults(r#"{"type": "area"}"#);
    assert_eq!(unknown, ["light 0 is of an unknown type, `area`, and is left out"]);
}
