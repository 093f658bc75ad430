//! The functions of FMI 2.0.4 for co-simulation, under the standard's own names.
//!
//! Pointers are the importing tool's; the standard says what they point to, and what is null is
//! refused. What an FMU of this kind has not (integers, booleans, strings, derivatives of inputs) is
//! an error with a message through the tool's logger.

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::path::PathBuf;
use std::slice;

pub use crate::component::Component;
use crate::joint::{Joint, JointError, guid};

/// The standard's `fmi2Status`.
pub type Status = c_int;
/// The call did what it is for.
pub const OK: Status = 0;
/// There is nothing to tell.
pub const DISCARD: Status = 2;
/// The call was refused; the logger was told why.
pub const ERROR: Status = 3;

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

/// What the tool's `fmi2Component` points to.
pub struct Instance {
    component: Component,
    name: CString,
    logger: Logger,
    environment: *mut c_void,
}

impl Instance {
    fn say(&self, error: &JointError) {
        log(self.logger, self.environment, &self.name, error);
    }

    fn ended(&self, result: Result<(), JointError>) -> Status {
        match result {
            Ok(()) => OK,
            Err(error) => {
                self.say(&error);
                ERROR
            }
        }
    }

    fn has_not(&self, what: &str) -> Status {
        self.say(&JointError(format!("this FMU has {what}")));
        ERROR
    }
}

fn log(logger: Logger, environment: *mut c_void, name: &CStr, error: &JointError) {
    let Some(logger) = logger else { return };
    // The message is a format to the tool.
    let Ok(message) = CString::new(error.0.replace('%', "%%")) else { return };
    // SAFETY: the tool's own logger; the strings end in zero and live over the call.
    unsafe { logger(environment, name.as_ptr(), ERROR, c"error".as_ptr(), message.as_ptr()) };
}

/// # Safety
/// `instance` is null or an instance that was not freed.
unsafe fn instance<'a>(instance: *mut Instance) -> Option<&'a mut Instance> {
    // SAFETY: as stated.
    unsafe { instance.as_mut() }
}

/// # Safety
/// `pointer` is null or to that many values.
unsafe fn list<'a, T>(pointer: *const T, number: usize) -> Option<&'a [T]> {
    if number == 0 {
        return Some(&[]);
    }
    // SAFETY: as stated.
    (!pointer.is_null()).then(|| unsafe { slice::from_raw_parts(pointer, number) })
}

