//! The documents say what the code does.

use std::path::{Path, PathBuf};

use host_harness::import::map_file;
use host_harness::import::signal::Signal;
use host_harness::import::unit::Scaling;
use host_harness::log::{Log, Need};
use host_harness::model::Model;
use host_harness::preflight::CHECKS;
use joint_core::effect::{Kind, ParameterSpec};
use joint_core::params::Location;

const MODEL: &str = include_str!("../../docs/model-format.md");
const EQUATIONS: &str = include_str!("../../docs/model.md");
const LOG: &str = include_str!("../../docs/log-format.md");
const IMPORT: &str = include_str!("../../docs/import.md");

#[test]
fn the_documented_model_is_read() {
    let text = MODEL.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let model = Model::parse(text, Path::new("arm.toml")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((model.stages.len(), model.effects.len()), (1, 1));
}

#[test]
fn every_check_of_the_pre_flight_stands_in_its_table() {
    for check in CHECKS {
        let row = format!("\n| `{}` | ", check.name);
        assert!(LOG.contains(&row), "docs/log-format.md lacks the row of {}", check.name);
    }
}

#[test]
fn every_effect_stands_in_the_table_of_effects() {
    for kind in Kind::ALL {
        let spec = kind.spec();
        let place = |place: &Location| match place {
            Location::Stage(_) => "stageK".to_owned(),
            place => place.to_string(),
        };
        let parameter = |parameter: &ParameterSpec| match parameter.default {
            Some(default) => format!("`{}` (default {default})", parameter.key),
            None => format!("`{}`", parameter.key),
        };
        let places: Vec<_> = spec.locations.iter().map(place).collect();
        let mut parameters: Vec<_> = spec.parameters.iter().map(parameter).collect();
        if let Some(table) = &spec.table {
            parameters.push(format!("`{}` (2 to {} knots)", table.forward, table.most));
            parameters.push(format!("`{}` (as many, default the same)", table.backward));
        }
        let row =
            format!("| `{}` | {} | {} |", spec.kind, places.join(", "), parameters.join(", "));
        assert!(MODEL.contains(&row), "docs/model-format.md lacks the row\n{row}");
    }
}

#[test]
fn every_effect_stands_with_its_equation_in_the_table_of_equations() {
    for kind in Kind::ALL {
        let spec = kind.spec();
        let start = format!("| `{}` |", spec.kind);
        let Some(row) = EQUATIONS.lines().find(|line| line.starts_with(&start)) else {
            panic!("docs/model.md lacks a row for {}", spec.kind)
        };
        let places = row.split('|').nth(2).unwrap_or_default();
        for place in spec.locations {
            let place = match place {
                Location::Stage(_) => "stage".to_owned(),
                place => place.to_string(),
            };
            assert!(places.contains(&place), "docs/model.md, {}: {place}", spec.kind);
        }
        for parameter in spec.parameters {
            let key = format!("`{}`", parameter.key);
            assert!(row.contains(&key), "docs/model.md, {}: {key}", spec.kind);
        }
        for key in spec.table.iter().flat_map(|table| [table.forward, table.backward]) {
            assert!(row.contains(&format!("`{key}`")), "docs/model.md, {}: {key}", spec.kind);
        }
    }
}

#[test]
fn the_documented_error_is_the_one_that_is_shown() {
    let text = "t_s,u_v,motor_angle_rad\n0,0,0\n0.0002,0,0\n0.0002,0,0\n";
    let error = Log::parse(text.as_bytes(), Path::new("arm.csv"), Need::Drive).unwrap_err();
    assert!(LOG.contains(&format!("error: {error}")), "{error}");
}

#[test]
fn the_documented_map_file_is_read() {
    let text = IMPORT.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let (map, settings) =
        map_file::parse(text, Path::new("map.toml")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((map.entries.len(), settings.rate_hz), (1, Some(1000.0)));
}

/// Every unit in the table of units is one, of the signals of its row.
#[test]
fn the_documented_units_are_read() {
    let row = |start: &str| IMPORT.lines().find(|line| line.starts_with(start)).unwrap();
    let rows = [
        ("| time |", vec![Signal::Time]),
        ("| voltage, current |", vec![Signal::Voltage, Signal::Current]),
        ("| angle |", vec![Signal::Motor]),
        ("| torque |", vec![Signal::Load]),
        ("| temperature |", vec![Signal::Temperature]),
    ];
    for (start, signals) in rows {
        for unit in row(start).split('`').skip(1).step_by(2) {
            let unit = unit.replace("/N", "/4096");
            let known = |signal: &Signal| Scaling::parse(signal.quantity(), &unit).is_ok();
            assert!(signals.iter().any(known), "{start} {unit}");
        }
    }
}

/// The pages of `docs/`, by name.
fn pages() -> Vec<(PathBuf, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|end| end == "md"))
        .map(|path| (path.clone(), std::fs::read_to_string(path).unwrap()))
        .collect();
    pages.sort();
    pages
}

/// A page without what stands in backticks.
fn prose(text: &str) -> String {
    let outside = |text: &str, mark: &str| -> String { text.split(mark).step_by(2).collect() };
    outside(&outside(text, "```"), "`")
}

/// Where the links and pictures of a page lead.
fn targets(text: &str) -> Vec<String> {
    let prose = prose(text);
    let ends = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    ends.map(|(target, _)| target.to_owned()).collect()
}

/// What headings are linked by, as GitHub and mdBook make it.
fn anchors(text: &str) -> Vec<String> {
    let outside: String = text.split("```").step_by(2).collect();
    let headings = outside.lines().filter(|line| line.starts_with('#'));
    let anchor = |line: &str| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

#[test]
fn every_link_of_the_pages_leads_somewhere() {
    let mut links = 0;
    for (path, text) in pages() {
        let name = path.display();
        for target in targets(&text).iter().filter(|target| !target.contains("://")) {
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            let other = match file {
                "" => path.clone(),
                file => path.with_file_name(file),
            };
            assert!(other.exists(), "{name}: no file behind {target}");
            if !anchor.is_empty() {
                let known = anchors(&std::fs::read_to_string(&other).unwrap());
                assert!(known.iter().any(|own| own == anchor), "{name}: no heading for {target}");
            }
            links += 1;
        }
    }
    assert!(links > 40, "{links} links");
}

/// A page that the table of contents lacks is not built.
#[test]
fn every_page_stands_once_in_the_table_of_contents() {
    let pages = pages();
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let (contents, others): (Vec<_>, Vec<_>) =
        pages.iter().partition(|(path, _)| name(path) == "SUMMARY.md");
    let mut told = targets(&contents[0].1);
    let mut files: Vec<_> = others.iter().map(|(path, _)| name(path)).collect();
    told.sort();
    files.sort();
    assert_eq!(told, files);
}
