//! Every colour of the manual pages of materials, textures and lights is converted to a working space.

use std::{fmt::Debug, fs};

use crate::{
    light::{LightDesc, LightFind, ProfileId},
    material::{Find, MaterialDesc, MaterialId},
    math::{ColorConversion, DVec3, Primaries, Rgb, Vec2, Vec3, WorkingSpace},
    texture::{
        BitmapId, Color, FindSources, Mapping, Pattern, PatternDesc, Texture, TextureId, TexturePoint, Textures,
        constant::Constant,
    },
    value::{ColorSource, Spanned},
};

/// Examples of colours that the first examples of the manual pages cannot hold.
const EXAMPLES: &[&str] = &[
    "rect = { position = [0, 1, 0], direction = [0, -1, 0], size = [1, 1], radiance = 1 }",
    "disk = { position = [0, 1, 0], direction = [0, -1, 0], radius = 1, radiance = 1 }",
    "sphere = { position = [0, 1, 0], radius = 1, radiance = 1 }",
    "tube = { from = [0, 1, 0], to = [0, 2, 0], radius = 1, radiance = 1 }",
    "point = { position = [0, 1, 0], power = 1 }",
    "spot = { position = [0, 1, 0], direction = [0, -1, 0], cone_angle = 9, power = 1 }",
    "metal = { eta = 0.2, k = 3 }",
    "glass = { ior = 1.5 }",
    "glass = { attenuation_color = 0.5, attenuation_distance = 1 }",
    "principled = { base_color = 1, transmission = 1, thickness = 1, attenuation_color = 0.5, attenuation_distance = 1 }",
];

/// Returns the numbers in the debug text of a kind, before and after the conversion of its colours.
fn before_and_after<T: Debug>(mut kind: T, convert: impl Fn(&mut T)) -> [Vec<String>; 2] {
    let before = numbers(&kind);
    convert(&mut kind);
    [before, numbers(&kind)]
}

fn numbers(kind: &impl Debug) -> Vec<String> {
    let text = format!("{kind:?}");
    let parts = text.split(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)));
    parts
        .filter(|part| part.parse::<f64>().is_ok())
        .map(str::to_owned)
        .collect()
}

/// Compiles a description of a room; `None` if it is not valid.
fn compiled(room: &str, text: &str) -> Option<[Vec<String>; 2]> {
    let space = WorkingSpace::AcesCg;
    let color = |source: &Spanned<ColorSource>| {
        Ok(match source.get_ref() {
            ColorSource::Constant(color) => Color::Constant(*color),
            _ => Color::Texture(TextureId(0)),
        })
    };
    match room {
        "material" => {
            let find = Find {
                color: &color,
                directions: &color,
                material: &|_| Ok(MaterialId(0)),
            };
            let material = toml::from_str::<MaterialDesc>(text).ok()?.compile(&find).ok()?;
            Some(before_and_after(material, |m| m.convert_colors(space)))
        }
        "texture" => {
            let pattern = toml::from_str::<PatternDesc>(text).ok()?;
            let find = FindSources {
                bitmap: &|_| Ok(BitmapId(0)),
                color: &color,
            };
            let pattern = pattern.compile(&find).ok()?;
            // Patterns keep their colours: what is looked up in them is converted.
            let convert = |colors: &mut Vec<Rgb>| {
                let conversion = ColorConversion::new(Primaries::default(), space);
                colors.iter_mut().for_each(|c| *c = conversion.convert(*c));
            };
            let places = (0..64).map(|i| Vec2::new((i % 8) as f32, (i / 8) as f32) / 8.0);
            let texture = Texture::new(Mapping::Uv, pattern);
            let gray = Constant { color: Rgb::gray(0.5) };
            let gray = Texture::new(Mapping::Uv, Pattern::Constant(gray));
            let textures = Textures {
                textures: &[gray],
                bitmaps: &[],
            };
            let at = |uv| TexturePoint {
                uv,
                ..TexturePoint::new(Vec3::ZERO, Vec3::Z)
            };
            let colors: Vec<Rgb> = places.map(|uv| texture.eval(&textures, &at(uv))).collect();
            Some(before_and_after(colors, convert))
        }
        _ => {
            let light = {
                let find = LightFind {
                    profile: &|_| Ok(ProfileId(0)),
                    ..LightFind::nothing(DVec3::ZERO)
                };
                toml::from_str::<LightDesc>(text).ok()?.compile(&find).ok()?
            };
            Some(before_and_after(light, |l| l.convert_colors(space)))
        }
    }
}

fn page(room: &str, kind: &str) -> String {
    let path = format!("{}/src/{room}/{kind}.rs", env!("CARGO_MANIFEST_DIR"));
    fs::read_to_string(path).expect("a kind has a file of its own")
}

/// The keys of a manual page whose type is a colour.
fn color_keys(page: &str) -> Vec<String> {
    let mut keys = Vec::new();
    for row in page.lines().filter_map(|line| line.strip_prefix("//! | ")) {
        let Some((names, meaning)) = row.split_once(" | ") else {
            continue;
        };
        if meaning.contains("`[r, g, b]`") || meaning.starts_with("colour") {
            keys.extend(names.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    keys
}

/// The examples of a kind as tables of keys.
fn tables(page: &str, kind: &str) -> Vec<toml::Table> {
    let start = format!("{kind} = {{");
    let lines = page.lines().filter_map(|line| line.strip_prefix("//! "));
    let examples = lines
        .chain(EXAMPLES.iter().copied())
        .filter(|line| line.starts_with(&start));
    let table = |line: &str| toml::from_str::<toml::Table>(line).ok()?.get(kind)?.as_table().cloned();
    examples.filter_map(table).collect()
}

/// The numbers of a kind in which `key` is a colour.
fn with_color(room: &str, kind: &str, table: &toml::Table, key: &str, color: [f64; 3]) -> Option<[Vec<String>; 2]> {
    let mut table = table.clone();
    table.insert(key.to_owned(), color.to_vec().into());
    let text = toml::Table::from_iter([(kind.to_owned(), table.into())]);
    compiled(room, &toml::to_string(&text).ok()?)
}

/// Returns whether the example shows `key`, after it saw that each number that depends on the colour is converted.
fn is_converted(room: &str, kind: &str, table: &toml::Table, key: &str) -> bool {
    let [a, b] = [[0.9, 0.2, 0.4], [0.3, 0.7, 0.6]].map(|color| with_color(room, kind, table, key, color));
    let (Some([before, after]), Some([other, _])) = (a, b) else {
        return false;
    };
    // Some kinds convert to another form, with other numbers.
    let has_one_form = before.len() == after.len();
    for i in (0..before.len()).filter(|i| has_one_form && before[*i] != other[*i]) {
        assert_ne!(before[i], after[i], "`{key}` of {room} `{kind}` is not converted");
    }
    before != other
}

#[test]
fn every_color_of_every_kind_is_converted_to_the_working_space() {
    let rooms = [
        ("material", MaterialDesc::NAMES),
        ("texture", PatternDesc::NAMES),
        ("light", LightDesc::NAMES),
    ];
    let mut count = 0;
    for (room, kinds) in rooms {
        for kind in kinds {
            let page = page(room, kind);
            let tables = tables(&page, kind);
            for key in color_keys(&page) {
                let shown = tables.iter().filter(|t| is_converted(room, kind, t, &key)).count();
                assert!(shown > 0, "no example of {room} `{kind}` can hold the colour `{key}`");
                count += 1;
            }
        }
    }
    assert!(count > 20, "{count} colours");
}
