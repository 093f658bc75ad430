//! States of an instance that the importing tool keeps, as they are or as bytes.

use crate::component::Component;
use crate::instance::{Instance, list, null};
use crate::joint::JointError;

const PLACE: &str = "the place of the state";
const STATE: &str = "the state";

/// # Safety
/// `place` is null, or holds null or a state that was given here and not freed.
unsafe fn put(place: *mut *mut Component, state: Component) -> Result<(), JointError> {
    // SAFETY: as stated.
    let place = unsafe { place.as_mut() }.ok_or_else(|| null(PLACE))?;
    // SAFETY: as stated.
    match unsafe { place.as_mut() } {
        Some(old) => *old = state,
        None => *place = Box::into_raw(Box::new(state)),
    }
    Ok(())
}

/// # Safety
/// As of [`put`].
pub(crate) unsafe fn copy(own: &Instance, place: *mut *mut Component) -> Result<(), JointError> {
    // SAFETY: as stated.
    unsafe { put(place, own.component.clone()) }
}

/// # Safety
/// `state` is null, or was given here and not freed.
pub(crate) unsafe fn set(own: &mut Instance, state: *const Component) -> Result<(), JointError> {
    // SAFETY: as stated.
    own.component = unsafe { state.as_ref() }.ok_or_else(|| null(STATE))?.clone();
    Ok(())
}

/// # Safety
/// As of [`set`]; `size` is null or a place.
pub(crate) unsafe fn size(state: *const Component, size: *mut usize) -> Result<(), JointError> {
    // SAFETY: as stated.
    let bytes = unsafe { state.as_ref() }.ok_or_else(|| null(STATE))?.bytes()?;
    if size.is_null() {
        return Err(null("the place of the size"));
    }
    // SAFETY: as stated.
    unsafe { size.write(bytes.len()) };
    Ok(())
}

/// # Safety
/// As of [`set`]; `bytes` is null or has room for `size` of them.
pub(crate) unsafe fn write(
    state: *const Component,
    bytes: *mut u8,
    size: usize,
) -> Result<(), JointError> {
    // SAFETY: as stated.
    let own = unsafe { state.as_ref() }.ok_or_else(|| null(STATE))?.bytes()?;
    if bytes.is_null() || own.len() > size {
        return Err(JointError(format!("a state takes {} bytes, not {size}", own.len())));
    }
    // SAFETY: room for `size` bytes, of which these are at most as many.
    unsafe { std::ptr::copy_nonoverlapping(own.as_ptr(), bytes, own.len()) };
    Ok(())
}

/// # Safety
/// As of [`put`]; `bytes` is null or points to `size` of them.
pub(crate) unsafe fn read(
    own: &Instance,
    bytes: *const u8,
    size: usize,
    place: *mut *mut Component,
) -> Result<(), JointError> {
    // SAFETY: as stated.
    unsafe { put(place, own.component.restored(list(bytes, size, "the bytes of the state")?)?) }
}

/// # Safety
/// As of [`put`].
pub(crate) unsafe fn free(place: *mut *mut Component) {
    // SAFETY: as stated.
    let Some(place) = (unsafe { place.as_mut() }) else { return };
    if !place.is_null() {
        // SAFETY: as stated; freed once, for what is left is null.
        drop(unsafe { Box::from_raw(*place) });
        *place = std::ptr::null_mut();
    }
}
