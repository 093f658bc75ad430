//! Bad inputs, with the exact message and exit code of each.
//!
//! The table stands in `snapshots/bad-inputs.txt`, where a change of wording shows in a diff. To write it
//! anew, run this test with `JOINT_SNAPSHOT=write`.

mod common;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use common::MODEL;

/// A log of so many samples of a joint that swings, at 200 µs.
fn log(samples: usize) -> String {
    let mut text = String::from("t_s,u_v,i_a,motor_angle_rad,output_angle_rad\n");
    for k in 0..samples {
        let t = 2e-4 * k as f64;
        let speed = 20.0 * (40.0 * t).cos();
        let angle = 0.5 * (40.0 * t).sin();
        let current = 0.1 * speed.signum() - 8.0e-3 * (40.0 * t).sin();
        let voltage = current + 0.1 * speed;
        let output = angle / 10.0;
        let _ = writeln!(text, "{t:.4},{voltage:.6},{current:.6},{angle:.6},{output:.7}");
    }
    text
}

/// The log with one field of one row changed.
fn with_field(row: usize, column: usize, to: &str) -> String {
    let text = log(300);
    let changed = text.lines().enumerate().map(|(line, content)| {
        let mut fields: Vec<&str> = content.split(',').collect();
        if line == row {
            fields[column] = to;
        }
        fields.join(",")
    });
    changed.collect::<Vec<_>>().join("\n") + "\n"
}

/// One row of the table: what is bad, the model, the log and the command.
struct Bad {
    what: &'static str,
    model: String,
    log: String,
    command: &'static str,
}

const CHECK: &str = "check --model m.toml --log l.csv";
const IDENTIFY: &str = "identify --model m.toml --log l.csv --out o";
const DISCOVER: &str = "discover --model m.toml --log l.csv --out o";
const SIMULATE: &str = "simulate --model m.toml --input l.csv --out o.csv";
const TRANSFER: &str = "transfer --model m.toml --log l.csv --out o";

fn of_model(what: &'static str, from: &str, to: &str) -> Bad {
    assert!(MODEL.contains(from), "{from}");
    Bad { what, model: MODEL.replacen(from, to, 1), log: log(300), command: SIMULATE }
}

fn of_log(what: &'static str, log: String) -> Bad {
    Bad { what, model: MODEL.to_owned(), log, command: SIMULATE }
}

fn of_usage(what: &'static str, command: &'static str) -> Bad {
    Bad { what, model: MODEL.to_owned(), log: log(300), command }
}

fn checked(bad: Bad, command: &'static str) -> Bad {
    Bad { command, ..bad }
}

