//! The FMU as an importing tool calls it, by either version of the standard.

#![allow(dead_code, reason = "a test calls some of it")]

use std::ffi::{CString, c_uint};
use std::fs;
use std::ops::Range;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicU32, Ordering};

use joint_fmu::fmi2::*;
use joint_fmu::fmi3::refused::fmi3GetInt32;
use joint_fmu::fmi3::*;
use joint_fmu::{Component, ERROR, Instance, OK, Status, Version, guid};

/// Both versions.
pub(crate) const VERSIONS: [Version; 2] = [Version::Fmi2, Version::Fmi3];

/// An instance, freed at its end.
pub(crate) struct Importer {
    pub(crate) version: Version,
    pub(crate) own: *mut Instance,
    /// FMI 3.0 is told the start as it enters the initialisation.
    start_s: f64,
}

/// The function of a version, with the same arguments in both.
macro_rules! by {
    ($version:expr, $second:ident, $third:ident $arguments:tt) => {
        match $version {
            // SAFETY: an instance that was not freed, and states that were not; as many values as are told.
            Version::Fmi2 => unsafe { $second $arguments },
            // SAFETY: as above.
            Version::Fmi3 => unsafe { $third $arguments },
        }
    };
}

impl Importer {
    /// Of the file that describes a joint; none where it is refused.
    pub(crate) fn new(version: Version, file: &str) -> Option<Self> {
        Self::wanted(version, file, &guid(file))
    }

