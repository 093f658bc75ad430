//! Firmware on emulated boards: build it, run it, read what it printed.
//!
//! The firmware is built by cargo into a target folder of its own, so a test run never waits for
//! the lock it holds itself. A program lands in the same place for every memory map; each is copied
//! aside under a file lock, since tests run in parallel.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::thread;
use std::time::{Duration, Instant};

use firmware::block::PAGE_ADDRESS_F405;

const QEMU: &str = "qemu-system-arm";
/// What the firmware is built for.
pub const TARGET: &str = "thumbv7em-none-eabihf";
const SOFT_TARGET: &str = "thumbv7em-none-eabi";
const PROGRAMS: [&str; 6] = ["arithmetic", "replay", "count", "hil", "observe", "prices"];
const TIME_LIMIT: Duration = Duration::from_secs(120);

/// An emulated board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// STM32F405, Cortex-M4F; the only one that counts instructions.
    NetduinoPlus2,
    /// The same without the use of its floating-point unit: programs in fixed point alone.
    NetduinoPlus2Soft,
    /// MPS2 with a Cortex-M4F.
    Mps2An386,
    /// MPS2 with a Cortex-M7.
    Mps2An500,
}

impl Board {
    /// Every board with a floating-point unit in use.
    pub const ALL: [Board; 3] = [Board::NetduinoPlus2, Board::Mps2An386, Board::Mps2An500];

    /// Its name in QEMU.
    pub fn machine(self) -> &'static str {
        match self {
            Board::NetduinoPlus2 | Board::NetduinoPlus2Soft => "netduinoplus2",
            Board::Mps2An386 => "mps2-an386",
            Board::Mps2An500 => "mps2-an500",
        }
    }

    /// Where the page of the parameters lies, by `memory.x`.
    pub fn page_address(self) -> u32 {
        match self {
            Board::NetduinoPlus2 | Board::NetduinoPlus2Soft => PAGE_ADDRESS_F405,
            Board::Mps2An386 | Board::Mps2An500 => PAGE_ADDRESS_F405 - 0x0800_0000,
        }
    }
}

/// What a program left behind.
#[derive(Debug)]
pub struct Run {
    /// Its standard output.
    pub stdout: String,
    /// Its standard error, and QEMU's.
    pub stderr: String,
    /// Its exit code.
    pub code: Option<i32>,
}

impl Run {
    /// The value of a `key=value` line.
    ///
    /// # Panics
    /// There is no such line.
    pub fn value(&self, key: &str) -> &str {
        let mut lines = self.stdout.lines().filter_map(|line| line.split_once('='));
        match lines.find(|(found, _)| *found == key) {
            Some((_, value)) => value,
            None => panic!("no line {key}=… in {self:?}"),
        }
    }
}

/// Whether the emulator is there; otherwise `test` is to be skipped.
///
/// # Panics
/// It is not there and `CI` is set.
pub fn available(test: &str) -> bool {
    let found = Command::new(QEMU).arg("--version").output().is_ok();
    if !found {
        crate::skip(test, "qemu-system-arm is not installed");
    }
    found
}

/// Whether the C cross compiler is there; otherwise `test` is to be skipped.
///
/// # Panics
/// It is not there and `CI` is set.
pub fn c_compiler(test: &str) -> bool {
    let found = Command::new("arm-none-eabi-gcc").arg("--version").output().is_ok();
    if !found {
        crate::skip(test, "arm-none-eabi-gcc is not installed");
    }
    found
}

/// The ELF file of a firmware program for a board; built once in a test process.
///
/// # Panics
/// It does not build.
pub fn firmware(program: &str, board: Board) -> PathBuf {
    static STM32: OnceLock<PathBuf> = OnceLock::new();
    static SOFT: OnceLock<PathBuf> = OnceLock::new();
    static MPS2: OnceLock<PathBuf> = OnceLock::new();
    let folder = match board {
        Board::NetduinoPlus2 => {
            STM32.get_or_init(|| build("stm32", TARGET, &["--bins"], &PROGRAMS))
        }
        Board::NetduinoPlus2Soft => SOFT.get_or_init(|| {
            build(
                "soft",
                SOFT_TARGET,
                &["--bin", "count_fixed", "--bin", "observe_fixed"],
                &["count_fixed", "observe_fixed"],
            )
        }),
        Board::Mps2An386 | Board::Mps2An500 => {
            MPS2.get_or_init(|| build("mps2", TARGET, &["--bins", "--features", "mps2"], &PROGRAMS))
        }
    };
    folder.join(program)
}

