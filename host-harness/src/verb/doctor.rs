//! `joint doctor`: what is installed of what the project uses.

use std::path::Path;
use std::process::Command;

use serde_json::json;

use super::{Common, Failure, Outcome};

/// Say what is installed of what the project uses, and how to install the rest
///
/// Exit code 1 where something is missing that `./check` needs. For models and logs alone, nothing is needed beside
/// this program.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(after_help = "Example:
  joint doctor --json")]
pub struct Args {}

/// One thing that is looked for.
#[derive(Clone, Debug, PartialEq)]
struct Finding {
    name: String,
    /// What it is for.
    purpose: &'static str,
    /// What was found: a version, or that it is there.
    found: Option<String>,
    /// Whether `./check` needs it.
    needed: bool,
    /// The command that installs it.
    install: String,
}

/// The workspace's pinned toolchain, as in `rust-toolchain.toml`.
const CHANNEL: &str = "1.95.0";
const COMPONENTS: [&str; 2] = ["rustfmt", "clippy"];
const TARGETS: [&str; 2] = ["thumbv7em-none-eabihf", "thumbv7em-none-eabi"];

/// A thing that `./check` needs.
fn needed(
    name: &str,
    purpose: &'static str,
    found: Option<String>,
    install: impl Into<String>,
) -> Finding {
    Finding { name: name.to_owned(), purpose, found, needed: true, install: install.into() }
}

/// Runs a program and gives back what it printed; `None` where it is not there or fails.
type Run<'a> = &'a dyn Fn(&str, &[&str]) -> Option<String>;

/// Runs the verb.
///
/// # Errors
/// None: what is missing is what it tells.
pub fn run(_args: &Args, _common: &Common) -> Result<Outcome, Failure> {
    Ok(outcome(&look(&run_program, &|path| Path::new(path).exists())))
}

