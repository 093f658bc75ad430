//! What `./check` packs is complete: each package tells what it is, and stands on nothing outside it but other packages.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use joint_tests::qemu::workspace;
use serde_json::Value;

/// The packages in the order in which `./check` packs them, as cargo describes them.
fn packages() -> Vec<Value> {
    let check = fs::read_to_string(workspace().join("check")).unwrap();
    let (_, names) = check.split_once("packages=(").unwrap();
    let (names, _) = names.split_once(')').unwrap();
    let told = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()))
        .current_dir(workspace())
        .args(["metadata", "--no-deps", "--offline", "--locked", "--format-version", "1"])
        .output()
        .unwrap();
    let told: Value = serde_json::from_slice(&told.stdout).unwrap();
    let all = told["packages"].as_array().unwrap();
    let named = |name| all.iter().find(|package| package["name"] == name);
    names.split_whitespace().map(|name| named(name).expect(name).clone()).collect()
}

fn folder(package: &Value) -> PathBuf {
    Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap().to_owned()
}

#[test]
fn every_package_says_what_it_is_and_carries_its_licences() {
    let root = workspace();
    for package in packages() {
        let name = &package["name"];
        for key in ["description", "license", "rust_version", "readme"] {
            assert!(package[key].as_str().is_some_and(|text| !text.is_empty()), "{name}: no {key}");
        }
        let readme = fs::read_to_string(folder(&package).join("README.md")).unwrap();
        let title = format!("# {}\n", name.as_str().unwrap());
        assert!(readme.starts_with(&title), "{name}: {readme}");
        // Others see it where the links of this repository lead nowhere.
        assert!(!readme.contains("]("), "{name}: {readme}");
        for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
            let own = fs::read_to_string(folder(&package).join(licence)).unwrap();
            assert_eq!(own, fs::read_to_string(root.join(licence)).unwrap(), "{name}");
        }
    }
}

#[test]
fn every_package_comes_after_those_it_needs_and_asks_for_their_versions() {
    let all = packages();
    let mut before = BTreeSet::new();
    let mut asked = 0;
    for package in &all {
        let name = package["name"].as_str().unwrap();
        for needed in package["dependencies"].as_array().unwrap() {
            if needed["path"].is_null() || needed["kind"] == "dev" {
                continue;
            }
            let other = needed["name"].as_str().unwrap();
            assert!(before.contains(other), "{name} needs {other}, which is not packed before");
            let version = all.iter().find(|own| own["name"] == other).unwrap()["version"].as_str();
            let caret = format!("^{}", version.unwrap());
            assert_eq!(needed["req"], caret.as_str(), "{name} needs {other}");
            asked += 1;
        }
        before.insert(name);
    }
    assert!(before.contains("host-harness") && asked >= 10, "{asked} among {before:?}");
}

/// Every Rust file of a package, without the packages in its folder.
fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.join("Cargo.toml").exists() {
            sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

#[test]
fn what_is_compiled_into_a_package_lies_in_it() {
    let mut included = 0;
    for package in packages() {
        let home = folder(&package).canonicalize().unwrap();
        let mut files = Vec::new();
        sources(&home.join("src"), &mut files);
        for file in files {
            let text = fs::read_to_string(&file).unwrap();
            let parts = text.split("include_").skip(1);
            let names = parts.filter_map(|part| {
                let rest = part.strip_prefix("str!(\"").or(part.strip_prefix("bytes!(\""))?;
                Some(rest.split_once('"')?.0)
            });
            for name in names {
                let path = file.parent().unwrap().join(name).canonicalize();
                let path =
                    path.unwrap_or_else(|error| panic!("{}: {name}: {error}", file.display()));
                assert!(path.starts_with(&home), "{}: {name}", file.display());
                let mut above = path.ancestors().skip(1).take_while(|folder| *folder != home);
                assert!(
                    above.all(|own| !own.join("Cargo.toml").exists()),
                    "{}: {name}",
                    file.display()
                );
                included += 1;
            }
        }
    }
    assert!(included > 10, "{included}");
}
