//! Reconstructions as texts.

use std::{collections::HashMap, fmt::Write as _};

use super::{
    model::{CameraModel, FileCamera},
    record::{Picture, Place},
    written::Reconstruction,
};
use crate::{
    assets::camera_path::{
        PathProblem, PathProblems,
        source::{self, Words},
    },
    value::one_line,
};

/// `CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]`.
pub fn cameras(bytes: &[u8]) -> Result<HashMap<u32, FileCamera>, PathProblems> {
    let (mut cameras, mut problems) = (HashMap::new(), PathProblems::default());
    for words in source::lines(source::text(bytes)?) {
        match camera(&words) {
            Ok((id, camera)) => drop(cameras.insert(id, camera)),
            Err(problem) => problems.push(problem),
        }
    }
    if problems.is_empty() {
        Ok(cameras)
    } else {
        Err(problems)
    }
}

fn camera(words: &Words<'_>) -> Result<(u32, FileCamera), PathProblem> {
    let id = id(words, 0, "CAMERA_ID")?;
    let name = words.words.get(1).copied().unwrap_or_default();
    let unknown = || {
        PathProblem::of_cell(
            words.line,
            "MODEL",
            format!("unknown camera model `{}`", one_line(name, 80)),
        )
    };
    let model = CameraModel::by_name(name).ok_or_else(unknown)?;
    let size = words.numbers(2, ["WIDTH", "HEIGHT"])?;
    let (found, expected) = (words.words.len() - 4, model.parameters());
    if found != expected {
        return Err(words.problem(format!("the model {name} has {expected} parameters, found {found}")));
    }
    let parameters = (4..4 + found).map(|i| words.number(i, "PARAMS"));
    let camera = FileCamera {
        place: Place::Line(words.line),
        model,
        size,
        parameters: parameters.collect::<Result<_, _>>()?,
    };
    Ok((id, camera))
}

/// Two lines for each image, `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME` and its points, which may be an empty line.
pub fn images(bytes: &[u8]) -> Result<Vec<Picture>, PathProblems> {
    let (mut pictures, mut problems) = (Vec::new(), PathProblems::default());
    let mut lines = source::text(bytes)?.lines().enumerate();
    while let Some((i, line)) = lines.next() {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let words = Words {
            line: i + 1,
            words: line.split_whitespace().collect(),
        };
        match picture(&words, line) {
            Ok(picture) => pictures.push(picture),
            Err(problem) => problems.push(problem),
        }
        if let Some((i, line)) = lines.next()
            && !are_points(line)
        {
            let message =
                "expected the points of the image above (X, Y, POINT3D_ID of each), or an empty line where it has none";
            problems.push(PathProblem::of_line(i + 1, message));
        }
    }
    if problems.is_empty() {
        Ok(pictures)
    } else {
        Err(problems)
    }
}

/// Whether a line has three numbers for each point, or none. A comment stands for no points.
fn are_points(line: &str) -> bool {
    let mut words = line.split_whitespace();
    line.trim_start().starts_with('#') || words.clone().count().is_multiple_of(3) && words.all(is_number)
}

fn is_number(word: &str) -> bool {
    word.parse::<f64>().is_ok()
}

fn picture(words: &Words<'_>, line: &str) -> Result<Picture, PathProblem> {
    id(words, 0, "IMAGE_ID")?;
    let rotation = words.numbers(1, ["QW", "QX", "QY", "QZ"])?;
    let translation = words.numbers(5, ["TX", "TY", "TZ"])?;
    let camera = id(words, 8, "CAMERA_ID")?;
    // A name may have blanks.
    let name = (0..9).try_fold(line, |rest, _| {
        let rest = rest.trim_start();
        rest.split_once(char::is_whitespace).map(|(_, rest)| rest)
    });
    let name = name.map(str::trim).filter(|name| !name.is_empty());
    let name = name.ok_or_else(|| PathProblem::of_cell(words.line, "NAME", "the name of the image is missing"))?;
    Ok(Picture {
        place: Place::Line(words.line),
        rotation,
        translation,
        camera,
        name: name.to_owned(),
    })
}

fn id(words: &Words<'_>, column: usize, name: &str) -> Result<u32, PathProblem> {
    let word = words.words.get(column).copied().unwrap_or_default();
    let message = || format!("'{}' is not a whole number of at least 0", one_line(word, 80));
    let parsed = word.parse();
    parsed.map_err(|_| PathProblem::of_cell(words.line, name, message()))
}

/// The names and the texts of the files.
pub fn files(all: &Reconstruction) -> [(&'static str, String); 3] {
    let mut images =
        String::from("# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME, and a line without points\n");
    for (i, shot) in all.shots.iter().enumerate() {
        write!(images, "{}", i + 1).expect("a text grows");
        for number in shot.pose {
            write!(images, " {number}").expect("a text grows");
        }
        writeln!(images, " {} {}\n", shot.camera + 1, shot.name).expect("a text grows");
    }
    let mut cameras = String::from("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n");
    for (i, camera) in all.cameras.iter().enumerate() {
        let [width, height] = camera.size;
        write!(cameras, "{} {} {width} {height}", i + 1, camera.model.name).expect("a text grows");
        for number in &camera.parameters {
            write!(cameras, " {number}").expect("a text grows");
        }
        cameras.push('\n');
    }
    let points = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]\n".to_owned();
    [
        ("cameras.txt", cameras),
        ("images.txt", images),
        ("points3D.txt", points),
    ]
}
