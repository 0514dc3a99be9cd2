//! The choice of the meshes of a model that become instances.
//!
//! Every part of a model is a mesh under a transform. Parts under the same transform become one *unit*. All parts that a model
//! has once become one unit too, so that a model of several objects is one instance for each of them, and not one for each
//! part.
//!
//! Instances make tracing at least 11 % slower, so small meshes are baked into world space: meshes of up to
//! [`MAX_BAKED_TRIANGLES`], whose copies take no more memory than instances do, and meshes whose copies have fewer than
//! [`MIN_SHARED_TRIANGLES`] together. Emitting meshes are baked, because lights are sampled by triangle; so are copies with a
//! singular transform, or one that shears so much that rounding would be visible.
//!
//! Parts that animations move or deform are instances always, those of each node for themselves. What is an instance does not
//! depend on the time.

use std::{collections::HashMap, ops::Range};

use crate::{
    assets::model::{MeshInstance, Model},
    math::DAffine3,
};

/// The most triangles of a mesh that is never an instance.
const MAX_BAKED_TRIANGLES: u64 = 8;

/// The least triangles of all copies of an instanced mesh together; fewer take about 10 MB.
const MIN_SHARED_TRIANGLES: u64 = 1 << 16;

/// When meshes become instances. Pictures differ only by rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instancing {
    /// If instances save memory or time.
    #[default]
    Auto,
    /// Never: every copy of a mesh that stands still is baked into world space.
    Never,
    /// Always, also for single copies, so that objects can be moved.
    Always,
}

impl Instancing {
    /// Whether a mesh with this many triangles and copies becomes an instance.
    pub(super) fn wants(self, triangles: u64, copies: u64) -> bool {
        match self {
            Self::Auto => {
                copies > 1
                    && triangles > MAX_BAKED_TRIANGLES
                    && triangles.saturating_mul(copies) >= MIN_SHARED_TRIANGLES
            }
            Self::Never => false,
            Self::Always => true,
        }
    }
}

/// Parts with a common transform, in all of their copies.
#[derive(Clone, Debug)]
pub(super) struct InstanceUnit {
    /// The parts of each copy, as a range of [`Model::instances`].
    pub copies: Vec<Range<usize>>,
    pub triangles: u64,
}

/// The copies of meshes in a model, which have numbers whether they become instances or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ModelCopies {
    /// The number from 0 of the copy that each part belongs to; `None` for those that the scene shows once.
    pub of_parts: Vec<Option<u32>>,
    pub count: u32,
}

impl ModelCopies {
    /// The copies in a model that `objects` objects use. All parts that the model has once are a copy for each object.
    fn new(model: &Model, units: &[InstanceUnit], objects: u64) -> Self {
        let (mut of_parts, mut count) = (vec![None; model.instances.len()], 0);
        let once = units.iter().filter(|unit| unit.copies.len() == 1 && objects > 1);
        for part in once.flat_map(|unit| unit.copies[0].clone()) {
            (of_parts[part], count) = (Some(0), 1);
        }
        for copy in units
            .iter()
            .filter(|unit| unit.copies.len() > 1)
            .flat_map(|unit| &unit.copies)
        {
            of_parts[copy.clone()].fill(Some(count));
            count += 1;
        }
        Self { of_parts, count }
    }
}

/// The parts of a model that can be instances.
#[derive(Clone, Debug)]
pub(super) struct InstanceUnits {
    pub copies: ModelCopies,
    /// The parts that are not shared within the model, in ascending order, and the number of their triangles.
    pub rest: Vec<usize>,
    pub triangles: u64,
    pub shared: Vec<InstanceUnit>,
}

impl InstanceUnits {
    /// The units of a model that `objects` objects use.
    pub fn new(model: &Model, objects: u64, instancing: Instancing) -> Self {
        let movers = model.movers();
        let units = repeated(model, &movers);
        let copies = ModelCopies::new(model, &units, objects);
        let (shared, once): (Vec<InstanceUnit>, Vec<InstanceUnit>) = units.into_iter().partition(|unit| {
            let copies = unit.copies.len() as u64;
            let moves = unit.copies.iter().any(|copy| movers[copy.start].is_some());
            moves && instancing != Instancing::Never || copies > 1 && instancing.wants(unit.triangles, copies * objects)
        });
        let mut rest: Vec<usize> = once.into_iter().flat_map(|unit| unit.copies).flatten().collect();
        rest.sort_unstable();
        let triangles = rest.iter().map(|&part| triangles(model, part)).sum();
        Self {
            copies,
            rest,
            triangles,
            shared,
        }
    }
}

fn triangles(model: &Model, part: usize) -> u64 {
    model.meshes[model.instances[part].mesh].triangles.len() as u64
}

/// The key by which parts are compared.
fn key(part: &MeshInstance) -> (usize, usize) {
    (part.mesh, part.material)
}

