//! Logs and models that others made: every one under the folder that `JOINT_DATA` names.

use std::path::{Path, PathBuf};

use host_harness::log::{Log, Need};
use host_harness::model::Model;
use host_harness::plant::{Inputs, ScalarKind, simulate};
use host_harness::preflight::{self, Severity};
use joint_tests::data;

/// The model files under a folder, each with the logs beside it.
fn cases(folder: &Path, found: &mut Vec<(PathBuf, Vec<PathBuf>)>) {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let is_log = |path: &PathBuf| {
        let name = name(path);
        (name.ends_with(".csv") || name.ends_with(".csv.gz")) && !name.starts_with("truth.")
    };
    if let Some(model) = paths.iter().find(|path| name(path) == "nominal.toml") {
        found.push((model.clone(), paths.iter().filter(|path| is_log(path)).cloned().collect()));
    }
    for path in paths.iter().filter(|path| path.is_dir()) {
        cases(path, found);
    }
}

/// What the pre-flight would stop at.
fn errors(model: &Model, log: &Log) -> Vec<String> {
    let found = preflight::findings(model, log).into_iter();
    found.filter(|f| f.severity == Severity::Error).map(|f| f.message).collect()
}

#[test]
fn a_voltage_computed_with_the_ripple_of_the_bus_is_stopped_and_one_without_is_not() {
    let test = "a_voltage_computed_with_the_ripple_of_the_bus_is_stopped_and_one_without_is_not";
    let Some(folder) = data::folder(test) else { return };
    let servo = folder.join("real/xl330");
    if !servo.is_dir() {
        return;
    }
    let model = Model::read(&servo.join("nominal.toml")).unwrap();
    for (own, stopped) in [("as-recorded", true), (".", false), ("transfer", false)] {
        for entry in std::fs::read_dir(servo.join(own)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "csv") {
                let found = errors(&model, &Log::read(&path, Need::Drive).unwrap().log);
                let carried = found.iter().any(|message| message.contains("u_v carries it"));
                assert_eq!((carried, found.len()), (stopped, usize::from(stopped)), "{found:?}");
            }
        }
    }
}

#[test]
fn every_model_reads_back_and_runs_on_every_log_beside_it() {
    let test = "every_model_reads_back_and_runs_on_every_log_beside_it";
    let Some(folder) = data::folder(test) else { return };
    let mut found = Vec::new();
    cases(&folder, &mut found);
    assert!(!found.is_empty(), "no nominal.toml under {}", folder.display());
    for (path, logs) in found {
        let model = Model::read(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(Model::parse(&model.to_toml(), &path).as_ref(), Ok(&model));
        for path in logs {
            let loaded = Log::read(&path, Need::Drive).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(loaded.warnings, Vec::<String>::new(), "{}", path.display());
            assert_eq!(errors(&model, &loaded.log), Vec::<String>::new(), "{}", path.display());
            let inputs = Inputs::from_log(&loaded.log);
            for scalar in [ScalarKind::F64, ScalarKind::F32] {
                let run = simulate(&model, &inputs, scalar, None, None).unwrap();
                let finite = run.iter().all(|s| s.motor_angle_rad.is_finite());
                assert!(finite && run.len() == loaded.log.len(), "{} {scalar:?}", path.display());
            }
        }
    }
}
