//! The functions of FMI 3.0.2 for co-simulation, under the standard's own names.
//!
//! Pointers are the importing tool's; the standard says what they point to, and what is null is
//! refused. All variables are of type `Float64`. The FMU has no event mode, no early return, no clocks and no
//! intermediate update: what belongs to them is an error with a message through the tool's logger, and so is
//! what belongs to model exchange and scheduled execution ([`refused`]).

pub mod refused;

use std::ffi::{CStr, c_char, c_uint, c_void};
use std::path::Path;

use crate::instance::{ERROR, Log, has, list, loaded, null, text};
use crate::joint::JointError;

/// The one category of messages, as `modelDescription.xml` declares it.
pub(crate) const CATEGORY: &CStr = c"logStatusError";

/// The standard's `fmi3LogMessageCallback`.
pub type LogMessage =
    Option<unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char)>;

/// A callback of the standard that this FMU has no use for, whatever its arguments.
pub type Callback = Option<unsafe extern "C" fn()>;

fn log(message: LogMessage, environment: *mut c_void) -> Log {
    // Value references stand in a message between these.
    Log::new('#', move |text| {
        let Some(message) = message else { return };
        // SAFETY: the tool's own logger; the strings end in zero and live over the call.
        unsafe { message(environment, ERROR, CATEGORY.as_ptr(), text.as_ptr()) };
    })
}

fn scalar(references: usize, values: usize) -> Result<(), JointError> {
    if references == values {
        return Ok(());
    }
    Err(JointError(format!("{values} values for {references} variables, which are scalars")))
}

fn value(component: &Component, reference: usize) -> Option<f64> {
    if reference == component.time_reference() {
        return Some(component.time_s());
    }
    component.get(reference)
}

/// # Safety
/// The strings are null, or end in zero and live over the call.
unsafe fn component(
    token: *const c_char,
    resources: *const c_char,
) -> Result<Component, JointError> {
    // SAFETY: as stated.
    let (token, resources) = unsafe { (text(token), text(resources)) };
    let resources = resources.ok_or_else(|| null("the path of the resources"))?;
    loaded(Path::new(resources.to_string_lossy().as_ref()), token)
}

shared! {
    fmi3FreeInstance, fmi3Terminate, fmi3Reset,
    fmi3GetFMUState, fmi3SetFMUState, fmi3FreeFMUState,
    fmi3SerializedFMUStateSize, fmi3SerializeFMUState, fmi3DeserializeFMUState,
}