/// All units, in the order of their first parts.
fn repeated(model: &Model, movers: &[Option<(Option<usize>, DAffine3)>]) -> Vec<InstanceUnit> {
    let parts = &model.instances;
    // Parts that stand together stay together.
    let stand_together = |a: usize, b: usize| match (movers[a], movers[b]) {
        (None, None) => parts[a].model_from_mesh == parts[b].model_from_mesh,
        (a, b) => a == b,
    };
    let mut runs: Vec<Range<usize>> = Vec::new();
    for i in 0..parts.len() {
        match runs.last_mut() {
            Some(run) if stand_together(run.start, i) => run.end = i + 1,
            _ => runs.push(i..i + 1),
        }
    }
    // A mesh that occurs together with different meshes would be stored several times, so it is a unit by itself.
    let mut company: HashMap<usize, Option<Range<usize>>> = HashMap::new();
    for run in &runs {
        for part in &parts[run.clone()] {
            let known = company.entry(part.mesh).or_insert_with(|| Some(run.clone()));
            if known.as_ref().is_some_and(|known| !alike(model, known, run)) {
                *known = None;
            }
        }
    }
    let mixed = |run: &Range<usize>| parts[run.clone()].iter().any(|part| company[&part.mesh].is_none());
    let whole = runs.into_iter().flat_map(|run| {
        let step = if mixed(&run) { 1 } else { run.len() };
        run.clone().step_by(step).map(move |start| start..start + step)
    });
    let mut units: Vec<InstanceUnit> = Vec::new();
    let mut known: HashMap<Vec<(usize, usize)>, usize> = HashMap::new();
    let mut own = Vec::new();
    for run in whole {
        own.clear();
        own.extend(parts[run.clone()].iter().map(key));
        match known.get(&own) {
            Some(&unit) => units[unit].copies.push(run),
            None => {
                known.insert(own.clone(), units.len());
                units.push(InstanceUnit {
                    triangles: run.clone().map(|part| triangles(model, part)).sum(),
                    copies: vec![run],
                });
            }
        }
    }
    units
}

fn alike(model: &Model, a: &Range<usize>, b: &Range<usize>) -> bool {
    let keys = |run: &Range<usize>| model.instances[run.clone()].iter().map(key);
    a == b || keys(a).eq(keys(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::{DVec3, Vec3},
        shape::mesh::Mesh,
    };

    /// A model of parts: mesh, material and position. Mesh `i` has `i` thousand triangles.
    fn model(parts: &[(usize, usize, f64)]) -> Model {
        let mesh = |i: usize| {
            let mesh = Mesh {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                triangles: vec![[0, 1, 2]; 1000 * i],
                ..Mesh::default()
            };
            mesh.into()
        };
        Model {
            meshes: (0..4).map(mesh).collect(),
            instances: parts
                .iter()
                .map(|&(mesh, material, x)| MeshInstance {
                    mesh,
                    material,
                    node: None,
                    model_from_mesh: DAffine3::from_translation(DVec3::X * x),
                })
                .collect(),
            ..Model::default()
        }
    }

    fn copies(units: &InstanceUnits) -> Vec<Vec<Range<usize>>> {
        units.shared.iter().map(|unit| unit.copies.clone()).collect()
    }

    #[test]
    fn parts_that_always_stand_together_are_one_unit() {
        let model = model(&[(1, 0, 0.0), (2, 0, 0.0), (3, 0, 1.0), (1, 0, 2.0), (2, 0, 2.0)]);
        let units = InstanceUnits::new(&model, 100, Instancing::Auto);
        assert_eq!(copies(&units), [[0..2, 3..5]]);
        assert_eq!(
            (units.rest, units.triangles, units.shared[0].triangles),
            (vec![2], 3000, 3000)
        );
    }

    #[test]
    fn a_mesh_in_different_company_is_a_unit_by_itself() {
        let model = model(&[(1, 0, 0.0), (2, 0, 0.0), (1, 0, 2.0), (1, 1, 3.0)]);
        let units = InstanceUnits::new(&model, 100, Instancing::Auto);
        assert_eq!(copies(&units), [[0..1, 2..3]]);
        assert_eq!(units.rest, [1, 3]);
    }

    #[test]
    fn copies_are_counted_whether_they_are_shared_or_not() {
        let model = model(&[(1, 0, 0.0), (2, 0, 1.0), (1, 0, 2.0), (3, 0, 3.0), (2, 0, 4.0)]);
        for instancing in [Instancing::Auto, Instancing::Never, Instancing::Always] {
            let of = |objects| InstanceUnits::new(&model, objects, instancing).copies;
            let (alone, twice) = (of(1), of(2));
            assert_eq!(alone.of_parts, [Some(0), Some(2), Some(1), None, Some(3)]);
            assert_eq!(twice.of_parts, [Some(1), Some(3), Some(2), Some(0), Some(4)]);
            assert_eq!((alone.count, twice.count), (4, 5));
        }
    }

    #[test]
    fn what_is_small_or_once_is_not_shared() {
        let model = model(&[(1, 0, 0.0), (1, 0, 1.0), (2, 0, 2.0)]);
        assert!(InstanceUnits::new(&model, 30, Instancing::Auto).shared.is_empty());
        assert!(InstanceUnits::new(&model, 30, Instancing::Never).shared.is_empty());
        assert_eq!(InstanceUnits::new(&model, 33, Instancing::Auto).rest, [2]);
        assert_eq!(InstanceUnits::new(&model, 1, Instancing::Always).rest, [2]);
        assert!(
            !Instancing::Auto.wants(MAX_BAKED_TRIANGLES, 1 << 40)
                && Instancing::Auto.wants(MAX_BAKED_TRIANGLES + 1, 1 << 40)
        );
        assert!(!Instancing::Auto.wants(1 << 40, 1) && Instancing::Always.wants(1, 1));
    }
}
