//! The layer of an EXR file that is its picture.
//!
//! A layer is the channels of one part whose names begin alike: `diffuse.R`, `diffuse.G`, `diffuse.B`. Of several with colours the
//! one counts that is named as programs name the light of a picture.

use std::collections::BTreeMap;

use ::exr::meta::header::Header;

use crate::assets::image::error::ImageProblem;
use crate::value::one_line;

/// The names of a picture's light, the most telling first. The empty one is that of plain `R`, `G`, `B`.
const LIGHT: [&str; 11] = [
    "",
    "rgba",
    "rgb",
    "beauty",
    "combined",
    "composite",
    "color",
    "colour",
    "image",
    "main",
    "master",
];

/// The channels of a picture: three or four colours, or a gray one.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct ShownChannels {
    /// An index into the parts.
    pub part: usize,
    /// Indices into the part's channels.
    pub channels: Vec<usize>,
}

/// A layer by its name.
struct NamedLayer {
    name: String,
    shown: ShownChannels,
}

/// Chooses the channels of the picture.
pub(super) fn choose(headers: &[Header]) -> Result<ShownChannels, ImageProblem> {
    let (mut colors, mut grays, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for (part, header) in headers.iter().enumerate() {
        let own_name = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
        let mut layers: BTreeMap<String, Vec<(String, usize)>> = BTreeMap::new();
        for (i, channel) in header.channels.list.iter().enumerate() {
            let name = channel.name.to_string();
            let (layer, last) = name.rsplit_once('.').unwrap_or(("", &name));
            layers
                .entry(layer.to_owned())
                .or_default()
                .push((last.to_uppercase(), i));
            all.push((part, i));
        }
        for (layer, channels) in layers {
            let name = match own_name.as_deref().unwrap_or_default() {
                "" => layer,
                own if layer.is_empty() => own.to_owned(),
                own => format!("{own}.{layer}"),
            };
            let find = |wanted: &str| channels.iter().find(|(last, _)| last == wanted).map(|(_, i)| *i);
            let named = |channels: Vec<usize>| NamedLayer {
                name: name.clone(),
                shown: ShownChannels { part, channels },
            };
            match (find("R"), find("G"), find("B"), find("Y")) {
                (Some(r), Some(g), Some(b), _) => {
                    colors.push(named([r, g, b].into_iter().chain(find("A")).collect()));
                }
                (_, _, _, Some(y)) => grays.push(named(vec![y])),
                _ => {}
            }
        }
    }
    let layers = if colors.is_empty() { grays } else { colors };
    match (layers.is_empty(), &all[..]) {
        (false, _) => of_light(layers),
        (true, &[(part, channel)]) => Ok(ShownChannels {
            part,
            channels: vec![channel],
        }),
        (true, _) => Err(ImageProblem::broken("no channels R, G, B or Y")),
    }
}

/// The one that is light, by its name; the first of several of one name, as of stereo views.
fn of_light(layers: Vec<NamedLayer>) -> Result<ShownChannels, ImageProblem> {
    let rank = |layer: &NamedLayer| {
        let last = layer.name.rsplit('.').next().unwrap_or_default().to_lowercase();
        LIGHT.iter().position(|known| *known == last)
    };
    let names: Vec<String> = layers.iter().map(|l| format!("`{}`", one_line(&l.name, 80))).collect();
    let is_alone = layers.len() == 1;
    let best = layers.into_iter().min_by_key(|l| rank(l).unwrap_or(LIGHT.len()));
    match best {
        Some(layer) if is_alone || rank(&layer).is_some() => Ok(layer.shown),
        _ => Err(ImageProblem::broken(format!(
            "it has several layers ({}), and none of them is named as light is ({})",
            names.join(", "),
            LIGHT[1..].join(", ")
        ))),
    }
}

#[cfg(test)]
mod tests {
    use ::exr::meta::attribute::{ChannelDescription, SampleType, Text};

    use super::*;

    /// A part of this name with these channels, in the order of files.
    fn part(name: &str, channels: &[&str]) -> Header {
        let mut names = channels.to_vec();
        names.sort_unstable();
        let channel = |name: &&str| ChannelDescription::named(*name, SampleType::F16);
        Header::new(Text::from(name), (1, 1), names.iter().map(channel).collect())
    }

    fn shown(parts: &[Header]) -> Result<(usize, Vec<String>), String> {
        let shown = choose(parts).map_err(|e| e.at(std::path::Path::new("a.exr")).to_string())?;
        let name = |i: &usize| parts[shown.part].channels.list[*i].name.to_string();
        Ok((shown.part, shown.channels.iter().map(name).collect()))
    }

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|n| (*n).to_owned()).collect()
    }

    #[test]
    fn the_layer_of_light_is_found_by_its_name() {
        let rgb = ["R", "G", "B"];
        let depth_first = [part("depth", &["Z"]), part("anything", &rgb)];
        assert_eq!(shown(&depth_first), Ok((1, names(&rgb))));
        let own = [part(
            "",
            &[
                "R", "G", "B", "A", "albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y", "N.Z",
            ],
        )];
        assert_eq!(shown(&own), Ok((0, names(&["R", "G", "B", "A"]))));
        let blender = [part(
            "",
            &[
                "ViewLayer.Albedo.R",
                "ViewLayer.Albedo.G",
                "ViewLayer.Albedo.B",
                "ViewLayer.Combined.R",
                "ViewLayer.Combined.G",
                "ViewLayer.Combined.B",
            ],
        )];
        let combined = ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"];
        assert_eq!(shown(&blender), Ok((0, names(&combined))));
        let parts = [part("normal", &rgb), part("Beauty", &rgb)];
        assert_eq!(shown(&parts), Ok((1, names(&rgb))));
        assert_eq!(shown(&[part("", &["Y"])]), Ok((0, names(&["Y"]))));
        assert_eq!(shown(&[part("", &["height"])]), Ok((0, names(&["height"]))));
    }

    #[test]
    fn layers_of_which_none_is_light_are_listed() {
        let rgb = ["R", "G", "B"];
        let error = shown(&[part("left", &rgb), part("right", &rgb)]).unwrap_err();
        assert!(error.contains("several layers (`left`, `right`), and none"), "{error}");
        let error = shown(&[part("depth", &["Z"]), part("ids", &["id"])]).unwrap_err();
        assert!(error.contains("no channels R, G, B or Y"), "{error}");
    }
}
