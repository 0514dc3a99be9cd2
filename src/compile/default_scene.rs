//! The scene of a model file. Missing parts have defaults.
//!
//! A model by itself stands for a scene file with the model as its only object, a camera, and lights where the model has none. The
//! file is written as text and read, so that values of a scene file have their names here as well.

mod camera;
pub mod normalise;

use std::{path::Path, sync::Arc};

use glam::DVec3;

use self::{
    camera::{StageLens, SuppliedCamera},
    normalise::{ModelPlace, Normalise},
};
use super::{
    Error,
    objects::world_from_object,
    placed::{self, NO_PARTS},
};
use crate::{
    assets::{
        AssetError, Store,
        model::{LightUnits, Model, ModelCamera, ModelChoice},
        motion::{EditedParts, ModelEdits},
        store::ModelRequest,
    },
    camera::{CameraDesc, Timing},
    describe::{
        self, BackgroundDesc, Diagnostics, MovingDesc, ObjectDesc, Overrides, PartsDesc, SceneDesc, Source, Stage,
        ValueSource, Values,
    },
    math::{DAabb, DAffine3, origin},
    shape::mesh::{AnimationChoice, Playback},
    value::Problem,
    warnings::{WarningKind, Warnings},
};

/// The number of steps of a run, and of a table, at whose ends the bounds are computed.
const RUN_SAMPLES: u32 = 64;

/// A sky that is brighter above than below, which shades white surfaces from 0.16 (facing down) over 0.26 (sideways) to 0.37 (up),
/// before a darker backdrop, so that none of them vanishes in it.
const SKY: &str = "[background]\ngradient = { up = 0.55, side = 0.3, down = 0.15 }\nbackdrop = 0.06\n";
/// The background of a file with lights, which gets no others.
const NO_SKY: &str = "[background]\ncolor = 0\n";
/// The same for a model on a ground, whose shadows need something to be seen on.
const BACKDROP: &str = "[background]\ncolor = 0\nbackdrop = 0.06\n";
/// A large sun over the left shoulder of the default camera, which adds up to 0.5 to a white surface and casts soft shadows. What
/// smooth metal mirrors of a smaller one speckles the ground.
const SUN: &str = "[[light]]\nsun = { direction = [0.35, -1, -0.75], irradiance = 1.9, angle = 20 }\n";

/// The choices about a model that is the scene.
#[derive(Clone, Copy, Debug)]
pub struct ModelOptions<'a> {
    /// Values for keys of the scene file that there might be.
    pub overrides: &'a Overrides,
    /// The tables of values of such keys.
    pub tables: &'a [ValueSource],
    /// The frames of a second.
    pub fps: f64,
    /// The name of a camera of the file; `None` for the first.
    pub camera: Option<&'a str>,
    /// The name of a material variant; `None` for the default materials.
    pub variant: Option<&'a str>,
    /// The unit of its lights.
    pub light_units: LightUnits,
    /// The animations that are played.
    pub animation: Option<&'a AnimationChoice>,
    /// The radius of points, in m.
    pub point_radius: Option<f32>,
    /// Whether it stands on a ground.
    pub ground: bool,
    /// The unit shape that the model is scaled to.
    pub normalise: Option<Normalise>,
}

/// The motion of a model by itself.
#[derive(Debug)]
pub struct ModelRun {
    /// The time of the last key of its animations, in s; `None` if it plays none.
    pub end: Option<f64>,
    /// The model with its camera that moves, and the centre of the model.
    camera: Option<(Arc<Model>, usize, DVec3)>,
    /// The place of the model, if it has been moved.
    place: Option<ModelPlace>,
    /// What flags say of its lens.
    lens: StageLens,
}

impl ModelRun {
    /// Whether the camera of the scene moves.
    pub fn moves_camera(&self) -> bool {
        self.camera.is_some()
    }

    /// The camera at `time`, in s, with these values of the model, if it moves and is not degenerate then.
    pub fn camera(&self, time: f64, parts: &PartsDesc) -> Option<CameraDesc> {
        let (model, camera, center) = self.camera.as_ref()?;
        let pose = model.pose(&Playback::default(), &placed::edits(parts, model), time)?;
        Some(
            own_camera(&pose.cameras[*camera], self.place, *center)?
                .with(self.lens)
                .desc(),
        )
    }
}

