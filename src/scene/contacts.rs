//! Rays that leave a shape where another one touches it.
//!
//! Rays leave surfaces from an origin that is offset by a bound of the rounding error. Where another surface is nearer than that,
//! the origin may lie behind it, and light would leak through a closed room. There a ray starts at its own surface instead, at a
//! `tmin` below 0: the line is the same, and the surface between is hit.
//!
//! Only flat shapes in a plane of two axes are found as the surfaces that touch others. Their contacts with a shape are thin boxes,
//! which few hits lie in. Shapes that are flat on the same axis do not touch: one may lie on the other.

use super::{Scene, SurfaceInteraction};
use crate::{
    geometry::{Geometry, Hit, InstanceId, PrimId},
    math::{Aabb, Ray, Transform, Vec3},
    shape::Shape,
};

/// The margin of contacts, relative to the largest coordinate; the offset of rays is smaller.
const MARGIN: f32 = 64.0 * f32::EPSILON;

/// The most pairs of shapes that are compared; scenes of more have no contacts.
const MOST_PAIRS: usize = 100_000_000;

/// The fraction of the offset beyond its own surface at which a ray starts. Surfaces nearer to the own one, such as
/// those in the same plane, are not hit.
const APART: f32 = 1e-3;

/// The largest part of a ray before its origin, in offsets of it; more grazing rays start at their origin.
const MOST_OFFSETS: f32 = 1000.0;

/// The contacts of a scene's shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contacts {
    /// The start of each shape's zones, and the end of the last one's; empty without contacts.
    starts: Vec<u32>,
    zones: Vec<Zone>,
    /// The number of triangles, which come before the shapes.
    triangles: u32,
    /// A box for each shape with nearly all its points, strictly within which are no zones; empty without contacts.
    clear: Vec<Aabb>,
    /// Whether there were too many pairs of shapes to compare.
    is_unknown: bool,
}

/// The number, the bounds with their margin, and the axis without extent of a flat shape.
type Flat = (usize, Aabb, usize);

/// The zone in which a flat shape touches another one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Zone {
    /// The number of the flat shape.
    flat: u32,
    bounds: Aabb,
    /// The axis along which the flat shape has no extent.
    axis: usize,
    /// The side of the other shape on which the flat one is, along the axis; 0 if it is on both.
    side: f32,
}

impl Zone {
    /// The zone of the box `own`, which a box without extent along `axis` touches.
    fn new(own: &Aabb, (number, flat, axis): &Flat) -> Self {
        let (own, axis) = (with_margin(own), *axis);
        let is_above = own.max[axis] <= flat.max[axis] + (flat.max[axis] - flat.min[axis]);
        let is_below = own.min[axis] >= flat.min[axis] - (flat.max[axis] - flat.min[axis]);
        Self {
            flat: *number as u32,
            bounds: flat.intersection(own),
            axis,
            side: f32::from(is_above) - f32::from(is_below),
        }
    }

    /// The larger part of the box `clear` beside the zone, by its part of `size`; empty where none is left.
    fn cut(&self, clear: Aabb, size: Vec3) -> Aabb {
        let Aabb { min, max } = self.bounds;
        let mut largest = (0.0, Aabb::EMPTY);
        for axis in 0..3 {
            let (mut below, mut above) = (clear, clear);
            below.max[axis] = below.max[axis].min(min[axis]);
            above.min[axis] = above.min[axis].max(max[axis]);
            for part in [below, above] {
                let share = part.extent()[axis] / size[axis];
                if share > largest.0 {
                    largest = (share, part);
                }
            }
        }
        largest.1
    }
}

impl Contacts {
    /// Finds the contacts of all shapes.
    pub(super) fn new(geometry: &Geometry) -> Self {
        Self::default().found(geometry, |_| true)
    }

    /// The contacts after these shapes were moved. Only pairs with one of them are compared.
    pub(super) fn after_moves(&self, geometry: &Geometry, moved: impl Iterator<Item = u32>) -> Self {
        let mut is_moved = vec![self.is_unknown; geometry.shapes.len()];
        moved.for_each(|shape| is_moved[shape as usize] = true);
        self.found(geometry, |shape| is_moved[shape])
    }

