//! All passes of an EXR file.
//!
//! A pass is the channels of a part whose names begin alike: `albedo.R`, `albedo.G`, `albedo.B`. A channel without a point in its
//! name is a pass of its own, but for `R`, `G`, `B` and `A`, which are one without a name.

use std::collections::BTreeMap;

use ::exr::image::{AnyChannels, FlatSamples, Layer};

/// A pass.
#[derive(Clone, Debug)]
pub struct ImagePass {
    /// The name of its part, if that has one, and the beginning of the names of its channels.
    pub name: String,
    /// The first column and row, and the numbers of columns and rows.
    pub window: [i64; 4],
    /// In the order of the file.
    pub channels: Vec<PassChannel>,
}

/// A channel of a pass.
#[derive(Clone, Debug)]
pub struct PassChannel {
    /// The end of its name.
    pub name: String,
    /// Whether its numbers are names: whole numbers, and the ids of Cryptomatte.
    pub is_id: bool,
    /// The bits of each whole number, or of each 32-bit float.
    pub bits: Vec<u32>,
}

/// The passes of the parts of a file, by their names.
pub(super) fn of_parts(parts: impl IntoIterator<Item = Layer<AnyChannels<FlatSamples>>>) -> Vec<ImagePass> {
    let mut passes: BTreeMap<String, ImagePass> = BTreeMap::new();
    for layer in parts {
        let part = layer.attributes.layer_name.as_ref().map(ToString::to_string);
        let part = part.unwrap_or_default();
        let (position, size) = (layer.attributes.layer_position, layer.size);
        let window = [position.0.into(), position.1.into(), size.0 as i64, size.1 as i64];
        for channel in layer.channel_data.list {
            let whole = channel.name.to_string();
            let (pass, name) = match whole.rsplit_once('.') {
                Some((pass, name)) => (pass, name),
                None if ["R", "G", "B", "A"].contains(&&*whole) => ("", &*whole),
                None => (&*whole, &*whole),
            };
            let (bits, is_whole): (Vec<u32>, bool) = match channel.sample_data {
                FlatSamples::F16(v) => (v.iter().map(|v| v.to_f32().to_bits()).collect(), false),
                FlatSamples::F32(v) => (v.iter().map(|v| v.to_bits()).collect(), false),
                FlatSamples::U32(v) => (v, true),
            };
            let channel = PassChannel {
                is_id: is_whole || pass.starts_with("Crypto") && ["R", "B"].contains(&name),
                name: name.to_owned(),
                bits,
            };
            let name = match [&part[..], pass] {
                ["", pass] => pass.to_owned(),
                [part, pass] if pass.is_empty() || part == pass => part.to_owned(),
                [part, pass] => format!("{part}.{pass}"),
            };
            let known = passes.entry(name).or_insert_with_key(|name| ImagePass {
                name: name.clone(),
                window,
                channels: Vec::new(),
            });
            known.channels.push(channel);
        }
    }
    passes.into_values().collect()
}
