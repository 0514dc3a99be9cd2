//! The categories of the instances in `coco.json`.

use std::path::Path;

use crate::{
    kind::named,
    scene::{MatteKind, ObjectId, Part, Scene},
};

/// The pass that divides objects by their materials.
pub(in crate::batch) const MATERIALS: &str = "materialId";

named! {
    /// What the category of an instance is named after. Numbers at the ends of names do not count.
    #[derive(Default)]
    pub enum CategoryKind: "categories" {
        /// The object, or the node of its model. The category above it is the object.
        #[default]
        Object = "object",
        /// The material, which then divides objects into instances.
        Material = "material",
        /// The file of the geometry, or the object where there is none. The category above it is the folder of the file.
        File = "file",
        /// The file of the scene. The category above it is its folder.
        Scene = "scene",
    }
}

/// The name of a category and of the one above it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct CategoryName {
    pub name: String,
    pub supercategory: String,
}

impl CategoryName {
    /// That of a name, in which points to parts of things are slashes.
    fn of_name(name: &str) -> Self {
        let name = without_number(name);
        Self {
            name: name.to_owned(),
            supercategory: name.split('/').next().unwrap_or_default().to_owned(),
        }
    }

    /// That of a file.
    pub fn of_file(file: &Path) -> Self {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let own = Self::of_name(&stem);
        let folder = file.parent().and_then(Path::file_name);
        match folder {
            Some(folder) => Self {
                supercategory: folder.to_string_lossy().into_owned(),
                ..own
            },
            None => own,
        }
    }
}

/// The category of each part of a scene, or of each of its materials. `source` is the file of the scene.
pub fn categories(kind: CategoryKind, scene: &Scene, source: &Path) -> Vec<CategoryName> {
    let mattes = scene.mattes();
    let names = |kind| &mattes.table(kind).mattes;
    let of_parts = |name: &dyn Fn(&Part) -> CategoryName| mattes.parts().iter().map(name).collect();
    match kind {
        CategoryKind::Object => of_parts(&|part| CategoryName::of_name(&scene.name_of(part))),
        CategoryKind::Material => {
            let materials = names(MatteKind::Material).iter();
            materials.map(|matte| CategoryName::of_name(&matte.name)).collect()
        }
        CategoryKind::File => of_parts(&|part| {
            let ObjectId(object) = part.object;
            let object = &scene.geometry.objects[object as usize];
            match &object.asset {
                Some(file) => CategoryName::of_file(&source.with_file_name(file)),
                None => CategoryName::of_name(&object.name),
            }
        }),
        CategoryKind::Scene => of_parts(&|_| CategoryName::of_file(source)),
    }
}

/// A name without the number that tells it from others of its kind: `chair` of `chair.001`, `chair_2` and `chair#2`.
fn without_number(name: &str) -> &str {
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let is_gap = |c: char| matches!(c, '.' | '_' | '-' | ' ' | '#');
    match stem.strip_suffix(is_gap).map(|stem| stem.trim_end_matches(is_gap)) {
        Some(short) if stem.len() < name.len() && !short.is_empty() && !short.ends_with('/') => short,
        _ => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn categories_are_names_without_the_number_at_their_end() {
        let names = [
            "chair.001",
            "chair_2",
            "chair",
            "chair#2",
            "model/leg-12",
            "ball 1",
            "7",
            "a/7",
            "room2",
            "a._1",
        ];
        let expected = [
            "chair",
            "chair",
            "chair",
            "chair",
            "model/leg",
            "ball",
            "7",
            "a/7",
            "room2",
            "a",
        ];
        assert_eq!(names.map(without_number), expected);
    }

    #[test]
    fn a_file_is_below_its_folder() {
        let of = |file: &str| {
            let CategoryName { name, supercategory } = CategoryName::of_file(Path::new(file));
            (name, supercategory)
        };
        let own = |name: &str, above: &str| (name.to_owned(), above.to_owned());
        assert_eq!(of("data/chairs/wing_03.glb"), own("wing", "chairs"));
        assert_eq!(of("mug.glb"), own("mug", "mug"));
        assert_eq!(of("../mug.glb"), own("mug", "mug"));
    }
}
