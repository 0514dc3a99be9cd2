//! The tables of a scene file with values that change over time.

use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet},
};

use toml::de::{DeTable, DeValue};

use super::{
    BackgroundDesc, Diagnostics, Entity, FrameTime, LightEntry, MaterialEntry, ObjectDesc, SceneDesc, Source,
    TextureEntry,
    names::unset,
    overrides::put,
    placed::placed,
    read::Reader,
    values::{Values, Word},
};
use crate::{
    camera::{CameraDesc, SceneCamera},
    value::{Problem, Span, Spanned, is_override},
};

/// A table that has values.
struct Changing<'d> {
    name: Spanned<String>,
    base: Spanned<DeValue<'d>>,
    /// The columns of its values.
    columns: Vec<usize>,
}

/// A scene file whose values change over time.
pub struct MovingDesc<'d> {
    desc: &'d SceneDesc,
    values: &'d Values,
    entities: BTreeMap<Entity, Changing<'d>>,
}

impl<'d> MovingDesc<'d> {
    /// The scene `desc`, for which `values` were made.
    pub fn new(desc: &'d SceneDesc, values: &'d Values) -> Self {
        let mut document = desc.document();
        let mut entities: BTreeMap<Entity, Changing<'d>> = BTreeMap::new();
        for (at, column) in values.columns.iter().enumerate() {
            let found = entities
                .entry(column.entity)
                .or_insert_with(|| Changing::take(desc, &mut document, column.entity));
            found.columns.push(at);
        }
        Self { desc, values, entities }
    }

    /// The keys whose values differ between two times, each by the steps from its entity; all keys
    /// without values of an earlier time.
    pub fn changed(&self, old: Option<&[String]>, new: &[String]) -> impl Iterator<Item = (Entity, &'d [String])> {
        let columns = self.values.columns.iter().enumerate();
        let differs = move |at: usize| old.is_none_or(|old| old[at] != new[at]);
        columns.filter_map(move |(at, column)| differs(at).then_some((column.entity, column.path.as_slice())))
    }

    /// Puts the entities of these changes into `desc`, with the values `own` of a time.
    ///
    /// # Errors
    /// Values do not fit together.
    pub fn set(
        &self,
        desc: &mut SceneDesc,
        (time, own): (FrameTime, &[String]),
        entities: &BTreeSet<Entity>,
    ) -> Result<(), Diagnostics> {
        let mut problems = Vec::new();
        for entity in entities {
            match self.entity(*entity, own) {
                Ok(read) => read.put(*entity, desc),
                Err(found) => problems.extend(found),
            }
        }
        desc.source.overrides = self.values.overrides_at(self.desc, time);
        Diagnostics::new(&desc.source, problems).map_or(Ok(()), Err)
    }

    /// Puts the entity of a word into `desc`, with the word and the other values of its time. Returns whether these fit together.
    pub fn put(&self, desc: &mut SceneDesc, word: &Word) -> bool {
        let mut own = self.values.at(word.time);
        own[word.column].clone_from(&word.text);
        let read = self.entity(word.entity, &own);
        read.map(|read| read.put(word.entity, desc)).is_ok()
    }

    /// The camera of the scene file at a time.
    ///
    /// # Errors
    /// Its values do not fit together.
    pub fn camera(&self, time: impl Into<FrameTime>) -> Result<Option<SceneCamera>, Diagnostics> {
        let time = time.into();
        if !self.entities.contains_key(&Entity::Camera) {
            let camera = self.desc.camera.as_ref().map(|camera| camera.get_ref().compile());
            return camera.transpose().map_err(|problems| self.diagnostics(time, problems));
        }
        let own = self.values.at(time);
        let invalid = |problems| self.diagnostics(time, self.of_cells(&own, problems));
        self.camera_without(None, &own).map_err(invalid)
    }

    /// The camera of the scene file with these values, but for one column.
    fn camera_without(&self, column: Option<usize>, own: &[String]) -> Result<Option<SceneCamera>, Vec<Problem>> {
        match self.entity_without(column, Entity::Camera, own)? {
            EntityDesc::Camera(camera) => camera.get_ref().compile().map(Some),
            _ => Ok(None),
        }
    }

