//! The passes of two EXR files, one beside the other.

use std::path::Path;

use serde::Serialize;

use crate::assets::{
    Files,
    image::{self, ImageError, ImagePass, PassChannel},
};

/// How far a pass is from that of the reference. All are 0 for equal passes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PassMeasures {
    /// The root of the mean squared difference of a number; `None` for ids.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rmse: Option<f64>,
    /// The largest difference of a number; `None` for ids.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest: Option<f64>,
    /// The share of pixels of which a number is farther away than the limit, or an id differs.
    pub pixels: f64,
}

/// A pass of one of two files, or of both.
#[derive(Clone, Debug)]
pub struct ComparedPass {
    pub name: String,
    /// The measures, or why there are none.
    pub measures: Result<PassMeasures, &'static str>,
}

/// Compares the passes of the EXR files `test` and `reference`, those of `names` or all. Files of other formats have none.
///
/// # Errors
/// A file cannot be read.
pub fn compare_passes(
    [reference, test]: [&Path; 2],
    names: &[String],
    limit: f64,
    files: &Files,
) -> Result<Vec<ComparedPass>, ImageError> {
    let [references, tests] = [image::passes(reference, files)?, image::passes(test, files)?];
    let (Some(references), Some(tests)) = (references, tests) else {
        return Ok(Vec::new());
    };
    let find = |passes: &[ImagePass], name: &str| passes.iter().position(|pass| pass.name == name);
    let mut all: Vec<&str> = match names {
        [] => references.iter().chain(&tests).map(|pass| &pass.name[..]).collect(),
        names => names.iter().map(String::as_str).collect(),
    };
    all.sort_unstable();
    all.dedup();
    let compared = all.into_iter().map(|name| {
        let measures = match (find(&references, name), find(&tests, name)) {
            (Some(a), Some(b)) => measures(&references[a], &tests[b], limit),
            (Some(_), None) => Err("the pass is missing"),
            (None, Some(_)) => Err("the reference has no such pass"),
            (None, None) => Err("neither file has such a pass"),
        };
        ComparedPass {
            name: name.to_owned(),
            measures,
        }
    });
    Ok(compared.collect())
}

fn measures(reference: &ImagePass, test: &ImagePass, limit: f64) -> Result<PassMeasures, &'static str> {
    if reference.window != test.window {
        return Err("the passes differ in size");
    }
    let kinds = |pass: &ImagePass| -> Vec<(String, bool)> {
        let kinds = pass
            .channels
            .iter()
            .map(|channel| (channel.name.clone(), channel.is_id));
        kinds.collect()
    };
    if kinds(reference) != kinds(test) {
        return Err("the passes differ in channels");
    }
    // Coverages of Cryptomatte belong to their ids.
    let is_of_ids = reference.channels.iter().any(|channel| channel.is_id);
    let pairs: Vec<(&PassChannel, &PassChannel)> = reference
        .channels
        .iter()
        .zip(&test.channels)
        .filter(|(channel, _)| channel.is_id == is_of_ids)
        .collect();
    let pixels = reference.channels.first().map_or(0, |channel| channel.bits.len());
    let (mut beyond, mut squares, mut largest) = (0_u64, 0.0, 0.0_f64);
    for i in 0..pixels {
        let mut differs = false;
        for (a, b) in &pairs {
            let [a, b] = [a.bits[i], b.bits[i]];
            // Equal numbers that are not finite do not differ.
            if a == b {
                continue;
            }
            let difference = match is_of_ids {
                true => f64::INFINITY,
                false => (f64::from(f32::from_bits(a)) - f64::from(f32::from_bits(b))).abs(),
            };
            let difference = if difference.is_nan() { f64::INFINITY } else { difference };
            differs |= difference > limit;
            squares += difference * difference;
            largest = largest.max(difference);
        }
        beyond += u64::from(differs);
    }
    let count = |n: usize| n.max(1) as f64;
    let of_numbers = |value: f64| Some(value).filter(|_| !is_of_ids);
    Ok(PassMeasures {
        rmse: of_numbers((squares / count(pixels * pairs.len())).sqrt()),
        largest: of_numbers(largest),
        pixels: beyond as f64 / count(pixels),
    })
}
