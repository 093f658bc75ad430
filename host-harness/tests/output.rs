//! Result folders and files.

use host_harness::output::{OutDir, OutFile};

#[test]
fn a_folder_is_taken_when_absent_or_empty() {
    let folder = tempfile::tempdir().unwrap();
    assert!(OutDir::new(folder.path(), false).is_ok());
    let deeper = folder.path().join("a/b");
    let out = OutDir::new(&deeper, false).unwrap();
    assert!(!deeper.exists(), "made before there is anything to put in");
    out.write("one.txt", "1").unwrap();
    out.write("two.txt", "2").unwrap();
    assert_eq!(std::fs::read_to_string(deeper.join("one.txt")).unwrap(), "1");
    assert_eq!(std::fs::read_dir(&deeper).unwrap().count(), 2, "no temporary file stays");
}

#[test]
fn a_folder_with_a_result_is_refused_and_with_force_only_its_own_files_change() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("notes.txt"), "mine").unwrap();
    std::fs::write(folder.path().join("model.toml"), "old").unwrap();
    let refused = OutDir::new(folder.path(), false).unwrap_err();
    assert_eq!(refused.code, 2);
    assert_eq!(
        refused.message,
        format!(
            "{}: holds a result already\n  help: choose another folder, or replace it with --force",
            folder.path().display()
        )
    );
    OutDir::new(folder.path(), true).unwrap().write("model.toml", "new").unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!((read("notes.txt").as_str(), read("model.toml").as_str()), ("mine", "new"));
}

#[test]
fn what_an_interrupted_run_left_is_no_result() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(".joint-a1b2"), "half").unwrap();
    assert!(OutDir::new(folder.path(), false).is_ok());
}

#[test]
fn a_file_is_no_folder_and_a_folder_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    std::fs::write(&path, "").unwrap();
    assert!(OutDir::new(&path, true).unwrap_err().message.contains("is a file"));
    assert!(OutFile::new(folder.path(), true).unwrap_err().message.contains("is a folder"));
}

#[test]
fn a_file_that_appears_meanwhile_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    let out = OutFile::new(&path, false).unwrap();
    std::fs::write(&path, "theirs").unwrap();
    assert!(out.write("ours").unwrap_err().message.contains("is there already"));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "theirs");
}
