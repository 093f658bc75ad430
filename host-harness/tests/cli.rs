//! The command `joint` from outside: exit codes, what it prints where, and what it leaves behind.

mod common;

use std::path::Path;
use std::process::{Command, Output};

use common::MODEL;
use host_harness::log::{Log, Need};

/// A folder with a model and a log of a voltage step, 2,000 samples at 200 µs.
fn folder() -> tempfile::TempDir {
    folder_with(2000)
}

/// The same with so many samples.
fn folder_with(samples: u32) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), MODEL).unwrap();
    let mut log = String::from("t_s,u_v,i_a,motor_angle_rad,output_angle_rad,note\n");
    for k in 0..samples {
        let voltage = if k < 100 { 0.0 } else { 3.0 };
        log.push_str(&format!("{:.4},{voltage},9,9,9,x\n", f64::from(k) * 2e-4));
    }
    std::fs::write(folder.path().join("l.csv"), log).unwrap();
    folder
}

fn object(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

fn joint(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_joint"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap()
}

fn simulate(folder: &Path, more: &str) -> Output {
    joint(folder, &format!("simulate --model m.toml --input l.csv --out o.csv {more}"))
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A column of a simulation.
fn column(folder: &Path, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(folder.join("o.csv")).unwrap();
    let at = reader.headers().unwrap().iter().position(|own| own == name).unwrap();
    reader.records().map(|record| record.unwrap()[at].parse().unwrap()).collect()
}

#[test]
fn a_simulation_has_the_columns_of_the_log_and_every_state() {
    let folder = folder();
    let output = simulate(folder.path(), "");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "warning: l.csv: unknown columns are ignored: note\n");
    let text = std::fs::read_to_string(folder.path().join("o.csv")).unwrap();
    assert_eq!(
        text.lines().next(),
        Some(
            "t_s,u_v,i_a,motor_angle_rad,output_angle_rad,current_a,motor_speed_rad_per_s,\
             motor_bristle,stage1_angle_rad,stage1_speed_rad_per_s,stage1_windup_rad,stage1_bristle"
        )
    );
    let log = Log::read(&folder.path().join("o.csv"), Need::Drive).unwrap().log;
    assert_eq!(log.len(), 2000);
    // 3 V over k_t = 0.1 is 30 rad/s, less what friction takes: 0.01 Nm / k_t · 2R / k_t = 1.
    let speed = column(folder.path(), "motor_speed_rad_per_s");
    assert!((speed[1999] - 29.0).abs() < 0.01, "{}", speed[1999]);
    let last = |name: &str| column(folder.path(), name)[1999];
    assert!((last("stage1_speed_rad_per_s") - 2.9).abs() < 0.01);
    assert_eq!(last("output_angle_rad"), last("stage1_angle_rad"));
    let (angle, output) = (last("motor_angle_rad"), last("output_angle_rad"));
    assert!((angle / 10.0 - output - last("stage1_windup_rad")).abs() < 1e-9);
}

#[test]
fn both_numbers_and_both_methods_agree() {
    let folder = folder();
    let angle = |more: &str| {
        let output = simulate(folder.path(), &format!("--force {more}"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        column(folder.path(), "motor_angle_rad")[1999]
    };
    let reference = angle("--method reference");
    for more in ["--scalar f64", "--scalar f32", "--step-us 50", "--method reference --step-us 2"] {
        let ours = angle(more);
        assert!((ours / reference - 1.0).abs() < 1e-3, "{more}: {ours} for {reference}");
    }
}

#[test]
fn a_run_begins_at_the_first_state_of_its_log_by_both_methods() {
    let folder = folder();
    assert_eq!(simulate(folder.path(), "").status.code(), Some(0));
    let whole = std::fs::read_to_string(folder.path().join("o.csv")).unwrap();
    // The simulated log from its middle on, where the joint turns and its bristles are stretched.
    let rest: Vec<&str> = whole.lines().take(1).chain(whole.lines().skip(1001)).collect();
    std::fs::write(folder.path().join("l.csv"), rest.join("\n")).unwrap();
    let last = whole.lines().next_back().unwrap().split(',').nth(3).unwrap();
    let last: f64 = last.parse().unwrap();
    for more in ["--force", "--force --method reference", "--force --scalar f32"] {
        assert_eq!(simulate(folder.path(), more).status.code(), Some(0), "{more}");
        let angle = column(folder.path(), "motor_angle_rad");
        // The start's speed is good to a thousandth of the 6 rad that follow, and so is the method.
        assert!((angle.last().unwrap() - last).abs() < 6e-3, "{more}: {:?} {last}", angle.last());
    }
}

#[test]
fn with_json_standard_output_is_one_object_whether_it_went_well_or_not() {
    let folder = folder();
    let done = object(&simulate(folder.path(), "--json"));
    assert_eq!(done, serde_json::json!({"out": "o.csv", "model": "m", "samples": 2000}));
    let refused = simulate(folder.path(), "--json");
    assert_eq!(refused.status.code(), Some(2));
    assert!(object(&refused)["error"].as_str().unwrap().contains("is there already"));
}

#[test]
fn an_earlier_result_is_replaced_only_when_forced() {
    let folder = folder();
    let path = folder.path().join("o.csv");
    std::fs::write(&path, "mine").unwrap();
    let output = simulate(folder.path(), "");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        stderr(&output),
        "error: o.csv: is there already\n  help: choose another name, or replace it with --force\n"
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    assert_eq!(simulate(folder.path(), "--force").status.code(), Some(0));
    assert_ne!(std::fs::read_to_string(&path).unwrap(), "mine");
}

#[test]
fn bad_input_and_bad_usage_exit_with_two_and_leave_nothing() {
    let folder = folder();
    std::fs::write(folder.path().join("bad.toml"), MODEL.replace("1e-5", "-1e-5")).unwrap();
    let (model, log, out) = ("--model m.toml", "--input l.csv", "--out o.csv");
    let cases = [
        String::new(),
        "nonsense".to_owned(),
        format!("simulate {model} {log}"),
        format!("simulate {model} {log} {out} --step-us 0"),
        format!("simulate {model} {log} {out} --step-us nan"),
        format!("simulate {model} {log} {out} --scalar f16"),
        format!("simulate {model} {log} {out} --method reference --scalar f32"),
        format!("simulate --model none.toml {log} {out}"),
        format!("simulate --model bad.toml {log} {out}"),
        format!("simulate {model} --input none.csv {out}"),
        format!("simulate {model} --input m.toml {out}"),
        format!("simulate {model} {log} --out ."),
    ];
    for arguments in cases {
        let output = joint(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        assert!(!stderr(&output).is_empty(), "{arguments}");
        assert!(output.stdout.is_empty(), "{arguments}");
    }
    let mut left: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(left, ["bad.toml", "l.csv", "m.toml"]);
}

#[test]
fn an_explicit_step_too_long_for_the_joint_is_a_failed_check() {
    let folder = folder();
    let output = simulate(folder.path(), "--method reference --step-us 150");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(!folder.path().join("o.csv").exists());
}

/// The verbs of `joint --help`, in its order.
fn verbs(help: &str) -> Vec<&str> {
    let listed = help.lines().take_while(|line| *line != "Options:");
    let listed = listed.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    listed.filter_map(|line| line.split_whitespace().next()).collect()
}

#[test]
fn every_verb_has_help_with_an_example_and_its_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let help = joint(folder.path(), "--help");
    assert_eq!(help.status.code(), Some(0));
    let help = String::from_utf8(help.stdout).unwrap();
    let verbs = verbs(&help);
    assert!(verbs.contains(&"simulate") && verbs.contains(&"man"), "{help}");
    // Under headings, each verb once.
    let mut once = verbs.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), verbs.len());
    assert!(help.lines().filter(|line| line.ends_with(':') && !line.starts_with(' ')).count() > 4);
    for verb in verbs {
        let output = joint(folder.path(), &format!("{verb} --help"));
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(0), "{verb}");
        assert!(text.contains(&format!("Example:\n  joint {verb} ")), "{verb}: {text}");
        assert!(text.contains("--json") && text.contains("--force"), "{verb}");
        assert!(text.contains("Exit code: 0 done, 1 "), "{verb}: {text}");
    }
}

