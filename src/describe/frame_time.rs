//! Times of a job, in frames.

/// A time of a job. While a shutter is open, values that are drawn at random are those of its frame; all others are those of the
/// time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    /// In frames.
    pub time: f64,
    /// The frame whose picture is taken.
    pub frame: i64,
}

/// A time between two frames belongs to the first of them.
impl From<f64> for FrameTime {
    fn from(time: f64) -> Self {
        let frame = time.floor() as i64;
        Self { time, frame }
    }
}
