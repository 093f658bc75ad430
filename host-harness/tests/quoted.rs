//! What README and docs quote is there: every relative link, every verb and flag of `joint`, and what README's first
//! commands print.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use host_harness::cli;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every page, by its path from the root.
fn pages() -> Vec<(PathBuf, String)> {
    let mut paths: Vec<PathBuf> =
        ["README.md", "CONTRIBUTING.md", "host-harness/python/README.md"].map(PathBuf::from).into();
    for entry in std::fs::read_dir(root().join("docs")).unwrap() {
        let name = entry.unwrap().file_name();
        if Path::new(&name).extension().is_some_and(|extension| extension == "md") {
            paths.push(Path::new("docs").join(name));
        }
    }
    assert!(paths.len() > 15, "{paths:?}");
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(root().join(&path)).unwrap();
        (path, text)
    };
    paths.into_iter().map(read).collect()
}

/// Headings of a page as the links to them are written.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter_map(|line| line.strip_prefix('#'));
    let plain = |heading: &str| -> String {
        let heading = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(plain).collect()
}

#[test]
fn every_relative_link_leads_somewhere() {
    let mut checked = 0;
    for (page, text) in pages() {
        for part in text.split("](").skip(1) {
            let Some((target, _)) = part.split_once(')') else { continue };
            if target.contains("://") {
                continue;
            }
            let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
            let folder = root().join(&page);
            let linked = match path {
                "" => folder,
                path => folder.parent().unwrap().join(path),
            };
            assert!(linked.exists(), "{}: {target} is not there", page.display());
            if !anchor.is_empty() {
                let text = std::fs::read_to_string(&linked).unwrap();
                let known = anchors(&text);
                assert!(known.contains(anchor), "{}: {target}: {known:?}", page.display());
            }
            checked += 1;
        }
    }
    assert!(checked > 50, "{checked}");
}

#[test]
fn every_page_stands_in_the_summary_once() {
    let summary = std::fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    for (page, _) in pages() {
        let name = page.file_name().unwrap().to_str().unwrap();
        if page.starts_with("docs") && name != "SUMMARY.md" {
            assert_eq!(summary.matches(&format!("]({name})")).count(), 1, "{name}");
        }
    }
}

/// Commands of `joint` in a page: in code, from the name to the end of its span or line.
fn commands(text: &str) -> Vec<String> {
    let text = text.replace("\\\n", " ");
    let (mut found, mut fenced) = (Vec::new(), false);
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
            continue;
        }
        let spans: Vec<&str> = match fenced {
            true => vec![line.split(" #").next().unwrap()],
            false => line.split('`').skip(1).step_by(2).collect(),
        };
        for span in spans {
            for start in ["joint ", "host-harness -- "] {
                let begins = span.trim_start().strip_prefix(start);
                let inside = span.split_once(&format!(" {start}")).map(|(_, rest)| rest);
                // What other programs are given is theirs.
                let rest = if start == "joint " { begins } else { inside };
                found.extend(rest.map(|rest| rest.split(" | ").next().unwrap().to_owned()));
            }
        }
    }
    found
}

#[test]
fn every_verb_and_flag_that_is_quoted_exists() {
    let mut program = cli::command();
    program.build();
    let mut checked = BTreeSet::new();
    for (page, text) in pages() {
        for command in commands(&text) {
            let mut words = command.split_whitespace();
            let Some(verb) = words.next().filter(|word| {
                word.chars().all(|c| c.is_ascii_lowercase() || c == '-') && !word.starts_with('-')
            }) else {
                continue;
            };
            let place = format!("{}: joint {command}", page.display());
            let own = program.find_subcommand(verb);
            let own = own.unwrap_or_else(|| panic!("{place}: there is no verb {verb}"));
            for word in words.filter(|word| word.starts_with('-') && word.len() > 1) {
                let word = word.trim_end_matches([',', '.', ';', ')', ':', ']']);
                let name = word.trim_start_matches('-').split('=').next().unwrap();
                let known = own.get_arguments().any(|argument| match word.starts_with("--") {
                    true => argument.get_long() == Some(name),
                    false => argument.get_short() == name.chars().next(),
                });
                let number = name.starts_with(|c: char| c.is_ascii_digit());
                assert!(known || number, "{place}: {verb} has no {word}");
                checked.insert(format!("{verb} {word}"));
            }
        }
    }
    assert!(checked.len() > 40, "{checked:?}");
}

/// Share by which a quoted number may be off: sines have other last bits on another processor.
const ROUNDING: f64 = 0.02;

/// Whether a printed line begins as a quoted one, its numbers alike.
fn begins_as(printed: &str, quoted: &str) -> bool {
    let bare = |word: &str| word.trim_matches(|c: char| "(),;%".contains(c)).to_owned();
    let mut words = printed.split_whitespace().map(bare);
    quoted.split_whitespace().map(bare).all(|wanted| {
        let Some(own) = words.next() else { return false };
        match (own.parse::<f64>(), wanted.parse::<f64>()) {
            (Ok(own), Ok(wanted)) => (own - wanted).abs() <= ROUNDING * wanted.abs(),
            _ => own == wanted,
        }
    })
}

#[test]
fn the_first_commands_print_what_the_readme_says() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let (_, section) = readme.split_once("## Two commands").unwrap();
    let (section, _) = section.split_once("Without an installation").unwrap();
    let blocks: Vec<&str> = section.split("```").skip(1).step_by(2).collect();
    let [run, told, check, noted] = blocks[..] else { panic!("{} blocks", blocks.len()) };
    let folder = tempfile::tempdir().unwrap();
    for (command, wanted) in [(run, told), (check, noted)] {
        let command = commands(&format!("```{command}```")).remove(0);
        let output = Command::new(env!("CARGO_BIN_EXE_joint"))
            .args(command.split_whitespace())
            .current_dir(folder.path())
            .output()
            .unwrap();
        let printed = [output.stdout, output.stderr].concat();
        let printed = String::from_utf8(printed).unwrap();
        let wanted = wanted.lines().map(str::trim).filter(|line| !line.is_empty());
        for line in wanted {
            assert!(printed.lines().any(|own| begins_as(own, line)), "{line}\nnot in\n{printed}");
        }
    }
    assert!(!begins_as("gap: 3.221 before", "gap: 4.221 before"));
    assert!(!begins_as("gap: 3.221 before", "gap: 3.221 after"));
}
