//! The content of `coco.json`: the instances of objects in the pictures of a sequence, as the data set COCO has them.
//!
//! The number of a picture is that of its frame. The number of an instance is that of its picture times 1,000,000, plus the number
//! of its object, from 1. So both are the same in every part of a job. A sequence with other names in the same file has picture
//! numbers that are larger by a multiple of 1,000,000. Where materials are the categories, an instance is the part of an object
//! with one material. Its place among the instances of its picture, from 1, then takes the place of the object's number.
//!
//! A mask has the pixels whose centre shows the object, the pass `objectId` with one sample.
//!
//! Categories are sorted by their names, so that they have the same numbers whichever part of a job comes first. Frames may show
//! other objects than those before them: each has the categories of its own scene, and the file those of all.
//!
//! Source: Lin et al., "Microsoft COCO: Common Objects in Context", ECCV 2014,
//! doi:10.1007/978-3-319-10602-1_48; cocodataset.org, "Data format".

pub mod categories;
mod runs;

use std::{
    borrow::Cow,
    cmp::Ordering,
    collections::{BTreeMap, HashMap, HashSet},
    path::Path,
};

use serde::{Deserialize, Serialize};

use self::{
    categories::{CategoryKind, CategoryName, MATERIALS, categories},
    runs::Runs,
};
use super::transforms::picture_name;
use crate::{
    batch::{Plan, plan::metering::OBJECTS},
    film::Film,
    math::sorting,
    scene::{ObjectRole, Part, Scene},
    warnings::WarningKind,
};

/// The difference between the numbers of the instances of one picture and those of the next.
const STRIDE: i64 = 1_000_000;

/// The difference between the numbers of the pictures of one sequence and those of the next.
const BLOCK: i64 = 1_000_000;

/// The conventions of the file, in words.
const CONVENTIONS: &str = "image_id is the number of the frame, plus 1,000,000 for each sequence of other names before it; object_id is the number \
     in objectId and ids.json, from 1; a mask has the pixels whose centre shows the object, and bbox is x, y, width, height of these pixels";

#[derive(Serialize, Deserialize)]
pub(super) struct Coco {
    info: Info,
    images: Vec<Image>,
    annotations: Vec<Annotation>,
    categories: Vec<Category>,
}

#[derive(Serialize, Deserialize)]
struct Info {
    description: Cow<'static, str>,
    /// What categories are named after, which a file of an older version does not say.
    #[serde(default)]
    categories: Option<Cow<'static, str>>,
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
    /// The name of the object, which a file of an older version does not have.
    #[serde(default)]
    object_name: String,
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

#[derive(Serialize, Deserialize)]
struct Category {
    id: usize,
    name: String,
    supercategory: String,
}

impl Category {
    fn compare(&self, other: &Self) -> Ordering {
        (&self.name, &self.supercategory).cmp(&(&other.name, &other.supercategory))
    }
}

/// The instances of the frames of a job, as they are rendered.
#[derive(Default)]
pub(in crate::batch) struct Instances {
    images: Vec<Image>,
    annotations: Vec<Annotation>,
    /// The names of categories, and the number of each, from 1, by its first use.
    categories: HashMap<CategoryName, usize>,
}

impl Instances {
    /// Those of no frame yet, with the categories of all models that frames may show, where files are categories.
    pub fn new(plan: &Plan) -> Self {
        let mut own = Self::default();
        if plan.files.categories == CategoryKind::File {
            let files = plan.values.iter().flat_map(|values| values.model_files());
            for file in files {
                own.category(CategoryName::of_file(&plan.files.scene.with_file_name(file)));
            }
        }
        own
    }

