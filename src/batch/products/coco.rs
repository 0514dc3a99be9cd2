//! The content of `coco.json`: the instances of objects in the pictures of a sequence, as the data set COCO has them.
//!
//! A picture's number is that of its frame, and an instance's number is that of the frame times 1,000,000 and that of the object. So
//! both are the same in every part of a job.
//!
//! A mask has the pixels whose centre shows the object, the pass `objectId` with one sample. It is a run-length encoding of columns:
//! the lengths of runs of 0 and 1 by turns, each but the first two as the difference from the one but one before it, in groups of 5 bits from the lowest
//! with a sixth bit where more follow, as characters from `0` on.
//!
//! Source: Lin et al., "Microsoft COCO: Common Objects in Context", ECCV 2014, doi:10.1007/978-3-319-10602-1_48; cocodataset.org, "Data format".

use std::{borrow::Cow, collections::HashSet, path::Path};

use serde::{Deserialize, Serialize};

use super::transforms::picture_name;
use crate::{
    batch::{FrameFailure, Plan, plan::metering::OBJECTS},
    film::Film,
    scene::{MatteKind, ObjectRole, Part, Scene},
    warnings::WarningKind,
};

/// The numbers of the instances of a frame, of which each object has one.
const STRIDE: i64 = 1_000_000;

/// The conventions of the file, in words.
const CONVENTIONS: &str = "image_id is the number of the frame; object_id is the number in objectId and ids.json, from 1; a mask has the pixels whose \
     centre shows the object, and bbox is x, y, width, height of these pixels";

#[derive(Serialize, Deserialize)]
pub(super) struct Coco {
    info: Info,
    images: Vec<Image>,
    annotations: Vec<Annotation>,
    categories: Vec<Category>,
}

#[derive(PartialEq, Serialize, Deserialize)]
struct Info {
    description: Cow<'static, str>,
}

#[derive(Serialize, Deserialize)]
struct Image {
    id: i64,
    width: u32,
    height: u32,
    file_name: String,
}

#[derive(Serialize, Deserialize)]
struct Annotation {
    id: i64,
    image_id: i64,
    category_id: usize,
    object_id: usize,
    segmentation: Mask,
    area: u32,
    bbox: [u32; 4],
    iscrowd: u8,
}

/// A run-length encoding.
#[derive(Serialize, Deserialize)]
struct Mask {
    /// Height and width.
    size: [u32; 2],
    counts: String,
}

#[derive(PartialEq, Serialize, Deserialize)]
struct Category {
    id: usize,
    name: String,
    supercategory: String,
}

/// The instances of the frames of a job, as they are rendered.
#[derive(Default)]
pub(in crate::batch) struct Instances {
    images: Vec<Image>,
    annotations: Vec<Annotation>,
}

impl Instances {
    /// Adds the instances of a frame, whose film has the numbers of objects.
    pub fn add(&mut self, plan: &Plan, frame: i32, (film, scene): (&Film, &Scene)) {
        let plane = film.plane(OBJECTS).expect("the pass was requested");
        let size = [film.window.width(), film.window.height()];
        let image_id = i64::from(frame);
        self.images.push(Image {
            id: image_id,
            width: size[0],
            height: size[1],
            file_name: picture_name(plan, frame),
        });
        let categories = Categories::new(scene);
        let parts = scene.mattes().parts();
        let mut found: Vec<Option<Runs>> = parts.iter().map(|_| None).collect();
        let [width, height] = size.map(|n| n as usize);
        for column in 0..width {
            for row in 0..height {
                let number = plane.values[row * width + column].to_bits() as usize;
                if let Some(runs) = number.checked_sub(1).and_then(|part| found.get_mut(part)) {
                    runs.get_or_insert_default()
                        .add([column as u32, row as u32], height as u32);
                }
            }
        }
        for (part, runs) in found.into_iter().enumerate() {
            let Some(runs) = runs.filter(|_| is_ordinary(scene, &parts[part])) else {
                continue;
            };
            self.annotations.push(Annotation {
                id: image_id * STRIDE + part as i64 + 1,
                image_id,
                category_id: categories.of_parts[part],
                object_id: part + 1,
                area: runs.area,
                bbox: runs.bounds(),
                segmentation: Mask {
                    size: [size[1], size[0]],
                    counts: runs.counts(size),
                },
                iscrowd: 0,
            });
        }
    }

