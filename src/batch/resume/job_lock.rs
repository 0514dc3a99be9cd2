//! Locks on the files of a job. A second job that would write the same files waits or ends.
//!
//! Jobs with other files in the same folder, such as parts of a sequence, run in parallel.

use std::{
    collections::{BTreeMap, HashSet},
    ffi::{OsStr, OsString},
    fmt,
    path::{Path, PathBuf},
    thread,
    time::Duration,
};

use crate::{
    batch::{IfBusy, Plan},
    error::Error,
    output::{
        FileNames,
        job_file::{self, FolderGate, JobFile},
    },
    render::{Cancel, Cancelled},
    warnings::WarningKind,
};

/// The interval of checks whether the other job has ended.
const POLL: Duration = Duration::from_millis(200);

/// A lock on the files of a job.
pub(in crate::batch) struct JobLock {
    _files: Vec<JobFile>,
}

/// Another job that writes a file of this one.
struct Busy {
    /// Its process and machine.
    job: String,
    path: PathBuf,
}

impl fmt::Display for Busy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "another job ({}) writes {}", self.job, self.path.display())
    }
}

impl JobLock {
    /// Locks the files of `plan`, whose folders exist. A folder in which no file can be created is not locked.
    ///
    /// # Errors
    /// Another job writes one of the files and the plan says to end, or waiting was cancelled.
    pub fn new(plan: &Plan, cancel: Option<&Cancel>) -> Result<Self, Error> {
        let folders = folders(plan);
        let mut is_told = false;
        loop {
            let busy = match Self::attempt(&folders, cancel) {
                Ok(lock) => return Ok(lock),
                Err(busy) => busy,
            };
            if plan.policy.if_busy == IfBusy::Leave {
                return Err(Error::Busy(busy.to_string()));
            }
            if !is_told {
                let text = format!("{busy}: this one waits until that has ended");
                plan.warnings.add_live(WarningKind::BUSY, busy.path.display(), text);
                is_told = true;
            }
            if cancel.is_some_and(Cancel::is_cancelled) {
                return Err(Cancelled.into());
            }
            thread::sleep(POLL);
        }
    }

    fn attempt(folders: &BTreeMap<PathBuf, Vec<String>>, cancel: Option<&Cancel>) -> Result<Self, Busy> {
        let mut files = Vec::new();
        for (folder, names) in folders {
            let _gate = FolderGate::close(folder, cancel);
            let others = job_file::of_others(folder);
            if let Some((job, name)) = others.iter().find_map(|text| common(text, names, FileNames::HERE)) {
                return Err(Busy {
                    job,
                    path: folder.join(name),
                });
            }
            files.extend(job_file::create(folder, &text(names)).ok());
        }
        Ok(Self { _files: files })
    }
}

/// The names of the files of a plan, by their folders.
fn folders(plan: &Plan) -> BTreeMap<PathBuf, Vec<String>> {
    let mut folders: BTreeMap<PathBuf, Vec<String>> = BTreeMap::new();
    for path in plan.frames.iter().flat_map(|frame| plan.files_of(frame)) {
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let names = folders.entry(folder.unwrap_or(Path::new(".")).to_owned()).or_default();
        names.push(name.into_owned());
    }
    folders
}

/// The content of a job file: the process, and a line for each file.
fn text(names: &[String]) -> String {
    [&[job_file::process()], names].concat().join("\n")
}

/// The other job, and the first of its files that is among `names`.
fn common(text: &str, names: &[String], rules: FileNames) -> Option<(String, String)> {
    let mut lines = text.lines();
    let job = lines.next()?;
    let comparable = |name: &str| rules.comparable(OsStr::new(name));
    let names: HashSet<OsString> = names.iter().map(|name| comparable(name)).collect();
    let name = lines.find(|line| names.contains(&comparable(line)))?;
    Some((job.to_owned(), name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_compared_as_the_system_does() {
        let other = "job 7\na.exr\nF.0001.EXR";
        let common = |name: &str, rules| common(other, &[name.to_owned()], rules);
        let found = Some(("job 7".to_owned(), "F.0001.EXR".to_owned()));
        assert_eq!(common("F.0001.EXR", FileNames::Unix), found);
        assert_eq!(common("f.0001.exr", FileNames::Unix), None);
        assert_eq!(common("f.0001.exr", FileNames::Windows), found);
        assert_eq!(common("f.0002.exr", FileNames::Windows), None);
    }
}
