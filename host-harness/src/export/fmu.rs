//! The joint as an FMU: the shared library that steps it, its parameters, and their description.

use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use joint_core::joint::Drive;
use joint_fmu::{EffectDescription, Input, Joint, Version, guid, model_description};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::{DriveOptions, ExportError, identifier};
use crate::grid::Grid;
use crate::model::Model;
use crate::plant;

/// The FMU's bytes: a zip archive for co-simulation by this version of FMI, for the computer that this runs on.
///
/// # Errors
/// The joint cannot be stepped, or the shared library is not where it was built.
pub fn fmu(
    model: &Model,
    options: &DriveOptions,
    version: Version,
) -> Result<Vec<u8>, ExportError> {
    // What the FMU would refuse is refused here.
    plant::plant(model, &Grid::new(&[0.0, options.period_s], None), options.drive)
        .map_err(|error| ExportError::Parameter(error.to_string()))?;
    let joint = Joint {
        name: model.name.clone(),
        input: match options.drive {
            Drive::Voltage => Input::Voltage,
            Drive::Current => Input::Current,
        },
        period_s: options.period_s,
        motor: model.motor,
        stage: model.stages.clone(),
        load: model.load,
        effect: model.effects.iter().map(EffectDescription::of).collect(),
    };
    let library = library()?;
    let contents = std::fs::read(&library)
        .map_err(|error| ExportError::Library(format!("{}: {error}", library.display())))?;
    let (text, name) = (joint.text(), identifier(model));
    let description = model_description(&joint, version, &name, &guid(&text));
    let platform = platform(version, OS, ARCH).ok_or_else(|| {
        ExportError::Library(format!("{version} has no folder for {ARCH} and {OS}"))
    })?;
    let binary = format!("binaries/{platform}/{name}{DLL_SUFFIX}");
    archive(&[
        ("modelDescription.xml", description.as_bytes()),
        ("resources/joint.json", text.as_bytes()),
        (&binary, &contents),
    ])
    .map_err(|error| ExportError::Library(error.to_string()))
}

fn archive(files: &[(&str, &[u8])]) -> zip::result::ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().unix_permissions(0o644);
    for (name, contents) in files {
        zip.start_file(*name, options)?;
        zip.write_all(contents)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// The folder that the standard gives a computer's libraries.
fn platform(version: Version, os: &str, arch: &str) -> Option<&'static str> {
    Some(match (version, os, arch) {
        (Version::Fmi2, "linux", "x86_64") => "linux64",
        (Version::Fmi2, "windows", "x86_64") => "win64",
        (Version::Fmi2, "macos", "x86_64") => "darwin64",
        (Version::Fmi3, "linux", "x86_64") => "x86_64-linux",
        (Version::Fmi3, "linux", "aarch64") => "aarch64-linux",
        (Version::Fmi3, "windows", "x86_64") => "x86_64-windows",
        (Version::Fmi3, "windows", "aarch64") => "aarch64-windows",
        (Version::Fmi3, "macos", "x86_64") => "x86_64-darwin",
        (Version::Fmi3, "macos", "aarch64") => "aarch64-darwin",
        _ => return None,
    })
}

/// The shared library, which is built with this program: beside it, among what it depends on, or,
/// where the program was copied or installed, where both were built.
fn library() -> Result<PathBuf, ExportError> {
    let name = format!("{DLL_PREFIX}joint_fmu{DLL_SUFFIX}");
    let program =
        std::env::current_exe().map_err(|error| ExportError::Library(error.to_string()))?;
    let beside = program.parent().unwrap_or(&program);
    let built = Path::new(env!("JOINT_BUILT_IN"));
    [beside, built].into_iter().find_map(|folder| newest(folder, &name)).ok_or_else(|| {
        ExportError::Library(format!(
            "{name} is neither in {} nor in {}, where `joint` was built. In the folder of its source, \
             run:\n  cargo build --release --package joint-fmu\n  cp target/release/{name} {}",
            beside.display(),
            built.display(),
            beside.display(),
        ))
    })
}

/// In the folder, or in what cargo keeps of dependencies there; one of the two may be of an earlier
/// build.
fn newest(folder: &Path, name: &str) -> Option<PathBuf> {
    [folder.join(name), folder.join("deps").join(name)]
        .into_iter()
        .filter(|path| path.is_file())
        .max_by_key(|path| path.metadata().and_then(|file| file.modified()).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_computer_that_fmi_2_has_no_folder_for_has_one_in_fmi_3() {
        let of = |os, arch| [Version::Fmi2, Version::Fmi3].map(|own| platform(own, os, arch));
        assert_eq!(of("linux", "x86_64"), [Some("linux64"), Some("x86_64-linux")]);
        assert_eq!(of("windows", "x86_64"), [Some("win64"), Some("x86_64-windows")]);
        assert_eq!(of("macos", "aarch64"), [None, Some("aarch64-darwin")]);
        assert_eq!(of("linux", "riscv64"), [None, None]);
    }

    #[test]
    fn the_library_is_found_beside_a_program_and_among_dependencies_and_else_not() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(newest(folder.path(), "l.so"), None);
        let deps = folder.path().join("deps");
        std::fs::create_dir(&deps).unwrap();
        std::fs::write(deps.join("l.so"), []).unwrap();
        assert_eq!(newest(folder.path(), "l.so"), Some(deps.join("l.so")));
    }
}
