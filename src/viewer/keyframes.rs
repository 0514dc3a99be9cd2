//! The edited camera path file: it is read at the start, changed by keys, and saved with a backup.

use std::{
    ffi::OsString,
    io,
    path::{Path, PathBuf},
    sync::Arc,
};

use crate::{
    assets::{
        Files, SuppliedFile,
        camera_path::{CameraPathError, CameraPathFormat, CameraPathOptions, EditError, PathDocument, PathProblem},
    },
    batch::Request,
    camera::{
        Lens, Timing,
        path::{CameraPath, PathKey},
    },
    error::Error,
    output::{OutputError, atomic},
};

/// The camera path file and its keys.
pub struct Keyframes {
    file: PathBuf,
    options: CameraPathOptions,
    document: PathDocument,
    path: Option<Arc<CameraPath>>,
    scene_timing: Timing,
    /// The content of the file when it was last read or saved; `None` if there was none.
    on_disk: Option<Arc<[u8]>>,
    is_changed: bool,
}

/// Why a camera path was not saved.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    #[error("there are no keys to save")]
    NoKeys,
    #[error("the file was changed by another program")]
    Foreign,
    #[error("cannot read the file: {0}")]
    Read(io::Error),
    #[error(transparent)]
    Write(#[from] OutputError),
}

impl Keyframes {
    /// Opens a file, or starts a new one if there is none.
    ///
    /// # Errors
    /// The file is invalid, or its name is not that of a camera path.
    pub fn open(file: &Path, request: &Request) -> Result<Self, Error> {
        match CameraPathFormat::of_path(file) {
            Some(format) if format.holds_values() => {}
            Some(format) => {
                let (name, path) = (format.name, file.display());
                let message =
                    format!("keys are kept in CSV files, not in those of {name} (convert-camera makes one): {path}");
                return Err(Error::Usage(message));
            }
            None => return Err(CameraPathError::UnknownFormat { path: file.to_owned() }.into()),
        }
        let options = request.path_options(None);
        let mut keyframes = Self {
            file: file.to_owned(),
            options,
            document: PathDocument::new(&options),
            path: None,
            scene_timing: Timing::default(),
            on_disk: None,
            is_changed: false,
        };
        match keyframes.load() {
            Err(CameraPathError::NotFound { .. }) => {}
            loaded => loaded?,
        }
        Ok(keyframes)
    }

    /// Reads the file again; on an error nothing changes.
    pub fn load(&mut self) -> Result<(), CameraPathError> {
        let path = || self.file.clone();
        let bytes = read(&self.file).map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => CameraPathError::NotFound { path: path() },
            _ => CameraPathError::Io { path: path(), source },
        })?;
        let invalid = |problems| CameraPathError::Invalid { path: path(), problems };
        let document = PathDocument::read(&bytes, &self.options).map_err(invalid)?;
        if document.keys().len() == 0 {
            return Err(invalid(
                PathProblem::of_file("there are no rows below the header").into(),
            ));
        }
        self.document = document;
        self.on_disk = Some(bytes);
        self.is_changed = false;
        self.renew();
        Ok(())
    }

    /// Saves the keys, and keeps the former content of the file as `.bak`. Without `force` a file that another
    /// program has changed is not overwritten.
    pub fn save(&mut self, force: bool) -> Result<(), SaveError> {
        if !self.has_keys() {
            return Err(SaveError::NoKeys);
        }
        let former = match read(&self.file) {
            Ok(bytes) => Some(bytes),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(SaveError::Read(error)),
        };
        if !force && former != self.on_disk {
            return Err(SaveError::Foreign);
        }
        atomic::check(&self.file)?;
        if let Some(former) = former {
            atomic::write(&backup_of(&self.file), |out| Ok(out.write_all(&former)?))?;
        }
        let bytes = self.document.to_bytes();
        atomic::write(&self.file, |out| Ok(out.write_all(&bytes)?))?;
        self.on_disk = Some(bytes.into());
        self.is_changed = false;
        Ok(())
    }

    /// Adds or replaces a key. Returns its frame in the file, which has times to the microsecond.
    pub fn set(&mut self, key: &PathKey, scene: &Lens) -> Result<f64, EditError> {
        self.document.set(key, scene)?;
        self.edited();
        let away = |frame: &f64| (frame - key.frame).abs();
        let frames = self.keys().map(|key| key.frame);
        let nearest = frames.min_by(|a, b| away(a).total_cmp(&away(b)));
        Ok(nearest.unwrap_or(key.frame))
    }

    pub fn move_key(&mut self, from: f64, to: f64) -> Result<(), EditError> {
        self.document.move_key(from, to)?;
        self.edited();
        Ok(())
    }

    pub fn remove(&mut self, frame: f64) -> Result<(), EditError> {
        self.document.remove(frame)?;
        self.edited();
        Ok(())
    }

    pub fn keys(&self) -> impl ExactSizeIterator<Item = &PathKey> {
        self.document.keys()
    }

    pub fn has_keys(&self) -> bool {
        self.path.is_some()
    }

    /// The file as the keys are now, saved or not; `None` without keys.
    pub fn file(&self) -> Option<SuppliedFile> {
        let saved = self.on_disk.as_ref().filter(|_| !self.is_changed);
        let bytes = || saved.map_or_else(|| self.document.to_bytes().into(), Arc::clone);
        self.has_keys().then(|| (self.file.clone(), bytes()))
    }

    /// Whether another program has changed or removed the file.
    pub fn has_changed_on_disk(&self) -> bool {
        read(&self.file).ok() != self.on_disk
    }

    /// Whether there are unsaved edits.
    pub fn is_changed(&self) -> bool {
        self.is_changed
    }

    /// The path through the keys; `None` without keys.
    pub fn path(&self) -> Option<&Arc<CameraPath>> {
        self.path.as_ref()
    }

    /// Sets the timing of the scene's camera, for paths without one.
    pub fn set_scene_timing(&mut self, timing: Timing) {
        self.scene_timing = timing;
        self.renew();
    }

    fn edited(&mut self) {
        self.is_changed = true;
        self.renew();
    }

    fn renew(&mut self) {
        let with_timing = |path: &Arc<CameraPath>| match self.scene_timing == Timing::default() {
            true => Arc::clone(path),
            false => Arc::new(CameraPath::clone(path).with_scene_timing(self.scene_timing)),
        };
        self.path = self.document.path().map(with_timing);
    }
}

fn read(path: &Path) -> io::Result<Arc<[u8]>> {
    Files::default().read(path)
}

fn backup_of(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".bak");
    PathBuf::from(name)
}
