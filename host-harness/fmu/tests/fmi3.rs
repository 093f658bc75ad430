//! What FMI 3.0 has beside FMI 2.0: messages by category, the time as a variable, an end of the experiment that
//! holds, and much that this FMU refuses.

#![allow(unsafe_code, reason = "what is called is C's interface")]

#[path = "../../../tests/fuzz/importer.rs"]
mod importer;
#[path = "../../../tests/fuzz/one_stage.rs"]
mod one_stage;

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};

use importer::Importer;
use joint_fmu::fmi3::refused::*;
use joint_fmu::fmi3::*;
use joint_fmu::{ERROR, Instance, OK, Status, Version, guid};
use one_stage::one_stage;

const PERIOD_S: f64 = 50e-6;
const VOLTAGE: u32 = 0;

fn instance() -> Importer {
    Importer::new(Version::Fmi3, &one_stage(PERIOD_S).text()).unwrap()
}

/// Value reference of the time.
fn time() -> u32 {
    one_stage(PERIOD_S).variables().len() as u32
}

fn enter(own: &Importer, start_s: f64, stop_s: Option<f64>) -> Status {
    let (ends, stop_s) = (stop_s.is_some(), stop_s.unwrap_or(f64::NAN));
    // SAFETY: an instance that was not freed.
    unsafe { fmi3EnterInitializationMode(own.own, false, 0.0, start_s, ends, stop_s) }
}

fn started(start_s: f64, stop_s: Option<f64>) -> Importer {
    let own = instance();
    assert_eq!(enter(&own, start_s, stop_s), OK);
    // SAFETY: as above.
    assert_eq!(unsafe { fmi3ExitInitializationMode(own.own) }, OK);
    own
}

/// Where messages go: category and text of those that tell of an error.
type Messages = Vec<String>;

unsafe extern "C" fn message(
    environment: *mut c_void,
    status: Status,
    category: *const c_char,
    text: *const c_char,
) {
    // SAFETY: the messages of the test, and strings that end in zero.
    let (messages, category, text) = unsafe {
        (&mut *environment.cast::<Messages>(), CStr::from_ptr(category), CStr::from_ptr(text))
    };
    assert_eq!((status, category), (ERROR, c"logStatusError"));
    messages.push(text.to_str().unwrap().to_owned());
}

/// Instantiated with that token in that folder.
fn made(
    token: Option<&CStr>,
    folder: Option<&CStr>,
    [event_mode, intermediate]: [bool; 2],
    messages: &mut Messages,
) -> *mut Instance {
    let pointer = |text: Option<&CStr>| text.map_or(null(), CStr::as_ptr);
    let (place, references) = ((&raw mut *messages).cast(), [VOLTAGE]);
    // SAFETY: the strings end in zero and live over the call, as the messages do.
    unsafe {
        fmi3InstantiateCoSimulation(
            c"own".as_ptr(),
            pointer(token),
            pointer(folder),
            false,
            true,
            event_mode,
            true,
            references.as_ptr(),
            usize::from(intermediate),
            place,
            Some(message),
            None,
        )
    }
}