/// The scene file of a model.
struct SuppliedScene<'a> {
    path: &'a Path,
    options: ModelOptions<'a>,
    is_lit: bool,
    has_object: bool,
    /// The bounds of the model in all its poses; the origin before they are known, so that the ground has its names.
    bounds: DAabb,
    /// The place of the model, once it is moved.
    place: Option<ModelPlace>,
}

impl SuppliedScene<'_> {
    fn text(&self, camera: &SuppliedCamera) -> String {
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let part = |part: Option<&std::ffi::OsStr>| quoted(&part.unwrap_or_default().to_string_lossy());
        let mut text = String::new();
        let has_map = self
            .options
            .overrides
            .stage()
            .any(|(stage, _)| stage == Stage::Environment);
        if !has_map && !self.replaces_background() {
            text += match (self.is_lit, self.options.ground) {
                (false, _) => SKY,
                (true, false) => NO_SKY,
                (true, true) => BACKDROP,
            };
        }
        if !has_map && !self.is_lit {
            text += SUN;
        }
        if !self.replaces_camera(camera) {
            text += &camera.toml();
        }
        if !self.has_object {
            return text;
        }
        text += &format!(
            "[[object]]\nname = {}\n[object.shape.mesh]\n",
            part(self.path.file_stem())
        );
        let mut key = |name: &str, value: String| text += &format!("{name} = {value}\n");
        key("file", part(self.path.file_name()));
        key("lights", "true".to_owned());
        key("light_units", quoted(self.options.light_units.name()));
        if let Some(variant) = self.options.variant {
            key("variant", quoted(variant));
        }
        match self.options.animation {
            None => {}
            Some(AnimationChoice::All) => key("animation", quoted("all")),
            Some(AnimationChoice::Named(names)) => key("animation", toml::Value::from(names.clone()).to_string()),
        }
        if let Some(radius) = self.options.point_radius {
            key("radius", format!("{:?}", f64::from(radius)));
        }
        if let Some(place) = &self.place {
            key("light_factor", format!("{:?}", place.light_factor()));
            text += &format!("[object.transform]\n{}", place.toml());
        }
        if self.options.ground && self.bounds.is_finite() {
            text += &ground(&self.bounds, self.path);
        }
        text
    }

    /// Whether overrides give a camera of another kind.
    fn replaces_camera(&self, camera: &SuppliedCamera) -> bool {
        let mut paths = self.options.overrides.paths();
        paths.any(|(_, path)| match path {
            [table, kind, ..] => table == "camera" && kind != camera.kind() && CameraDesc::NAMES.contains(&&kind[..]),
            _ => false,
        })
    }

    /// Whether overrides or a table give the light of the background.
    fn replaces_background(&self) -> bool {
        // A number of the supplied sky changes that one.
        let own = |path: &[&str]| !self.is_lit && path.len() > 2 && path[1] == "gradient";
        let gives = |path: &[&str]| match path {
            ["background", kind, ..] => BackgroundDesc::NAMES.contains(kind) && !own(path),
            _ => false,
        };
        let steps = |path: &[String]| gives(&path.iter().map(String::as_str).collect::<Vec<_>>());
        let mut names = self.options.tables.iter().flat_map(ValueSource::names);
        self.options.overrides.paths().any(|(_, path)| steps(path))
            || names.any(|name| gives(&name.split('.').collect::<Vec<_>>()))
    }

    /// Warns of textures that overrides make and no other value names.
    fn warn_of_textures(&self, warnings: &Warnings) {
        let values = self.options.overrides.of_scene();
        for (origin, path) in self.options.overrides.paths() {
            let [table, name, ..] = path else { continue };
            if table == "texture" && self.options.tables.is_empty() && !values.contains(&format!("\"texture.{name}\""))
            {
                let text = format!("{origin} has no effect: nothing is made of the texture `{name}`");
                warnings.add(WarningKind::UNUSED_SETTING, origin, text);
            }
        }
    }

    fn desc(&self, camera: &SuppliedCamera) -> Result<SceneDesc, Error> {
        let source = Source::of_model(self.path.to_owned(), self.text(camera));
        describe::parse(source.with(self.options.overrides.clone())).map_err(Error::Invalid)
    }
}