fn run_program(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

fn look(run: Run<'_>, exists: &dyn Fn(&str) -> bool) -> Vec<Finding> {
    let channel = CHANNEL;
    let first = |text: Option<String>| text.and_then(|text| text.lines().next().map(str::to_owned));
    let mut found = vec![
        needed(
            "rustup",
            "installs the pinned toolchain",
            first(run("rustup", &["--version"])),
            "curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh",
        ),
        needed(
            &format!("Rust {channel}"),
            "builds everything",
            first(run("rustup", &["run", channel, "rustc", "--version"])),
            format!("rustup toolchain install {channel} --profile minimal"),
        ),
    ];
    let list = |what| run("rustup", &[what, "list", "--installed", "--toolchain", channel]);
    let (components, targets) = (list("component"), list("target"));
    found.extend(COMPONENTS.map(|component| {
        let install = format!("rustup component add {component} --toolchain {channel}");
        needed(component, "format and lints", listed(components.as_deref(), component), install)
    }));
    found.extend(TARGETS.map(|target| {
        let install = format!("rustup target add {target} --toolchain {channel}");
        needed(target, "firmware for Cortex-M4", listed(targets.as_deref(), target), install)
    }));
    found.push(needed(
        "qemu-system-arm",
        "runs the firmware: joint budget, tests",
        first(run("qemu-system-arm", &["--version"])),
        package(exists, ["qemu-system-arm", "qemu-system-arm", "qemu-system-arm", "qemu"]),
    ));
    found.push(needed(
        "arm-none-eabi-gcc",
        "builds the example of the C library",
        first(run("arm-none-eabi-gcc", &["--version"])),
        package(
            exists,
            [
                "gcc-arm-none-eabi libnewlib-arm-none-eabi",
                "arm-none-eabi-gcc-cs arm-none-eabi-newlib",
                "arm-none-eabi-gcc arm-none-eabi-newlib",
                "--cask gcc-arm-embedded",
            ],
        ),
    ));
    found.extend(debug_probe(exists));
    found
}

/// A line of a list of rustup's that is this name, or begins with it as `clippy-x86_64…` does.
fn listed(list: Option<&str>, name: &str) -> Option<String> {
    let own = |line: &&str| *line == name || line.starts_with(&format!("{name}-"));
    list?.lines().find(own).map(|_| "installed".to_owned())
}

/// The command of this system's package manager: Debian, Fedora, Arch, Homebrew.
fn package(exists: &dyn Fn(&str) -> bool, names: [&str; 4]) -> String {
    let [debian, fedora, arch, brew] = names;
    let at = |name: &str| exists(&format!("/usr/bin/{name}"));
    if cfg!(target_os = "macos") {
        format!("brew install {brew}")
    } else if at("dnf") {
        format!("sudo dnf install {fedora}")
    } else if at("pacman") {
        format!("sudo pacman -S {arch}")
    } else {
        format!("sudo apt-get install {debian}")
    }
}

/// Where udev keeps rules for who may open a device.
const RULES: [&str; 3] = [
    "/etc/udev/rules.d/69-probe-rs.rules",
    "/usr/lib/udev/rules.d/69-probe-rs.rules",
    "/lib/udev/rules.d/69-probe-rs.rules",
];

/// Debug probes: whether this program can use them, and whether this user may.
fn debug_probe(exists: &dyn Fn(&str) -> bool) -> Vec<Finding> {
    let mut found = vec![Finding {
        name: "debug probes".to_owned(),
        purpose: "joint flash, monitor and capture on a board",
        found: cfg!(feature = "probe").then(|| "built in".to_owned()),
        needed: false,
        install: "cargo build --release -p host-harness --features probe".to_owned(),
    }];
    if cfg!(feature = "probe") && cfg!(target_os = "linux") {
        found.push(Finding {
            name: "udev rules".to_owned(),
            purpose: "lets this user open a debug probe",
            found: RULES.iter().find(|path| exists(path)).map(|path| (*path).to_owned()),
            needed: false,
            install: "sudo curl -L https://probe.rs/files/69-probe-rs.rules -o /etc/udev/rules.d/69-probe-rs.rules && sudo udevadm control --reload && sudo udevadm trigger".to_owned(),
        });
    }
    found.extend(connected());
    found
}

#[cfg(feature = "probe")]
fn connected() -> Option<Finding> {
    let found = crate::probe::board::connected();
    Some(Finding {
        name: "a connected probe".to_owned(),
        purpose: "joint flash, monitor and capture on a board",
        found: (!found.is_empty()).then(|| found.join(", ")),
        needed: false,
        install: "connect one; PROBE_RS_PROBE chooses among several".to_owned(),
    })
}

#[cfg(not(feature = "probe"))]
fn connected() -> Option<Finding> {
    None
}

fn outcome(findings: &[Finding]) -> Outcome {
    let lacks = |finding: &&Finding| finding.needed && finding.found.is_none();
    let passed = !findings.iter().any(|finding| lacks(&finding));
    let width = findings.iter().map(|finding| finding.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for Finding { name, purpose, found, needed, install } in findings {
        match found {
            Some(found) => text.push_str(&format!("found    {name:width$}  {found}\n")),
            None => {
                let optional = if *needed { "" } else { " (optional)" };
                text.push_str(&format!("missing  {name:width$}  {purpose}{optional}\n"));
                text.push_str(&format!("         {:width$}  {install}\n", ""));
            }
        }
    }
    text.push_str(match passed {
        true => "All that ./check needs is there.",
        false => "Something that ./check needs is missing. Models and logs need nothing beside this program.",
    });
    let list = findings.iter().map(|finding| {
        json!({
            "name": finding.name, "purpose": finding.purpose, "found": finding.found.is_some(),
            "version": finding.found, "needed_by_check": finding.needed, "install": finding.install,
        })
    });
    Outcome { json: json!({"passed": passed, "findings": list.collect::<Vec<_>>()}), text, passed }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_there(program: &str, arguments: &[&str]) -> Option<String> {
        Some(match (program, arguments) {
            ("rustup", ["component", ..]) => "cargo-x\nclippy-x\nrustfmt-x\n".to_owned(),
            ("rustup", ["target", ..]) => {
                "thumbv7em-none-eabi\nthumbv7em-none-eabihf\nx86_64-unknown-linux-gnu\n".to_owned()
            }
            _ => format!("{program} 1.2.3\nmore\n"),
        })
    }

    #[test]
    fn the_toolchain_is_the_one_that_the_workspace_pins() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rust-toolchain.toml");
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.contains(&format!("channel = \"{CHANNEL}\"\n")), "{text}");
        assert!(text.contains(&format!("components = {COMPONENTS:?}\n")), "{text}");
        assert!(text.contains(&format!("targets = {TARGETS:?}\n")), "{text}");
    }

    #[test]
    fn where_all_is_there_it_passes_and_says_versions() {
        let outcome = outcome(&look(&all_there, &|_| true));
        assert!(outcome.passed, "{}", outcome.text);
        assert!(outcome.text.contains("qemu-system-arm 1.2.3\n"), "{}", outcome.text);
        assert_eq!(outcome.json["passed"], true);
    }

    #[test]
    fn each_thing_that_check_needs_fails_it_with_the_command_that_installs_it() {
        let lacking: [(&str, &str, &str); 5] = [
            ("qemu-system-arm", "", "install"),
            ("arm-none-eabi-gcc", "", "install"),
            ("rustup", "run", "rustup toolchain install"),
            ("rustup", "target", "rustup target add thumbv7em-none-eabihf"),
            ("rustup", "component", "rustup component add clippy"),
        ];
        for (program, first, command) in lacking {
            let run = |own: &str, arguments: &[&str]| match own == program
                && (first.is_empty() || arguments.first() == Some(&first))
            {
                true => None,
                false => all_there(own, arguments),
            };
            let outcome = outcome(&look(&run, &|_| false));
            assert!(!outcome.passed, "{program} {first}");
            assert!(outcome.text.contains(command), "{}", outcome.text);
        }
    }

    /// A target whose name is the beginning of another's is not taken for it.
    #[test]
    fn a_hard_float_target_does_not_stand_for_the_soft_one() {
        assert_eq!(listed(Some("thumbv7em-none-eabihf\n"), "thumbv7em-none-eabi"), None);
        assert!(listed(Some("clippy-x86_64-unknown-linux-gnu\n"), "clippy").is_some());
    }

    #[test]
    fn no_debug_probe_fails_nothing() {
        assert!(debug_probe(&|_| false).iter().all(|finding| !finding.needed));
    }
}