    /// The same with any GUID or token.
    pub(crate) fn wanted(version: Version, file: &str, token: &str) -> Option<Self> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let folder =
            std::env::temp_dir().join(format!("joint-fmu-{}-{number}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("joint.json"), file).unwrap();
        let place = CString::new(format!("{}/", folder.to_str()?)).ok()?;
        let (token, name) = (CString::new(token).ok()?, c"own".as_ptr());
        let (token, resources) = (token.as_ptr(), place.as_ptr());
        // SAFETY: the strings end in zero and live over the call.
        let own = unsafe {
            match version {
                Version::Fmi2 => fmi2Instantiate(name, 1, token, resources, null(), 0, 0),
                Version::Fmi3 => fmi3InstantiateCoSimulation(
                    name,
                    token,
                    resources,
                    false,
                    false,
                    false,
                    false,
                    null(),
                    0,
                    null_mut(),
                    None,
                    None,
                ),
            }
        };
        fs::remove_dir_all(&folder).unwrap();
        (!own.is_null()).then_some(Self { version, own, start_s: 0.0 })
    }

    /// When the experiment starts; FMI 3.0 looks at it in [`Importer::start`].
    pub(crate) fn start_at(&mut self, start_s: f64) -> Status {
        self.start_s = start_s;
        match self.version {
            // SAFETY: as in `by`.
            Version::Fmi2 => unsafe { fmi2SetupExperiment(self.own, 0, 0.0, start_s, 0, 0.0) },
            Version::Fmi3 => OK,
        }
    }

    /// Into the initialisation, and out of it if it was entered.
    pub(crate) fn start(&self) -> Status {
        // SAFETY: as in `by`.
        unsafe {
            match self.version {
                Version::Fmi2 => {
                    assert_eq!(fmi2EnterInitializationMode(self.own), OK);
                    fmi2ExitInitializationMode(self.own)
                }
                Version::Fmi3 => {
                    let entered =
                        fmi3EnterInitializationMode(self.own, false, 0.0, self.start_s, false, 0.0);
                    if entered == OK { fmi3ExitInitializationMode(self.own) } else { entered }
                }
            }
        }
    }

    pub(crate) fn reset(&mut self) -> Status {
        self.start_s = 0.0;
        by!(self.version, fmi2Reset, fmi3Reset(self.own))
    }

    pub(crate) fn terminate(&self) -> Status {
        by!(self.version, fmi2Terminate, fmi3Terminate(self.own))
    }

    pub(crate) fn set(&self, reference: c_uint, value: f64) -> Status {
        match self.version {
            // SAFETY: as in `by`.
            Version::Fmi2 => unsafe { fmi2SetReal(self.own, &reference, 1, &value) },
            // SAFETY: as above.
            Version::Fmi3 => unsafe { fmi3SetFloat64(self.own, &reference, 1, &value, 1) },
        }
    }

    /// An integer, which no FMU of this kind has.
    pub(crate) fn integer(&self) -> Status {
        let mut value = 0;
        match self.version {
            // SAFETY: as in `by`.
            Version::Fmi2 => unsafe { fmi2GetInteger(self.own, &0, 1, &mut value) },
            // SAFETY: as above.
            Version::Fmi3 => unsafe { fmi3GetInt32(self.own, &0, 1, &mut value, 1) },
        }
    }

    /// The bits of values.
    pub(crate) fn bits(&self, references: Range<c_uint>) -> Vec<u64> {
        let references: Vec<c_uint> = references.collect();
        let mut values = vec![f64::NAN; references.len()];
        let (from, n, to) = (references.as_ptr(), references.len(), values.as_mut_ptr());
        let answer = match self.version {
            // SAFETY: as in `by`.
            Version::Fmi2 => unsafe { fmi2GetReal(self.own, from, n, to) },
            // SAFETY: as above.
            Version::Fmi3 => unsafe { fmi3GetFloat64(self.own, from, n, to, n) },
        };
        assert_eq!(answer, OK);
        values.into_iter().map(f64::to_bits).collect()
    }

    /// A communication step. FMI 3.0 tells of no event, no end and no early return, and the time it was made to.
    pub(crate) fn step(&self, from_s: f64, step_s: f64) -> Status {
        let Version::Fmi3 = self.version else {
            // SAFETY: as in `by`.
            return unsafe { fmi2DoStep(self.own, from_s, step_s, 0) };
        };
        let (mut event, mut ends, mut early, mut last) = (true, true, true, f64::NAN);
        // SAFETY: as in `by`, and a place for each answer.
        let answer = unsafe {
            fmi3DoStep(
                self.own, from_s, step_s, false, &mut event, &mut ends, &mut early, &mut last,
            )
        };
        assert_eq!([event, ends, early], [false; 3]);
        if answer == OK {
            assert_eq!(last.to_bits(), (from_s + step_s).to_bits());
        }
        answer
    }

    /// A copy of the state, in the place of an earlier one if there is one.
    pub(crate) fn copy(&self, state: &mut *mut Component) -> Status {
        by!(self.version, fmi2GetFMUstate, fmi3GetFMUState(self.own, state))
    }

    /// Back to a state.
    pub(crate) fn go_back(&self, state: *mut Component) -> Status {
        by!(self.version, fmi2SetFMUstate, fmi3SetFMUState(self.own, state))
    }

    pub(crate) fn free(&self, state: &mut *mut Component) {
        assert_eq!(by!(self.version, fmi2FreeFMUstate, fmi3FreeFMUState(self.own, state)), OK);
        assert!(state.is_null());
    }

    /// A state as bytes; none where it is null.
    pub(crate) fn bytes(&self, state: *mut Component) -> Option<Vec<u8>> {
        let (own, mut size) = (self.own, 0);
        let sized = by!(
            self.version,
            fmi2SerializedFMUstateSize,
            fmi3SerializedFMUStateSize(own, state, &mut size)
        );
        if sized != OK {
            return None;
        }
        let mut bytes = vec![0; size];
        let write = |to: *mut u8, size| {
            by!(self.version, fmi2SerializeFMUstate, fmi3SerializeFMUState(own, state, to, size))
        };
        assert_eq!(write(bytes.as_mut_ptr(), size - 1), ERROR);
        assert_eq!(write(bytes.as_mut_ptr(), size), OK);
        Some(bytes)
    }

    /// A state of bytes, in a place that holds null; it stays null where they are refused.
    pub(crate) fn made(&self, bytes: &[u8], state: &mut *mut Component) -> Status {
        let (from, size) = (bytes.as_ptr(), bytes.len());
        let answer = by!(
            self.version,
            fmi2DeSerializeFMUstate,
            fmi3DeserializeFMUState(self.own, from, size, state)
        );
        assert_eq!(answer == OK, !state.is_null());
        answer
    }
}

impl Drop for Importer {
    fn drop(&mut self) {
        by!(self.version, fmi2FreeInstance, fmi3FreeInstance(self.own));
    }
}