    /// Adds the instances of a frame, whose film has the numbers of objects, and those of materials where they are the categories.
    pub fn add(&mut self, plan: &Plan, frame: i32, (film, scene): (&Film, &Scene)) {
        let size = [film.window.width(), film.window.height()];
        let image_id = i64::from(frame);
        self.images.push(Image {
            id: image_id,
            width: size[0],
            height: size[1],
            file_name: picture_name(plan, frame),
        });
        let kind = plan.files.categories;
        let names = categories(kind, scene, &plan.files.scene);
        let parts = scene.mattes().parts();
        let has_instances = |i: usize| kind == CategoryKind::Material || is_ordinary(scene, &parts[i]);
        let numbered = |(i, name)| has_instances(i).then(|| self.category(name));
        let numbers: Vec<Option<usize>> = names.into_iter().enumerate().map(numbered).collect();
        let found = instances(film, kind);
        let known = found.into_iter().filter(|((part, _), _)| {
            let part = parts.get(*part);
            part.is_some_and(|part| is_ordinary(scene, part))
        });
        for (place, ((part, material), runs)) in known.enumerate() {
            let (of_kind, number) = match kind {
                CategoryKind::Material => (material, place),
                CategoryKind::Object | CategoryKind::File | CategoryKind::Scene => (part, part),
            };
            self.annotations.push(Annotation {
                id: image_id * STRIDE + number as i64 + 1,
                image_id,
                category_id: numbers[of_kind].expect("ordinary parts have categories"),
                object_id: part + 1,
                object_name: scene.name_of(&parts[part]),
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

    fn category(&mut self, name: CategoryName) -> usize {
        let next = self.categories.len() + 1;
        *self.categories.entry(name).or_insert(next)
    }

    /// The file of those of these frames that are on disk.
    pub(super) fn file(self, kind: CategoryKind, done: &HashSet<i32>) -> Coco {
        let is_done = |frame: i64| i32::try_from(frame).is_ok_and(|frame| done.contains(&frame));
        let (mut images, mut annotations) = (self.images, self.annotations);
        images.retain(|image| is_done(image.id));
        annotations.retain(|annotation| is_done(annotation.image_id));
        let categories = self.categories.into_iter();
        let mut file = Coco {
            info: Info {
                description: CONVENTIONS.into(),
                categories: Some(kind.name().into()),
            },
            images,
            annotations,
            categories: categories
                .map(|(CategoryName { name, supercategory }, id)| Category {
                    id,
                    name,
                    supercategory,
                })
                .collect(),
        };
        file.sort();
        file
    }
}

/// The pixels of each instance, by the indices of its part and its material. The latter is 0 unless materials are the categories.
fn instances(film: &Film, kind: CategoryKind) -> BTreeMap<(usize, usize), Runs> {
    let plane = |name| &film.plane(name).expect("the pass was requested").values;
    let objects = plane(OBJECTS);
    let materials = (kind == CategoryKind::Material).then(|| plane(MATERIALS));
    let [width, height] = [film.window.width(), film.window.height()].map(|n| n as usize);
    let at = |column: usize, row: usize| {
        let pixel = row * width + column;
        let part = (objects[pixel].to_bits() as usize).checked_sub(1)?;
        let material = materials.map_or(0, |materials| (materials[pixel].to_bits() as usize).saturating_sub(1));
        Some((part, material))
    };
    let mut found: BTreeMap<(usize, usize), Runs> = BTreeMap::new();
    for column in 0..width {
        let mut row = 0;
        while row < height {
            let shown = at(column, row);
            let end = (row..height).find(|row| at(column, *row) != shown).unwrap_or(height);
            if let Some(shown) = shown {
                let runs = found.entry(shown).or_default();
                (row..end).for_each(|row| runs.add([column as u32, row as u32], height as u32));
            }
            row = end;
        }
    }
    found
}

/// Whether a part is neither a shadow catcher nor a holdout.
fn is_ordinary(scene: &Scene, part: &Part) -> bool {
    scene.geometry.objects[part.object.0 as usize].role == ObjectRole::Ordinary
}

impl Coco {
    /// Adds the pictures of other jobs in the file that is there, whose folder is `folder`: those of the same sequence, and those
    /// of other names as long as they are there. Pictures of this job replace theirs.
    pub fn join(&mut self, others: Self, plan: &Plan, folder: &Path) {
        let own: HashSet<String> = self.images.iter().map(|image| image.file_name.clone()).collect();
        let (mut images, mut offset, mut taken) = (Vec::new(), None, HashSet::new());
        for image in others.images {
            let own_offset = offset_in_sequence(&image, plan);
            let is_kept = match own_offset {
                Some(_) => plan.is_chunk,
                None => folder.join(&image.file_name).is_file(),
            };
            match own_offset {
                Some(_) => offset = offset.or(own_offset),
                None if is_kept => drop(taken.insert(image.id.div_euclid(BLOCK))),
                None => {}
            }
            if is_kept && !own.contains(&image.file_name) {
                images.push(image);
            }
        }
        let free = || {
            let blocks: HashSet<i64> = self.images.iter().map(|image| image.id.div_euclid(BLOCK)).collect();
            let is_free = |at: &i64| blocks.iter().all(|block| !taken.contains(&(block + at)));
            (0..).find(is_free).expect("there are more numbers than pictures") * BLOCK
        };
        self.shift(offset.unwrap_or_else(free));
        if images.is_empty() {
            return;
        }
        if let (Some(own), Some(other)) = (&self.info.categories, &others.info.categories)
            && own != other
        {
            let path = folder.join("coco.json");
            let path = path.display();
            let text = format!(
                "the categories of this job are named after `{own}`, those of other pictures after `{other}` (--categories): {path}"
            );
            plan.warnings.add_live(WarningKind::MIXED_LABELS, &path, text);
        }
        let first = self.categories.len();
        let number: HashMap<usize, usize> = (others.categories.iter().map(|category| category.id))
            .zip(first + 1..)
            .collect();
        let added: HashSet<i64> = images.iter().map(|image| image.id).collect();
        let annotations = others.annotations.into_iter().filter_map(|annotation| {
            let category_id = *number.get(&annotation.category_id)?;
            added.contains(&annotation.image_id).then_some(Annotation {
                category_id,
                ..annotation
            })
        });
        self.annotations.extend(annotations);
        self.categories
            .extend(others.categories.into_iter().map(|category| Category {
                id: number[&category.id],
                ..category
            }));
        self.images.extend(images);
        self.sort();
    }

    /// Adds a number to those of pictures.
    fn shift(&mut self, offset: i64) {
        self.images.iter_mut().for_each(|image| image.id += offset);
        for annotation in &mut self.annotations {
            annotation.image_id += offset;
            annotation.id += offset * STRIDE;
        }
    }

    /// Puts the names of folders before those of files that are the same in several folders.
    fn tell_files_apart(&mut self) {
        let are_files = [CategoryKind::File, CategoryKind::Scene].map(|kind| Some(kind.name().into()));
        if !are_files.contains(&self.info.categories) {
            return;
        }
        sorting::sort_by(&mut self.categories, Category::compare);
        let pair = |category: &Category| [category.name.clone(), category.supercategory.clone()];
        let known: Vec<[String; 2]> = self.categories.iter().map(pair).collect();
        for category in &mut self.categories {
            let [name, folder] = pair(category);
            let first = known.partition_point(|[other, _]| *other < name);
            let next = known.partition_point(|[other, _]| *other <= name);
            let is_shared = known[first][1] != known[next - 1][1];
            let whole = [format!("{folder}/{name}"), folder];
            if is_shared || known.binary_search(&whole).is_ok() {
                [category.name, _] = whole;
            }
        }
    }

    /// Sorts all by their numbers, and categories by their names, each of which is there once.
    fn sort(&mut self) {
        self.tell_files_apart();
        sorting::sort_by(&mut self.categories, Category::compare);
        let mut numbers = HashMap::new();
        let mut sorted: Vec<Category> = Vec::with_capacity(self.categories.len());
        for category in std::mem::take(&mut self.categories) {
            let last = sorted.last();
            let is_known =
                last.is_some_and(|last| (&last.name, &last.supercategory) == (&category.name, &category.supercategory));
            let id = sorted.len() + usize::from(!is_known);
            numbers.insert(category.id, id);
            if !is_known {
                sorted.push(Category { id, ..category });
            }
        }
        self.categories = sorted;
        for annotation in &mut self.annotations {
            annotation.category_id = numbers[&annotation.category_id];
        }
        sorting::sort_by_key(&mut self.images, |image| image.id);
        sorting::sort_by_key(&mut self.annotations, |annotation| annotation.id);
    }
}

/// The difference of the number of a picture from that of its frame, if it is one of the sequence of the plan.
fn offset_in_sequence(image: &Image, plan: &Plan) -> Option<i64> {
    let block = image.id.div_euclid(BLOCK).max(0);
    [block, block + 1, 0]
        .map(|block| block * BLOCK)
        .into_iter()
        .find(|offset| {
            let frame = i32::try_from(image.id - offset);
            frame.is_ok_and(|frame| picture_name(plan, frame) == image.file_name)
        })
}