/// A camera of a model at this place, whose centre is `center`; `None` if it is degenerate.
fn own_camera(camera: &ModelCamera, place: Option<ModelPlace>, center: DVec3) -> Option<SuppliedCamera> {
    let placed = place.map(|place| place.camera(camera));
    camera::own(placed.as_ref().unwrap_or(camera), center)
}

/// The name of the ground of the model at `path`, which is not that of the model.
fn ground_name(path: &Path) -> &'static str {
    let is_ground = path.file_stem().is_some_and(|stem| stem == "ground");
    if is_ground { "ground 2" } else { "ground" }
}

/// The ground below a model with these bounds: a shadow catcher, which hides nothing of the background and has no rim.
fn ground(bounds: &DAabb, path: &Path) -> String {
    let name = ground_name(path);
    let center = bounds.center();
    let point = [center.x, bounds.min.y, center.z];
    format!(
        "[material.ground]\nmatte = {{ albedo = 0.2 }}\n\
         [[object]]\nname = \"{name}\"\nmaterial = \"ground\"\nshadow_catcher = true\n\
         shape.plane = {{ point = {point:?}, normal = [0, 1, 0] }}\n"
    )
}

/// The model at rest in a scene, at one time or another.
struct Shown<'a> {
    model: &'a Model,
    desc: &'a SceneDesc,
    values: Option<&'a Values>,
    fps: f64,
}

impl Shown<'_> {
    /// The bounds of the model in the world, in all poses of its run and of a table.
    fn bounds(&self) -> DAabb {
        let still = self.desc.objects.first();
        let steps = |from: f64, to: f64| {
            let step = move |i: u32| from + (to - from) * f64::from(i) / f64::from(RUN_SAMPLES);
            (0..=RUN_SAMPLES).map(step)
        };
        let motion = self.model.motion.as_ref().filter(|motion| !motion.clips.is_empty());
        let run = motion.map(|motion| f64::from(motion.end()));
        match (self.values, run) {
            (None, None) => self.at(0.0, still),
            (None, Some(end)) => (steps(0.0, end).map(|time| self.at(time, still))).fold(DAabb::EMPTY, DAabb::union),
            (Some(values), _) => {
                let frames = values.sampled_frames();
                let moving = MovingDesc::new(self.desc, values);
                let at = |frame: f64| {
                    let object = moving.object(0, frame);
                    self.at(frame / self.fps, object.as_ref().or(still))
                };
                let of_table = steps(*frames.start() as f64, *frames.end() as f64).map(at);
                let of_run = run.into_iter().flat_map(|end| steps(0.0, end * self.fps)).map(at);
                of_table.chain(of_run).fold(DAabb::EMPTY, DAabb::union)
            }
        }
    }

    /// The bounds at a time, in s, with the values of `object`.
    fn at(&self, time: f64, object: Option<&ObjectDesc>) -> DAabb {
        let parts = object.map_or(ModelEdits::default(), |object| placed::edits(&object.parts, self.model));
        let own = match self.model.pose(&Playback::default(), &parts, time) {
            Some(pose) => self.model.posed(pose).bounds(),
            None => self.model.bounds(),
        };
        let place = object.and_then(|object| world_from_object(object).ok());
        match place {
            Some(place) if place != DAffine3::IDENTITY => own.transformed(&place),
            _ => own,
        }
    }
}