    /// Finds the contacts of the shapes for which `is_new` holds, and keeps those of the others.
    fn found(&self, geometry: &Geometry, is_new: impl Fn(usize) -> bool) -> Self {
        let prim = |shape: usize| PrimId::new((geometry.triangles.len() + shape) as u32);
        let bounds: Vec<Aabb> = (0..geometry.shapes.len()).map(|i| geometry.bounds(prim(i))).collect();
        let flats: Vec<Flat> = (bounds.iter().enumerate())
            .filter_map(|(i, b)| Some((i, with_margin(b), is_flat(b).iter().position(|flat| *flat)?)))
            .collect();
        let mut contacts = Self {
            triangles: geometry.triangles.len() as u32,
            ..Self::default()
        };
        if flats.is_empty() || flats.len().saturating_mul(bounds.len()) > MOST_PAIRS {
            contacts.is_unknown = !flats.is_empty();
            return contacts;
        }
        let new_flats: Vec<Flat> = flats.iter().filter(|(i, ..)| is_new(*i)).copied().collect();
        for (i, own) in bounds.iter().enumerate() {
            let first = contacts.zones.len();
            contacts.starts.push(first as u32);
            let compared = if is_new(i) {
                &flats
            } else {
                contacts
                    .zones
                    .extend(self.zones_of(i).iter().filter(|zone| !is_new(zone.flat as usize)));
                &new_flats
            };
            let own_flat = is_flat(own);
            for flat in compared.iter().filter(|(other, ..)| *other != i) {
                let zone = Zone::new(own, flat);
                if !own_flat[zone.axis] && !zone.bounds.is_empty() {
                    contacts.zones.push(zone);
                }
            }
            contacts.zones[first..].sort_unstable_by_key(|zone| zone.flat);
            let all = with_margin(own);
            let cut = |clear, zone: &Zone| zone.cut(clear, all.extent());
            contacts.clear.push(contacts.zones[first..].iter().fold(all, cut));
        }
        contacts.starts.push(contacts.zones.len() as u32);
        if contacts.zones.is_empty() {
            return Self::default();
        }
        contacts
    }

    /// The shape that may have a contact at a hit with the point `p`. Few have.
    #[inline(always)]
    fn near(&self, hit: &Hit, p: Vec3) -> Option<usize> {
        let shape = hit.prim.index().checked_sub(self.triangles)? as usize;
        let clear = self.clear.get(shape).filter(|_| hit.instance == InstanceId::NONE)?;
        let is_clear = p.cmpgt(clear.min).all() && p.cmplt(clear.max).all();
        (!is_clear).then_some(shape)
    }

    fn zones_of(&self, shape: usize) -> &[Zone] {
        match self.starts.get(shape..shape + 2) {
            Some(&[start, end]) => &self.zones[start as usize..end as usize],
            _ => &[],
        }
    }

    /// The directions towards the shapes that touch `shape` at `p`, seen from `wo`: the sign on each axis, 0
    /// for none. `None` without a contact.
    #[inline]
    fn towards(&self, shape: usize, p: Vec3, wo: Vec3) -> Option<Vec3> {
        let is_in = |zone: &&Zone| p.cmpge(zone.bounds.min).all() && p.cmple(zone.bounds.max).all();
        let mut towards = None;
        for zone in self.zones_of(shape).iter().filter(is_in) {
            let side = if zone.side == 0.0 {
                -wo[zone.axis].signum()
            } else {
                zone.side
            };
            towards.get_or_insert(Vec3::ZERO)[zone.axis] = side;
        }
        towards
    }
}

/// Whether a box has no extent but for rounding, on each axis.
fn is_flat(b: &Aabb) -> [bool; 3] {
    let largest = b.min.abs().max(b.max.abs());
    let most = MARGIN * largest.max_element();
    if most.is_finite() {
        b.extent().to_array().map(|extent| extent <= most)
    } else {
        [false; 3]
    }
}

fn with_margin(b: &Aabb) -> Aabb {
    let margin = MARGIN * b.min.abs().max(b.max.abs()).max_element();
    Aabb {
        min: b.min - margin,
        max: b.max + margin,
    }
}

/// A point on a shape where another one touches it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    shape: Shape,
    world_from_local: Option<Transform>,
    p: Vec3,
    ng: Vec3,
    /// The side on which other shapes are, on each axis; 0 where none is.
    towards: Vec3,
}

impl Contact {
    /// The ray that leaves the shape; it starts at the shape.
    #[cold]
    #[inline(never)]
    pub fn start(&self, ray: Ray) -> Ray {
        let offset = (ray.o - self.p).length();
        let reach = offset / self.ng.dot(ray.d).abs();
        // A ray away from another shape would meet its back.
        let is_away = (ray.d * self.towards).min_element() < 0.0;
        let is_grazing = !reach.is_finite() || reach * ray.d.length() >= MOST_OFFSETS * offset;
        if is_away || is_grazing || ray.tmin != 0.0 {
            return ray;
        }
        let mut before = Ray {
            tmin: -4.0 * reach,
            tmax: 0.0,
            ..ray
        };
        let mut start = 0.0;
        // The last one, if there are several.
        while let Some(hit) = match &self.world_from_local {
            None => self.shape.intersect(&before),
            Some(t) => self.shape.intersect(&t.ray_to_local(&before)),
        } {
            (start, before.tmin) = (hit.t, hit.t);
        }
        let tmin = start * (1.0 - APART);
        if tmin < 0.0 { Ray { tmin, ..ray } } else { ray }
    }
}

