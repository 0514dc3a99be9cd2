//! The files of a scene: each loaded once, side by side.

use std::{
    collections::{BTreeSet, HashMap},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use super::{
    AssetError, Files, MemoryKind,
    image::{self, AlphaUse, BitmapKey, EncodedImage, ImageError},
    load_model::load_model,
    model::{ImageSource, Model, ModelChoice, ModelFeature},
    motion::ModelClip,
};
pub use super::{image::ImageRequest, load_model::ModelRequest};
use crate::{
    math::{WorkingSpace, parallel, sorting},
    scene::BackgroundRadiance,
    texture::{Bitmap, bitmap::ColorSpace},
    value::one_line,
    warnings::{WarningKind, Warnings},
};

/// The contents of a model file that was loaded.
#[derive(Clone, Debug)]
pub struct ModelReport {
    pub request: ModelRequest,
    pub features: Vec<ModelFeature>,
    /// The names of its cameras; may be empty.
    pub cameras: Vec<String>,
    /// The names of its material variants.
    pub variants: Vec<String>,
    /// Its animations.
    pub clips: Vec<ModelClip>,
    pub lights: usize,
}

/// The treatment of images that are missing or broken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MissingAssets {
    /// The scene is refused.
    #[default]
    Error,
    /// Squares of magenta and black take its place, and a warning says so.
    Placeholder,
}

/// The files of a job: what was read, the models that are loaded already, and what to do where images are missing.
#[derive(Default)]
pub struct Store {
    files: Files,
    models: Mutex<HashMap<ModelRequest, Arc<Model>>>,
    reports: Mutex<Vec<ModelReport>>,
    missing: MissingAssets,
    is_strict: bool,
    /// The most that all images may take, in bytes; `None` is no limit.
    texture_memory: Option<u64>,
    /// The number of times that each image was halved, of each list of images of which one was.
    halvings: Mutex<Vec<Vec<u32>>>,
    replaced: Mutex<BTreeSet<PathBuf>>,
    /// The bitmaps of a scene that is compiled again.
    kept: Mutex<Vec<(BitmapKey, Bitmap)>>,
    /// The background of such a scene.
    kept_background: Mutex<Option<(EnvironmentKey, BackgroundRadiance)>>,
}

/// The content of an environment map.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentKey {
    pub picture: BitmapKey,
    pub intensity: f32,
    pub working_space: WorkingSpace,
}

impl Store {
    /// An empty store, into which files come by way of `files`.
    pub fn new(missing: MissingAssets, files: Files) -> Self {
        Self {
            missing,
            files,
            ..Self::default()
        }
    }

    /// The same, whose images take `bytes` at the most, if any: the larger ones are loaded at a lower resolution.
    pub fn texture_memory(mut self, bytes: Option<u64>) -> Self {
        self.texture_memory = bytes;
        self
    }

    /// The same, which refuses a model if a part of it would not be rendered.
    pub fn strict(mut self, is_strict: bool) -> Self {
        self.is_strict = is_strict;
        self
    }

    /// Reports on the models that were loaded, by their files.
    pub fn model_reports(&self) -> Vec<ModelReport> {
        let mut reports = self.reports.lock().unwrap_or_else(PoisonError::into_inner).clone();
        sorting::sort_by(&mut reports, |a, b| a.request.cmp(&b.request));
        reports.dedup_by(|a, b| a.request == b.request);
        reports
    }

    /// The report on a model file, if it was loaded.
    pub fn model_report(&self, path: &Path) -> Option<ModelReport> {
        let reports = self.reports.lock().unwrap_or_else(PoisonError::into_inner);
        reports.iter().find(|report| report.request.path == path).cloned()
    }

    /// The number of times that each image was halved to fit into memory, of each list of images of which one was.
    pub fn halved(&self) -> Vec<Vec<u32>> {
        let mut halvings = self.halvings.lock().unwrap_or_else(PoisonError::into_inner).clone();
        sorting::sort_by(&mut halvings, Ord::cmp);
        halvings
    }

