//! What the observer says of itself.

use core::fmt;

/// Flags beside an estimate; none set means that all is well.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status(u16);

impl Status {
    /// All is well.
    pub const OK: Status = Status(0);
    /// The state is still settling after a start.
    pub const STARTING: Status = Status(1);
    /// The load cannot be seen: the joint is held by friction and no sensor is behind it.
    pub const UNOBSERVABLE: Status = Status(1 << 1);
    /// No rotor angle came with this sample; the model alone went on.
    pub const COASTING: Status = Status(1 << 2);
    /// A measurement was too far off to be believed, and was left out.
    pub const GLITCH: Status = Status(1 << 3);
    /// The very same measurements as before while the joint moved: left out.
    pub const REPEATED: Status = Status(1 << 4);
    /// The current sensor is at its end or silent; the current was left out.
    pub const NO_CURRENT: Status = Status(1 << 5);
    /// The applied voltage (or current) was not a number; the last one was kept.
    pub const NO_DRIVE: Status = Status(1 << 6);
    /// The innovations stay larger than the design says: wrong parameters, or a drive that does
    /// not put out what it is told.
    pub const MISMATCH: Status = Status(1 << 7);
    /// An estimate is at the bound it is held to.
    pub const BOUNDED: Status = Status(1 << 8);
    /// There is no estimate: no rotor angle has come yet, or for too long.
    pub const LOST: Status = Status(1 << 9);

    /// Each flag with its name, the gravest first.
    pub const NAMES: [(Status, &'static str); 10] = [
        (Status::LOST, "lost"),
        (Status::STARTING, "starting"),
        (Status::COASTING, "coasting"),
        (Status::GLITCH, "glitch"),
        (Status::REPEATED, "repeated"),
        (Status::NO_DRIVE, "no-drive"),
        (Status::NO_CURRENT, "no-current"),
        (Status::BOUNDED, "bounded"),
        (Status::MISMATCH, "mismatch"),
        (Status::UNOBSERVABLE, "unobservable"),
    ];

    /// Whether every one of these flags is set.
    #[inline(always)]
    pub const fn has(self, flags: Status) -> bool {
        self.0 & flags.0 == flags.0
    }

    /// Whether any of these flags is set.
    #[inline(always)]
    pub const fn any(self, flags: Status) -> bool {
        self.0 & flags.0 != 0
    }

    /// With these flags set.
    #[inline(always)]
    #[must_use]
    pub const fn with(self, flags: Status) -> Self {
        Self(self.0 | flags.0)
    }

    /// With these flags set where that is so.
    #[inline(always)]
    #[must_use]
    pub const fn with_if(self, so: bool, flags: Status) -> Self {
        if so { self.with(flags) } else { self }
    }

    /// As a number: bit k is the k-th flag.
    pub const fn bits(self) -> u16 {
        self.0
    }
}

/// The names of the flags that are set, joined by `+`; `ok` where none is.
impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Status::OK {
            return f.write_str("ok");
        }
        let mut first = true;
        for (flag, name) in Status::NAMES {
            if self.has(flag) {
                if !first {
                    f.write_str("+")?;
                }
                f.write_str(name)?;
                first = false;
            }
        }
        Ok(())
    }
}