fn models() -> Vec<Bad> {
    vec![
        of_model("no TOML", "[motor]", "[motor"),
        of_model("no motor", "[motor]", "[engine]"),
        of_model("unknown key", "coulomb_nm", "coulomb"),
        of_model("unknown table", "[[stage]]", "[[gear]]"),
        of_model("stage that is no array", "[[stage]]", "[stage]"),
        of_model("text for a number", "= 300", "= \"300\""),
        of_model("boolean for a number", "= 300", "= true"),
        of_model("key given twice", "= 300", "= 300\nreduction = 3"),
        of_model("inertia missing", "rotor_inertia_kg_m2 = 1e-5\n", ""),
        of_model("inertia zero", "= 1e-5", "= 0"),
        of_model("inertia negative", "= 1e-5", "= -1e-5"),
        of_model("inertia not a number", "= 1e-5", "= nan"),
        of_model("inertia infinite", "= 1e-5", "= inf"),
        of_model("inertia of 1e-300", "= 1e-5", "= 1e-300"),
        of_model("stiffness of 1e300", "= 300", "= 1e300"),
        of_model("stiffness zero", "= 300", "= 0"),
        of_model("stiffness negative", "= 300", "= -300"),
        of_model("stiffness missing", "stiffness_nm_per_rad = 300\n", ""),
        of_model("reduction zero", "= 10\ninertia", "= 0\ninertia"),
        of_model("torque constant zero", "= 0.1", "= 0"),
        of_model("resistance negative", "= 0.5", "= -0.5"),
        of_model("resistance zero with a voltage", "= 0.5", "= 0"),
        of_model("inductance negative", "= 1e-4", "= -1e-4"),
        of_model("bristles without a level", "coulomb_nm = 0.01", "coulomb_nm = 0"),
        of_model("a level without bristles", "sigma0_nm_per_rad = 10", "sigma0_nm_per_rad = 0"),
        of_model("Coulomb level negative", "coulomb_nm = 0.01", "coulomb_nm = -0.01"),
        of_model("pole pairs zero", "[motor.friction]", "pole_pairs = 0\n[motor.friction]"),
        of_model("pole pairs negative", "[motor.friction]", "pole_pairs = -1\n[motor.friction]"),
        of_model(
            "power balance broken",
            "[motor.friction]",
            "phase_back_emf_constant_v_s_per_rad = 0.1\n[motor.friction]",
        ),
        of_model(
            "counts negative",
            "[[stage]]",
            "[sensor]\nmotor_encoder_counts_per_rev = -1\n[[stage]]",
        ),
        of_model(
            "unknown kind",
            "[[stage]]",
            "[[effect]]\nkind = \"clogging\"\nlocation = \"motor\"\n[[stage]]",
        ),
        of_model(
            "effect without a kind",
            "[[stage]]",
            "[[effect]]\nlocation = \"motor\"\n[[stage]]",
        ),
        of_model(
            "effect at no such place",
            "[[stage]]",
            "[[effect]]\nkind = \"cogging\"\nlocation = \"stage1\"\norder = 6\namplitude_nm = 1\n[[stage]]",
        ),
        of_model(
            "effect behind the last stage",
            "[[stage]]",
            "[[effect]]\nkind = \"backlash\"\nlocation = \"stage2\"\nwidth_rad = 0.01\n[[stage]]",
        ),
        of_model(
            "effect without its parameter",
            "[[stage]]",
            "[[effect]]\nkind = \"cogging\"\nlocation = \"motor\"\norder = 6\n[[stage]]",
        ),
        checked(of_model("inertia of 442", "= 1e-5", "= 442"), CHECK),
        checked(of_model("stiffness of 1e20", "= 300", "= 1e20"), CHECK),
        checked(of_model("reduction inverted", "= 10\ninertia", "= 0.1\ninertia"), CHECK),
        checked(of_model("reduction 5 % off", "= 10\ninertia", "= 10.5\ninertia"), IDENTIFY),
        checked(
            of_model("reduction of the wrong sign", "= 10\ninertia", "= -10\ninertia"),
            DISCOVER,
        ),
    ]
}

fn logs() -> Vec<Bad> {
    let long = "x".repeat(500);
    let wide: Vec<String> = (0..200_000).map(|k| format!("column{k}")).collect();
    let wide = wide.join(",");
    let many: Vec<String> = (0..50).map(|k| format!("c{k}")).collect();
    let many = log(300)
        .lines()
        .enumerate()
        .map(|(k, line)| format!("{line},{}", if k == 0 { many.join(",") } else { ",".repeat(49) }))
        .collect::<Vec<_>>()
        .join("\n");
    let header = "t_s,u_v,motor_angle_rad\n";
    let reversed = log(300).replacen("0.0002,", "0.0000,", 1);
    vec![
        of_log("empty", String::new()),
        of_log("header alone", header.to_owned()),
        of_log("one row", format!("{header}0,1,0\n")),
        of_log("no header", "0,1,0\n1,1,0\n".to_owned()),
        of_log("semicolons", header.replace(',', ";") + "0;1;0\n1;1;0\n"),
        of_log("tabs", header.replace(',', "\t") + "0\t1\t0\n1\t1\t0\n"),
        of_log("no time", "time,u_v,motor_angle_rad\n0,1,0\n1,1,0\n".to_owned()),
        of_log("no rotor angle", "t_s,u_v\n0,1\n1,1\n".to_owned()),
        of_log("no drive", "t_s,motor_angle_rad\n0,1\n1,1\n".to_owned()),
        of_log("rotor angle without a value", format!("{header}0,1,\n1,1,\n")),
        of_log("column twice", "t_s,u_v,u_v,motor_angle_rad\n0,1,1,0\n1,1,1,0\n".to_owned()),
        of_log("row cut short", format!("{header}0,1,0\n1,1\n")),
        of_log("row too long", format!("{header}0,1,0\n1,1,0,0\n")),
        of_log("time missing", format!("{header}0,1,0\n,1,0\n")),
        of_log("time that does not rise", reversed),
        of_log("time that falls", format!("{header}1,1,0\n0,1,0\n")),
        of_log("text for a number", with_field(7, 1, "abc")),
        of_log("decimal comma in quotes", with_field(7, 1, "\"1;5\"")),
        of_log("hexadecimal", with_field(7, 1, "0x10")),
        of_log("not a number", with_field(7, 1, "NaN")),
        of_log("infinite", with_field(7, 1, "-inf")),
        of_log("1e999", with_field(7, 1, "1e999")),
        of_log("1e300", with_field(7, 1, "1e300")),
        of_log("field of 500 characters", with_field(7, 1, &long)),
        of_log("header of 200,000 columns", format!("{wide}\n")),
        checked(of_log("50 unknown columns", many), CHECK),
        checked(of_log("one voltage of 1e6", with_field(100, 1, "1e6")), DISCOVER),
        checked(of_log("one current of -1e9", with_field(100, 2, "-1e9")), IDENTIFY),
        checked(of_log("one angle of 1e30", with_field(100, 3, "1e30")), CHECK),
        checked(of_log("five rows", log(5)), IDENTIFY),
        checked(of_log("five rows", log(5)), DISCOVER),
        checked(of_log("199 rows", log(199)), CHECK),
        of_log("first angle missing", with_field(1, 3, "")),
    ]
}

