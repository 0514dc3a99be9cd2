//! The films that EXR files hold.

use std::sync::Arc;

use crate::{
    batch::Plan,
    film::{
        Film, FilmLayout, PlaneSpec,
        passes::{BEAUTY, DEFAULT_GROUP, GROUP_PREFIX},
    },
    output::{ExrFile, Numbers, Value},
    value::UnknownName,
};

/// The beauty of a file.
pub(super) fn picture(file: &ExrFile) -> Film {
    film(file, &FilmLayout::default())
}

/// All passes of a file that `plan` has rendered.
///
/// # Errors
/// A pass shows a light group whose light the file does not hold.
pub(super) fn all_passes(file: &ExrFile, plan: &Plan) -> Result<Film, UnknownName> {
    let layout = plan.picture.settings.film_layout(BEAUTY, &light_groups(file))?;
    let layout = layout.with_matte_tables(|plane| file.mattes(&plane.name).map(Arc::new));
    Ok(film(file, &layout))
}

/// The names of the light groups whose light a file holds.
fn light_groups(file: &ExrFile) -> Vec<String> {
    let layers = file
        .planes()
        .filter_map(|plane| plane.name.strip_prefix(GROUP_PREFIX)?.strip_suffix(".R"));
    let name = |layer: &str| if layer == DEFAULT_GROUP { "" } else { layer }.to_owned();
    layers.map(name).collect()
}

/// A film with the numbers of a file; passes that the file does not hold are empty.
fn film(file: &ExrFile, layout: &FilmLayout) -> Film {
    let part = &file.parts[0];
    let resolution = [part.display.width(), part.display.height()];
    let mut film = Film::new(resolution, part.data, layout);
    if let Some(Value::Int(samples)) = file.attribute("batch-render/samples") {
        film.samples = samples.unsigned_abs();
    }
    for (i, spec) in layout.planes().iter().enumerate() {
        for (channel, name) in spec.channel_names().iter().enumerate() {
            if let Some(plane) = file.planes().find(|plane| plane.name == *name) {
                put(film.values_mut(i), spec, channel, &plane.numbers);
            }
        }
    }
    film
}

/// Puts the numbers of a channel into the values of its plane.
fn put(values: &mut [f32], spec: &PlaneSpec, channel: usize, numbers: &Numbers) {
    let step = spec.step();
    let layer = values.len() / (spec.width() / step);
    let places = values[channel / step * layer..]
        .iter_mut()
        .skip(channel % step)
        .step_by(step);
    match numbers {
        Numbers::Half(numbers) | Numbers::Float(numbers) => {
            places.zip(numbers).for_each(|(place, number)| *place = *number);
        }
        Numbers::Uint(numbers) => places
            .zip(numbers)
            .for_each(|(place, bits)| *place = f32::from_bits(*bits)),
    }
}