functions! {
    /// The version of the standard.
    fn fmi3GetVersion() -> *const c_char { c"3.0".as_ptr() }

    /// Errors are logged until this switches them off.
    fn fmi3SetDebugLogging(
        own: *mut Instance, on: bool, n: usize, categories: *const *const c_char,
    ) -> Status {
        // SAFETY: as the standard says: `n` strings.
        unsafe {
            answer(own, |own| {
                for category in list(categories, n, "the categories")? {
                    let category = text(*category).ok_or_else(|| null("a category"))?;
                    if category != CATEGORY {
                        let category = category.to_string_lossy();
                        return Err(has(&format!("no category {category} of messages")));
                    }
                }
                own.log.is_on = on;
                Ok(())
            })
        }
    }

    /// A new instance, from `joint.json` in the resources; null where that is no joint, and where events or
    /// intermediate values are asked for.
    fn fmi3InstantiateCoSimulation(
        name: *const c_char, token: *const c_char, resources: *const c_char,
        visible: bool, logging: bool, event_mode: bool, early_return: bool,
        intermediate: *const c_uint, n: usize,
        environment: *mut c_void, message: LogMessage, update: Callback,
    ) -> *mut Instance {
        let made = match (event_mode, n) {
            (true, _) => Err(has("no event mode")),
            (_, 1..) => Err(has("no intermediate variables")),
            // SAFETY: the tool's strings, null or as the standard says.
            _ => unsafe { component(token, resources) },
        };
        Instance::made(log(message, environment), made)
    }

    /// Null: this FMU is for co-simulation.
    fn fmi3InstantiateModelExchange(
        name: *const c_char, token: *const c_char, resources: *const c_char,
        visible: bool, logging: bool, environment: *mut c_void, message: LogMessage,
    ) -> *mut Instance {
        Instance::made(log(message, environment), Err(has("no model exchange")))
    }

    /// Null: this FMU is for co-simulation.
    fn fmi3InstantiateScheduledExecution(
        name: *const c_char, token: *const c_char, resources: *const c_char,
        visible: bool, logging: bool, environment: *mut c_void, message: LogMessage,
        clock: Callback, lock: Callback, unlock: Callback,
    ) -> *mut Instance {
        Instance::made(log(message, environment), Err(has("no scheduled execution")))
    }

    /// When the experiment starts, and where it ends; parameters may be set as well as before.
    fn fmi3EnterInitializationMode(
        own: *mut Instance, tolerant: bool, tolerance: f64, start: f64, ends: bool, stop: f64,
    ) -> Status {
        let stop_s = ends.then_some(stop);
        // SAFETY: as the standard says.
        unsafe {
            answer(own, |own| {
                if stop_s.is_some_and(|stop_s| stop_s.is_nan() || stop_s < start) {
                    return Err(JointError(format!("no stop at {stop} s follows a start at {start} s")));
                }
                own.component.start_at(start)?;
                own.stop_s = stop_s;
                Ok(())
            })
        }
    }

    /// Builds the joint of its parameters, at rest; from here it is in step mode.
    fn fmi3ExitInitializationMode(own: *mut Instance) -> Status {
        // SAFETY: as the standard says.
        unsafe {
            answer(own, |own| {
                if own.component.runs() {
                    return Err(JointError("it runs: a reset comes before a new start".to_owned()));
                }
                own.component.initialise()
            })
        }
    }

    /// Nothing to do: without an event mode it is always in step mode, once it is initialised.
    fn fmi3EnterStepMode(own: *mut Instance) -> Status {
        // SAFETY: as the standard says.
        unsafe {
            answer(own, |own| match own.component.runs() {
                true => Ok(()),
                false => Err(JointError("not initialised".to_owned())),
            })
        }
    }

    /// Values by reference; the last reference is the time's.
    fn fmi3GetFloat64(
        own: *mut Instance, references: *const c_uint, n: usize, values: *mut f64, n_values: usize,
    ) -> Status {
        // SAFETY: as the standard says: `n` references, `n_values` places.
        unsafe {
            answer(own, |own| {
                scalar(n, n_values)?;
                own.get(references, n, values, value)
            })
        }
    }

    /// Inputs at any time, parameters until the joint is initialised.
    fn fmi3SetFloat64(
        own: *mut Instance, references: *const c_uint, n: usize, values: *const f64, n_values: usize,
    ) -> Status {
        // SAFETY: as the standard says: `n` references, `n_values` values.
        unsafe {
            answer(own, |own| {
                scalar(n, n_values)?;
                own.set(references, n, values)
            })
        }
    }

    /// Advances to the end of the communication step, without events and without an early return.
    fn fmi3DoStep(
        own: *mut Instance, time: f64, step: f64, no_return: bool,
        event: *mut bool, terminate: *mut bool, early: *mut bool, last: *mut f64,
    ) -> Status {
        // SAFETY: as the standard says: a place for each answer.
        unsafe {
            answer(own, |own| {
                let answers = [event, terminate, early];
                if last.is_null() || answers.iter().any(|place| place.is_null()) {
                    return Err(null("the place of an answer"));
                }
                answers.into_iter().for_each(|place| place.write(false));
                last.write(own.component.time_s());
                let until_s = time + step;
                if let Some(stop_s) = own.stop_s.filter(|stop_s| own.component.exceeds(until_s, *stop_s)) {
                    return Err(JointError(format!("a communication step to {until_s} s, behind the stop at {stop_s} s")));
                }
                own.component.advance(time, step)?;
                last.write(own.component.time_s());
                Ok(())
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::{Input, Joint};
    use joint_core::params::{Load, Motor, Stage};

    #[test]
    fn the_times_reference_follows_those_of_all_variables() {
        let joint = Joint {
            name: "j".to_owned(),
            input: Input::Current,
            period_s: 5e-5,
            motor: Motor::default(),
            stage: vec![Stage::default(); 2],
            load: Load::default(),
            effect: Vec::new(),
        };
        let variables = joint.variables().len();
        let component = Component::new(joint);
        assert_eq!(component.time_reference(), variables);
        assert_eq!(value(&component, variables), Some(0.0));
        assert_eq!(value(&component, variables + 1), None);
    }
}
