//! A frame brought to the pixels of another: by the cameras and the depth, or by motion vectors where the surface moves,
//! with what does not fit left out.
//!
//! Where the camera rests and the scene is the same, pixels show the same. Where one of them has changed, a pixel must show the
//! same surface, and its light is tested (`accumulate`).

use super::{
    albedo::{self, Albedo},
    frame::Frame,
    motion::{self, Follow, Way},
    places::{self, Taps, around, cubic, has_depth, rests},
    projection::{Place, Projection},
    signal::Signal,
};
use crate::math::parallel;

/// A frame at the pixels of another.
pub(super) struct Reprojected {
    pub signal: Signal,
    /// Whether each pixel has been found, from 0 to 1.
    pub found: Vec<f32>,
    /// Whether the camera rests and the scene is the same.
    pub is_still: bool,
    /// The divisor of its light, where something moves.
    pub albedo: Option<Albedo>,
}

/// The pixels that show what a pixel shows.
#[derive(Clone, Copy, Default)]
struct Found {
    taps: Taps,
    /// The place of a surface that moves in the world.
    moves: Option<Place>,
}

/// The other frame at the pixels of `own`, with those between them in the order of the way; `None` where
/// it cannot be told where they are.
pub(super) fn reproject<'a>(
    own: &'a Frame,
    between: impl Iterator<Item = &'a Frame>,
    other: &'a Frame,
) -> Option<Reprojected> {
    if is_still(own, other) {
        return Some(Reprojected {
            signal: same_pixels(own, other),
            found: own
                .alpha
                .iter()
                .zip(&other.alpha)
                .map(|(a, b)| covered(*a, *b))
                .collect(),
            is_still: true,
            albedo: None,
        });
    }
    let rests = rests(own, other);
    let projection = if rests { None } else { Projection::new(own, other) };
    let way = Way::new(own, between, other);
    if !rests && projection.is_none() && way.is_none() {
        return None;
    }
    let finder = Finder {
        own,
        other,
        rests,
        projection,
        way,
    };
    let all: Vec<Found> = parallel::table(own.pixels(), |i| finder.find(i));
    let gather = |plane: &[f32], square: bool| -> Vec<f32> {
        parallel::table(all.len(), |i| {
            let taps = all[i].taps.iter();
            taps.map(|&(i, w)| if square { w * w } else { w } * plane[i as usize])
                .sum()
        })
    };
    let covers = gather(&other.alpha, false);
    let albedo = finder.way.as_ref().map(|_| {
        let Albedo { color, variance, .. } = Albedo::of(other);
        Albedo {
            color: std::array::from_fn(|c| finder.sharp(&color[c], &all)),
            variance: gather(&variance, true),
            is_between: all.iter().map(|found| found.taps[0].1 != 1.0).collect(),
        }
    });
    let found = (0..own.pixels())
        .map(|i| {
            // What mirrors and glass show is not at the place of their surface: where that or the camera
            // moves, it is left to the own frame.
            let specular = own.specular.as_ref().filter(|_| !rests || all[i].moves.is_some());
            covered(own.alpha[i], covers[i]) * (1.0 - specular.map_or(0.0, |specular| specular[i]))
        })
        .collect();
    let color = |color: &[Vec<f32>; 3], square| std::array::from_fn(|c| gather(&color[c], square));
    let Signal {
        halves,
        variance,
        light,
    } = &other.signal;
    Some(Reprojected {
        signal: Signal {
            halves: [color(&halves[0], false), color(&halves[1], false)],
            variance: color(variance, true),
            light: light.iter().map(|layer| color(layer, false)).collect(),
        },
        found,
        is_still: false,
        albedo,
    })
}

/// Whether the camera rests and the scene is the same.
pub(super) fn is_still(own: &Frame, other: &Frame) -> bool {
    rests(own, other) && own.is_of_scene_of(other)
}

/// The weight of a pixel of another frame by the alphas of both.
fn covered(own: f32, other: f32) -> f32 {
    if own > 0.0 { (other / own).min(1.0) } else { 0.0 }
}