    /// The file of these frames but for those that failed.
    pub(super) fn file(self, scene: &Scene, failures: &[FrameFailure]) -> Coco {
        let failed: HashSet<i64> = failures.iter().map(|failure| failure.frame.into()).collect();
        let (mut images, mut annotations) = (self.images, self.annotations);
        images.retain(|image| !failed.contains(&image.id));
        annotations.retain(|annotation| !failed.contains(&annotation.image_id));
        Coco {
            info: Info {
                description: CONVENTIONS.into(),
            },
            images,
            annotations,
            categories: Categories::new(scene).all,
        }
    }
}

/// Whether a part is neither a shadow catcher nor a holdout.
fn is_ordinary(scene: &Scene, part: &Part) -> bool {
    scene.geometry.objects[part.object.0 as usize].role == ObjectRole::Ordinary
}

impl Coco {
    /// Adds the frames of other jobs of the same sequence, in rising order. Frames of this job replace theirs.
    pub fn join(&mut self, others: Self, plan: &Plan, path: &Path) {
        if (&self.info, &self.categories) != (&others.info, &others.categories) {
            let (frames, path) = (others.images.len(), path.display());
            let text = format!("the {frames} frames of other jobs are lost: they have other objects: {path}");
            plan.warnings.add_live(WarningKind::LOST_FRAMES, path, text);
            return;
        }
        let own: HashSet<i64> = self.images.iter().map(|image| image.id).collect();
        let is_other = |image: &Image| {
            let name = i32::try_from(image.id).map(|frame| picture_name(plan, frame));
            !own.contains(&image.id) && name.as_ref() == Ok(&image.file_name)
        };
        let images: Vec<Image> = others.images.into_iter().filter(is_other).collect();
        let added: HashSet<i64> = images.iter().map(|image| image.id).collect();
        let annotations = others.annotations.into_iter();
        self.annotations
            .extend(annotations.filter(|annotation| added.contains(&annotation.image_id)));
        self.images.extend(images);
        self.images.sort_by_key(|image| image.id);
        self.annotations.sort_by_key(|annotation| annotation.id);
    }
}

/// The categories of a scene, in the order of its objects.
struct Categories {
    all: Vec<Category>,
    /// The number of the category of each part.
    of_parts: Vec<usize>,
}

impl Categories {
    fn new(scene: &Scene) -> Self {
        let mattes = scene.mattes();
        let names = &mattes.table(MatteKind::Object).mattes;
        let (mut all, mut of_parts) = (Vec::<Category>::new(), Vec::new());
        for part in mattes.parts() {
            let name = match part.matte {
                Some(matte) => names[matte as usize].name.clone(),
                None => scene.part_name(part.object, part.node),
            };
            let name = without_number(&name);
            let known = all
                .iter()
                .find(|category| category.name == name)
                .map(|category| category.id);
            of_parts.push(known.unwrap_or_else(|| {
                all.push(Category {
                    id: all.len() + 1,
                    name: name.to_owned(),
                    supercategory: name.split('/').next().unwrap_or_default().to_owned(),
                });
                all.len()
            }));
        }
        Self { all, of_parts }
    }
}

/// A name without the number that tells it from others of its kind: `chair` of `chair.001` and `chair_2`.
fn without_number(name: &str) -> &str {
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let is_gap = |c: char| matches!(c, '.' | '_' | '-' | ' ');
    match stem.strip_suffix(is_gap).map(|stem| stem.trim_end_matches(is_gap)) {
        Some(short) if stem.len() < name.len() && !short.is_empty() && !short.ends_with('/') => short,
        _ => name,
    }
}

/// The pixels of an object, as runs down the columns.
#[derive(Default)]
struct Runs {
    /// The first pixel of each run and the one after its last, counted down the columns.
    runs: Vec<[u32; 2]>,
    area: u32,
    /// The first and the last column and row.
    corners: Option<[[u32; 2]; 2]>,
}

