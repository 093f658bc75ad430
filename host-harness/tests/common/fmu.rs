//! An FMU that is loaded and called as an importing tool does.

#![allow(unsafe_code)]

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::path::Path;

use libloading::Library;

/// An FMU, unpacked and loaded.
pub(crate) struct Fmu {
    library: Library,
    description: String,
    _folder: tempfile::TempDir,
    own: *mut c_void,
}

pub(crate) type Own = *mut c_void;
type Make = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const c_void,
    c_int,
    c_int,
) -> Own;

impl Fmu {
    pub(crate) fn load(path: &Path) -> Self {
        let folder = tempfile::tempdir().unwrap();
        // A name that needs encoding in a URI.
        let place = folder.path().join("an fmu");
        zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap().extract(&place).unwrap();
        let description = std::fs::read_to_string(place.join("modelDescription.xml")).unwrap();
        let library = place.join("binaries/linux64/two_stages.so");
        // SAFETY: the FMU's library, whose start runs no code of its own.
        let library = unsafe { Library::new(library) }.unwrap();
        let uri = format!("file://{}", place.join("resources").display()).replace(' ', "%20");
        let guid = description.split("guid=\"").nth(1).unwrap().split('"').next().unwrap();
        let (name, guid) = (CString::new("own").unwrap(), CString::new(guid).unwrap());
        let uri = CString::new(uri).unwrap();
        // SAFETY: the function of this name has this type by FMI 2.0.
        let made = |guid: &CString| unsafe {
            let make = library.get::<Make>(b"fmi2Instantiate").unwrap();
            make(name.as_ptr(), 1, guid.as_ptr(), uri.as_ptr(), std::ptr::null(), 0, 0)
        };
        let wrong = CString::new("{joint-of-somebody-else}").unwrap();
        assert!(made(&wrong).is_null(), "a wrong guid is accepted");
        let own = made(&guid);
        assert!(!own.is_null(), "the FMU is not instantiated");
        Self { library, description, _folder: folder, own }
    }

    pub(crate) fn reference(&self, name: &str) -> c_uint {
        let line = self.description.lines().find(|line| line.contains(&format!("\"{name}\"")));
        let rest = line.unwrap_or_else(|| panic!("no variable {name}"));
        let (_, rest) = rest.split_once("valueReference=\"").unwrap();
        rest.split('"').next().unwrap().parse().unwrap()
    }

    pub(crate) fn call(&self, name: &str) -> c_int {
        // SAFETY: as in `load`; these take an instance alone.
        unsafe {
            let f: libloading::Symbol<'_, unsafe extern "C" fn(Own) -> c_int> =
                self.library.get(name.as_bytes()).unwrap();
            f(self.own)
        }
    }

    pub(crate) fn start(&self) {
        assert_eq!(self.call("fmi2EnterInitializationMode"), 0);
        assert_eq!(self.call("fmi2ExitInitializationMode"), 0);
    }

    pub(crate) fn set(&self, name: &str, value: f64) -> c_int {
        type Set = unsafe extern "C" fn(Own, *const c_uint, usize, *const f64) -> c_int;
        let reference = self.reference(name);
        // SAFETY: as in `load`; one reference, one value.
        unsafe { self.library.get::<Set>(b"fmi2SetReal").unwrap()(self.own, &reference, 1, &value) }
    }

    pub(crate) fn get(&self, name: &str) -> f64 {
        type Get = unsafe extern "C" fn(Own, *const c_uint, usize, *mut f64) -> c_int;
        let (reference, mut value) = (self.reference(name), f64::NAN);
        // SAFETY: as in `load`; one reference, one place.
        let code = unsafe {
            self.library.get::<Get>(b"fmi2GetReal").unwrap()(self.own, &reference, 1, &mut value)
        };
        assert_eq!(code, 0, "{name}");
        value
    }

    pub(crate) fn step(&self, time: f64, step: f64) -> c_int {
        type Step = unsafe extern "C" fn(Own, f64, f64, c_int) -> c_int;
        // SAFETY: as in `load`.
        unsafe { self.library.get::<Step>(b"fmi2DoStep").unwrap()(self.own, time, step, 0) }
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        // SAFETY: as in `load`; freed once.
        unsafe {
            self.library.get::<unsafe extern "C" fn(Own)>(b"fmi2FreeInstance").unwrap()(self.own);
        }
    }
}