/// The scene of the model at `path`, and its motion, if it has one.
pub fn describe(path: &Path, options: ModelOptions<'_>, store: &Store) -> Result<(SceneDesc, Option<ModelRun>), Error> {
    if path.file_name().is_some_and(|name| name.to_str().is_none()) {
        return Err(AssetError::NotUtf8 { path: path.to_owned() }.into());
    }
    let mut supplied = SuppliedScene {
        path,
        options,
        is_lit: false,
        has_object: true,
        bounds: DAabb {
            min: DVec3::ZERO,
            max: DVec3::ZERO,
        },
        place: None,
    };
    // The names of values tell which parts of the model are loaded so that they may change.
    let unit = camera::framing(&DAabb::EMPTY, 1.0, None);
    let lens = StageLens::new(options.overrides);
    let first = supplied.desc(&unit)?;
    let [width, height] = first.render.resolution().map(f64::from);
    let aspect = width / height;
    let mut edited: EditedParts = first
        .objects
        .first()
        .map(|object| object.parts.edited())
        .unwrap_or_default();
    let names = || options.tables.iter().flat_map(ValueSource::names);
    edited.extend(&describe::edited_parts(&first, names()));
    let changes = |key: &str| names().any(|name| name.ends_with(&format!(".shape.mesh.{key}")));
    let undecided = || changes("animation").then(|| AnimationChoice::Named(Vec::new()));
    let model = store.model(&ModelRequest {
        path: path.to_owned(),
        choice: ModelChoice {
            scene: None,
            variant: options.variant.map(str::to_owned),
            is_varied: changes("variant"),
            lights: Some(true),
            light_units: options.light_units,
            animation: options.animation.cloned().or_else(undecided),
            edited,
            subdivision: None,
            displacement: None,
        },
    })?;
    if model.is_empty() {
        let path = path.display();
        let text = format!("the model has no triangles, there is nothing to see: {path}");
        store.warnings().add(WarningKind::EMPTY_MODEL, path, text);
        supplied.has_object = false;
        let names = first
            .objects
            .first()
            .into_iter()
            .flat_map(|object| object.parts.names());
        let problems = names.map(|(_, _, span)| Problem::at(span, NO_PARTS)).collect();
        Diagnostics::new(&first.source, problems).map_or(Ok(()), |found| Err(Error::Invalid(found)))?;
    }
    supplied.is_lit = model.lights.iter().any(|light| !light.strength.is_black());
    let desc = supplied.desc(&unit)?;
    let shown = Shown {
        model: &model,
        desc: &desc,
        values: None,
        fps: options.fps,
    };
    let at_rest = shown.bounds();
    // A table may move parts of the model; what is wrong with it is told by the plan.
    let values = (!options.tables.is_empty()).then(|| Values::new(&desc, options.tables).ok());
    let shown = Shown {
        values: values.as_ref().and_then(Option::as_ref),
        ..shown
    };
    let whole = options.normalise.map(|shape| (shape, shown.bounds()));
    let place = whole.and_then(|(shape, bounds)| ModelPlace::new(shape, &bounds));
    if let Some((_, bounds)) = whole.filter(|_| place.is_some_and(|place| place.is_too_large())) {
        let (size, path) = (2.0 * bounds.half_diagonal(), path.to_owned());
        return Err(Error::TooSmall { size, path });
    }
    let placed = |bounds: DAabb| place.map_or(bounds, |place| place.bounds(&bounds));
    let bounds = placed(at_rest);
    let center = center(&bounds);
    let chosen = camera::chosen(&model.cameras, options.camera, path, store.warnings())?;
    let parts = desc.objects.first().map(|object| &object.parts);
    let edits = parts.map_or(ModelEdits::default(), |parts| placed::edits(parts, &model));
    let cameras = match model.pose(&Playback::default(), &edits, 0.0) {
        Some(pose) => pose.cameras,
        None => model.cameras.clone(),
    };
    let own = chosen.and_then(|chosen| own_camera(&cameras[chosen], place, center));
    let given = |(_, path): (&str, &[String])| {
        path[0] == "camera" && path.get(1).is_none_or(|key| !Timing::KEYS.contains(&key.as_str()))
    };
    let is_given = options.overrides.paths().any(given);
    let moves = |camera: &usize| model.motion.as_ref().is_some_and(|motion| motion.moves_camera(*camera));
    let moving = chosen.filter(|_| !is_given && own.is_some()).filter(moves);
    let run = model.motion.as_ref().map(|motion| ModelRun {
        end: (!motion.clips.is_empty()).then(|| motion.end().into()),
        camera: moving.map(|camera| (Arc::clone(&model), camera, center)),
        place,
        lens,
    });
    let bounds = match options.tables.is_empty() || own.is_some() && !options.ground {
        true => bounds,
        // A table may move the model as well.
        false => placed(shown.bounds()),
    };
    let camera = own.unwrap_or_else(|| camera::framing(&bounds, aspect, lens.focal_length));
    (supplied.bounds, supplied.place) = (bounds, place);
    supplied.warn_of_textures(store.warnings());
    Ok((supplied.desc(&camera)?, run))
}

/// The centre of a box, as seen from the origin that suits it.
fn center(bounds: &DAabb) -> DVec3 {
    let origin = origin::of_box(bounds).unwrap_or_default();
    origin + bounds.relative_to(origin).center().as_dvec3()
}