#[test]
fn help_fits_the_width_and_its_examples_stay_commands() {
    let folder = tempfile::tempdir().unwrap();
    let help = |width: &str, verb: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_joint"))
            .args([verb, "--help"].iter().filter(|own| !own.is_empty()))
            .env("COLUMNS", width)
            .current_dir(folder.path())
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    for verb in ["", "simulate", "cross-check", "observe-bench"] {
        let narrow = help("60", verb);
        // The line of usage is one command, and the terminal's to break.
        for line in narrow.lines().filter(|line| !line.starts_with("Usage:")) {
            assert!(line.chars().count() <= 60, "{verb}: {line}");
        }
        assert!(help("200", verb).lines().count() < narrow.lines().count(), "{verb}");
    }
    let text = help("60", "simulate");
    let example = text.lines().skip_while(|line| *line != "Example:").nth(1).unwrap();
    assert!(example.ends_with(" \\"), "{example}");
}

#[test]
fn an_error_of_usage_is_an_object_too_where_json_is_asked_for() {
    let folder = folder();
    for (arguments, told) in [
        ("--json", "no verb is given"),
        ("nonsense --json", "nonsense"),
        ("simulate --json", "--model <TOML>"),
        ("simulate --json --model m.toml --input l.csv --out o.csv --step-us 0", "above zero"),
    ] {
        let output = joint(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        let error = object(&output)["error"].as_str().unwrap().to_owned();
        assert!(error.contains(told) && !error.contains('\u{1b}'), "{arguments}: {error}");
        assert!(!stderr(&output).is_empty(), "{arguments}");
    }
}

#[test]
fn a_log_comes_by_standard_input_and_a_file_goes_by_standard_output() {
    let folder = folder();
    assert!(simulate(folder.path(), "").status.success());
    let wanted = std::fs::read(folder.path().join("o.csv")).unwrap();
    let piped = |arguments: &str, log: &str| {
        Command::new(env!("CARGO_BIN_EXE_joint"))
            .args(arguments.split_whitespace())
            .current_dir(folder.path())
            .stdin(std::fs::File::open(folder.path().join(log)).unwrap())
            .output()
            .unwrap()
    };
    let output = piped("simulate -m m.toml -i - -o -", "l.csv");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(output.stdout, wanted);
    // What a person is told stands beside it.
    assert!(stderr(&output).contains("2000 samples of m"), "{}", stderr(&output));
    assert!(!folder.path().join("-").exists());
    // The same finding by either way, at its line.
    let [file, input] =
        [piped("check -m m.toml -l o.csv", "o.csv"), piped("check -m m.toml -l -", "o.csv")];
    let text = |output: &Output| String::from_utf8(output.stdout.clone()).unwrap();
    assert_eq!(text(&input).replace(" -:", " o.csv:"), text(&file));
    let refused = piped("simulate -m m.toml -i - -o p.csv", "m.toml");
    assert!(stderr(&refused).starts_with("error: standard input"), "{}", stderr(&refused));
    for (arguments, told) in [
        ("simulate -m m.toml -i l.csv -o - --json", "standard output takes one thing"),
        ("identify -m m.toml -l l.csv -o -", "several files"),
        ("import l.csv -o - --save-map -", "standard output takes one thing"),
    ] {
        let refused = joint(folder.path(), arguments);
        assert_eq!(refused.status.code(), Some(2), "{arguments}");
        assert!(stderr(&refused).contains(told), "{arguments}: {}", stderr(&refused));
    }
}

#[test]
fn shells_complete_every_verb_and_the_manual_has_a_page_of_each() {
    let folder = tempfile::tempdir().unwrap();
    let help = String::from_utf8(joint(folder.path(), "--help").stdout).unwrap();
    let verbs = verbs(&help);
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let output = joint(folder.path(), &format!("completions {shell}"));
        let script = String::from_utf8(output.stdout).unwrap();
        for verb in &verbs {
            assert!(script.contains(verb), "{shell}: {verb}");
        }
        assert!(script.contains("rated-load-nm"), "{shell}");
    }
    assert_eq!(joint(folder.path(), "completions tcsh").status.code(), Some(2));
    assert_eq!(joint(folder.path(), "man --out man").status.code(), Some(0));
    for verb in &verbs {
        let page = folder.path().join(format!("man/joint-{verb}.1"));
        let page = std::fs::read_to_string(&page).unwrap_or_else(|error| panic!("{verb}: {error}"));
        assert!(page.contains(".SH OPTIONS") && page.contains("Exit code"), "{verb}: {page}");
    }
    let program = std::fs::read_to_string(folder.path().join("man/joint.1")).unwrap();
    assert!(program.contains("joint\\-discover(1)"), "{program}");
}

