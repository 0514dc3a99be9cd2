//! Textures and mixtures are made of others of their kind: how deep, of how many, and never of themselves.

/// Things, each of which is made of the next, at most.
pub(super) const MAX_DEPTH: u32 = 64;

/// The steps of a circle that a message names at most.
const NAMED: usize = 8;

/// What a thing is made of, all the way down.
#[derive(Clone, Copy)]
pub(super) struct Sources {
    /// The number of look-ups that one makes, itself among them.
    pub lookups: u64,
    /// The number of things of the longest chain, itself among them.
    depth: u32,
}

/// The sources of a thing as far as they are known.
#[derive(Clone, Copy)]
enum Known {
    Unknown,
    /// They are being counted.
    Counting,
    Counted(Sources),
}

/// The reason why a thing cannot be made.
pub(super) enum Tangle {
    /// Each of these is made of the next, and the last of the first.
    Circle(Vec<usize>),
    /// More than [`MAX_DEPTH`] are made of each other.
    Depth,
}

impl Tangle {
    /// The message of a thing of this kind, one of `names`.
    pub fn message<'n>(&self, kind: &str, name: impl Fn(usize) -> &'n str) -> String {
        match self {
            Self::Depth => format!("more than {MAX_DEPTH} {kind}s, each made of the next"),
            Self::Circle(circle) => {
                let next = circle.iter().cycle().skip(1);
                let steps = circle.iter().zip(next).enumerate().take(NAMED);
                let steps = steps.map(|(at, (from, to))| {
                    let made = if at == 0 { "is made of" } else { "of" };
                    format!("`{}` {made} `{}`", name(*from), name(*to))
                });
                let steps = steps.collect::<Vec<_>>().join(", ");
                let rest = if circle.len() > NAMED { ", ..." } else { "" };
                format!("this {kind} contains itself: {steps}{rest}")
            }
        }
    }
}

/// The sources of things of one kind, each of which is counted once.
pub(super) struct Nesting<S> {
    /// The sources that a thing names itself.
    sources: S,
    known: Vec<Known>,
    /// The things that are being counted, each made of the next.
    chain: Vec<usize>,
}

impl<S: Fn(usize) -> I, I: IntoIterator<Item = usize>> Nesting<S> {
    /// Those of `count` things.
    pub fn new(count: usize, sources: S) -> Self {
        let known = vec![Known::Unknown; count];
        let chain = Vec::new();
        Self { sources, known, chain }
    }

    /// The sources of a thing. After an error no others are to be asked for.
    pub fn of(&mut self, id: usize) -> Result<Sources, Tangle> {
        let above = self.chain.len() as u32;
        match self.known[id] {
            Known::Counted(sources) if above + sources.depth > MAX_DEPTH => return Err(Tangle::Depth),
            Known::Counted(sources) => return Ok(sources),
            Known::Counting => {
                let start = self.chain.iter().position(|above| *above == id).unwrap_or(0);
                return Err(Tangle::Circle(self.chain.split_off(start)));
            }
            Known::Unknown if above >= MAX_DEPTH => return Err(Tangle::Depth),
            Known::Unknown => self.known[id] = Known::Counting,
        }
        self.chain.push(id);
        let mut all = Sources { lookups: 1, depth: 1 };
        for source in (self.sources)(id) {
            let of_source = self.of(source)?;
            all.lookups = all.lookups.saturating_add(of_source.lookups);
            all.depth = all.depth.max(of_source.depth + 1);
        }
        self.chain.pop();
        self.known[id] = Known::Counted(all);
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first problem of these things.
    fn tangle(sources: &[&[usize]]) -> Option<String> {
        let mut nesting = Nesting::new(sources.len(), |id: usize| sources[id].iter().copied());
        let found = (0..sources.len()).find_map(|id| nesting.of(id).err());
        found.map(|tangle| tangle.message("thing", |id| ["a", "b", "c", "d"][id]))
    }

    #[test]
    fn a_circle_is_told_step_by_step() {
        assert_eq!(tangle(&[&[1, 2], &[3], &[3], &[]]), None);
        let circle = "this thing contains itself: `b` is made of `c`, `c` of `d`, `d` of `b`";
        assert_eq!(tangle(&[&[1], &[2], &[3], &[1]]).as_deref(), Some(circle));
        let circle = "this thing contains itself: `a` is made of `a`";
        assert_eq!(tangle(&[&[0]]).as_deref(), Some(circle));
    }

    #[test]
    fn shared_sources_are_counted_once_and_their_look_ups_each_time() {
        let mut nesting = Nesting::new(60, |id: usize| if id < 59 { vec![id + 1; 2] } else { Vec::new() });
        let lookups = nesting.of(0).map(|sources| sources.lookups);
        assert_eq!(lookups.ok(), Some((1 << 60) - 1));
    }
}