    /// The gate through which all files come in.
    pub fn files(&self) -> &Files {
        &self.files
    }

    /// The warnings about files and what was made of them.
    pub fn warnings(&self) -> &Warnings {
        self.files.warnings()
    }

    /// Drops the models: a model that is needed later is loaded again.
    pub fn forget_models(&self) {
        self.models.lock().unwrap_or_else(PoisonError::into_inner).clear();
        self.files.memory().release(MemoryKind::Models);
    }

    /// Drops all models but these.
    pub fn keep_models(&self, requests: &[ModelRequest]) {
        let mut models = self.models.lock().unwrap_or_else(PoisonError::into_inner);
        let count = models.len();
        models.retain(|request, _| requests.contains(request));
        if models.len() < count {
            let memory = self.files.memory();
            memory.release(MemoryKind::Models);
            let bytes = models.values().map(|model| model.bytes()).sum();
            memory.take(MemoryKind::Models, bytes).expect("more of them did fit");
        }
    }

    /// Whether placeholders replace images that are missing or broken.
    pub fn has_placeholders(&self) -> bool {
        self.missing == MissingAssets::Placeholder
    }

    /// The number of image files that placeholders replace.
    pub fn replaced(&self) -> usize {
        self.replaced.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// The models of these files, in order, loaded on the threads of the current rayon pool; or what is wrong with each
    /// file that cannot be loaded, by the index of its first request.
    pub fn models(&self, requests: &[ModelRequest]) -> Result<Vec<Arc<Model>>, Vec<(usize, AssetError)>> {
        let mut once: Vec<&ModelRequest> = requests.iter().collect();
        sorting::sort_by(&mut once, Ord::cmp);
        once.dedup();
        let first = |request: &ModelRequest| requests.iter().position(|other| other == request);
        let load = |request| {
            let failed = |error| (first(request).expect("it is one of them"), error);
            Ok((request, self.model(request).map_err(failed)?))
        };
        let loaded = collect(parallel::map(once, load))?;
        let by_request: HashMap<_, _> = loaded.into_iter().collect();
        Ok(requests.iter().map(|r| Arc::clone(&by_request[r])).collect())
    }

    /// The names of the nodes and of the materials of a model file, which is not kept.
    ///
    /// # Errors
    /// The file cannot be loaded.
    pub fn names_of_parts(&self, path: &Path) -> Result<[Vec<String>; 2], AssetError> {
        let request = ModelRequest {
            path: path.to_owned(),
            choice: ModelChoice::default(),
        };
        let model = load_model(&request, &self.files)?;
        let materials = model.names_of_materials().into_iter().map(|(name, _)| name);
        Ok([model.names_of_nodes(), materials.collect()])
    }

    /// The model of a file. What of it is not rendered is warned of, or is an error where the store is strict.
    pub fn model(&self, request: &ModelRequest) -> Result<Arc<Model>, AssetError> {
        let path = &request.path;
        let models = || self.models.lock().unwrap_or_else(PoisonError::into_inner);
        let known = models().get(request).map(Arc::clone);
        if let Some(known) = known {
            return Ok(known);
        }
        let model = Arc::new(load_model(request, &self.files)?);
        self.files
            .memory()
            .take(MemoryKind::Models, model.bytes())
            .map_err(|cause| AssetError::Memory {
                cause,
                path: path.clone(),
            })?;
        self.report(request, &model)?;
        models().insert(request.clone(), Arc::clone(&model));
        Ok(model)
    }

    fn report(&self, request: &ModelRequest, model: &Model) -> Result<(), AssetError> {
        let path = &request.path;
        let losses = model
            .features
            .iter()
            .filter_map(|f| Some((WarningKind::FEATURE, &f.name, model.loss(f)?)));
        let faults = model
            .faults
            .iter()
            .map(|fault| (WarningKind::FAULT, fault, fault.clone()));
        let losses: Vec<_> = losses.chain(faults).collect();
        let mut reports = self.reports.lock().unwrap_or_else(PoisonError::into_inner);
        if reports.iter().any(|r| r.request == *request) {
            return Ok(());
        }
        if self.is_strict && !losses.is_empty() {
            let (losses, path) = (losses.into_iter().map(|(_, _, loss)| loss).collect(), path.clone());
            return Err(AssetError::Incomplete { losses, path });
        }
        let shown = path.display();
        for (kind, topic, loss) in losses {
            self.warnings()
                .add_topic(kind, topic, &shown, format!("{shown}: {loss}"));
        }
        if request.choice.variant.is_none() && !request.choice.is_varied && !model.variants.is_empty() {
            let names: Vec<String> = model
                .variants
                .iter()
                .map(|n| format!("`{}`", one_line(n, 80)))
                .collect();
            let names = names.join(", ");
            let text = format!(
                "{shown}: there are material variants ({names}), and the default materials are shown; `variant` or --variant chooses one"
            );
            self.warnings().add_topic(WarningKind::CHOICE, "variants", shown, text);
        }
        reports.push(ModelReport {
            request: request.clone(),
            features: model.features.clone(),
            cameras: model.cameras.iter().map(|c| c.name.clone()).collect(),
            variants: model.variants.clone(),
            clips: model.clips.clone(),
            lights: model.lights.len(),
        });
        Ok(())
    }

    /// Keeps the bitmaps of a scene that is compiled again for the next call of [`Store::images`], which takes those
    /// that it needs and drops the others.
    pub fn keep_images(&self, images: impl Iterator<Item = (BitmapKey, Bitmap)>) {
        *self.kept.lock().unwrap_or_else(PoisonError::into_inner) = images.collect();
    }

    /// Keeps the background of a scene that is compiled again for the next call of [`Store::background`].
    pub fn keep_background(&self, key: EnvironmentKey, radiance: BackgroundRadiance) {
        let mut kept = self.kept_background.lock().unwrap_or_else(PoisonError::into_inner);
        *kept = Some((key, radiance));
    }

    /// The background that was kept, if that of this picture is the same but for its rotation. Nothing is kept afterwards.
    pub fn background(
        &self,
        picture: &ImageRequest,
        intensity: f32,
        working_space: WorkingSpace,
    ) -> Option<(EnvironmentKey, BackgroundRadiance)> {
        let mut kept = self.kept_background.lock().unwrap_or_else(PoisonError::into_inner);
        let (old, radiance) = kept.take()?;
        // Alone the picture may get another resolution than among all images.
        if !self.halved().is_empty() {
            return None;
        }
        EncodedImage::read(picture, &self.files).ok()?;
        let key = EnvironmentKey {
            picture: BitmapKey::new(picture, 0, &self.files)?,
            intensity,
            working_space,
        };
        (key == old).then_some((key, radiance))
    }

    /// Decodes images, in order, on the threads of the current rayon pool; or says what is wrong with each that is broken,
    /// unless a placeholder takes its place. The key of a placeholder is `None`.
    pub fn images(&self, requests: &[ImageRequest]) -> Result<Vec<(Option<BitmapKey>, Bitmap)>, Vec<AssetError>> {
        let encoded = parallel::map(requests, |request| EncodedImage::read(request, &self.files));
        let halvings = self.halvings(&encoded);
        let mut known = std::mem::take(&mut *self.kept.lock().unwrap_or_else(PoisonError::into_inner));
        let images = encoded.into_iter().zip(halvings).zip(requests);
        let keyed: Vec<_> = images
            .map(|((image, halvings), request)| {
                let key = BitmapKey::new(request, halvings, &self.files);
                let at = known.iter().position(|(own, _)| key.as_ref() == Some(own));
                (image, halvings, key, at.map(|at| known.swap_remove(at).1))
            })
            .collect();
        drop(known);
        let memory = self.files.memory();
        let decode = |(image, halvings, key, known): (Result<EncodedImage, ImageError>, _, _, _)| {
            let image = image?;
            let bitmap = match known {
                Some(bitmap) => {
                    image.count(halvings, memory)?;
                    bitmap
                }
                None => image.decode(halvings, memory)?,
            };
            Ok((key, bitmap))
        };
        let loaded: Vec<Result<_, ImageError>> = parallel::map(keyed, decode);
        let kept = loaded.into_iter().zip(requests).map(|(image, request)| match image {
            Err(e) if self.missing == MissingAssets::Placeholder => Ok((None, self.replace(&request.source, &e))),
            image => {
                let (key, image) = image?;
                self.warn_of_repairs(&request.source, image.repaired);
                if request.color_space == ColorSpace::Srgb && request.alpha != AlphaUse::Unused {
                    self.warn_of_negative(&request.source, image.negative);
                }
                Ok((key, image))
            }
        });
        collect(kept.collect())
    }

    /// The number of times that each image is halved, which a warning tells.
    fn halvings(&self, images: &[Result<EncodedImage, ImageError>]) -> Vec<u32> {
        let bytes = images.iter().map(|i| i.as_ref().map_or(0, |image| image.memory(0)));
        let bytes: Vec<u64> = bytes.collect();
        let limit = self.texture_memory.unwrap_or(u64::MAX);
        let halvings = image::halvings(&bytes, limit);
        let halved = halvings.iter().filter(|h| **h > 0).count();
        if halved > 0 {
            let mut all = self.halvings.lock().unwrap_or_else(PoisonError::into_inner);
            all.push(halvings.clone());
            let mebibytes = |bytes: u64| bytes.div_ceil(1 << 20);
            let sum = mebibytes(bytes.iter().sum());
            let limit = mebibytes(limit);
            let are = if halved == 1 { "image is" } else { "images are" };
            let text = format!(
                "the images need {sum} MiB of memory and {limit} MiB are allowed (--texture-memory): {halved} {are} \
                 shown at half of their resolution or less"
            );
            self.warnings().add(WarningKind::TEXTURE_MEMORY, "images", text);
        }
        halvings
    }

    /// Says once for each file that its image is not there.
    fn replace(&self, source: &ImageSource, error: &ImageError) -> Bitmap {
        let name = source.name();
        let mut replaced = self.replaced.lock().unwrap_or_else(PoisonError::into_inner);
        if replaced.insert(name.to_owned()) {
            let text = format!("a placeholder is shown: {error}");
            self.warnings()
                .add_topic(WarningKind::MISSING_FILE, "placeholder", name.display(), text);
        }
        Bitmap::placeholder()
    }

    /// Warns of numbers in an image that are NaN or infinite and were replaced.
    fn warn_of_repairs(&self, source: &ImageSource, count: u64) {
        let are = match count {
            0 => return,
            1 => "number that is",
            _ => "numbers that are",
        };
        let file = source.name().display();
        let text = format!("{count} {are} not finite became 0 or 65504: {file}");
        self.warnings()
            .add_topic(WarningKind::IMAGE_NUMBERS, "not finite", file, text);
    }

    /// Warns of numbers of colours that are below 0.
    fn warn_of_negative(&self, source: &ImageSource, count: u64) {
        let numbers = match count {
            0 => return,
            1 => "number",
            _ => "numbers",
        };
        let file = source.name().display();
        let text = format!("{count} {numbers} below 0 became 0, where they are colours: {file}");
        self.warnings()
            .add_topic(WarningKind::IMAGE_NUMBERS, "below 0", file, text);
    }
}

/// All results, or all errors.
fn collect<T, E>(results: Vec<Result<T, E>>) -> Result<Vec<T>, Vec<E>> {
    let (mut values, mut errors) = (Vec::with_capacity(results.len()), Vec::new());
    for result in results {
        match result {
            Ok(value) => values.push(value),
            Err(e) => errors.push(e),
        }
    }
    if errors.is_empty() { Ok(values) } else { Err(errors) }
}