impl Runs {
    /// Adds a pixel that comes after all others.
    fn add(&mut self, pixel: [u32; 2], height: u32) {
        let at = pixel[0] * height + pixel[1];
        match self.runs.last_mut() {
            Some([_, end]) if *end == at => *end += 1,
            _ => self.runs.push([at, at + 1]),
        }
        self.area += 1;
        let [first, last] = self.corners.get_or_insert([pixel; 2]);
        for axis in 0..2 {
            first[axis] = first[axis].min(pixel[axis]);
            last[axis] = last[axis].max(pixel[axis]);
        }
    }

    /// The first column and row, the width and the height.
    fn bounds(&self) -> [u32; 4] {
        let [[x0, y0], [x1, y1]] = self.corners.unwrap_or_default();
        [x0, y0, x1 + 1 - x0, y1 + 1 - y0]
    }

    /// The encoding in a picture of this size.
    fn counts(&self, [width, height]: [u32; 2]) -> String {
        let mut lengths = Vec::with_capacity(2 * self.runs.len() + 1);
        let mut end = 0;
        for [from, to] in &self.runs {
            lengths.extend([from - end, to - from]);
            end = *to;
        }
        if end < width * height {
            lengths.push(width * height - end);
        }
        let lengths: Vec<i64> = lengths.into_iter().map(i64::from).collect();
        let mut text = String::new();
        for (i, length) in lengths.iter().enumerate() {
            let mut rest = if i > 2 { length - lengths[i - 2] } else { *length };
            loop {
                let group = (rest & 0x1f) as u8;
                rest >>= 5;
                // The highest bit of the last group is the sign.
                let is_last = rest == if group & 0x10 == 0 { 0 } else { -1 };
                text.push(char::from(b'0' + (group | if is_last { 0 } else { 0x20 })));
                if is_last {
                    break;
                }
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(rows: &[&str]) -> (Runs, [u32; 2]) {
        let size = [rows[0].len() as u32, rows.len() as u32];
        let mut runs = Runs::default();
        for column in 0..size[0] {
            for row in 0..size[1] {
                if rows[row as usize].as_bytes()[column as usize] == b'#' {
                    runs.add([column, row], size[1]);
                }
            }
        }
        (runs, size)
    }

    /// The lengths that a text encodes.
    fn decoded(text: &str) -> Vec<i64> {
        let (mut lengths, mut bytes) = (Vec::<i64>::new(), text.bytes().peekable());
        while bytes.peek().is_some() {
            let (mut value, mut shift) = (0, 0);
            for byte in bytes.by_ref() {
                let group = i64::from(byte - b'0');
                value |= (group & 0x1f) << shift;
                shift += 5;
                if group & 0x20 == 0 {
                    if group & 0x10 != 0 {
                        value |= -1 << shift;
                    }
                    break;
                }
            }
            if lengths.len() > 2 {
                value += lengths[lengths.len() - 2];
            }
            lengths.push(value);
        }
        lengths
    }

    #[test]
    fn masks_are_runs_of_columns_with_their_box_and_area() {
        let (mask, size) = runs(&["....", ".##.", ".#.#"]);
        assert_eq!((mask.area, mask.bounds()), (4, [1, 1, 3, 2]));
        assert_eq!(decoded(&mask.counts(size)), [4, 2, 1, 1, 3, 1]);
        let (whole, size) = runs(&["##", "##"]);
        assert_eq!(
            (decoded(&whole.counts(size)), whole.bounds()),
            (vec![0, 4], [0, 0, 2, 2])
        );
        // As pycocotools encodes it.
        assert_eq!(whole.counts(size), "04");
    }

    #[test]
    fn long_and_shrinking_runs_come_back() {
        let mut mask = Runs::default();
        for at in (0..5000).chain([5001, 6000, 6001, 9000]) {
            mask.add([at / 100, at % 100], 100);
        }
        let lengths = [0, 5000, 1, 1, 998, 2, 2998, 1, 999];
        assert_eq!(decoded(&mask.counts([100, 100])), lengths);
    }

    #[test]
    fn categories_are_names_without_the_number_at_their_end() {
        let names = [
            "chair.001",
            "chair_2",
            "chair",
            "model/leg-12",
            "ball 1",
            "7",
            "a/7",
            "room2",
            "a._1",
        ];
        let expected = ["chair", "chair", "chair", "model/leg", "ball", "7", "a/7", "room2", "a"];
        assert_eq!(names.map(without_number), expected);
    }
}
