//! The messages of pages, and the facts sent to them.

use serde::{Deserialize, Serialize};

use super::{
    camera::{LensNumbers, ViewCamera},
    look::Look,
};
use crate::camera::path::{Interp, PathKey};

/// A message of a page. `seq` increases with each message that changes the view.
#[derive(Debug, Deserialize)]
#[serde(tag = "t", rename_all = "lowercase", deny_unknown_fields)]
pub enum PageMessage {
    /// The camera that the page wants.
    View {
        seq: u64,
        camera: ViewCamera,
    },
    /// The scene's own camera.
    Home {
        seq: u64,
    },
    /// The page's frame; the camera becomes that of the path, if it has one there.
    Frame {
        seq: u64,
        frame: f64,
    },
    Look {
        seq: u64,
        look: Look,
    },
    /// Requests the surface at a point of the picture, from 0 to 1 to the right and down.
    Pick {
        id: u64,
        x: f32,
        y: f32,
    },
    /// Adds or replaces the key of the current frame.
    Set,
    Move {
        from: f64,
        to: f64,
    },
    Delete {
        frame: f64,
    },
    Save {
        #[serde(default)]
        force: bool,
    },
    Load,
    /// Loads the scene again.
    Reload,
    /// Starts the batch job, and stops it.
    Render,
    Cancel,
    /// The page has drawn the picture and is ready for the next one.
    Ack,
}

impl PageMessage {
    /// The number of a message that changes the view.
    pub fn seq(&self) -> Option<u64> {
        match self {
            Self::View { seq, .. } | Self::Home { seq } | Self::Frame { seq, .. } | Self::Look { seq, .. } => {
                Some(*seq)
            }
            _ => None,
        }
    }
}

/// The first message to a page, and the first after the scene was loaded again.
#[derive(Debug, Serialize)]
pub struct Hello<'a> {
    pub t: &'static str,
    pub client: u64,
    pub scene: &'a str,
    pub resolution: [u32; 2],
    pub integrators: &'a [&'a str],
    pub views: &'a [&'a str],
    pub passes: &'a [&'a str],
    /// The columns of camera paths that the lens of the scene supports.
    pub columns: &'a [&'a str],
    /// A suitable step of the camera, in m.
    pub step: f64,
    pub fps: f64,
    /// The first and the last frame of the job, if frames have different scenes.
    pub frames: Option<[i32; 2]>,
    pub up: [f64; 3],
    pub has_home: bool,
    /// A line for each kind of warning about the scene.
    pub warnings: Vec<String>,
}

/// The facts that a page shows beside pictures.
#[derive(Debug, Serialize)]
pub struct Facts<'a> {
    pub t: &'static str,
    pub look: &'a Look,
    pub file: String,
    /// Whether there are unsaved keys.
    pub is_changed: bool,
    /// The command that renders the path with the look of the page.
    pub command: String,
}

/// A key on the timeline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeyFact {
    pub frame: f64,
    pub name: Option<String>,
    pub interp: &'static str,
}

impl KeyFact {
    pub fn of(key: &PathKey) -> Self {
        Self {
            frame: key.frame,
            name: key.name.clone(),
            interp: match key.interp {
                Interp::Smooth => "smooth",
                Interp::Linear => "linear",
                Interp::Step => "hold",
            },
        }
    }
}

/// The change of the keys since the last message, so that an edit of one key sends this key only.
#[derive(Debug, PartialEq, Serialize)]
pub struct KeysChange<'a> {
    pub t: &'static str,
    /// The index of the first key that differs.
    pub at: usize,
    /// The number of keys that are removed there.
    pub remove: usize,
    /// The keys in their place.
    pub insert: &'a [KeyFact],
}

