//! An FMU that is loaded and called as an importing tool does, by the version of FMI that it is of.

#![allow(unsafe_code)]

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};

use libloading::{Library, Symbol};

/// An FMU, unpacked and loaded.
pub(crate) struct Fmu {
    library: Library,
    description: String,
    is_third: bool,
    _folder: tempfile::TempDir,
    own: *mut c_void,
}

pub(crate) type Own = *mut c_void;
type Text = *const c_char;
type Make2 = unsafe extern "C" fn(Text, c_int, Text, Text, *const c_void, c_int, c_int) -> Own;
type Make3 = unsafe extern "C" fn(
    Text,
    Text,
    Text,
    bool,
    bool,
    bool,
    bool,
    *const c_uint,
    usize,
    *mut c_void,
    *const c_void,
    *const c_void,
) -> Own;
type Of = unsafe extern "C" fn(Own) -> c_int;

impl Fmu {
    pub(crate) fn load(path: &Path) -> Self {
        let folder = tempfile::tempdir().unwrap();
        // A name that needs encoding in a URI.
        let place = folder.path().join("an fmu");
        zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap().extract(&place).unwrap();
        let description = std::fs::read_to_string(place.join("modelDescription.xml")).unwrap();
        let is_third = description.contains("fmiVersion=\"3.0\"");
        let (platform, token) = match is_third {
            true => ("x86_64-linux", "instantiationToken"),
            false => ("linux64", "guid"),
        };
        let library = place.join("binaries").join(platform).join("two_stages.so");
        // SAFETY: the FMU's library, whose start runs no code of its own.
        let library = unsafe { Library::new(library) }.unwrap();
        let resources = format!("{}/", place.join("resources").display());
        let uri = format!("file://{resources}").replace(' ', "%20");
        let token = description.split(&format!("{token}=\"")).nth(1).unwrap();
        let token = CString::new(token.split('"').next().unwrap()).unwrap();
        let [name, resources, uri] =
            ["own", &resources, &uri].map(|text| CString::new(text).unwrap());
        // SAFETY: the functions of these names have these types by FMI 2.0 and 3.0.
        let made = |token: &CString| unsafe {
            let (name, token) = (name.as_ptr(), token.as_ptr());
            if is_third {
                let make = library.get::<Make3>(b"fmi3InstantiateCoSimulation").unwrap();
                let (place, flags) = (resources.as_ptr(), [false; 4]);
                let [visible, logs, events, early] = flags;
                let none = (null(), 0, null_mut(), null(), null());
                make(
                    name, token, place, visible, logs, events, early, none.0, none.1, none.2,
                    none.3, none.4,
                )
            } else {
                let make = library.get::<Make2>(b"fmi2Instantiate").unwrap();
                make(name, 1, token, uri.as_ptr(), null(), 0, 0)
            }
        };
        let wrong = CString::new("{joint-of-somebody-else}").unwrap();
        assert!(made(&wrong).is_null(), "a wrong token is accepted");
        let own = made(&token);
        assert!(!own.is_null(), "the FMU is not instantiated");
        Self { library, description, is_third, _folder: folder, own }
    }

    pub(crate) fn reference(&self, name: &str) -> c_uint {
        let line = self.description.lines().find(|line| line.contains(&format!("\"{name}\"")));
        let rest = line.unwrap_or_else(|| panic!("no variable {name}"));
        let (_, rest) = rest.split_once("valueReference=\"").unwrap();
        rest.split('"').next().unwrap().parse().unwrap()
    }

    /// The function of this name behind `fmi2` or `fmi3`.
    ///
    /// # Safety
    /// Its type is this one.
    unsafe fn function<T>(&self, name: &str) -> Symbol<'_, T> {
        let name = format!("fmi{}{name}", if self.is_third { 3 } else { 2 });
        // SAFETY: as stated.
        unsafe { self.library.get(name.as_bytes()) }.unwrap()
    }

    /// Calls a function that takes an instance alone.
    pub(crate) fn call(&self, name: &str) -> c_int {
        // SAFETY: as in `load`.
        unsafe { self.function::<Of>(name)(self.own) }
    }

    pub(crate) fn start(&self) {
        type Enter = unsafe extern "C" fn(Own, bool, f64, f64, bool, f64) -> c_int;
        let entered = match self.is_third {
            // SAFETY: as in `load`.
            true => unsafe {
                self.function::<Enter>("EnterInitializationMode")(
                    self.own, false, 0.0, 0.0, false, 0.0,
                )
            },
            false => self.call("EnterInitializationMode"),
        };
        assert_eq!((entered, self.call("ExitInitializationMode")), (0, 0));
    }

    pub(crate) fn set(&self, name: &str, value: f64) -> c_int {
        type Set2 = unsafe extern "C" fn(Own, *const c_uint, usize, *const f64) -> c_int;
        type Set3 = unsafe extern "C" fn(Own, *const c_uint, usize, *const f64, usize) -> c_int;
        let reference = self.reference(name);
        // SAFETY: as in `load`; one reference, one value.
        unsafe {
            match self.is_third {
                true => self.function::<Set3>("SetFloat64")(self.own, &reference, 1, &value, 1),
                false => self.function::<Set2>("SetReal")(self.own, &reference, 1, &value),
            }
        }
    }

    pub(crate) fn get(&self, name: &str) -> f64 {
        type Get2 = unsafe extern "C" fn(Own, *const c_uint, usize, *mut f64) -> c_int;
        type Get3 = unsafe extern "C" fn(Own, *const c_uint, usize, *mut f64, usize) -> c_int;
        let (reference, mut value) = (self.reference(name), f64::NAN);
        // SAFETY: as in `load`; one reference, one place.
        let code = unsafe {
            match self.is_third {
                true => self.function::<Get3>("GetFloat64")(self.own, &reference, 1, &mut value, 1),
                false => self.function::<Get2>("GetReal")(self.own, &reference, 1, &mut value),
            }
        };
        assert_eq!(code, 0, "{name}");
        value
    }

    pub(crate) fn step(&self, time: f64, step: f64) -> c_int {
        type Step2 = unsafe extern "C" fn(Own, f64, f64, c_int) -> c_int;
        type Flag = *mut bool;
        type Step3 = unsafe extern "C" fn(Own, f64, f64, bool, Flag, Flag, Flag, *mut f64) -> c_int;
        let (mut flags, mut last) = ([true; 3], f64::NAN);
        let [event, ends, early] = &mut flags;
        // SAFETY: as in `load`; a place for each answer.
        let code = unsafe {
            match self.is_third {
                true => self.function::<Step3>("DoStep")(
                    self.own, time, step, false, event, ends, early, &mut last,
                ),
                false => return self.function::<Step2>("DoStep")(self.own, time, step, 0),
            }
        };
        assert_eq!(flags, [false; 3]);
        assert!(code != 0 || last == self.get("time"));
        code
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        // SAFETY: as in `load`; freed once.
        unsafe { self.function::<unsafe extern "C" fn(Own)>("FreeInstance")(self.own) };
    }
}
