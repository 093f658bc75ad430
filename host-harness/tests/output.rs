//! Result folders and files.

use std::path::Path;

use host_harness::output::{OutDir, OutFile};
use host_harness::verb::Failure;

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Writes a result of these files, each with the same contents.
fn result(folder: &Path, force: bool, files: &[&str], contents: &str) -> Result<(), Failure> {
    let out = OutDir::new(folder, force)?;
    for name in files {
        out.write(name, contents)?;
    }
    out.finish()
}

#[test]
fn a_folder_is_taken_when_absent_or_empty_and_its_files_come_together() {
    let folder = tempfile::tempdir().unwrap();
    assert!(OutDir::new(folder.path(), false).is_ok());
    let deeper = folder.path().join("a/b");
    let out = OutDir::new(&deeper, false).unwrap();
    out.write("one.txt", "1").unwrap();
    out.write("two.txt", "2").unwrap();
    assert!(!deeper.join("one.txt").exists(), "there before the other is");
    out.finish().unwrap();
    assert_eq!(read(&deeper, "one.txt"), "1");
    assert_eq!(names(&deeper), [".joint-files", "one.txt", "two.txt"]);
}

#[test]
fn a_run_that_fails_leaves_no_folder_and_no_half_of_a_result() {
    let folder = tempfile::tempdir().unwrap();
    let deeper = folder.path().join("a/b");
    let out = OutDir::new(&deeper, false).unwrap();
    out.write("one.txt", "1").unwrap();
    drop(out);
    assert_eq!(names(folder.path()), [""; 0]);
    result(folder.path(), false, &["one.txt"], "old").unwrap();
    OutDir::new(folder.path(), true).unwrap().write("one.txt", "new").unwrap();
    assert_eq!(read(folder.path(), "one.txt"), "old");
}

#[test]
fn a_folder_with_a_result_is_refused_and_force_clears_that_result_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("notes.txt"), "mine").unwrap();
    std::fs::create_dir(path.join("plots")).unwrap();
    let refused = OutDir::new(path, false).unwrap_err();
    assert_eq!(refused.code, 2);
    assert_eq!(
        refused.message,
        format!(
            "{}: holds a result already\n  help: choose another folder, or replace it with --force",
            path.display()
        )
    );
    result(path, true, &["model.toml", "next.csv"], "old").unwrap();
    result(path, true, &["model.toml", "page.html"], "new").unwrap();
    assert_eq!(names(path), [".joint-files", "model.toml", "notes.txt", "page.html", "plots"]);
    assert_eq!(
        (read(path, "notes.txt").as_str(), read(path, "model.toml").as_str()),
        ("mine", "new")
    );
}

#[test]
fn a_list_of_files_leads_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out");
    result(&path, false, &["model.toml"], "old").unwrap();
    std::fs::write(folder.path().join("mine.txt"), "mine").unwrap();
    let outside = folder.path().join("mine.txt");
    let list = format!("../mine.txt\n{}\n.\n..\n\nmodel.toml", outside.display());
    std::fs::write(path.join(".joint-files"), list).unwrap();
    result(&path, true, &["other.toml"], "new").unwrap();
    assert_eq!(names(&path), [".joint-files", "other.toml"]);
    assert_eq!(read(folder.path(), "mine.txt"), "mine");
}

#[test]
fn of_two_runs_into_one_folder_one_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out");
    let first = OutDir::new(&path, true).unwrap();
    for force in [false, true] {
        let refused = OutDir::new(&path, force).unwrap_err();
        assert_eq!(refused.code, 2);
        assert!(refused.message.contains("another run writes there"), "{refused}");
    }
    first.write("one.txt", "1").unwrap();
    first.finish().unwrap();
    assert!(OutDir::new(&path, true).is_ok());
}

