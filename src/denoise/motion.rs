//! The way of what a pixel shows from frame to frame, by the motion vectors of the frames.
//!
//! A vector leads to the next frame or to the one before, so a frame further away is reached by those of the frames between. Each
//! step must come to the same object at the expected depth, whose own vector leads back: what is hidden there is lost.

use super::{
    frame::Frame,
    places,
    projection::{Place, Projection},
    vectors::Vectors,
};

/// The frames from one to another.
pub(super) struct Way<'a> {
    own: &'a Frame,
    /// See [`fronts`].
    fronts: Vec<u32>,
    /// The frames between, and the other one.
    steps: Vec<Step<'a>>,
    is_later: bool,
}

struct Step<'a> {
    vectors: &'a Vectors,
    to: &'a Frame,
    /// The vectors of `to`, and the pixels that tell its surfaces.
    next: &'a Vectors,
    fronts: Vec<u32>,
    rest: Rest,
}

/// The motion in the picture of a surface that rests.
enum Rest {
    /// None: the camera rests, too.
    Still,
    Projected(Box<Projection>),
    Unknown,
}

/// The place of what a pixel shows in another frame.
pub(super) enum Follow {
    /// The surface rests in the world.
    Rests,
    /// The surface is here, to which the last step has led.
    Moves(Place, [f32; 3]),
    /// The surface is hidden in a frame between.
    Lost,
}

impl<'a> Way<'a> {
    /// The way from `own` to `other` by the frames `between`, in the order of the way. `None` where nothing moves, a frame has no
    /// vectors, or one is missing.
    pub fn new(own: &'a Frame, between: impl Iterator<Item = &'a Frame>, other: &'a Frame) -> Option<Self> {
        let is_same = own.is_of_scene_of(other);
        let is_later = other.number > own.number;
        let mut from = own;
        let mut steps = Vec::new();
        for to in between.chain(std::iter::once(other)).filter(|_| !is_same) {
            if from.number.abs_diff(to.number) != 1 {
                return None;
            }
            steps.push(Step {
                vectors: from.vectors.as_ref()?,
                to,
                next: to.vectors.as_ref()?,
                fronts: fronts(to),
                rest: match places::rests(from, to) {
                    true => Rest::Still,
                    false => Projection::new(from, to).map_or(Rest::Unknown, |way| Rest::Projected(Box::new(way))),
                },
            });
            from = to;
        }
        (!steps.is_empty()).then(|| Self {
            own,
            fronts: fronts(own),
            steps,
            is_later,
        })
    }