fn usage() -> Vec<Bad> {
    vec![
        of_usage("no such model", "simulate --model none.toml --input l.csv --out o.csv"),
        of_usage("no such log", "simulate --model m.toml --input none.csv --out o.csv"),
        of_usage("a log for a model", "simulate --model l.csv --input l.csv --out o.csv"),
        of_usage("a model for a log", "simulate --model m.toml --input m.toml --out o.csv"),
        of_usage("a folder for a log", "check --model m.toml --log ."),
        of_usage("a folder for a file", "simulate --model m.toml --input l.csv --out ."),
        of_usage("a file for a folder", "identify --model m.toml --log l.csv --out m.toml"),
        of_usage("an earlier result", "transfer --model m.toml --log l.csv --out ."),
        of_usage("step zero", "simulate --model m.toml --input l.csv --out o.csv --step-us 0"),
        of_usage(
            "reference in f32",
            "simulate --model m.toml --input l.csv --out o.csv --method reference --scalar f32",
        ),
        of_usage("no model", "check --log l.csv"),
        of_usage("no log", "transfer --model m.toml"),
        of_usage("no such verb", "chekc --model m.toml"),
        of_usage("no such kind", "discover --model m.toml --log l.csv --out o --without clogging"),
        checked(of_log("a log that is no text", "\u{0}\u{1}".to_owned()), TRANSFER),
    ]
}

#[test]
fn every_bad_input_is_told_in_these_words_and_leaves_nothing() {
    let all: Vec<Bad> = [models(), logs(), usage()].into_iter().flatten().collect();
    assert!(all.len() >= 80, "{}", all.len());
    let mut told = String::new();
    for bad in &all {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("m.toml"), &bad.model).unwrap();
        std::fs::write(folder.path().join("l.csv"), &bad.log).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_joint"))
            .args(bad.command.split_whitespace())
            .current_dir(folder.path())
            .output()
            .unwrap();
        let code = output.status.code();
        assert!(code.is_some_and(|code| code <= 2), "{}: {code:?}", bad.what);
        let mut left: Vec<_> = std::fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        assert_eq!(left, ["l.csv", "m.toml"], "{}", bad.what);
        // What a check finds stands on standard output; its notes are measurements and stay out.
        let found = String::from_utf8(output.stdout).unwrap();
        let found =
            found.lines().filter(|line| !line.starts_with("note: ") || line.contains("ignored"));
        let words = String::from_utf8(output.stderr).unwrap();
        let _ = writeln!(told, "## {}\n$ joint {}\nexit {}", bad.what, bad.command, code.unwrap());
        found.for_each(|line| {
            let _ = writeln!(told, "{line}");
        });
        let _ = writeln!(told, "{words}");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots/bad-inputs.txt");
    if std::env::var_os("JOINT_SNAPSHOT").is_some_and(|value| value == "write") {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &told).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap();
    for (now, kept) in told.split("## ").zip(kept.split("## ")) {
        assert_eq!(now, kept);
    }
    assert_eq!(told.len(), kept.len());
}
