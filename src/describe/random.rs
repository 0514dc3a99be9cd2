//! Values that are drawn at random for each frame.
//!
//! A draw depends on the seed, the name of the scene, the name of the value and the number of the frame, and on nothing else: not
//! on other values, nor on the frames that a job renders, nor on their order.

use std::{collections::HashMap, path::PathBuf, sync::Arc};

use toml::de::{DeTable, DeValue};

use super::Source;
use crate::value::{Problem, Span, Spanned, is_override};

mod distribution;
mod draw;
mod read;
mod wildcards;

pub use distribution::Distribution;
pub use draw::DrawKey;
pub(super) use wildcards::is_wildcard;

/// Values that are drawn at random for each frame: another light, place or material in every picture of a data set.
///
/// | key | type | default |
/// |---|---|---|
/// | `seed` | a whole number: each has draws of its own | 0 |
/// | `scene` | a text that takes the place of the scene's name | the name of the file without its ending |
/// | the name of a value | a distribution, see below | none |
///
/// The [names](../animation.md#values) are those that `--set` and tables of values have. They stand in quotes, since they have
/// points in them. Whatever can vary over frames can be drawn.
///
/// | distribution | what is drawn |
/// |---|---|
/// | `[1, 10]` or `{ uniform = [1, 10] }` | a number between the two |
/// | `[[0, 0, 0], [1, 1, 0.5]]` | a colour or a vector, whose numbers are drawn each by itself; `uniform`, `log` and `normal` take lists as well |
/// | `{ log = [1, 100] }` | a number whose logarithm is uniform: as many between 1 and 10 as between 10 and 100 |
/// | `{ normal = [5, 1.5], min = 0, max = 10 }` | a number by its mean and its standard deviation, drawn again until it lies between `min` and `max`, of which each may be left out |
/// | `{ integer = [1, 6] }` | a whole number, both ends among them |
/// | `["red", "blue"]` or `[true, false]` | one of these |
/// | `{ choice = [1, 2, [0, 1, 0]], weights = [1, 1, 2] }` | one of any values, all as likely or by their weights |
/// | `"none"` | nothing: the value is that of the scene |
/// | `{ sphere = 3, center = [0, 1, 0], upper = true }` | a point at this distance from `center` (`[0, 0, 0]`), in a direction that is uniform; with `upper` above it, +y. `sphere = [2, 4]` draws the distance as well |
///
/// ```toml
/// [random]
/// seed = 7
/// "light.key.point.intensity" = { log = [20, 200] }
/// "light.key.point.position" = { sphere = [3, 5], center = [0, 1, 0], upper = true }
/// "object.mug.material" = ["red", "blue"]
/// "object.mug.transform.rotate.y" = [0, 360]
/// "background.color" = [[0.02, 0.02, 0.02], [0.3, 0.3, 0.5]]
///
/// [camera]
/// perspective = { eye = [0, 2, 5], target = [0, 1, 0] }
///
/// [material.red]
/// matte = { albedo = [0.8, 0.1, 0.1] }
///
/// [material.blue]
/// matte = { albedo = [0.1, 0.2, 0.8] }
///
/// [[object]]
/// name = "mug"
/// material = "red"
/// shape.cuboid = { min = [-0.5, 0.5, -0.5], max = [0.5, 1.5, 0.5] }
///
/// [[light]]
/// name = "key"
/// point = { position = [0, 4, 0], intensity = 40 }
/// ```
///
/// A frame draws by the seed, the name of the scene, the name of the value and its number, and by nothing else: it is the same
/// by itself, in a chunk, in a job that continues, on any machine and with any other values beside it. Both eyes of stereo, and
/// all crops of a frame, share it. `--views`, `--turntable`, `--frames`, `--values` or `--range` say which frames there are;
/// without any of them it is frame 1.
///
/// - `--random FILE` reads the same keys from a TOML file, in place of this table: for models without a scene file, and for many
///   scenes in one command. `--random 'draws/{scene}.toml'` is a file for each scene. Scenes whose files have the same name draw
///   the same values: `--set 'random.scene="{scene}"'` tells them apart.
/// - `*` in place of a name stands for all objects, lights, materials or textures of the scene that have the value, and each draws
///   by itself: `"object.*.material"`, `"light.*.point.intensity"`. Of a model by itself it stands for all nodes and materials as
///   well: `"material.*.base_color"`; `"object.*"` is the model without the ground of `--ground`. A value that has its whole name
///   in a table or here is not among them.
/// - `--set random.seed=8` draws others, `--set random.light.key.point.intensity=[1,2]` replaces a distribution, and
///   `--set random.light.key.point.intensity=none` takes it out.
/// - A rotation that is uniform has the components of a quaternion that are normal: `rotate.qx`, `.qy`, `.qz` and
///   `.qw`, each `{ normal = [0, 1] }`.
/// - A value that `--set` gives is not drawn. One of which `--set` gives a part, such as `intensity.r`, is an error, and so is one
///   that a table of values has as well.
/// - Draws hold while the shutter is open, so that nothing is blurred by them, and motion vectors lead to where the draws of the
///   next frame put an object. Frames do not help to denoise each other.
/// - What was drawn is in `transforms.json` (`--metadata transforms`) as `values` of each frame, and in the attribute
///   `batch-render/values` of EXR, NPZ and PNG files, as JSON. `--dry-run` lists it before anything is rendered.
/// - Views place the camera: with `--views` its lens can be drawn, such as `"camera.perspective.fov" = [30, 60]`,
///   and not `eye`, `target` and `up`.
/// - The ends of each range and all names are checked before the first frame, whichever frames there are. A normal distribution
///   that lacks an end reaches 8.6 deviations. Values that do not fit together fail at their frame.
/// - A job looks whether all files are there that may be drawn; `--check` and `--dry-run` load each of them, and
///   each variant of a model that may be.
///
/// The file is whole without this table, as it is without a table of values. An example is `scenes/random/scene.toml`.
#[derive(Clone, Debug)]
pub struct RandomDesc {
    /// The file that has it.
    pub path: PathBuf,
    /// Whether that is a file of distributions alone, of which only the draws count.
    pub is_apart: bool,
    pub seed: u64,
    /// The name by which it draws, in place of that of the scene.
    pub scene: Option<String>,
    pub draws: Vec<DrawDesc>,
    /// The values that are not drawn.
    pub left_out: Vec<LeftOut>,
}

