//! Tests of atomic files.

use super::*;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn folders_are_made_and_nothing_else_is_left() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("a/b/frame.exr");
    check(&path).unwrap();
    let seven = write(&path, |out| {
        out.write_all(b"whole")?;
        Ok(7)
    });
    assert_eq!(seven.unwrap(), 7);
    assert_eq!(fs::read(&path).unwrap(), b"whole");
    assert_eq!(names(path.parent().unwrap()), ["frame.exr"]);
}

#[test]
fn an_error_in_the_middle_keeps_the_old_file_and_leaves_no_temporary() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("frame.exr");
    fs::write(&path, b"old").unwrap();
    for unfit in [true, false] {
        let failed = write(&path, |out| -> Result<(), _> {
            out.write_all(&[1; 1 << 20])?;
            assert_eq!(names(home.path()).len(), 2);
            Err(match unfit {
                true => EncodeError::Unfit("too wide".into()),
                false => io::Error::from(io::ErrorKind::StorageFull).into(),
            })
        });
        let error = failed.unwrap_err();
        assert_eq!(error.ends_the_job(), !unfit);
        assert_eq!(unfit, matches!(error, OutputError::Encode { .. }));
        assert!(error.to_string().ends_with("frame.exr"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(home.path()), ["frame.exr"]);
    }
}

#[test]
fn files_that_are_written_together_are_all_new_or_all_old() {
    let home = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| (home.path().join(name), text.to_owned());
    let old = [file("a", "old"), file("b", "old")];
    write_together(&old).unwrap();
    assert!(write_together(&[file("a", "new"), file("missing/c", "new"), file("b", "new")]).is_err());
    let contents = |text: &str| old.iter().all(|(path, _)| fs::read(path).unwrap() == text.as_bytes());
    assert!(contents("old"));
    write_together(&[file("a", "new"), file("b", "new")]).unwrap();
    assert!(contents("new"));
    assert_eq!(names(home.path()), ["a", "b"]);
}

#[test]
fn many_files_of_several_folders_are_put_together_and_those_that_are_not_put_leave_nothing() {
    let home = tempfile::tempdir().unwrap();
    let path = |i: usize| {
        home.path()
            .join(if i.is_multiple_of(2) { "a" } else { "b" })
            .join(i.to_string())
    };
    check(&path(0)).unwrap();
    check(&path(1)).unwrap();
    let pending = |i: usize| PendingFile::new(&path(i), |out| Ok(write!(out, "{i}")?)).unwrap().0;
    let files: Vec<PendingFile> = (0..101).map(pending).collect();
    assert!(!path(100).exists());
    put(files).unwrap();
    drop((0..4).map(|i| pending(200 + i)).collect::<Vec<_>>());
    assert!((0..101).all(|i| fs::read(path(i)).unwrap() == i.to_string().as_bytes()));
    assert_eq!(["a", "b"].map(|name| names(&home.path().join(name)).len()), [51, 50]);
}

#[test]
fn a_panic_in_the_middle_leaves_no_temporary() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("frame.exr");
    let attempt = std::panic::catch_unwind(|| write(&path, |_| -> Result<(), _> { panic!("on purpose") }));
    assert!(attempt.is_err());
    assert!(names(home.path()).is_empty());
}

#[test]
fn a_place_where_nothing_can_be_made_is_a_create_error() {
    let home = tempfile::tempdir().unwrap();
    fs::write(home.path().join("file"), b"").unwrap();
    fs::create_dir(home.path().join("folder.exr")).unwrap();
    for path in ["file/frame.exr", "folder.exr"] {
        let path = home.path().join(path);
        for failed in [check(&path), write(&path, |_| Ok(()))] {
            assert!(matches!(failed, Err(OutputError::Create { .. })), "{}", path.display());
        }
    }
    assert_eq!(names(home.path()), ["file", "folder.exr"]);
}

#[cfg(unix)]
#[test]
fn a_link_is_followed_and_stays_a_link() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("store");
    fs::create_dir(&folder).unwrap();
    let link = home.path().join("frame.exr");
    std::os::unix::fs::symlink("store/real.exr", &link).unwrap();
    // The link is dangling at first, then it leads to an old file.
    for content in [b"one", b"two"] {
        write(&link, |out| Ok(out.write_all(content)?)).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(folder.join("real.exr")).unwrap(), content);
    }
    assert_eq!(names(&folder), ["real.exr"]);

    let circle = home.path().join("circle.exr");
    std::os::unix::fs::symlink("circle.exr", &circle).unwrap();
    assert!(matches!(check(&circle), Err(OutputError::Create { .. })));
}

#[cfg(unix)]
#[test]
fn nothing_without_write_permission_is_replaced() {
    use std::os::unix::fs::PermissionsExt;
    let home = tempfile::tempdir().unwrap();
    let set = |path: &Path, mode| fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    let file = home.path().join("file.exr");
    fs::write(&file, b"old").unwrap();
    set(&file, 0o444);
    let folder = home.path().join("folder");
    fs::create_dir(&folder).unwrap();
    set(&folder, 0o555);
    for path in [&file, &folder.join("new.exr")] {
        for failed in [check(path), write(path, |_| Ok(()))] {
            assert!(matches!(failed, Err(OutputError::Create { .. })), "{}", path.display());
        }
    }
    assert_eq!(fs::read(&file).unwrap(), b"old");
    set(&folder, 0o755);
}

#[test]
fn temporaries_of_the_dead_are_removed_and_those_of_the_living_stay() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("frame.exr");
    fs::write(home.path().join(".batch-render-0123456789.tmp"), b"half").unwrap();
    fs::write(home.path().join(".batch-render-notes"), b"not ours").unwrap();
    write(&path, |_| {
        check(&home.path().join("other.exr")).unwrap();
        let left = names(home.path());
        assert_eq!(left.len(), 2, "{left:?}");
        Ok(())
    })
    .unwrap();
    assert_eq!(names(home.path()), [".batch-render-notes", "frame.exr"]);
}

#[cfg(unix)]
#[test]
fn a_file_has_the_permissions_of_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let home = tempfile::tempdir().unwrap();
    let (plain, ours) = (home.path().join("plain"), home.path().join("ours"));
    fs::write(&plain, b"").unwrap();
    write(&ours, |_| Ok(())).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&ours), mode(&plain));
}

#[test]
fn a_file_whose_temporary_is_removed_by_another_machine_may_be_written_again() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("frame.exr");
    let pending = || PendingFile::new(&path, |out| Ok(out.write_all(b"whole")?)).unwrap().0;
    let file = pending();
    fs::remove_file(file.file.path()).unwrap();
    assert!(put(vec![file]).unwrap_err().may_pass());
    put(vec![pending()]).unwrap();
    assert_eq!(names(home.path()), ["frame.exr"]);
}