impl<'a> KeysChange<'a> {
    /// The change from `old` to `new`.
    pub fn between(old: &[KeyFact], new: &'a [KeyFact]) -> Self {
        let at = old.iter().zip(new).take_while(|(a, b)| a == b).count();
        let (old, new) = (&old[at..], &new[at..]);
        let same = old.iter().rev().zip(new.iter().rev());
        let end = same.take_while(|(a, b)| a == b).count();
        Self {
            t: "keys",
            at,
            remove: old.len() - end,
            insert: &new[..new.len() - end],
        }
    }
}

/// The state of the scene on disk.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SceneFacts {
    pub t: &'static str,
    /// Whether the scene on disk is another than that of the page.
    pub has_changed: bool,
    pub is_loading: bool,
    /// Why the scene on disk was not loaded.
    pub error: String,
    /// Why the frame of the view has no picture.
    pub frame_error: String,
    /// The number of times that the scene was loaded again.
    pub loads: u64,
}

/// The state of the job.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct JobFacts {
    pub t: &'static str,
    /// `idle`, `loading`, `running`, `done`, `failed` or `cancelled`.
    pub state: &'static str,
    pub frame: i32,
    /// The number of frames on disk, and of all.
    pub done: usize,
    pub frames: usize,
    /// The fraction of the current frame that is rendered, from 0 to 1.
    pub fraction: f64,
    /// The last file that was written, or why the job failed.
    pub text: String,
}

/// The surface at a point of the picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Picked {
    pub object: String,
    pub material: String,
    /// From the camera, in m.
    pub distance: f64,
    /// The depth along the line of sight, in m: the focus distance for this surface.
    pub depth: f64,
    /// In m, in the world.
    pub point: [f64; 3],
}

/// Answers to single pages.
#[derive(Debug, Serialize)]
#[serde(tag = "t", rename_all = "lowercase")]
pub enum Answer {
    Picked {
        id: u64,
        found: Option<Picked>,
    },
    /// The result of a request.
    Note {
        is_error: bool,
        text: String,
        /// The number of the message that was refused.
        seq: Option<u64>,
    },
    /// The file on disk has changed since it was read.
    Foreign,
}

impl Answer {
    pub fn done(text: impl Into<String>) -> Self {
        Self::Note {
            is_error: false,
            text: text.into(),
            seq: None,
        }
    }

    pub fn error(error: impl ToString) -> Self {
        Self::Note {
            is_error: true,
            text: error.to_string(),
            seq: None,
        }
    }

    /// The refusal of the message `seq`.
    pub fn refusal(seq: Option<u64>, text: String) -> Self {
        Self::Note {
            is_error: true,
            text,
            seq,
        }
    }
}

/// The first parameter that is not one of `columns`, those that the lens of the scene supports.
pub fn unsupported(lens: &LensNumbers, columns: &[&str]) -> Option<&'static str> {
    let given = lens.overrides();
    given.columns().find(|column| !columns.contains(column))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_keys_has_the_keys_that_differ() {
        let keys = |frames: &[u8]| -> Vec<KeyFact> {
            let key = |frame: &u8| KeyFact {
                frame: f64::from(*frame),
                name: None,
                interp: "smooth",
            };
            frames.iter().map(key).collect()
        };
        for (old, new, at, remove, insert) in [
            (&[][..], &[1, 2][..], 0, 0, &[1, 2][..]),
            (&[1, 2], &[], 0, 2, &[]),
            (&[1, 2, 3], &[1, 2, 3], 3, 0, &[]),
            (&[1, 2, 3], &[1, 3], 1, 1, &[]),
            (&[1, 3], &[1, 2, 3], 1, 0, &[2]),
            (&[1, 5, 9], &[1, 6, 9], 1, 1, &[6]),
            (&[1, 5, 9], &[5, 9, 11], 0, 3, &[5, 9, 11]),
        ] {
            let (new, insert) = (keys(new), keys(insert));
            let change = KeysChange::between(&keys(old), &new);
            let t = "keys";
            let insert = &insert[..];
            assert_eq!(change, KeysChange { t, at, remove, insert });
        }
    }
}
