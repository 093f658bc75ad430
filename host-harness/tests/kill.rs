//! Runs that are killed at any moment, and disks that are full: the earlier result is whole, and the new
//! one whole or absent.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::MODEL;
use host_harness::output::OutDir;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Runs that died, of those that write a file and of those that write a folder.
const KILLS_OF_FILES: usize = 80;
const KILLS_OF_FOLDERS: usize = 20;

/// Runs at most for each that dies: a run that ends before its kill makes the next kill come sooner.
const RUNS_PER_KILL: usize = 20;

fn joint(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_joint"));
    command.args(arguments).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().unwrap()
}

/// How long a whole run takes.
fn whole(folder: &Path, arguments: &[&str]) -> Duration {
    let began = Instant::now();
    assert!(joint(folder, arguments).wait().unwrap().success(), "{arguments:?}");
    began.elapsed()
}

/// Kills runs, the more often the nearer their end.
struct Killer {
    /// How long a run takes, longer after each that died and shorter after each that ended.
    takes: Duration,
    random: ChaCha8Rng,
    runs: usize,
    kills: usize,
}

impl Killer {
    fn new(takes: Duration, seed: u64) -> Self {
        Self { takes, random: ChaCha8Rng::seed_from_u64(seed), runs: 0, kills: 0 }
    }

    /// Whether another run is due for so many kills.
    fn goes_on(&self, kills: usize) -> bool {
        assert!(self.runs < RUNS_PER_KILL * kills, "{} of {} runs died", self.kills, self.runs);
        self.kills < kills
    }

    fn kill(&mut self, folder: &Path, arguments: &[&str]) {
        let mut child = joint(folder, arguments);
        std::thread::sleep(self.takes.mul_f64(self.random.random_range(0.0_f64..1.0).sqrt()));
        let _ = child.kill();
        let died = !child.wait().unwrap().success();
        self.takes = self.takes.mul_f64(if died { 1.1 } else { 0.9 });
        self.runs += 1;
        self.kills += usize::from(died);
    }
}

fn log(samples: usize) -> String {
    use std::fmt::Write;
    let mut text = String::from("t_s,u_v,i_a,motor_angle_rad\n");
    for k in 0..samples {
        let t = 2e-4 * k as f64;
        let speed = 20.0 * (40.0 * t).cos();
        let current = 0.1 * speed.signum() - 8.0e-3 * (40.0 * t).sin();
        let angle = 0.5 * (40.0 * t).sin();
        let _ = writeln!(text, "{t:.4},{:.6},{current:.6},{angle:.6}", current + 0.1 * speed);
    }
    text
}

/// A folder with two models and a log.
fn inputs() -> (tempfile::TempDir, PathBuf) {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().to_owned();
    let motor = MODEL.split("[[stage]]").next().unwrap();
    fs::write(folder.join("a.toml"), motor).unwrap();
    fs::write(folder.join("b.toml"), motor.replace("= 1e-5", "= 2e-5")).unwrap();
    fs::write(folder.join("log.csv"), log(2000)).unwrap();
    (temporary, folder)
}

#[test]
fn a_file_of_results_survives_every_kill() {
    let (_temporary, folder) = inputs();
    let run = |model: &'static str| {
        ["simulate", "--model", model, "--input", "log.csv", "--out", "out.csv", "--force"]
    };
    let out = folder.join("out.csv");
    let [(takes, a), (_, b)] = ["a.toml", "b.toml"].map(|model| {
        let takes = whole(&folder, &run(model));
        (takes, fs::read(&out).unwrap())
    });
    assert_ne!(a, b);
    let mut killer = Killer::new(takes, 1);
    let mut absent_kept = 0;
    while killer.goes_on(KILLS_OF_FILES) {
        let k = killer.runs;
        let fresh = k % 4 == 3;
        if fresh {
            let _ = fs::remove_file(&out);
        }
        let model = if k.is_multiple_of(2) { "a.toml" } else { "b.toml" };
        killer.kill(&folder, &run(model));
        match fs::read(&out) {
            Ok(found) => assert!(found == a || found == b, "half a file after kill {k}"),
            Err(error) => {
                assert!(fresh, "{error}: the earlier result is gone after kill {k}");
                absent_kept += 1;
                fs::write(&out, &a).unwrap();
            }
        }
    }
    println!("{} runs, {absent_kept} left nothing where nothing was", killer.runs);
    assert!(absent_kept > 0);
}

