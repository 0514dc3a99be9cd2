//! The scenes of a job's frames.

use std::{collections::BTreeSet, sync::Arc};

use crate::{
    accel::BuildOptions,
    assets::{MemoryKind, Store},
    compile::{self, Change, LastPoses, LoadOptions, Refresher, SceneMotion},
    describe::{Entity, FrameTime, MovingDesc, PartsDesc, SceneDesc, Values},
    error::Error,
    math::{DVec3, sorting},
    scene::Scene,
};

/// The source of the scenes that a job renders. [`Scenes::seek`] gives the scene of a frame, which depends on the frame alone and
/// never on those that were sought before.
pub struct Scenes<'j> {
    scene: Arc<Scene>,
    moving: Option<Moving<'j>>,
}

/// The inputs from which scenes of other times are compiled.
pub(super) struct SceneSource<'j> {
    pub desc: &'j SceneDesc,
    /// The description and the values of which the scene was compiled, where these are not those of the file.
    pub first: Option<&'j (SceneDesc, Vec<String>)>,
    pub store: &'j Store,
    pub accel: BuildOptions,
    /// The motion of the models of the scene, which was compiled for the time of [`load_options`].
    pub motion: Arc<SceneMotion>,
    pub fps: f64,
}

/// A scene whose values change over time, or whose models play animations.
struct Moving<'j> {
    source: SceneSource<'j>,
    values: Option<(&'j Values, MovingDesc<'j>)>,
    options: LoadOptions,
    refresher: Refresher,
    last: LastPoses,
    /// Whether the light of the background has changed since the scene was compiled.
    has_new_background: bool,
    /// The description of the scene that was sought last.
    desc: SceneDesc,
    state: State,
}

/// The values of the scene that was sought last.
enum State {
    /// Those of the scene file.
    Base,
    At(Vec<String>),
    /// Unknown: the scene is compiled again.
    Broken,
}

/// The options by which the scene of a job is loaded. `eye` is the first position of the camera,
/// `time` that of the animations in s.
pub(super) fn load_options(values: Option<&Values>, eye: Option<DVec3>, time: f64) -> LoadOptions {
    LoadOptions {
        eye,
        time,
        moved: values.map(Values::moved_objects).unwrap_or_default(),
        edited: values.map(Values::edited_parts).unwrap_or_default(),
        animated: values.map(|own| own.objects_with("animation")).unwrap_or_default(),
        varied: values.map(|own| own.objects_with("variant")).unwrap_or_default(),
        changes_materials: values.is_some_and(|values| {
            let is_of_material = |entity: Entity| matches!(entity, Entity::Material(_));
            values.keys().any(|(entity, _)| is_of_material(entity))
        }),
        ..LoadOptions::default()
    }
}

/// Whether some of these values change a scene so that it is compiled again.
pub(super) fn rebuilds(values: &Values) -> bool {
    values
        .keys()
        .any(|(entity, path)| change(entity, path) == Some(Change::Other))
}

/// The description of a scene at a time in frames with its values, if they fit together.
pub(super) fn moved_description(desc: &SceneDesc, values: &Values, frame: f64) -> Option<SceneDesc> {
    let (reader, frame) = (MovingDesc::new(desc, values), FrameTime::from(frame));
    let own = values.at(frame);
    let entities = sorting::ordered(reader.changed(None, &own).map(|(entity, _)| entity));
    let mut desc = desc.clone();
    reader.set(&mut desc, (frame, &own), &entities).ok()?;
    Some(desc)
}

/// The description of a scene at a time in frames with its values, where some of these change a scene so that it is
/// compiled again, and they fit together.
pub(super) fn description_at(
    desc: &SceneDesc,
    values: Option<&Values>,
    frame: f64,
) -> Option<(SceneDesc, Vec<String>)> {
    let values = values.filter(|values| rebuilds(values))?;
    Some((moved_description(desc, values, frame)?, values.at(frame)))
}

impl<'j> Scenes<'j> {
    /// The same scene for all frames.
    pub fn still(scene: impl Into<Arc<Scene>>) -> Self {
        Self {
            scene: scene.into(),
            moving: None,
        }
    }

    /// The scenes that `values` and animations make of `scene`, which was compiled of `source` by [`load_options`].
    pub(super) fn moving(scene: Arc<Scene>, source: SceneSource<'j>, values: Option<&'j Values>) -> Self {
        if values.is_none() && source.motion.is_still() {
            return Self::still(scene);
        }
        let options = LoadOptions {
            origin: Some(scene.origin),
            ..load_options(values, None, 0.0)
        };
        let (desc, state) = match source.first {
            Some((desc, own)) => (desc, State::At(own.clone())),
            None => (source.desc, State::Base),
        };
        let moving = Moving {
            values: values.map(|values| (values, MovingDesc::new(source.desc, values))),
            desc: desc.clone(),
            source,
            options,
            refresher: Refresher::default(),
            last: LastPoses::default(),
            has_new_background: false,
            state,
        };
        Self {
            scene,
            moving: Some(moving),
        }
    }

    /// Whether all frames have the same scene.
    pub fn is_still(&self) -> bool {
        self.moving.is_none()
    }