/// The path of the resources: a `file:` URI, percent-encoded.
fn path(uri: &str) -> PathBuf {
    let rest = uri.strip_prefix("file:").unwrap_or(uri);
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

fn loaded(resources: &str, wanted: &CStr) -> Result<Component, JointError> {
    let file = path(resources).join("joint.json");
    let text = std::fs::read_to_string(&file)
        .map_err(|error| JointError(format!("{}: {error}", file.display())))?;
    let own = guid(&text);
    if wanted.to_bytes() != own.as_bytes() {
        let wanted = wanted.to_string_lossy();
        return Err(JointError(format!("the guid {wanted} is not of this FMU, which is {own}")));
    }
    Joint::read(&text).map(Component::new)
}

/// Why these are unsafe is the standard's: the importing tool answers for its pointers.
macro_rules! functions {
    ($($(#[$doc:meta])* fn $name:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty $body:block)*) => {
        $(
            $(#[$doc])*
            ///
            /// # Safety
            /// The pointers are what FMI 2.0.4 says of this function.
            #[unsafe(no_mangle)]
            #[allow(non_snake_case)]
            pub unsafe extern "C" fn $name($($argument: $type),*) -> $result {
                $(let _ = &$argument;)*
                $body
            }
        )*
    };
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
        let (name, wanted, resources, callbacks) = unsafe {
            let text = |own: *const c_char| (!own.is_null()).then(|| CStr::from_ptr(own));
            (text(name), text(guid), text(resources), callbacks.as_ref())
        };
        let name = name.unwrap_or(c"joint").to_owned();
        let (logger, environment) =
            callbacks.map_or((None, std::ptr::null_mut()), |own| (own.logger, own.environment));
        let made = match resources {
            None => Err(JointError("no place of the resources".to_owned())),
            Some(_) if kind != 1 => Err(JointError("this FMU is for co-simulation".to_owned())),
            Some(place) => loaded(&place.to_string_lossy(), wanted.unwrap_or_default()),
        };
        match made {
            Ok(component) => {
                Box::into_raw(Box::new(Instance { component, name, logger, environment }))
            }
            Err(error) => {
                log(logger, environment, &name, &error);
                std::ptr::null_mut()
            }
        }
    }

    /// The end of an instance.
    fn fmi2FreeInstance(own: *mut Instance) -> () {
        if !own.is_null() {
            // SAFETY: made by `fmi2Instantiate`, and freed once.
            drop(unsafe { Box::from_raw(own) });
        }
    }

    /// When the experiment starts.
    fn fmi2SetupExperiment(
        own: *mut Instance, tolerant: c_int, tolerance: f64, start: f64, ends: c_int, stop: f64,
    ) -> Status {
        // SAFETY: as the standard says.
        let Some(own) = (unsafe { instance(own) }) else { return ERROR };
        let result = own.component.start_at(start);
        own.ended(result)
    }

    /// From here parameters may be set as well as before.
    fn fmi2EnterInitializationMode(own: *mut Instance) -> Status {
        // SAFETY: as the standard says.
        if unsafe { instance(own) }.is_some() { OK } else { ERROR }
    }

    /// Builds the joint of its parameters, at rest.
    fn fmi2ExitInitializationMode(own: *mut Instance) -> Status {
        // SAFETY: as the standard says.
        let Some(own) = (unsafe { instance(own) }) else { return ERROR };
        let result = own.component.initialise();
        own.ended(result)
    }

    /// The end of a simulation.
    fn fmi2Terminate(own: *mut Instance) -> Status {
        // SAFETY: as the standard says.
        if unsafe { instance(own) }.is_some() { OK } else { ERROR }
    }

    /// As instantiated.
    fn fmi2Reset(own: *mut Instance) -> Status {
        // SAFETY: as the standard says.
        let Some(own) = (unsafe { instance(own) }) else { return ERROR };
        own.component.reset();
        OK
    }

    /// Values by reference.
    fn fmi2GetReal(own: *mut Instance, references: *const c_uint, n: usize, values: *mut f64) -> Status {
        // SAFETY: as the standard says: `n` of each.
        let (Some(own), Some(references)) = (unsafe { (instance(own), list(references, n)) }) else {
            return ERROR;
        };
        if values.is_null() && n > 0 {
            return own.has_not("no place for values");
        }
        for (k, reference) in references.iter().enumerate() {
            let Some(value) = own.component.get(*reference as usize) else {
                return own.has_not(&format!("no real variable {reference}"));
            };
            // SAFETY: the place of number `k` of `n`.
            unsafe { values.add(k).write(value) };
        }
        OK
    }

    /// Inputs at any time, parameters until the joint is initialised.
    fn fmi2SetReal(own: *mut Instance, references: *const c_uint, n: usize, values: *const f64) -> Status {
        // SAFETY: as the standard says: `n` of each.
        let (Some(own), Some(references), Some(values)) =
            (unsafe { (instance(own), list(references, n), list(values, n)) })
        else {
            return ERROR;
        };
        for (reference, value) in references.iter().zip(values) {
            if let Err(error) = own.component.set(*reference as usize, *value) {
                own.say(&error);
                return ERROR;
            }
        }
        OK
    }

    /// Advances to the end of the communication step.
    fn fmi2DoStep(own: *mut Instance, time: f64, step: f64, no_return: c_int) -> Status {
        // SAFETY: as the standard says.
        let Some(own) = (unsafe { instance(own) }) else { return ERROR };
        let result = own.component.advance(time, step);
        own.ended(result)
    }

    /// A copy of the instance's state.
    fn fmi2GetFMUstate(own: *mut Instance, state: *mut *mut Component) -> Status {
        // SAFETY: as the standard says; what is there is null or was given here.
        let (Some(own), Some(place)) = (unsafe { (instance(own), state.as_mut()) }) else {
            return ERROR;
        };
        let copy = own.component.clone();
        // SAFETY: null, or a state given here and not freed.
        match unsafe { place.as_mut() } {
            Some(old) => *old = copy,
            None => *place = Box::into_raw(Box::new(copy)),
        }
        OK
    }

    /// Back to a state.
    fn fmi2SetFMUstate(own: *mut Instance, state: *mut Component) -> Status {
        // SAFETY: as the standard says: a state given here and not freed.
        let (Some(own), Some(state)) = (unsafe { (instance(own), state.as_ref()) }) else {
            return ERROR;
        };
        own.component = state.clone();
        OK
    }

    /// How many bytes a state takes.
    fn fmi2SerializedFMUstateSize(own: *mut Instance, state: *mut Component, size: *mut usize) -> Status {
        // SAFETY: as the standard says: a state given here and not freed.
        let (Some(own), Some(state), Some(size)) =
            (unsafe { (instance(own), state.as_ref(), size.as_mut()) })
        else {
            return ERROR;
        };
        let result = state.bytes().map(|bytes| *size = bytes.len());
        own.ended(result)
    }

    /// A state as bytes.
    fn fmi2SerializeFMUstate(own: *mut Instance, state: *mut Component, bytes: *mut u8, size: usize) -> Status {
        // SAFETY: as the standard says: a state given here and not freed.
        let (Some(own), Some(state)) = (unsafe { (instance(own), state.as_ref()) }) else {
            return ERROR;
        };
        let result = state.bytes().and_then(|own| {
            if bytes.is_null() || own.len() > size {
                return Err(JointError(format!("a state takes {} bytes, not {size}", own.len())));
            }
            // SAFETY: room for `size` bytes, of which these are at most as many.
            unsafe { std::ptr::copy_nonoverlapping(own.as_ptr(), bytes, own.len()) };
            Ok(())
        });
        own.ended(result)
    }

    /// A state from its bytes.
    fn fmi2DeSerializeFMUstate(own: *mut Instance, bytes: *const u8, size: usize, state: *mut *mut Component) -> Status {
        // SAFETY: as the standard says: `size` bytes; what is there is null or was given here.
        let (Some(own), Some(bytes), Some(place)) =
            (unsafe { (instance(own), list(bytes, size), state.as_mut()) })
        else {
            return ERROR;
        };
        match own.component.restored(bytes) {
            // SAFETY: null, or a state given here and not freed.
            Ok(made) => match unsafe { place.as_mut() } {
                Some(old) => *old = made,
                None => *place = Box::into_raw(Box::new(made)),
            },
            Err(error) => return own.ended(Err(error)),
        }
        OK
    }

    /// The end of a state.
    fn fmi2FreeFMUstate(own: *mut Instance, state: *mut *mut Component) -> Status {
        // SAFETY: as the standard says.
        let Some(place) = (unsafe { state.as_mut() }) else { return OK };
        if !place.is_null() {
            // SAFETY: given here, and freed once.
            drop(unsafe { Box::from_raw(*place) });
            *place = std::ptr::null_mut();
        }
        OK
    }
}

/// What this FMU says no to.
macro_rules! refused {
    ($($name:ident($($type:ty),*): $what:literal,)*) => {
        $(
            #[doc = concat!("This FMU has ", $what, ".")]
            ///
            /// # Safety
            /// `own` is null or an instance that was not freed.
            #[unsafe(no_mangle)]
            #[allow(non_snake_case)]
            pub unsafe extern "C" fn $name(own: *mut Instance, $(_: $type),*) -> Status {
                // SAFETY: as stated.
                unsafe { instance(own) }.map_or(ERROR, |own| own.has_not($what))
            }
        )*
    };
}

type References = *const c_uint;

refused! {
    fmi2GetInteger(References, usize, *mut c_int): "no integers",
    fmi2SetInteger(References, usize, *const c_int): "no integers",
    fmi2GetBoolean(References, usize, *mut c_int): "no booleans",
    fmi2SetBoolean(References, usize, *const c_int): "no booleans",
    fmi2GetString(References, usize, *mut *const c_char): "no strings",
    fmi2SetString(References, usize, *const *const c_char): "no strings",
    fmi2GetDirectionalDerivative(References, usize, References, usize, *const f64, *mut f64): "no derivatives",
    fmi2SetRealInputDerivatives(References, usize, *const c_int, *const f64): "inputs that are held, without derivatives",
    fmi2GetRealOutputDerivatives(References, usize, *const c_int, *mut f64): "no derivatives",
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
        for uri in ["file:///a%20b/c", "file:/a%20b/c", "file://localhost/a b/c", "/a b/c"] {
            assert_eq!(path(uri), PathBuf::from("/a b/c"), "{uri}");
        }
        assert_eq!(path("/a%2"), PathBuf::from("/a%2"));
    }
}