#[test]
fn a_folder_of_results_survives_every_kill() {
    let (_temporary, folder) = inputs();
    let run = |model: &'static str| {
        ["identify", "--model", model, "--log", "log.csv", "--out", "out", "--force", "--anyway"]
    };
    let out = folder.join("out");
    let both = || ["model.toml", "identify.json"].map(|name| fs::read(out.join(name)).ok());
    let [(takes, a), (_, b)] = ["a.toml", "b.toml"].map(|model| {
        let takes = whole(&folder, &run(model));
        (takes, both())
    });
    assert_ne!(a, b);
    fs::write(out.join("notes.txt"), "mine").unwrap();
    let mut killer = Killer::new(takes, 2);
    while killer.goes_on(KILLS_OF_FOLDERS) {
        let k = killer.runs;
        let model = if k.is_multiple_of(2) { "a.toml" } else { "b.toml" };
        killer.kill(&folder, &run(model));
        // What the next run does first, whatever it is.
        drop(OutDir::new(&out, true).unwrap());
        let found = both();
        assert!(found == a || found == b, "two results in one folder after kill {k}");
        let mut names: Vec<_> =
            fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(
            names,
            [".joint-files", "identify.json", "model.toml", "notes.txt", "report.html"]
        );
    }
    println!("{} runs", killer.runs);
}

/// A file system of so many bytes, unmounted at the end.
struct Disk(PathBuf);

impl Disk {
    /// `None` where this user may not mount one.
    fn of(bytes: usize, folder: &Path) -> Option<Self> {
        let path = folder.join("disk");
        fs::create_dir(&path).unwrap();
        let size = format!("size={bytes}");
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(&path).stderr(Stdio::null());
        mount.status().is_ok_and(|status| status.success()).then_some(Self(path))
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn on_a_full_disk_the_earlier_result_stays_and_nothing_is_left_of_the_new_one() {
    let temporary = tempfile::tempdir().unwrap();
    let Some(disk) = Disk::of(64 * 1024, temporary.path()) else {
        eprintln!("skipped on_a_full_disk: no file system can be mounted here");
        return;
    };
    let out = disk.0.join("out");
    let first = OutDir::new(&out, false).unwrap();
    first.write("model.toml", "old").unwrap();
    first.write("page.html", vec![b'x'; 20_000]).unwrap();
    first.finish().unwrap();
    let second = OutDir::new(&out, true).unwrap();
    second.write("model.toml", "new").unwrap();
    let refused = second.write("page.html", vec![b'y'; 60_000]).unwrap_err();
    assert!(refused.message.contains("cannot be written"), "{refused}");
    drop(second);
    assert_eq!(fs::read_to_string(out.join("model.toml")).unwrap(), "old");
    assert_eq!(fs::metadata(out.join("page.html")).unwrap().len(), 20_000);
    assert_eq!(fs::read_dir(&out).unwrap().count(), 3);
    // The program itself, whose log is larger than what is left.
    fs::write(temporary.path().join("m.toml"), MODEL).unwrap();
    fs::write(temporary.path().join("l.csv"), log(2000)).unwrap();
    let file = disk.0.join("out.csv");
    fs::write(&file, "old").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_joint"))
        .args(["simulate", "--model", "m.toml", "--input", "l.csv", "--force", "--out"])
        .arg(&file)
        .current_dir(temporary.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("out.csv: cannot be written: No space left"), "{told}");
    assert_eq!(fs::read_to_string(&file).unwrap(), "old");
    assert_eq!(fs::read_dir(&disk.0).unwrap().count(), 2);
}