    /// The place of what pixel `i` shows in the other frame.
    pub fn follow(&self, i: usize) -> Follow {
        let mut place = places::of(self.own, i);
        let mut taps = [(i as u32, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
        let (mut rests, mut by) = (true, [0.0; 3]);
        for (k, step) in self.steps.iter().enumerate() {
            if k > 0 {
                let before = &self.steps[k - 1];
                let fits = |j: usize| self.shows_object(before, (i, j), place) && self.leads(before, j, by);
                taps = places::around(before.to, place, fits);
                if taps.iter().all(|(_, weight)| *weight == 0.0) {
                    return if rests { Follow::Rests } else { Follow::Lost };
                }
            }
            by = [0.0; 3];
            let fronts = if k > 0 { &self.steps[k - 1].fronts } else { &self.fronts };
            for (j, weight) in taps.iter().filter(|(_, weight)| *weight > 0.0) {
                let away = step.vectors.away(self.is_later, fronts[*j as usize] as usize);
                by.iter_mut().zip(away).for_each(|(by, away)| *by += weight * away);
            }
            let resting = step.rest.place(place);
            if by == [0.0; 3]
                && let Some(resting) = resting
            {
                // The vector of a surface that rests, or an unknown one.
                by = resting.from(place);
            }
            place = place.moved(by);
            rests &= resting.is_some_and(|resting| resting.is_near(place));
        }
        match rests {
            true => Follow::Rests,
            false => Follow::Moves(place, by),
        }
    }

    /// Whether pixel `j` of the frame of a step shows the object of the own pixel `i` at this depth.
    fn shows_object(&self, step: &Step<'_>, (i, j): (usize, usize), place: Place) -> bool {
        let (a, b) = (&self.own.guides, &step.to.guides);
        self.is_same_object(step, (i, j))
            && step.to.alpha[j] > 0.0
            && places::has_depth((a, i), (b, j), (1.0 / place.depth) as f32)
    }

    /// Whether the own vector of pixel `j` of the frame of a step leads back.
    fn leads(&self, step: &Step<'_>, j: usize, by: [f32; 3]) -> bool {
        /// Pixels by which vectors may differ, and the part of their length.
        const APART: f32 = 1.0;
        const PART: f32 = 0.1;
        let arrival = step.next.arrival(self.is_later, step.fronts[j] as usize);
        let square = |v: [f32; 3]| v[0] * v[0] + v[1] * v[1];
        let apart = square([arrival[0] - by[0], arrival[1] - by[1], 0.0]);
        apart <= APART * APART + PART * PART * square(by)
    }

    /// Whether pixel `j` of the frame of a step shows the object of the own pixel `i`.
    fn is_same_object(&self, step: &Step<'_>, (i, j): (usize, usize)) -> bool {
        match (&self.own.guides.object, &step.to.guides.object) {
            (Some(a), Some(b)) => a[self.fronts[i] as usize] == b[step.fronts[j] as usize],
            _ => true,
        }
    }

    /// Whether pixel `j` of the other frame shows the object of pixel `i`.
    pub fn shows_same_object(&self, i: usize, j: usize) -> bool {
        self.steps.last().is_none_or(|last| self.is_same_object(last, (i, j)))
    }

    /// Whether the own vector of pixel `j` of the other frame leads back to where a last step came from.
    pub fn leads_back(&self, j: usize, by: [f32; 3]) -> bool {
        self.steps.last().is_none_or(|last| self.leads(last, j, by))
    }
}

/// For each pixel, the one that tells its object and its motion. Numbers and vectors are those of one sample, which at an edge may
/// be on either side: the side in front counts, as the nearest of the 3 x 3 pixels has it.
fn fronts(frame: &Frame) -> Vec<u32> {
    /// The variances of the normal and of the inverse depth, in parts of its square, from which on a pixel is at an edge.
    const NORMAL: f32 = 1e-3;
    const DEPTH: f32 = 1e-5;
    let ([width, height], guides) = (frame.size, &frame.guides);
    let depths = &guides.inverse_depth;
    let front = |i: usize| {
        let is_edge =
            guides.normal_variance[i] > NORMAL || guides.inverse_depth_variance[i] > DEPTH * depths[i] * depths[i];
        let around = |at: usize, size: usize| at.saturating_sub(1)..(at + 2).min(size);
        let mut front = i;
        for y in around(i / width, height).filter(|_| is_edge) {
            for j in around(i % width, width).map(|x| y * width + x) {
                if depths[j] > depths[front] && frame.alpha[j] > 0.0 {
                    front = j;
                }
            }
        }
        front as u32
    };
    (0..frame.pixels()).map(front).collect()
}

/// Whether the own vector of pixel `i` leads elsewhere on the way to another frame that shows another scene.
pub(super) fn moves(own: &Frame, other: &Frame, i: usize) -> bool {
    let is_same = own.is_of_scene_of(other);
    let is_later = other.number > own.number;
    let away = |vectors: &Vectors| vectors.away(is_later, i) != [0.0; 3];
    !is_same && own.vectors.as_ref().is_some_and(away)
}

impl Rest {
    /// The place after the step of a surface that rests; `None` where it cannot be told.
    fn place(&self, place: Place) -> Option<Place> {
        match self {
            Self::Still => Some(place),
            Self::Projected(projection) => projection.place(place),
            Self::Unknown => None,
        }
    }
}

impl Place {
    /// The place after a motion.
    fn moved(self, [u, v, z]: [f32; 3]) -> Self {
        Self {
            x: self.x + f64::from(u),
            y: self.y - f64::from(v),
            depth: (self.depth + f64::from(z)).max(f64::MIN_POSITIVE),
        }
    }

    /// The motion from another place to this one.
    fn from(self, other: Self) -> [f32; 3] {
        [self.x - other.x, other.y - self.y, self.depth - other.depth].map(|v| v as f32)
    }

    /// Whether two places are the same but for the error of vectors, which are those of one sample in a pixel.
    fn is_near(self, other: Self) -> bool {
        /// In pixels, and in parts of the depth.
        const APART: f64 = 0.05;
        const DEPTH: f64 = 0.01;
        let apart = (self.x - other.x).hypot(self.y - other.y);
        apart <= APART && (self.depth - other.depth).abs() <= DEPTH * other.depth
    }
}