    /// The scene at a time, which may lie between two frames.
    ///
    /// # Errors
    /// There is no such scene: a value of this time does not fit the others, or a file that it names cannot be loaded.
    pub fn seek(&mut self, time: impl Into<FrameTime>) -> Result<&Scene, Error> {
        if let Some(moving) = &mut self.moving {
            moving.seek(&mut self.scene, time.into())?;
        }
        Ok(&self.scene)
    }

    /// Whether the scene is the same at all of these times.
    pub fn is_same(&self, mut times: impl Iterator<Item = FrameTime>) -> bool {
        self.is_still() || {
            let first = times.next().map(|time| self.moment(time));
            times.all(|time| first.as_ref() == Some(&self.moment(time)))
        }
    }

    /// The values that change over time, as they are at a time, and the times within the animations of models. Scenes of the same
    /// ones are the same.
    fn moment(&self, time: FrameTime) -> (Vec<String>, Vec<f32>) {
        let Some(moving) = &self.moving else {
            return Default::default();
        };
        let values = moving.values.as_ref().map(|(values, _)| values.at(time));
        let times = moving.source.motion.local_times(time.time / moving.source.fps);
        (values.unwrap_or_default(), times.collect())
    }

    /// The scene that was sought last. Its names and ids are those of all frames.
    pub fn current(&self) -> &Scene {
        &self.scene
    }

    /// The same scene for others. While they have it, [`Scenes::seek`] compiles another one.
    pub fn shared(&self) -> Arc<Scene> {
        Arc::clone(&self.scene)
    }

    /// Drops what a panic may have left inconsistent.
    pub(super) fn recover(&mut self) {
        if let Some(moving) = &mut self.moving {
            moving.state = State::Broken;
        }
    }
}

impl Moving<'_> {
    /// Makes `scene` that of a time.
    fn seek(&mut self, shared: &mut Arc<Scene>, time: FrameTime) -> Result<(), Error> {
        let old = match std::mem::replace(&mut self.state, State::Broken) {
            State::Base => Ok(None),
            State::At(old) => Ok(Some(old)),
            State::Broken => Err(()),
        };
        let (new, changes) = match &self.values {
            Some((values, reader)) => {
                let new = values.at(time);
                let known = old.as_ref().ok().and_then(|old| old.as_deref());
                let changed: Vec<_> = reader.changed(known, &new).collect();
                let entities: BTreeSet<Entity> = sorting::ordered(changed.iter().map(|(entity, _)| *entity));
                if !entities.is_empty() {
                    let set = reader.set(&mut self.desc, (time, &new), &entities);
                    set.map_err(|found| Error::Compile(compile::Error::Invalid(found)))?;
                }
                let changes = changed.iter().filter_map(|(entity, path)| change(*entity, path));
                (new, sorting::ordered(changes))
            }
            None => (Vec::new(), BTreeSet::new()),
        };
        self.options.time = time.time / self.source.fps;
        let store = self.source.store;
        let own = Arc::get_mut(shared).filter(|_| old.is_ok());
        let is_fresh = match own {
            Some(scene) => self.refresher.refresh(scene, &self.desc, &changes, store)? && self.play(scene),
            None => false,
        };
        self.has_new_background |= is_fresh && changes.contains(&Change::Background);
        if !is_fresh {
            store.files().memory().release(MemoryKind::Images);
            if let Some(scene) = Arc::get_mut(shared) {
                self.source.motion.keep_images(scene, store, self.has_new_background);
            }
            self.has_new_background = false;
            let (new, motion) = compile::moving_scene(&self.desc, self.source.accel, store, &self.options)?;
            (*shared, self.source.motion) = (Arc::new(new), Arc::new(motion));
            self.last = LastPoses::default();
        }
        self.state = State::At(new);
        Ok(())
    }

    /// Plays the animations of models up to the time of the options. Returns whether that was possible; if not, the scene is to be
    /// compiled again.
    fn play(&mut self, scene: &mut Scene) -> bool {
        let motion = &self.source.motion;
        if motion.is_still() {
            return true;
        }
        let Some((update, shading)) = motion.update(scene, &self.desc, self.options.time, &mut self.last) else {
            return false;
        };
        let has_moved = update.is_empty() || scene.apply(&update).is_ok();
        has_moved && (shading.is_empty() || scene.reshade(shading).is_ok())
    }
}

/// The change of the compiled scene where the key at `path` of an entity changes.
fn change(entity: Entity, path: &[String]) -> Option<Change> {
    let is = |step: usize, name: &str| path.get(step).is_some_and(|own| own == name);
    match entity {
        Entity::Material(_) if is(0, "back_faces") => Some(Change::Other),
        Entity::Material(at) => Some(Change::Material(at)),
        Entity::Light(_) if is(1, "ies") => Some(Change::Other),
        Entity::Light(at) => Some(Change::Light(at)),
        Entity::Background if is(0, "visible") => Some(Change::BackgroundVisible),
        Entity::Background if is(1, "rotate") => Some(Change::BackgroundRotation),
        Entity::Background if !is(1, "file") => Some(Change::Background),
        Entity::Object(at) if is(0, "transform") => Some(Change::Transform(at)),
        Entity::Object(at) if is(0, "material") => Some(Change::ObjectMaterial(at)),
        Entity::Object(_) if PartsDesc::is_of_pose(path) => Some(Change::Parts),
        Entity::Camera => None,
        Entity::Background | Entity::Object(_) | Entity::Texture(_) => Some(Change::Other),
    }
}

#[cfg(test)]
mod tests;