#[test]
fn a_result_that_was_done_but_not_in_its_place_is_put_there_by_the_next_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    result(path, false, &["model.toml", "next.csv"], "old").unwrap();
    // As a run leaves it that is killed after the first of two moves.
    let done = path.join(".joint-done");
    std::fs::create_dir(&done).unwrap();
    std::fs::write(done.join(".joint-files"), "model.toml\npage.html").unwrap();
    std::fs::write(done.join("page.html"), "new").unwrap();
    std::fs::write(path.join("model.toml"), "new").unwrap();
    assert!(OutDir::new(path, false).unwrap_err().message.contains("holds a result"));
    assert_eq!(names(path), [".joint-files", "model.toml", "page.html"]);
    assert_eq!(
        (read(path, "model.toml").as_str(), read(path, "page.html").as_str()),
        ("new", "new")
    );
}

#[test]
fn where_a_file_cannot_be_moved_to_its_place_the_earlier_result_stays_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    result(path, false, &["model.toml", "page.html"], "old").unwrap();
    std::fs::create_dir(path.join("verdict.json")).unwrap();
    let refused = result(path, true, &["model.toml", "verdict.json"], "new").unwrap_err();
    assert!(refused.message.contains("is a folder, where a file of the result goes"), "{refused}");
    assert_eq!(names(path), [".joint-files", "model.toml", "page.html", "verdict.json"]);
    assert_eq!(read(path, "model.toml"), "old");
    let file = path.join("single.csv");
    std::fs::write(&file, "old").unwrap();
    let out = OutFile::new(&file, true).unwrap();
    std::fs::remove_file(&file).unwrap();
    std::fs::create_dir(&file).unwrap();
    assert!(out.write("new").unwrap_err().message.contains("cannot be written"));
    assert_eq!(names(path).iter().filter(|name| name.starts_with(".joint-")).count(), 1);
}

#[test]
fn no_output_is_put_over_an_input() {
    let folder = tempfile::tempdir().unwrap();
    let [log, out] = ["log.csv", "found"].map(|name| folder.path().join(name));
    std::fs::write(&log, "old").unwrap();
    result(&out, false, &["model.toml"], "old").unwrap();
    let refused = OutFile::new(&log, true).unwrap().apart_from([&log]).unwrap_err();
    assert!(refused.message.contains("is read by this run"), "{refused}");
    let input = out.join("model.toml");
    let refused = OutDir::new(&out, true).unwrap().apart_from([&log, &input], &["model.toml"]);
    assert!(refused.unwrap_err().message.contains("is read by this run"));
    #[cfg(unix)]
    {
        let link = folder.path().join("link.csv");
        std::os::unix::fs::symlink(&log, &link).unwrap();
        assert!(OutFile::new(&link, true).unwrap().apart_from([&log]).is_err());
    }
    assert_eq!(read(folder.path(), "log.csv"), "old");
}

#[cfg(unix)]
#[test]
fn a_device_is_not_replaced_by_a_file() {
    let refused = OutFile::new(Path::new("/dev/null"), true).unwrap_err();
    assert!(refused.message.contains("is no file that can be replaced"), "{refused}");
}

#[cfg(unix)]
#[test]
fn where_nothing_can_be_written_that_is_said_before_the_work() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let closed = folder.path().join("closed");
    std::fs::create_dir(&closed).unwrap();
    std::fs::set_permissions(&closed, PermissionsExt::from_mode(0o555)).unwrap();
    if std::fs::write(closed.join("probe"), "").is_ok() {
        // Root writes anywhere but where nobody does.
        for path in ["/proc/joint", "/sys/joint"].map(Path::new) {
            assert!(OutDir::new(path, false).unwrap_err().message.contains("cannot be written"));
            assert!(OutFile::new(path, false).unwrap_err().message.contains("cannot be written"));
        }
        return;
    }
    for path in [closed.clone(), closed.join("deeper")] {
        assert!(OutDir::new(&path, false).unwrap_err().message.contains("cannot be written"));
    }
    let file = OutFile::new(&closed.join("out.csv"), false).unwrap_err();
    assert!(file.message.contains("cannot be written"), "{file}");
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