    /// Gives problems of the camera that are in the scene file the first column without which there are none.
    fn of_cells(&self, own: &[String], problems: Vec<Problem>) -> Vec<Problem> {
        let columns = &self.entities[&Entity::Camera].columns;
        let is_of_file = |problem: &Problem| problem.span.as_ref().is_none_or(|span| !is_override(span));
        let culprit = || {
            let is_it = |at: &&usize| self.camera_without(Some(**at), own).is_ok();
            let culprit = columns.iter().find(is_it).or(columns.first());
            culprit.map(|at| self.values.span(*at))
        };
        let moved = |problem: Problem| match is_of_file(&problem) {
            true => Problem {
                span: culprit(),
                ..problem
            },
            false => problem,
        };
        problems.into_iter().map(moved).collect()
    }

    /// The problems at a time, with the cells of their values.
    pub(super) fn diagnostics(&self, time: FrameTime, problems: Vec<Problem>) -> Diagnostics {
        let source = (self.desc.source.clone()).with(self.values.overrides_at(self.desc, time));
        Diagnostics::new(&source, problems).expect("what cannot be read has a problem")
    }

    /// The text of the scene file with the places of the values of a word's time, to which the spans of values lead.
    pub fn source_of(&self, word: &Word) -> Source {
        let overrides = self.values.overrides_of_words(self.desc, word.time);
        self.desc.source.clone().with(overrides)
    }

    /// The span of a word.
    pub fn span_of(&self, word: &Word) -> Span {
        self.values.span(word.column)
    }

    /// The problem of a word.
    pub fn word_problem(&self, word: &Word, message: String) -> Diagnostics {
        let problem = vec![Problem::at(self.span_of(word), message)];
        Diagnostics::new(&self.source_of(word), problem).expect("there is a problem")
    }

    /// An object at a time, if it has values and they fit together.
    pub fn object(&self, at: usize, time: impl Into<FrameTime>) -> Option<ObjectDesc> {
        let entity = Entity::Object(at);
        self.entities.contains_key(&entity).then_some(())?;
        match self.entity_at(entity, time.into()) {
            Ok(EntityDesc::Object(object)) => Some(*object),
            _ => None,
        }
    }

    /// Reads an entity with these values, all of a time.
    pub(super) fn entity(&self, entity: Entity, own: &[String]) -> Result<EntityDesc, Vec<Problem>> {
        self.entity_without(None, entity, own)
    }

    /// Reads an entity at a time.
    pub(super) fn entity_at(&self, entity: Entity, time: FrameTime) -> Result<EntityDesc, Vec<Problem>> {
        let columns = &self.entities[&entity].columns;
        self.entity_with(entity, columns, |at| self.values.columns[at].curve.at(time).into())
    }

    /// The problems of the value `text`, in TOML, of a column among the other values of a time.
    pub(super) fn problems_of(&self, column: usize, text: &str, time: FrameTime) -> Vec<Problem> {
        let entity = self.values.columns[column].entity;
        let text_of = |at: usize| match at == column {
            true => Cow::Borrowed(text),
            false => self.values.columns[at].curve.at(time).into(),
        };
        let read = self.entity_with(entity, &self.entities[&entity].columns, text_of);
        let mut problems = read.err().unwrap_or_default();
        problems.retain(|problem| self.values.column_of(problem) == Some(column));
        problems
    }

    /// Whether the key of a column takes the value `text`, in TOML, whatever the other columns have.
    pub(super) fn takes(&self, column: usize, text: &str) -> bool {
        let read = self.entity_with(self.values.columns[column].entity, &[column], |_| text.into());
        let span = self.values.span(column);
        let of_other = |problem: &Problem| problem.span.as_ref() != Some(&span);
        read.map_or_else(|problems| problems.iter().all(of_other), |_| true)
    }

    /// Reads an entity with these values but for that of one column.
    fn entity_without(
        &self,
        left_out: Option<usize>,
        entity: Entity,
        own: &[String],
    ) -> Result<EntityDesc, Vec<Problem>> {
        let columns = self.entities[&entity].columns.iter().copied();
        let columns: Vec<usize> = columns.filter(|at| Some(*at) != left_out).collect();
        self.entity_with(entity, &columns, |at| own[at].as_str().into())
    }

