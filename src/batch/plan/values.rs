//! The values of a job that change from frame to frame: of a table, of the camera path, and those that are drawn at random.

use std::{borrow::Cow, collections::HashMap, path::Path, sync::Arc};

use crate::{
    assets::{
        Files, Store,
        camera_path::{self, CameraPathFormat, ValueColumns, load_values},
    },
    batch::{DenoiseOptions, Request},
    compile,
    describe::{RandomDesc, SceneDesc, ValueFile, ValueSource, Values},
    error::Error,
};

/// Reads the sources of values of a job: those of the scene file `scene`, or of a model by itself, which has
/// its path alone, and of the request.
pub(in crate::batch) fn tables(
    scene: Result<&SceneDesc, &Path>,
    request: &Request,
    inputs: &Files,
) -> Result<Vec<ValueSource>, Error> {
    let options = request.path_options(None);
    let of_scene = scene.ok().and_then(|desc| Some((desc, desc.values.as_ref()?)));
    let of_scene = of_scene.map(|(desc, file)| desc.folder().join(file.get_ref()));
    let table = request
        .values
        .clone()
        .or(of_scene)
        .map(|path| (path, ValueColumns::All));
    let camera_path = request
        .camera_path
        .clone()
        .filter(|path| CameraPathFormat::of_path(path).is_none_or(CameraPathFormat::holds_values))
        .map(|path| (path, ValueColumns::BesideCamera));
    let mut sources = Vec::new();
    for (path, which) in table.into_iter().chain(camera_path) {
        let table = load_values(&path, which, &options, inputs);
        if which == ValueColumns::BesideCamera && table.is_err() {
            // Errors of the path itself come first.
            camera_path::load(&path, None, &options, inputs)?;
        }
        let table = table?;
        if !table.columns.is_empty() {
            sources.push(ValueSource::Table(ValueFile { path, table }));
        }
    }
    let random = match (&request.random, scene) {
        (Some(path), _) => Some(RandomDesc::load(path, &request.overrides, |path| inputs.read(path))?),
        (None, Ok(desc)) => desc.random.clone(),
        (None, Err(model)) => {
            let own = RandomDesc::of_overrides(model, &request.overrides);
            Some(own.map_err(Error::Invalid)?)
        }
    };
    // Frames are there also if the last draw is taken out.
    let random = random.filter(|random| !random.draws.is_empty() || !random.left_out.is_empty());
    sources.extend(random.map(|random| ValueSource::Random(Arc::new(random))));
    Ok(sources)
}

/// The sources with a draw for each node and each material of the model at `path` that a `*` stands for.
pub(in crate::batch) fn of_parts(
    sources: Vec<ValueSource>,
    path: &Path,
    store: &Store,
) -> Result<Vec<ValueSource>, Error> {
    let mut names: Option<[Vec<String>; 2]> = None;
    let mut own = |source: ValueSource| match source {
        ValueSource::Random(random) if random.has_wildcards() => {
            let [nodes, materials] = match &mut names {
                Some(names) => names,
                names => names.insert(store.names_of_parts(path).map_err(compile::Error::from)?),
            };
            Ok(ValueSource::Random(Arc::new(random.of_parts(nodes, materials))))
        }
        other => Ok(other),
    };
    sources.into_iter().map(&mut own).collect()
}

/// The request of a job with these sources. Frames whose values are drawn each by itself do not help to denoise each other.
pub(in crate::batch) fn independent<'r>(request: &'r Request, sources: &[ValueSource]) -> Cow<'r, Request> {
    let are_drawn = sources.iter().any(|source| matches!(source, ValueSource::Random(_)));
    let mut request = Cow::Borrowed(request);
    if are_drawn && request.denoise.is_some() {
        request.to_mut().denoise = request.denoise.clone().map(|own| DenoiseOptions { temporal: 0, ..own });
    }
    request
}

/// The values of these sources, if there are any.
pub(in crate::batch) fn values(desc: &SceneDesc, sources: &[ValueSource]) -> Result<Option<Arc<Values>>, Error> {
    if sources.is_empty() {
        return Ok(None);
    }
    let mut known = HashMap::new();
    for source in sources {
        for name in source.names() {
            if let Some(other) = known.insert(name, source.path()) {
                return Err(Error::SetTwice {
                    path: source.path().to_owned(),
                    name: name.to_owned(),
                    other: other.display().to_string(),
                    is_drawn: matches!(source, ValueSource::Random(_)),
                });
            }
        }
    }
    Ok(Some(Arc::new(Values::new(desc, sources)?)))
}
