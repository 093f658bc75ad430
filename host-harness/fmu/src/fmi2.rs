//! The functions of FMI 2.0.4 for co-simulation, under the standard's own names.
//!
//! Pointers are the importing tool's; the standard says what they point to, and what is null is
//! refused. What an FMU of this kind has not (integers, booleans, strings, derivatives of inputs) is
//! an error with a message through the tool's logger.

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::path::PathBuf;

use crate::instance::{DISCARD, ERROR, Log, has, loaded, null, text};

type References = *const c_uint;
type Logger = Option<
    unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...),
>;

/// The standard's `fmi2CallbackFunctions`; only the logger is used.
#[repr(C)]
#[derive(Debug)]
pub struct Callbacks {
    logger: Logger,
    allocate: *const c_void,
    free: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

fn log(callbacks: Option<&Callbacks>, name: CString) -> Log {
    let logger = callbacks.and_then(|own| Some((own.logger?, own.environment)));
    // A message is a format to the tool.
    Log::new('%', move |message| {
        let Some((logger, environment)) = logger else { return };
        let (name, category) = (name.as_ptr(), c"error".as_ptr());
        // SAFETY: the tool's own logger; the strings end in zero and live over the call.
        unsafe { logger(environment, name, ERROR, category, message.as_ptr()) };
    })
}

/// The path of the resources: a `file:` URI, percent-encoded.
fn path(uri: &CStr) -> PathBuf {
    let uri = uri.to_string_lossy();
    let rest = uri.strip_prefix("file:").unwrap_or(&uri);
    let rest = rest.strip_prefix("//localhost").or(rest.strip_prefix("//")).unwrap_or(rest);
    let mut bytes = Vec::with_capacity(rest.len());
    let mut left = rest.bytes();
    while let Some(byte) = left.next() {
        let hex = |digit: u8| char::from(digit).to_digit(16);
        let mut ahead = left.clone();
        match (byte, ahead.next().and_then(hex), ahead.next().and_then(hex)) {
            (b'%', Some(high), Some(low)) => {
                bytes.push((high * 16 + low) as u8);
                left = ahead;
            }
            _ => bytes.push(byte),
        }
    }
    let text = String::from_utf8_lossy(&bytes);
    // On Windows the path follows the slash.
    let text = if cfg!(windows) { text.trim_start_matches('/') } else { &text };
    PathBuf::from(text)
}

shared! {
    fmi2FreeInstance, fmi2Terminate, fmi2Reset,
    fmi2GetFMUstate, fmi2SetFMUstate, fmi2FreeFMUstate,
    fmi2SerializedFMUstateSize, fmi2SerializeFMUstate, fmi2DeSerializeFMUstate,
}

functions! {
    /// The platform's types are the standard's.
    fn fmi2GetTypesPlatform() -> *const c_char { c"default".as_ptr() }

    /// The version of the standard.
    fn fmi2GetVersion() -> *const c_char { c"2.0".as_ptr() }

    /// Nothing but errors is logged.
    fn fmi2SetDebugLogging(own: *mut Instance, on: c_int, n: usize, categories: *const *const c_char) -> Status {
        OK
    }

    /// A new instance, from `joint.json` in the resources; null where that is no joint.
    fn fmi2Instantiate(
        name: *const c_char, kind: c_int, guid: *const c_char, resources: *const c_char,
        callbacks: *const Callbacks, visible: c_int, logging: c_int,
    ) -> *mut Instance {
        // SAFETY: the tool's callbacks and strings, null or as the standard says.
        let (name, guid, resources, callbacks) =
            unsafe { (text(name), text(guid), text(resources), callbacks.as_ref()) };
        let component = match resources {
            None => Err(null("the place of the resources")),
            Some(_) if kind != 1 => Err(has("co-simulation and nothing else")),
            Some(uri) => loaded(&path(uri), guid),
        };
        Instance::made(log(callbacks, name.unwrap_or(c"joint").to_owned()), component)
    }

    /// When the experiment starts.
    fn fmi2SetupExperiment(
        own: *mut Instance, tolerant: c_int, tolerance: f64, start: f64, ends: c_int, stop: f64,
    ) -> Status {
        // SAFETY: as the standard says.
        unsafe { answer(own, |own| own.component.start_at(start)) }
    }

    /// From here parameters may be set as well as before.
    fn fmi2EnterInitializationMode(own: *mut Instance) -> Status {
        // SAFETY: as the standard says.
        unsafe { answer(own, |_| Ok(())) }
    }

    /// Builds the joint of its parameters, at rest.
    fn fmi2ExitInitializationMode(own: *mut Instance) -> Status {
        // SAFETY: as the standard says.
        unsafe { answer(own, |own| own.component.initialise()) }
    }

    /// Values by reference.
    fn fmi2GetReal(own: *mut Instance, references: References, n: usize, values: *mut f64) -> Status {
        // SAFETY: as the standard says: `n` of each.
        unsafe { answer(own, |own| own.get(references, n, values, Component::get)) }
    }

    /// Inputs at any time, parameters until the joint is initialised.
    fn fmi2SetReal(own: *mut Instance, references: References, n: usize, values: *const f64) -> Status {
        // SAFETY: as the standard says: `n` of each.
        unsafe { answer(own, |own| own.set(references, n, values)) }
    }

    /// Advances to the end of the communication step.
    fn fmi2DoStep(own: *mut Instance, time: f64, step: f64, no_return: c_int) -> Status {
        // SAFETY: as the standard says.
        unsafe { answer(own, |own| own.component.advance(time, step)) }
    }
}

without! {
    fmi2GetInteger(*mut c_int): "no integers",
    fmi2SetInteger(*const c_int): "no integers",
    fmi2GetBoolean(*mut c_int): "no booleans",
    fmi2SetBoolean(*const c_int): "no booleans",
    fmi2GetString(*mut *const c_char): "no strings",
    fmi2SetString(*const *const c_char): "no strings",
    fmi2GetDirectionalDerivative(References, usize, *const f64, *mut f64): "no derivatives",
    fmi2SetRealInputDerivatives(*const c_int, *const f64): "inputs that are held, without derivatives",
    fmi2GetRealOutputDerivatives(*const c_int, *mut f64): "no derivatives",
}

refused! {
    fmi2CancelStep(): "no steps that wait",
}

/// Steps never wait, so there is no status of one.
macro_rules! discarded {
    ($($name:ident($type:ty),)*) => {
        $(
            /// Steps never wait: there is nothing to say.
            ///
            /// # Safety
            /// Nothing is looked at.
            #[unsafe(no_mangle)]
            #[allow(non_snake_case)]
            pub unsafe extern "C" fn $name(_: *mut Instance, _: c_int, _: *mut $type) -> Status {
                DISCARD
            }
        )*
    };
}

discarded! {
    fmi2GetStatus(c_int),
    fmi2GetRealStatus(f64),
    fmi2GetIntegerStatus(c_int),
    fmi2GetBooleanStatus(c_int),
    fmi2GetStringStatus(*const c_char),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uri_of_resources_is_a_path_whatever_its_form() {
        for uri in [c"file:///a%20b/c", c"file:/a%20b/c", c"file://localhost/a b/c", c"/a b/c"] {
            assert_eq!(path(uri), PathBuf::from("/a b/c"), "{uri:?}");
        }
        assert_eq!(path(c"/a%2"), PathBuf::from("/a%2"));
    }
}