#[test]
fn what_cannot_be_instantiated_is_null_and_told_why() {
    let folder = std::env::temp_dir().join(format!("joint-fmu-#1-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let text = one_stage(PERIOD_S).text();
    std::fs::write(folder.join("joint.json"), &text).unwrap();
    let token = CString::new(guid(&text)).unwrap();
    let place = CString::new(folder.to_str().unwrap()).unwrap();
    let elsewhere = CString::new(folder.join("no").to_str().unwrap()).unwrap();
    let (token, place, elsewhere) =
        (Some(token.as_c_str()), Some(place.as_c_str()), Some(elsewhere.as_c_str()));
    let plain = [false; 2];
    let mut messages = Messages::new();
    for (token, folder, flags, told) in [
        (token, None, plain, "the path of the resources: a null pointer"),
        // A number sign is doubled: between two of them stands a value reference.
        (token, elsewhere, plain, "joint-fmu-##1-"),
        (None, place, plain, "is the GUID or token of no such FMU; this is {joint-"),
        (Some(c"{joint-of-others}"), place, plain, "{joint-of-others} is the GUID or token of no"),
        (token, place, [true, false], "this FMU has no event mode"),
        (token, place, [false, true], "this FMU has no intermediate variables"),
    ] {
        assert!(made(token, folder, flags, &mut messages).is_null(), "{told}");
        assert!(messages.pop().unwrap().contains(told), "{told}");
    }
    let environment = (&raw mut messages).cast();
    let (log, own): (LogMessage, _) = (Some(message), c"own".as_ptr());
    // SAFETY: as in `made`.
    unsafe {
        assert!(
            fmi3InstantiateModelExchange(own, null(), null(), false, false, environment, log)
                .is_null()
        );
        assert!(
            fmi3InstantiateScheduledExecution(
                own,
                null(),
                null(),
                false,
                false,
                environment,
                log,
                None,
                None,
                None
            )
            .is_null()
        );
    }
    assert_eq!(messages, ["this FMU has no model exchange", "this FMU has no scheduled execution"]);
    messages.clear();

    let own = made(token, place, plain, &mut messages);
    let off = |on, categories: &[*const c_char]| {
        // SAFETY: an instance that was not freed, and as many strings as are told.
        unsafe { fmi3SetDebugLogging(own, on, categories.len(), categories.as_ptr()) }
    };
    // SAFETY: an instance that was not freed.
    unsafe {
        assert_eq!(fmi3EnterStepMode(own), ERROR);
        assert_eq!(off(false, &[c"logStatusError".as_ptr()]), OK);
        assert_eq!(fmi3EnterStepMode(own), ERROR);
        assert_eq!(off(true, &[]), OK);
        assert_eq!(off(true, &[c"logAll".as_ptr()]), ERROR);
        fmi3FreeInstance(own);
    }
    assert_eq!(messages, ["not initialised", "this FMU has no category logAll of messages"]);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_time_is_a_variable_that_steps_alone_set() {
    let own = started(2.0, None);
    let told = || f64::from_bits(own.bits(time()..time() + 1)[0]);
    assert_eq!(told(), 2.0);
    // Part of a step too, though the joint waits for the rest of it.
    for step_s in [PERIOD_S, 0.5 * PERIOD_S, 3.0 * PERIOD_S] {
        let from_s = told();
        assert_eq!(own.step(from_s, step_s), OK);
        assert_eq!(told(), from_s + step_s);
    }
    assert_eq!(own.set(time(), 0.0), ERROR);
    let (before, mut value) = (instance(), 1.0);
    assert_eq!(enter(&before, -3.0, None), OK);
    // SAFETY: an instance that was not freed; one reference, one place.
    unsafe {
        assert_eq!(fmi3GetFloat64(before.own, &time(), 1, &mut value, 1), OK);
        assert_eq!(value, -3.0);
        let unknown = time() + 1;
        assert_eq!(fmi3GetFloat64(before.own, &unknown, 1, &mut value, 1), ERROR);
    }
}

#[test]
fn nothing_is_computed_behind_the_stop_and_a_reset_takes_it_back() {
    let (own, stop_s) = (instance(), 10.0 * PERIOD_S);
    for stop_s in [f64::NAN, 0.5] {
        assert_eq!(enter(&own, 1.0, Some(stop_s)), ERROR, "{stop_s}");
    }
    let mut own = started(0.0, Some(stop_s));
    assert_eq!(own.step(0.0, 11.0 * PERIOD_S), ERROR);
    // Rounding of the tool's clock is none.
    assert_eq!(own.step(0.0, stop_s + 1e-9 * PERIOD_S), OK);
    assert_eq!(own.step(stop_s, PERIOD_S), ERROR);
    assert_eq!([own.start(), own.reset(), own.start()], [ERROR, OK, OK]);
    assert_eq!(own.step(0.0, 11.0 * PERIOD_S), OK);
}

#[test]
fn what_this_fmu_has_not_is_refused_and_none_of_it_is_not() {
    let own = started(0.0, None);
    let references = [VOLTAGE];
    let (mut float, mut integer, mut counts, mut flag) = ([0_f32], [0_i64], [0_u64; 2], [false]);
    let (mut text, mut binary, mut size, mut real) = ([null()], [null()], [0], [0.0]);
    let (mut kind, mut number) = ([0], 0);
    for (n, wanted) in [(1, ERROR), (0, OK)] {
        let (own, from) = (own.own, references.as_ptr());
        // SAFETY: an instance that was not freed, and a place for each value.
        let answers = unsafe {
            [
                fmi3GetFloat32(own, from, n, float.as_mut_ptr(), n),
                fmi3SetInt64(own, from, n, integer.as_mut_ptr(), n),
                fmi3GetBoolean(own, from, n, flag.as_mut_ptr(), n),
                fmi3GetString(own, from, n, text.as_mut_ptr(), n),
                fmi3GetBinary(own, from, n, size.as_mut_ptr(), binary.as_mut_ptr(), n),
                fmi3SetClock(own, from, n, flag.as_ptr()),
                fmi3GetIntervalDecimal(own, from, n, real.as_mut_ptr(), kind.as_mut_ptr()),
                fmi3SetShiftFraction(own, from, n, &counts[0], &counts[1]),
                fmi3GetDirectionalDerivative(own, from, n, from, n, &1.0, n, &mut real[0], n),
                fmi3GetOutputDerivatives(own, from, n, &1, real.as_mut_ptr(), n),
            ]
        };
        assert_eq!(answers, [wanted; 10], "{n}");
    }
    let (own, counts) = (own.own, &mut counts[0]);
    let flags = flag.as_mut_ptr();
    // SAFETY: as above.
    let answers = unsafe {
        [
            fmi3EnterConfigurationMode(own),
            fmi3ExitConfigurationMode(own),
            fmi3EnterEventMode(own),
            fmi3EvaluateDiscreteStates(own),
            fmi3UpdateDiscreteStates(own, flags, flags, flags, flags, flags, &mut real[0]),
            fmi3GetNumberOfVariableDependencies(own, VOLTAGE, &mut number),
            fmi3EnterContinuousTimeMode(own),
            fmi3SetTime(own, 0.0),
            fmi3GetContinuousStates(own, real.as_mut_ptr(), 1),
            fmi3GetNumberOfContinuousStates(own, &mut number),
            fmi3ActivateModelPartition(own, VOLTAGE, 0.0),
            fmi3GetFloat64(own, references.as_ptr(), 1, real.as_mut_ptr(), 2),
            fmi3SetFloat64(own, references.as_ptr(), 1, real.as_ptr(), 0),
        ]
    };
    assert_eq!(answers, [ERROR; 13]);
    assert_eq!((number, *counts, real), (0, 0, [0.0]));
    // SAFETY: as above.
    assert_eq!(unsafe { [fmi3EnterStepMode(own), fmi3Terminate(own)] }, [OK; 2]);
}

#[test]
fn a_pointer_that_leads_nowhere_is_refused() {
    let own = started(0.0, None);
    let (none, mut value, mut state, mut size) = (null_mut(), 0.0, null_mut(), 0);
    let (place, own, mut flag) = (&raw mut value, own.own, true);
    // SAFETY: nothing is read behind a pointer that is null.
    let answers = unsafe {
        [
            fmi3SetDebugLogging(none, false, 0, null()),
            fmi3SetDebugLogging(own, false, 1, null()),
            fmi3SetDebugLogging(own, false, 1, &null()),
            fmi3EnterInitializationMode(none, false, 0.0, 0.0, false, 0.0),
            fmi3ExitInitializationMode(none),
            fmi3EnterStepMode(none),
            fmi3Terminate(none),
            fmi3Reset(none),
            fmi3DoStep(none, 0.0, PERIOD_S, true, &mut flag, &mut flag, &mut flag, place),
            fmi3DoStep(own, 0.0, PERIOD_S, true, null_mut(), &mut flag, &mut flag, place),
            fmi3DoStep(own, 0.0, PERIOD_S, true, &mut flag, null_mut(), &mut flag, place),
            fmi3DoStep(own, 0.0, PERIOD_S, true, &mut flag, &mut flag, null_mut(), place),
            fmi3DoStep(own, 0.0, PERIOD_S, true, &mut flag, &mut flag, &mut flag, null_mut()),
            fmi3GetFloat64(none, &VOLTAGE, 1, place, 1),
            fmi3GetFloat64(own, null(), 1, place, 1),
            fmi3GetFloat64(own, &VOLTAGE, 1, null_mut(), 1),
            fmi3SetFloat64(own, null(), 1, place, 1),
            fmi3SetFloat64(own, &VOLTAGE, 1, null(), 1),
            fmi3GetFMUState(none, &mut state),
            fmi3GetFMUState(own, null_mut()),
            fmi3SetFMUState(own, null_mut()),
            fmi3SerializedFMUStateSize(own, null_mut(), &mut size),
            fmi3SerializeFMUState(own, null_mut(), null_mut(), 0),
            fmi3DeserializeFMUState(own, null(), 8, &mut state),
            fmi3GetString(none, null(), 0, null_mut(), 0),
        ]
    };
    assert_eq!(answers, [ERROR; 25]);
    assert!(flag, "an answer was written by a step that was refused");
    // SAFETY: as above.
    unsafe {
        fmi3FreeInstance(none);
        assert_eq!(fmi3FreeFMUState(own, null_mut()), OK);
        assert_eq!(fmi3GetFMUState(own, &mut state), OK);
        assert_eq!(fmi3SerializedFMUStateSize(own, state, null_mut()), ERROR);
        assert_eq!(fmi3FreeFMUState(own, &mut state), OK);
    }
}
