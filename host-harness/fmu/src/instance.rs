//! An instance as the importing tool holds it: the joint, and the logger that is told why a call was refused.

use std::ffi::{CStr, CString, c_char, c_int, c_uint};
use std::path::Path;
use std::slice;

use crate::component::Component;
use crate::joint::{Joint, JointError, guid};

/// The standard's `fmi2Status` and `fmi3Status`.
pub type Status = c_int;
/// The call did what it is for.
pub const OK: Status = 0;
/// There is nothing to tell.
pub const DISCARD: Status = 2;
/// The call was refused; the logger was told why.
pub const ERROR: Status = 3;

/// What the tool's `fmi2Component` or `fmi3Instance` points to.
pub struct Instance {
    pub(crate) component: Component,
    pub(crate) log: Log,
    /// The end of the experiment, s, beyond which FMI 3.0 lets nothing be computed.
    pub(crate) stop_s: Option<f64>,
}

/// The importing tool's logger.
pub(crate) struct Log {
    pub(crate) is_on: bool,
    /// What has a meaning in a message and is doubled where it has none.
    escape: char,
    tell: Box<dyn Fn(&CStr)>,
}

impl Log {
    pub(crate) fn new(escape: char, tell: impl Fn(&CStr) + 'static) -> Self {
        Self { is_on: true, escape, tell: Box::new(tell) }
    }

    fn say(&self, error: &JointError) {
        let message = error.0.replace(self.escape, &format!("{0}{0}", self.escape));
        if let (true, Ok(message)) = (self.is_on, CString::new(message)) {
            (self.tell)(&message);
        }
    }
}

impl Instance {
    /// A new instance; null where there is none, with the reason told.
    pub(crate) fn made(log: Log, component: Result<Component, JointError>) -> *mut Self {
        match component {
            Ok(component) => Box::into_raw(Box::new(Self { component, log, stop_s: None })),
            Err(error) => {
                log.say(&error);
                std::ptr::null_mut()
            }
        }
    }

    /// As it was instantiated.
    pub(crate) fn reset(&mut self) {
        self.component.reset();
        self.stop_s = None;
    }

    /// # Safety
    /// Both are null or point to that many.
    pub(crate) unsafe fn get(
        &self,
        references: *const c_uint,
        number: usize,
        values: *mut f64,
        value: impl Fn(&Component, usize) -> Option<f64>,
    ) -> Result<(), JointError> {
        // SAFETY: as stated.
        let references = unsafe { list(references, number, "the value references") }?;
        if values.is_null() && number > 0 {
            return Err(null("the place of the values"));
        }
        for (k, reference) in references.iter().enumerate() {
            let value = value(&self.component, *reference as usize)
                .ok_or_else(|| has(&format!("no real variable {reference}")))?;
            // SAFETY: the place of number `k` of `number`.
            unsafe { values.add(k).write(value) };
        }
        Ok(())
    }

    /// # Safety
    /// Both are null or point to that many.
    pub(crate) unsafe fn set(
        &mut self,
        references: *const c_uint,
        number: usize,
        values: *const f64,
    ) -> Result<(), JointError> {
        // SAFETY: as stated.
        let (references, values) = unsafe {
            (list(references, number, "the value references")?, list(values, number, "the values")?)
        };
        for (reference, value) in references.iter().zip(values) {
            self.component.set(*reference as usize, *value)?;
        }
        Ok(())
    }
}

/// What a call answers; why it was refused is told.
///
/// # Safety
/// `own` is null or an instance that was not freed.
pub(crate) unsafe fn answer(
    own: *mut Instance,
    call: impl FnOnce(&mut Instance) -> Result<(), JointError>,
) -> Status {
    // SAFETY: as stated.
    let Some(own) = (unsafe { own.as_mut() }) else { return ERROR };
    match call(own) {
        Ok(()) => OK,
        Err(error) => {
            own.log.say(&error);
            ERROR
        }
    }
}

/// # Safety
/// `own` is null, or was made here and is freed once.
pub(crate) unsafe fn free(own: *mut Instance) {
    if !own.is_null() {
        // SAFETY: as stated.
        drop(unsafe { Box::from_raw(own) });
    }
}

/// An error that says what this FMU has or has not.
pub(crate) fn has(what: &str) -> JointError {
    JointError(format!("this FMU has {what}"))
}

pub(crate) fn null(what: &str) -> JointError {
    JointError(format!("{what}: a null pointer"))
}

/// # Safety
/// `pointer` is null or to that many values.
pub(crate) unsafe fn list<'a, T>(
    pointer: *const T,
    number: usize,
    what: &str,
) -> Result<&'a [T], JointError> {
    match (number, pointer.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(null(what)),
        // SAFETY: as stated.
        _ => Ok(unsafe { slice::from_raw_parts(pointer, number) }),
    }
}

/// # Safety
/// `pointer` is null or to a string that ends in zero and lives over the call.
pub(crate) unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: as stated.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// The joint in a folder of resources, if the FMU that was unpacked there is the one that is wanted.
pub(crate) fn loaded(resources: &Path, wanted: Option<&CStr>) -> Result<Component, JointError> {
    let file = resources.join("joint.json");
    let text = std::fs::read_to_string(&file)
        .map_err(|error| JointError(format!("{}: {error}", file.display())))?;
    let own = guid(&text);
    let wanted = wanted.unwrap_or_default();
    if wanted.to_bytes() != own.as_bytes() {
        let wanted = wanted.to_string_lossy();
        return Err(JointError(format!(
            "{wanted} is the GUID or token of no such FMU; this is {own}"
        )));
    }
    Joint::read(&text).map(Component::new)
}
