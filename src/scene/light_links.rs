//! Light linking: the lights that light an object.

use super::{LightId, ObjectId};

/// An index into the sets of lights of a scene; the first has all lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightSetId(u16);

/// The source of light, as sets of lights tell sources apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightOrigin {
    /// An analytic light.
    Light(LightId),
    /// An object that emits.
    Object(ObjectId),
    Background,
}

/// Some of the lights of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightSet {
    lights: Vec<bool>,
    objects: Vec<bool>,
    background: bool,
    /// Whether lights and objects beyond the lists are in it.
    rest: bool,
}

/// The sets of lights of a scene.
#[derive(Clone, Debug, Default)]
pub struct LightLinks {
    /// All but the first.
    sets: Vec<LightSet>,
}

fn put(list: &mut Vec<bool>, at: usize, rest: bool, value: bool) {
    if list.len() <= at {
        list.resize(at + 1, rest);
    }
    list[at] = value;
}

impl LightSet {
    /// All lights.
    pub const ALL: Self = Self::of_rest(true);

    /// No light.
    pub const NONE: Self = Self::of_rest(false);

    const fn of_rest(rest: bool) -> Self {
        Self {
            lights: Vec::new(),
            objects: Vec::new(),
            background: rest,
            rest,
        }
    }

    fn put(&mut self, origin: LightOrigin, value: bool) {
        match origin {
            LightOrigin::Light(light) => put(&mut self.lights, light.0 as usize, self.rest, value),
            LightOrigin::Object(object) => put(&mut self.objects, object.0 as usize, self.rest, value),
            LightOrigin::Background => self.background = value,
        }
    }

    /// Adds the light of an origin.
    pub fn add(&mut self, origin: LightOrigin) {
        self.put(origin, true);
    }

    /// Removes the light of an origin.
    pub fn remove(&mut self, origin: LightOrigin) {
        self.put(origin, false);
    }

    fn has(&self, origin: LightOrigin) -> bool {
        let listed = |list: &[bool], at: u32| list.get(at as usize).copied().unwrap_or(self.rest);
        match origin {
            LightOrigin::Light(light) => listed(&self.lights, light.0),
            LightOrigin::Object(object) => listed(&self.objects, object.0),
            LightOrigin::Background => self.background,
        }
    }
}

impl LightLinks {
    /// Returns the id of a set, and adds it if it is new; `None` if there are too many.
    pub fn add(&mut self, set: LightSet) -> Option<LightSetId> {
        if set == LightSet::ALL {
            return Some(LightSetId::default());
        }
        let known = self.sets.iter().position(|other| *other == set);
        let at = known.unwrap_or_else(|| {
            self.sets.push(set);
            self.sets.len() - 1
        });
        u16::try_from(at + 1).ok().map(LightSetId)
    }

    /// Makes an analytic light part of an object or of the background: it is in the sets that have its owner.
    pub(super) fn set_owner(&mut self, light: LightId, owner: LightOrigin) {
        for set in &mut self.sets {
            let value = set.has(owner);
            set.put(LightOrigin::Light(light), value);
        }
    }

    pub(super) fn has(&self, set: LightSetId, origin: LightOrigin) -> bool {
        let set = usize::from(set.0).checked_sub(1).and_then(|at| self.sets.get(at));
        set.is_none_or(|set| set.has(origin))
    }
}

/// The objects that take part in light transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LitWorld {
    Whole,
    /// Shadow catchers alone: other objects emit nothing.
    Catchers,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_stored_once_and_the_first_has_all_lights() {
        let mut links = LightLinks::default();
        let lamp = LightOrigin::Light(LightId(3));
        let mut key = LightSet::NONE;
        key.add(lamp);
        let ids = [LightSet::ALL, key.clone(), LightSet::NONE, key].map(|set| links.add(set).expect("few sets"));
        assert_eq!(ids, [0, 1, 2, 1].map(LightSetId));
        let has = |origin| ids.map(|id| links.has(id, origin));
        assert_eq!(has(lamp), [true, true, false, true]);
        for other in [
            LightOrigin::Background,
            LightOrigin::Light(LightId(4)),
            LightOrigin::Object(ObjectId(3)),
        ] {
            assert_eq!(has(other), [true, false, false, false]);
        }
    }

    #[test]
    fn lights_of_an_object_are_where_the_object_is() {
        let mut links = LightLinks::default();
        let mut others = LightSet::ALL;
        others.remove(LightOrigin::Object(ObjectId(2)));
        let id = links.add(others).expect("few sets");
        links.set_owner(LightId(5), LightOrigin::Object(ObjectId(2)));
        links.set_owner(LightId(6), LightOrigin::Object(ObjectId(1)));
        let has = [5, 6, 7].map(|light| links.has(id, LightOrigin::Light(LightId(light))));
        assert_eq!(has, [false, true, true]);
    }
}
