//! The tiles of a frame with their samples so far.

use std::time::Duration;

use crate::film::{Film, TileAccumulator, Window, accumulator::AccumulatorLayout};

/// A tile of a frame.
pub(super) struct Tile {
    pub window: Window,
    /// The samples that each of its pixels has.
    pub done: u32,
    /// Their sums; `None` before the first sample, and once they are in the film.
    pub accumulator: Option<TileAccumulator>,
}

/// The tiles of a frame.
pub(super) struct TileSet {
    side: u32,
    pub tiles: Vec<Tile>,
}

impl TileSet {
    /// Tiles without samples.
    pub fn new(window: Window, side: u32) -> Self {
        let tile = |window| Tile {
            window,
            done: 0,
            accumulator: None,
        };
        Self {
            side,
            tiles: window.tiles(side).map(tile).collect(),
        }
    }

    /// The samples that every pixel has.
    pub fn samples(&self) -> u32 {
        self.tiles.iter().map(|tile| tile.done).min().unwrap_or(0)
    }

    /// Writes the pixels as they stand into a film, but for those without samples and those that are there.
    pub fn resolve_into(&self, layout: &AccumulatorLayout, film: &mut Film) {
        for tile in self.tiles.iter().filter(|tile| tile.done > 0) {
            if let Some(accumulator) = &tile.accumulator {
                accumulator.resolve_into(layout, film);
            }
        }
    }

    /// The state as bytes; `elapsed` is the time that the frame has taken so far. The sums of all tiles are there.
    pub fn state(&self, elapsed: Duration) -> Vec<u8> {
        let mut out = Vec::new();
        out.extend(self.side.to_le_bytes());
        out.extend(elapsed.as_secs_f64().to_le_bytes());
        for tile in &self.tiles {
            let accumulator = tile.accumulator.as_ref().filter(|_| tile.done > 0);
            out.extend(accumulator.map_or(0, |_| tile.done).to_le_bytes());
            if let Some(accumulator) = accumulator {
                accumulator.write_state(&mut out);
            }
        }
        out
    }

    /// The tiles of `window` with this state, and the time that they took; `None` where the bytes hold no such state.
    pub fn from_state(window: Window, layout: &AccumulatorLayout, mut bytes: &[u8]) -> Option<(Self, Duration)> {
        let side = u32::from_le_bytes(*take(&mut bytes)?);
        let elapsed = Duration::try_from_secs_f64(f64::from_le_bytes(*take(&mut bytes)?)).ok()?;
        if side == 0 {
            return None;
        }
        let mut set = Self::new(window, side);
        for tile in &mut set.tiles {
            tile.done = u32::from_le_bytes(*take(&mut bytes)?);
            if tile.done > 0 {
                let mut accumulator = TileAccumulator::new(tile.window, layout);
                accumulator.read_state(&mut bytes)?;
                tile.accumulator = Some(accumulator);
            }
        }
        bytes.is_empty().then_some((set, elapsed))
    }
}

fn take<'a, const N: usize>(bytes: &mut &'a [u8]) -> Option<&'a [u8; N]> {
    let (taken, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(taken)
}