/// The signal of the other frame in parts of the own albedo, whose noise cancels then.
fn same_pixels(own: &Frame, other: &Frame) -> Signal {
    let mut signal = other.signal.clone();
    for c in 0..3 {
        let albedo = |frame: &Frame, i: usize| frame.modulation[c][i] / frame.alpha[i];
        let factor = |i: usize| {
            let is_covered = own.alpha[i] > 0.0 && other.alpha[i] > 0.0;
            if is_covered {
                albedo(other, i) / albedo(own, i)
            } else {
                0.0
            }
        };
        let factors: Vec<f32> = (0..own.pixels()).map(factor).collect();
        albedo::scale(&mut signal, c, &factors);
    }
    signal
}

/// Finds what pixels of a frame show in another one.
struct Finder<'a> {
    own: &'a Frame,
    other: &'a Frame,
    /// Whether the camera rests.
    rests: bool,
    /// The way of surfaces that rest, where the camera moves and it can be told.
    projection: Option<Projection>,
    /// The way of surfaces that move, where they do.
    way: Option<Way<'a>>,
}

impl Finder<'_> {
    /// The pixels of the other frame around the place of pixel `i`, as far as they show the same surface.
    fn find(&self, i: usize) -> Found {
        const NONE: Taps = [(0, 0.0); 4];
        let follow = match &self.way {
            Some(way) => way.follow(i),
            // The way lacks a frame.
            None if self.rests && motion::moves(self.own, self.other, i) => Follow::Lost,
            None => Follow::Rests,
        };
        let (place, by) = match (&follow, &self.projection) {
            (Follow::Moves(place, by), _) => (Some(*place), Some(*by)),
            (Follow::Rests, Some(projection)) => (projection.place(places::of(self.own, i)), None),
            (Follow::Rests, None) if self.rests => {
                let mut taps = NONE;
                let fits = self.shows_same(i, i, self.own.guides.inverse_depth[i]);
                taps[0] = (i as u32, f32::from(fits));
                return Found { taps, moves: None };
            }
            (Follow::Rests | Follow::Lost, _) => (None, None),
        };
        let taps = place.map_or(NONE, |place| {
            let leads_back = |j| by.is_none_or(|by| self.way.as_ref().is_none_or(|way| way.leads_back(j, by)));
            let fits = |j| self.shows_same(i, j, (1.0 / place.depth) as f32) && leads_back(j);
            around(self.other, place, fits)
        });
        Found {
            taps,
            moves: place.filter(|_| by.is_some()),
        }
    }

    /// A plane of the other frame at these places, by cubic interpolation where a surface that moves fills the pixels around.
    fn sharp(&self, plane: &[f32], found: &[Found]) -> Vec<f32> {
        parallel::table(found.len(), |i| {
            let Found { taps, moves } = &found[i];
            let sharp = moves.and_then(|place| cubic(self.other, place, plane, taps[0].0 as usize));
            sharp.unwrap_or_else(|| taps.iter().map(|&(i, w)| w * plane[i as usize]).sum())
        })
    }

    /// Whether pixel `j` of the other frame shows the surface of pixel `i`, whose inverse depth from there is given.
    fn shows_same(&self, i: usize, j: usize, inverse_depth: f32) -> bool {
        /// The squared length by which normals may differ.
        const NORMAL: f32 = 0.15;
        let (a, b) = (&self.own.guides, &self.other.guides);
        let is_same_object = match (&self.way, &a.object, &b.object) {
            (Some(way), ..) => way.shows_same_object(i, j),
            (None, Some(a), Some(b)) => a[i] == b[j],
            _ => true,
        };
        let normals: f32 = (0..3).map(|c| (a.normal[c][i] - b.normal[c][j]).powi(2)).sum();
        self.other.alpha[j] > 0.0
            && is_same_object
            && normals <= NORMAL + 4.0 * (a.normal_variance[i] + b.normal_variance[j])
            && has_depth((a, i), (b, j), inverse_depth)
    }
}