/// The workspace's root.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Where the firmware is built.
pub fn target_folder() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) => workspace().join(folder).join("qemu"),
        None => workspace().join("target/qemu"),
    }
}

/// Builds something for the chip, in release, into [`target_folder`].
///
/// # Panics
/// There is no cargo.
pub fn cargo_build(triple: &str, what: &[&str]) -> Output {
    Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()))
        .current_dir(workspace())
        .args(["build", "--release", "--target", triple])
        .args(what)
        .arg("--target-dir")
        .arg(target_folder())
        .output()
        .unwrap()
}

/// Says what the compiler said where it failed.
///
/// # Panics
/// It did.
pub fn built(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn build(map: &str, triple: &str, what: &[&str], programs: &[&str]) -> PathBuf {
    let target = target_folder();
    let folder = target.join("boards").join(map);
    fs::create_dir_all(&folder).unwrap();
    let lock = File::create(target.join("boards/lock")).unwrap();
    lock.lock().unwrap();
    built(&cargo_build(triple, &[&["--package", "firmware"], what].concat()));
    for program in programs {
        // By a rename, which leaves whole what another process may be running.
        let fresh = folder.join(format!("{program}.{}", std::process::id()));
        fs::copy(target.join(triple).join("release").join(program), &fresh).unwrap();
        fs::rename(fresh, folder.join(program)).unwrap();
    }
    folder
}

/// Runs a program on a board in `folder`, where the files that its arguments name stand.
///
/// # Panics
/// The emulator does not start, or the program does not end in two minutes.
pub fn run(program: &str, board: Board, folder: &Path, arguments: &[&str]) -> Run {
    run_elf(&firmware(program, board), board, folder, arguments, None)
}

/// Runs any program for a board, with the flash page of the parameters filled from a file.
///
/// # Panics
/// As [`run`].
pub fn run_elf(
    elf: &Path,
    board: Board,
    folder: &Path,
    arguments: &[&str],
    page: Option<&Path>,
) -> Run {
    let program = elf.file_name().unwrap_or_default().to_string_lossy();
    let mut semihosting = format!("enable=on,target=native,arg={program}");
    for argument in arguments {
        semihosting.push_str(",arg=");
        semihosting.push_str(argument);
    }
    let mut command = Command::new(QEMU);
    if let Some(page) = page {
        let address = board.page_address();
        let page = page.display();
        command.args(["-device", &format!("loader,file={page},addr={address:#x},force-raw=on")]);
    }
    command.args(["-serial", "null", "-semihosting-config", &semihosting]);
    let mut child = start(command, elf, board, folder);
    let stdout = collect(child.stdout.take());
    let stderr = collect(child.stderr.take());
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > TIME_LIMIT {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{program} on {} did not end in {TIME_LIMIT:?}", board.machine());
        }
        thread::sleep(Duration::from_millis(5));
    };
    Run { stdout: stdout.join().unwrap(), stderr: stderr.join().unwrap(), code: status.code() }
}

/// Runs a program that never ends until it has sent that many bytes at the board's first serial port.
///
/// # Panics
/// The emulator does not start or ends by itself, or the bytes do not come in two minutes.
pub fn run_serial(elf: &Path, board: Board, folder: &Path, bytes: usize) -> Vec<u8> {
    let sent = folder.join("serial.bin");
    // One of an earlier run would count as this one's.
    File::create(&sent).unwrap();
    let mut command = Command::new(QEMU);
    command.args(["-serial", "file:serial.bin"]);
    let mut child = start(command, elf, board, folder);
    let began = Instant::now();
    let enough = || fs::metadata(&sent).is_ok_and(|file| file.len() >= bytes as u64);
    while !enough() && began.elapsed() < TIME_LIMIT && child.try_wait().unwrap().is_none() {
        thread::sleep(Duration::from_millis(5));
    }
    // It may have ended.
    let _ = child.kill();
    let end = child.wait_with_output().unwrap();
    let sent = fs::read(&sent).unwrap();
    assert!(sent.len() >= bytes, "{} bytes, {end:?}", sent.len());
    sent
}

fn start(mut command: Command, elf: &Path, board: Board, folder: &Path) -> Child {
    command
        .current_dir(folder)
        .args(["-M", board.machine(), "-display", "none", "-monitor", "none"])
        .args(["-icount", "shift=0,sleep=off", "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn collect(pipe: Option<impl Read + Send + 'static>) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.unwrap().read_to_end(&mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    })
}
