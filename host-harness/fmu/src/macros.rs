//! How functions of the standard are declared.

/// Functions under the standard's names. Why they are unsafe is the standard's: the importing tool answers for
/// its pointers.
macro_rules! functions {
    ($($(#[$doc:meta])* fn $name:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty $body:block)*) => {
        $(
            $(#[$doc])*
            ///
            /// # Safety
            /// The pointers are what the standard says of this function.
            #[unsafe(no_mangle)]
            #[allow(non_snake_case)]
            pub unsafe extern "C" fn $name($($argument: $type),*) -> $result {
                $(let _ = &$argument;)*
                $body
            }
        )*
    };
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
            pub unsafe extern "C" fn $name(
                own: *mut $crate::instance::Instance, $(_: $type),*
            ) -> $crate::instance::Status {
                // SAFETY: as stated.
                unsafe { $crate::instance::answer(own, |_| Err($crate::instance::has($what))) }
            }
        )*
    };
}

/// The same of a number of variables, where none of them are nothing to refuse; the types are of what follows
/// their value references and their number.
macro_rules! without {
    ($($name:ident($($type:ty),*): $what:literal,)*) => {
        $(
            #[doc = concat!("This FMU has ", $what, ".")]
            ///
            /// # Safety
            /// `own` is null or an instance that was not freed.
            #[unsafe(no_mangle)]
            #[allow(non_snake_case)]
            pub unsafe extern "C" fn $name(
                own: *mut $crate::instance::Instance,
                _: *const std::ffi::c_uint,
                number: usize,
                $(_: $type),*
            ) -> $crate::instance::Status {
                let none = |_: &mut $crate::instance::Instance| match number {
                    0 => Ok(()),
                    _ => Err($crate::instance::has($what)),
                };
                // SAFETY: as stated.
                unsafe { $crate::instance::answer(own, none) }
            }
        )*
    };
}

/// What is the same in both versions of the standard, under one's names.
macro_rules! shared {
    (
        $free_instance:ident, $terminate:ident, $reset:ident,
        $get_state:ident, $set_state:ident, $free_state:ident,
        $size:ident, $serialize:ident, $deserialize:ident $(,)?
    ) => {
        use $crate::component::Component;
        use $crate::instance::{self, Instance, Status, OK, answer};
        use $crate::state;

        functions! {
            /// The end of an instance.
            fn $free_instance(own: *mut Instance) -> () {
                // SAFETY: as the standard says: made here, and freed once.
                unsafe { instance::free(own) }
            }

            /// The end of a simulation.
            fn $terminate(own: *mut Instance) -> Status {
                // SAFETY: as the standard says.
                unsafe { answer(own, |_| Ok(())) }
            }

            /// As instantiated.
            fn $reset(own: *mut Instance) -> Status {
                // SAFETY: as the standard says.
                unsafe { answer(own, |own| { own.reset(); Ok(()) }) }
            }

            /// A copy of the instance's state.
            fn $get_state(own: *mut Instance, state: *mut *mut Component) -> Status {
                // SAFETY: as the standard says; what is there is null or was given here.
                unsafe { answer(own, |own| state::copy(own, state)) }
            }

            /// Back to a state.
            fn $set_state(own: *mut Instance, state: *mut Component) -> Status {
                // SAFETY: as the standard says: a state given here and not freed.
                unsafe { answer(own, |own| state::set(own, state)) }
            }

            /// The end of a state.
            fn $free_state(own: *mut Instance, state: *mut *mut Component) -> Status {
                // SAFETY: as the standard says: given here, and freed once.
                unsafe { state::free(state) };
                OK
            }

            /// How many bytes a state takes.
            fn $size(own: *mut Instance, state: *mut Component, size: *mut usize) -> Status {
                // SAFETY: as the standard says: a state given here and not freed.
                unsafe { answer(own, |_| state::size(state, size)) }
            }

            /// A state as bytes.
            fn $serialize(own: *mut Instance, state: *mut Component, bytes: *mut u8, size: usize) -> Status {
                // SAFETY: as the standard says: a state given here and not freed, and room for `size` bytes.
                unsafe { answer(own, |_| state::write(state, bytes, size)) }
            }

            /// A state from its bytes.
            fn $deserialize(
                own: *mut Instance, bytes: *const u8, size: usize, state: *mut *mut Component,
            ) -> Status {
                // SAFETY: as the standard says: `size` bytes; what is there is null or was given here.
                unsafe { answer(own, |own| state::read(own, bytes, size, state)) }
            }
        }
    };
}