    /// Reads an entity with the values of these of its columns.
    fn entity_with<'t>(
        &self,
        entity: Entity,
        columns: &[usize],
        text: impl Fn(usize) -> Cow<'t, str>,
    ) -> Result<EntityDesc, Vec<Problem>> {
        let changing = &self.entities[&entity];
        let texts: Vec<(usize, Cow<'_, str>)> = columns.iter().map(|at| (*at, text(*at))).collect();
        let mut problems = Vec::new();
        let mut value: Spanned<DeValue<'_>> = changing.base.clone();
        if let DeValue::Table(table) = value.get_mut() {
            for (at, text) in &texts {
                let (column, span) = (&self.values.columns[*at], self.values.span(*at));
                let path: Vec<Cow<'_, str>> = column.path.iter().map(|step| Cow::Borrowed(step.as_str())).collect();
                let new = DeValue::parse(text).expect("the TOML crate has written it");
                let set = put(table, (&path, column.component), placed(new.into_inner(), &span));
                problems.extend(set.err());
            }
            for (at, _) in &texts {
                let column = &self.values.columns[*at];
                if column.component.is_some() {
                    problems.extend(unset(table, &column.path, &self.values.span(*at)));
                }
            }
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        let overrides = &self.desc.source.overrides;
        let mut reader = Reader::new(overrides, &self.desc.source.text);
        reader.may_flatten = true;
        let name = || changing.name.clone();
        let read = match entity {
            Entity::Object(_) => reader
                .object(value)
                .map(|it| EntityDesc::Object(Box::new(it.without_scales_of_zero()))),
            Entity::Light(_) => reader.light(value).map(|it| EntityDesc::Light(Box::new(it))),
            Entity::Material(_) => reader
                .material(name(), value)
                .map(|it| EntityDesc::Material(Box::new(it))),
            Entity::Texture(_) => reader
                .texture(name(), value)
                .map(|it| EntityDesc::Texture(Box::new(it))),
            Entity::Background => reader.entity(value).map(|it| EntityDesc::Background(Box::new(it))),
            Entity::Camera => reader.camera(value).map(|it| EntityDesc::Camera(Box::new(it))),
        };
        match read {
            Some(read) if reader.problems.is_empty() => Ok(read),
            _ => Err(reader.problems),
        }
    }
}

impl<'d> Changing<'d> {
    /// Takes the table of an entity out of the document; one that is not there is empty.
    fn take(desc: &SceneDesc, document: &mut DeTable<'d>, entity: Entity) -> Self {
        let mut of_list = |what: &str, at: usize| {
            let list = document.get_mut(what).map(Spanned::get_mut);
            let element = match list {
                Some(DeValue::Array(list)) => list.get_mut(at).map(|element| element.clone()),
                _ => None,
            };
            (Spanned::new(0..0, String::new()), element)
        };
        let (name, base) = match entity {
            Entity::Object(at) => of_list("object", at),
            Entity::Light(at) => of_list("light", at),
            Entity::Background => (Spanned::new(0..0, String::new()), document.remove("background")),
            Entity::Camera => (Spanned::new(0..0, String::new()), document.remove("camera")),
            Entity::Material(at) => Self::named(document, "material", &desc.materials[at].name),
            Entity::Texture(at) => Self::named(document, "texture", &desc.textures[at].name),
        };
        Self {
            name,
            base: base.unwrap_or_else(|| Spanned::new(0..0, DeValue::Table(DeTable::new()))),
            columns: Vec::new(),
        }
    }

    fn named(
        document: &mut DeTable<'d>,
        what: &str,
        name: &Spanned<String>,
    ) -> (Spanned<String>, Option<Spanned<DeValue<'d>>>) {
        let tables = document.get_mut(what).map(Spanned::get_mut);
        let own = match tables {
            Some(DeValue::Table(tables)) => tables.remove(name.get_ref().as_str()),
            _ => None,
        };
        (name.clone(), own)
    }
}

/// An entity, read.
pub(super) enum EntityDesc {
    Object(Box<ObjectDesc>),
    Light(Box<LightEntry>),
    Material(Box<MaterialEntry>),
    Texture(Box<TextureEntry>),
    Background(Box<BackgroundDesc>),
    Camera(Box<Spanned<CameraDesc>>),
}

impl EntityDesc {
    /// Replaces `entity` of a scene.
    fn put(self, entity: Entity, desc: &mut SceneDesc) {
        match (self, entity) {
            (Self::Object(own), Entity::Object(at)) => desc.objects[at] = *own,
            (Self::Light(own), Entity::Light(at)) => desc.lights[at] = *own,
            (Self::Material(own), Entity::Material(at)) => desc.materials[at] = *own,
            (Self::Texture(own), Entity::Texture(at)) => desc.textures[at] = *own,
            (Self::Background(own), Entity::Background) => desc.background = *own,
            (Self::Camera(own), Entity::Camera) => desc.camera = Some(*own),
            _ => unreachable!("an entity is read as what it is"),
        }
    }
}