/// A value that is not drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The name of the value.
    pub name: String,
    /// The place that says so: a line of a file, or a flag.
    pub origin: String,
    /// Whether a draw by the same name is taken out.
    pub has_draw: bool,
}

/// A value that is drawn.
#[derive(Clone, Debug)]
pub struct DrawDesc {
    /// The name of the value.
    pub name: String,
    /// The place of its distribution: a line of a file, or a flag.
    pub origin: String,
    pub distribution: Arc<Distribution>,
}

impl RandomDesc {
    /// Reads a table of `source`, with its overrides, and collects what is wrong with it.
    pub(super) fn read(mut table: DeTable<'_>, source: &Source, problems: &mut Vec<Problem>) -> Self {
        let Source {
            text, overrides, path, ..
        } = source;
        let mut take = |key: &str| table.remove(key);
        let (seed, scene) = (take("seed"), take("scene"));
        let seed = seed.and_then(|value| kept(read::seed(value, overrides), problems));
        let scene = scene.and_then(|value| kept(read::text(value, overrides), problems));
        let mut found = Vec::new();
        leaves(table, &mut Vec::new(), &mut found, problems);
        let mut draws: Vec<(Span, Drawn)> = Vec::new();
        let mut known: HashMap<String, usize> = HashMap::new();
        for (name, span, value) in found {
            let distribution = match read::is_none(&value) {
                true => Some(None),
                false => kept(read::distribution(value, overrides), problems).map(Some),
            };
            let Some(distribution) = distribution else { continue };
            let line = || 1 + text.get(..span.start).map_or(0, |before| before.matches('\n').count());
            let origin = overrides.origin(&span).map(str::to_owned);
            let origin = origin.unwrap_or_else(|| format!("{}:{}", path.display(), line()));
            let draw = match distribution {
                Some(distribution) => Ok(DrawDesc {
                    name: name.clone(),
                    origin,
                    distribution: Arc::new(distribution),
                }),
                None => Err(LeftOut {
                    name: name.clone(),
                    origin,
                    has_draw: false,
                }),
            };
            match known.get(&name).map(|at| &mut draws[*at]) {
                None => {
                    known.insert(name, draws.len());
                    draws.push((span, draw));
                }
                // A flag wins over the file, however the name is written there.
                Some(other) if is_override(&span) != is_override(&other.0) => {
                    let has_draw = draw.is_ok() || other.1.is_ok();
                    if is_override(&span) {
                        *other = (span, draw);
                    }
                    if let Err(left_out) = &mut other.1 {
                        left_out.has_draw = has_draw;
                    }
                }
                Some(_) => problems.push(Problem::at(span, format!("`{name}` is drawn twice"))),
            }
        }
        Self {
            path: path.clone(),
            is_apart: false,
            seed: seed.unwrap_or_default(),
            scene,
            left_out: (draws.iter())
                .filter_map(|(_, draw)| draw.as_ref().err().cloned())
                .collect(),
            draws: draws.into_iter().filter_map(|(_, draw)| draw.ok()).collect(),
        }
    }
}

/// A value that is drawn, or one that is not.
type Drawn = Result<DrawDesc, LeftOut>;

/// Returns what was read, or collects its problem.
fn kept<T>(read: Result<T, Problem>, problems: &mut Vec<Problem>) -> Option<T> {
    read.map_err(|problem| problems.push(problem)).ok()
}

/// Collects the names with their places and their distributions. A name in one piece has points in it; one that is
/// spread over tables is their keys.
fn leaves<'i>(
    table: DeTable<'i>,
    path: &mut Vec<String>,
    found: &mut Vec<(String, Span, Spanned<DeValue<'i>>)>,
    problems: &mut Vec<Problem>,
) {
    for (key, value) in table {
        path.push(key.get_ref().to_string());
        let is_spread = !key.get_ref().contains('.');
        match value.get_ref() {
            DeValue::Table(table) if is_spread && !read::is_distribution(table) => {
                let span = key.span();
                match value.into_inner() {
                    DeValue::Table(table) if table.is_empty() => {
                        problems.push(Problem::at(span, "there is no distribution"));
                    }
                    DeValue::Table(table) => leaves(table, path, found, problems),
                    _ => unreachable!("it is a table"),
                }
            }
            _ => found.push((path.join("."), key.span(), value)),
        }
        path.pop();
    }
}

#[cfg(test)]
mod tests;