impl Scene {
    /// The contact at a hit, if there is one. Few hits have one.
    #[inline(always)]
    pub(crate) fn contact(&self, surface: &SurfaceInteraction, hit: &Hit) -> Option<Contact> {
        let shape = self.geometry.contacts.near(hit, surface.p)?;
        self.contact_of_shape(surface, shape)
    }

    #[cold]
    #[inline(never)]
    fn contact_of_shape(&self, surface: &SurfaceInteraction, shape: usize) -> Option<Contact> {
        let contacts = &self.geometry.contacts;
        let geometry = self.geometry.accel.geometry();
        let towards = contacts.towards(shape, surface.p, surface.wo)?;
        let placed = &geometry.shapes[shape];
        Some(Contact {
            shape: placed.shape,
            world_from_local: geometry.transform(placed).copied(),
            p: surface.p,
            ng: surface.ng,
            towards,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        accel::AccelKind,
        material::{Material, matte::Matte},
        math::{DAffine3, DVec3, Rgb},
        scene::{Background, SceneBuilder, SceneUpdate},
        shape::quad::QuadDesc,
        texture::Color,
        value::{List, Point, Spanned},
    };

    /// A floor and a wall at x = 1 that meet in an edge, and a sheet on the floor.
    fn corner() -> Scene {
        let mut builder = SceneBuilder::new(Background::new(Rgb::BLACK));
        let material = builder.material(Material::Matte(Matte::smooth(Color::Constant(Rgb::WHITE))));
        for corners in [
            [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]],
            [[1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [1.0, 2.0, 1.0], [1.0, 2.0, -1.0]],
            [[-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5], [-0.5, 0.0, -0.5]],
        ] {
            let corners = Spanned::new(0..0, List(corners.map(|p| Point(DVec3::from_array(p)))));
            let quad = QuadDesc { corners }.compile(DVec3::ZERO).expect("a quad");
            builder.shape("quad", Shape::Quad(quad), None, material);
        }
        builder.build(AccelKind::default()).expect("a scene")
    }

    fn nearest(scene: &Scene, ray: Ray) -> Option<Hit> {
        let mut hits = [None];
        scene.geometry.accel.nearest(&[ray], &mut hits);
        hits[0]
    }

    #[test]
    fn rays_from_an_edge_of_two_walls_meet_the_other_wall() {
        let scene = corner();
        let (mut on_the_edge, mut met) = (0, 0);
        for i in 0..2000 {
            let from = Vec3::new(0.3, 0.5 + i as f32 * 1e-4, 0.1);
            let ray = Ray::new(from, Vec3::new(1.0 - 2e-8, 0.0, i as f32 * 1e-4) - from);
            let Some(hit) = nearest(&scene, ray).filter(|hit| hit.prim == PrimId::new(0)) else {
                continue;
            };
            let surface = scene.surface(&ray, &hit);
            if surface.p.x != 1.0 {
                continue;
            }
            on_the_edge += 1;
            let contact = scene.contact(&surface, &hit).expect("a contact");
            let leaving = surface.spawn_ray(false, Vec3::new(0.6, 0.64, 0.48));
            let hit = nearest(&scene, contact.start(leaving));
            met += usize::from(hit.is_some_and(|hit| hit.prim == PrimId::new(1)));
            // One that goes away from the wall does not meet its back.
            let away = surface.spawn_ray(false, Vec3::new(-0.6, 0.64, 0.48));
            assert!(nearest(&scene, contact.start(away)).is_none());
        }
        assert!(on_the_edge > 100, "{on_the_edge}");
        assert_eq!(met, on_the_edge);
    }

    #[test]
    fn a_sheet_on_a_floor_and_what_is_away_from_edges_have_no_contact() {
        let scene = corner();
        for x in [0.2, 0.9] {
            let ray = Ray::new(Vec3::new(x, 1.0, 0.0), -Vec3::Y);
            let hit = nearest(&scene, ray).expect("the floor");
            assert!(scene.contact(&scene.surface(&ray, &hit), &hit).is_none());
        }
    }

    #[test]
    fn contacts_after_moves_are_those_of_all_shapes_anew() {
        let mut scene = corner();
        for (shape, by) in [
            (2_usize, Vec3::new(0.5, 0.0, 0.0)),
            (1, Vec3::new(-0.3, 0.2, 0.0)),
            (0, Vec3::new(0.0, 5.0, 0.0)),
            (0, Vec3::ZERO),
        ] {
            let moved = scene.geometry.shape_objects[shape];
            let transform = Transform::new(DAffine3::from_translation(by.as_dvec3())).expect("it has an inverse");
            let update = SceneUpdate {
                transforms: vec![(moved, transform)],
                ..SceneUpdate::default()
            };
            scene.apply(&update).expect("it can be moved");
            let geometry = scene.geometry.accel.geometry();
            assert_eq!(
                scene.geometry.contacts,
                Contacts::new(geometry),
                "shape {shape} by {by}"
            );
        }
    }
}