#[test]
fn doctor_names_what_it_looked_for_and_its_code_follows() {
    let folder = tempfile::tempdir().unwrap();
    let output = joint(folder.path(), "doctor --json");
    let told = object(&output);
    assert_eq!(output.status.code(), Some(if told["passed"] == true { 0 } else { 1 }));
    let findings = told["findings"].as_array().unwrap();
    assert!(findings.iter().any(|finding| finding["name"] == "qemu-system-arm"), "{told}");
    for finding in findings {
        assert!(!finding["install"].as_str().unwrap().is_empty(), "{finding}");
        let lacks = finding["needed_by_check"] == true && finding["found"] == false;
        assert!(told["passed"] == false || !lacks, "{finding}");
    }
}

#[test]
fn a_kind_that_is_not_on_the_list_is_refused_with_the_list() {
    let folder = folder();
    let refused =
        joint(folder.path(), "discover --model m.toml --log l.csv --out found --without clogging");
    assert_eq!(refused.status.code(), Some(2));
    let message = stderr(&refused);
    assert!(message.contains("clogging") && message.contains("asymmetric-friction"), "{message}");
}

/// A signal is sent by the shell's `kill`: the standard library sends none.
#[cfg(unix)]
#[test]
fn an_interrupt_concludes_with_all_files_and_says_so() {
    let folder = folder_with(30_000);
    assert!(simulate(folder.path(), "").status.success());
    std::fs::rename(folder.path().join("o.csv"), folder.path().join("l.csv")).unwrap();
    let mut search = Command::new(env!("CARGO_BIN_EXE_joint"))
        .args("discover --model m.toml --log l.csv --out found --json".split_whitespace())
        .current_dir(folder.path())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // Long enough for the handler to stand, far shorter than a search of so many samples takes.
    std::thread::sleep(std::time::Duration::from_secs(1));
    assert!(search.try_wait().unwrap().is_none(), "the search ended before it was interrupted");
    let sent = Command::new("kill").args(["-INT", &search.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let output = search.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("interrupt again to quit"), "{}", stderr(&output));
    let verdict = std::fs::read_to_string(folder.path().join("found/verdict.json")).unwrap();
    assert!(verdict.contains("interrupted: this is what was known by then"), "{verdict}");
    for file in ["model.toml", "report.html", "residuals.csv"] {
        assert!(folder.path().join("found").join(file).exists(), "{file}");
    }
}

#[test]
fn a_drawn_benchmark_counts_what_it_scored() {
    let folder = tempfile::tempdir().unwrap();
    let score = "score --simulate 5 --from 2 --only adequate --seed 5 --out scores --json";
    let done = object(&joint(folder.path(), score));
    let shares = &done["summary"]["shares"];
    assert_eq!(done["cases"][0]["truth"], "adequate");
    assert_eq!(done["cases"][0]["case"], "0002");
    assert_eq!(done["cases"].as_array().unwrap().len(), 1, "the others hide an effect");
    assert_eq!(shares["false_alarms"]["of"], 1);
    assert!(shares.get("named_rightly").is_none(), "no effect was hidden: {shares}");
    let kept: serde_json::Value = serde_json::from_str(
        &std::fs::read_to_string(folder.path().join("scores/score.json")).unwrap(),
    )
    .unwrap();
    assert_eq!(kept, done);
    // An answer that is wrong is kept with its log.
    let right = shares["false_alarms"]["count"] == 0;
    assert_eq!(folder.path().join("scores/0002/log.csv").exists(), !right);
    // The draw alone is a set, of which the same answer is given.
    let draw = "score --simulate 5 --from 2 --only adequate --seed 5 --logs-only --out set --json";
    assert_eq!(object(&joint(folder.path(), draw))["cases"][0]["case"], "0002");
    let of_set = object(&joint(folder.path(), "score --set set --out of-set --json"));
    let timeless = |cases: &serde_json::Value| {
        let mut case = cases[0].clone();
        case["seconds"] = 0.into();
        case
    };
    assert_eq!(timeless(&of_set["cases"]), timeless(&done["cases"]));
    let join = "score --join scores/score.json scores/score.json --out both --json";
    let both = object(&joint(folder.path(), join));
    assert_eq!(both["cases"], serde_json::json!([done["cases"][0], done["cases"][0]]));
    assert_eq!(both["summary"]["shares"]["false_alarms"]["of"], 2);
    std::fs::write(folder.path().join("no.json"), "{}").unwrap();
    // What a draw asks for is no matter of a set.
    let refused = joint(folder.path(), "score --set practice --seed 3 --out none");
    assert!(stderr(&refused).contains("cannot be used with '--seed"), "{}", stderr(&refused));
    let refused = joint(folder.path(), "score --join no.json --out none");
    assert!(!refused.status.success() && !folder.path().join("none").exists());
    assert!(stderr(&refused).contains("no.json: missing field `cases`"), "{}", stderr(&refused));
}
