//! The observer for firmware in C.
//!
//! Three calls: give it a parameter block, give it every control period's measurement, read what it
//! estimates. All state stands in memory of the caller's; nothing is allocated, nothing panics (the
//! library links only where that is so), and every refusal has a number.

#![cfg_attr(target_os = "none", no_std)]
#![allow(unsafe_code)]
// The header says in C's terms what pointers must be.
#![allow(clippy::missing_safety_doc)]

use core::mem::MaybeUninit;

use firmware::any_control::AnyControl;
use firmware::block::{Block, BlockError};
use joint_core::observer::Status as Health;
use joint_core::telemetry::{Report, Status};

/// Version of this header: major, minor and patch, a byte each.
pub const JOINT_VERSION: u32 = 0x0000_0100;

/// Eight-byte words of a joint.
pub const JOINT_WORDS: usize = 768;
/// Most gear stages.
pub const JOINT_STAGES: usize = 3;

/// All went well.
pub const JOINT_OK: i32 = 0;
/// A pointer is null or not aligned.
pub const JOINT_POINTER: i32 = -1;
/// The joint was not initialised.
pub const JOINT_NOT_INITIALISED: i32 = -2;
/// There is no parameter block: the memory is erased.
pub const JOINT_BLOCK_EMPTY: i32 = 1;
/// This is no parameter block.
pub const JOINT_BLOCK_MAGIC: i32 = 2;
/// The block is of a version that this library does not know.
pub const JOINT_BLOCK_VERSION: i32 = 3;
/// The block is shorter or longer than it says.
pub const JOINT_BLOCK_LENGTH: i32 = 4;
/// The block's checksum is wrong.
pub const JOINT_BLOCK_CRC: i32 = 5;
/// The block's joint has too many stages.
pub const JOINT_BLOCK_STAGES: i32 = 6;
/// The block's payload cannot be read.
pub const JOINT_BLOCK_PAYLOAD: i32 = 7;
/// The block holds a value that the equations cannot take.
pub const JOINT_BLOCK_INADMISSIBLE: i32 = 8;
/// The block is of an older version and has effects, which that version numbers otherwise: export it anew.
pub const JOINT_BLOCK_EFFECTS: i32 = 10;

/// Bit of `status`: no parameters were accepted: estimates are those of the documented default joint.
pub const JOINT_STATUS_DEFAULTS: u16 = 1 << 0;
/// Bit of `status`: a measurement was no number, or beyond what its sensor can show, and was left out.
pub const JOINT_STATUS_MEASUREMENT: u16 = 1 << 1;
/// Bit of `status`: the motor encoder moved further than the joint can in one period.
pub const JOINT_STATUS_ENCODER_JUMP: u16 = 1 << 2;
/// Bit of `status`: control periods were missed before this one.
pub const JOINT_STATUS_LATE: u16 = 1 << 3;
/// Bit of `status`: the output stage is enabled.
pub const JOINT_STATUS_OUTPUT_ON: u16 = 1 << 4;
/// Bit of `health`: the state is still settling after a start.
pub const JOINT_HEALTH_STARTING: u16 = 1 << 0;
/// Bit of `health`: the load cannot be seen: the joint is held by friction and no sensor is behind it.
pub const JOINT_HEALTH_UNOBSERVABLE: u16 = 1 << 1;
/// Bit of `health`: no rotor angle came with this sample; the model alone went on.
pub const JOINT_HEALTH_COASTING: u16 = 1 << 2;
/// Bit of `health`: a measurement was too far off to be believed, and was left out.
pub const JOINT_HEALTH_GLITCH: u16 = 1 << 3;
/// Bit of `health`: the very same measurements as before while the joint moved: left out.
pub const JOINT_HEALTH_REPEATED: u16 = 1 << 4;
/// Bit of `health`: the current sensor is at its end or silent; the current was left out.
pub const JOINT_HEALTH_NO_CURRENT: u16 = 1 << 5;
/// Bit of `health`: the applied voltage (or current) was not a number; the last one was kept.
pub const JOINT_HEALTH_NO_DRIVE: u16 = 1 << 6;
/// Bit of `health`: the innovations stay larger than the design says: wrong parameters, or a drive that does not put out what it is told.
pub const JOINT_HEALTH_MISMATCH: u16 = 1 << 7;
/// Bit of `health`: an estimate is at the bound it is held to.
pub const JOINT_HEALTH_BOUNDED: u16 = 1 << 8;
/// Bit of `health`: there is no estimate: no rotor angle has come yet, or for too long.
pub const JOINT_HEALTH_LOST: u16 = 1 << 9;

/// A joint: memory for the library, not to be looked into. It may be moved between calls.
#[repr(C)]
#[derive(Debug)]
pub struct Joint {
    memory: [MaybeUninit<u64>; JOINT_WORDS],
}

/// What the drive measured in one control period.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// DC-equivalent voltage on the two conducting phases, V, held until the next sample.
    pub voltage_v: f32,
    /// Motor current, A.
    pub current_a: f32,
    /// Counts of the motor encoder since the start, over all turns.
    pub motor_counts: i32,
    /// Counts of the output encoder since the start; zero where there is none.
    pub output_counts: i32,
    /// Control periods that were missed before this one.
    pub missed: u32,
}

/// What is estimated, and one standard deviation of each.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Estimate {
    /// Control periods since the start.
    pub tick: u32,
    /// What is wrong or special, the bits JOINT_STATUS_...; zero where all is well.
    pub status: u16,
    /// What the observer says of itself, the bits JOINT_HEALTH_...; zero where all is well.
    pub health: u16,
    /// Rotor speed, rad/s.
    pub motor_velocity_rad_per_s: f32,
    /// Friction of all masses, felt at the motor, Nm, positive against positive motion.
    pub total_friction_at_motor_nm: f32,
    /// Angle behind the last stage, rad.
    pub output_angle_rad: f32,
    /// Speed behind the last stage, rad/s.
    pub output_velocity_rad_per_s: f32,
    /// Load torque at the output, Nm, positive against positive motion.
    pub load_torque_nm: f32,
    /// Deflection of each stage's spring at its output, rad; zero where there is no such stage.
    pub windup_rad: [f32; JOINT_STAGES],
    /// Standard deviation of the rotor speed.
    pub motor_velocity_std: f32,
    /// Standard deviation of the friction.
    pub total_friction_std: f32,
    /// Standard deviation of the output angle.
    pub output_angle_std: f32,
    /// Standard deviation of the output speed.
    pub output_velocity_std: f32,
    /// Standard deviation of the load torque.
    pub load_torque_std: f32,
    /// Standard deviation of each deflection.
    pub windup_std: [f32; JOINT_STAGES],
}

/// What stands in a [`Joint`].
struct Own {
    mark: u32,
    control: AnyControl,
    report: Report,
}

/// Tells an initialised joint from other memory.
const MARK: u32 = 0x4a4f_494e;

const _: () = assert!(size_of::<Own>() <= size_of::<Joint>(), "JOINT_WORDS is too small");
const _: () = assert!(JOINT_STAGES == joint_core::telemetry::MAX_STAGES);
/// The header's numbers are those of the code behind it, and of the package.
const _: () = {
    assert!(JOINT_BLOCK_EMPTY == BlockError::Empty.code() as i32);
    assert!(JOINT_BLOCK_MAGIC == BlockError::Magic.code() as i32);
    assert!(JOINT_BLOCK_VERSION == BlockError::Version(0).code() as i32);
    assert!(JOINT_BLOCK_LENGTH == BlockError::Length.code() as i32);
    assert!(JOINT_BLOCK_CRC == BlockError::Crc { stored: 0, found: 0 }.code() as i32);
    assert!(JOINT_BLOCK_STAGES == BlockError::Stages(0).code() as i32);
    assert!(JOINT_BLOCK_PAYLOAD == BlockError::Payload.code() as i32);
    assert!(JOINT_BLOCK_INADMISSIBLE == BlockError::Inadmissible("").code() as i32);
    assert!(JOINT_BLOCK_EFFECTS == BlockError::Effects(0).code() as i32);
    assert!(JOINT_STATUS_DEFAULTS == Status::DEFAULTS.0);
    assert!(JOINT_STATUS_MEASUREMENT == Status::MEASUREMENT.0);
    assert!(JOINT_STATUS_ENCODER_JUMP == Status::ENCODER_JUMP.0);
    assert!(JOINT_STATUS_LATE == Status::LATE.0);
    assert!(JOINT_STATUS_OUTPUT_ON == Status::OUTPUT_ON.0);
    assert!(JOINT_HEALTH_STARTING == Health::STARTING.bits());
    assert!(JOINT_HEALTH_UNOBSERVABLE == Health::UNOBSERVABLE.bits());
    assert!(JOINT_HEALTH_COASTING == Health::COASTING.bits());
    assert!(JOINT_HEALTH_GLITCH == Health::GLITCH.bits());
    assert!(JOINT_HEALTH_REPEATED == Health::REPEATED.bits());
    assert!(JOINT_HEALTH_NO_CURRENT == Health::NO_CURRENT.bits());
    assert!(JOINT_HEALTH_NO_DRIVE == Health::NO_DRIVE.bits());
    assert!(JOINT_HEALTH_MISMATCH == Health::MISMATCH.bits());
    assert!(JOINT_HEALTH_BOUNDED == Health::BOUNDED.bits());
    assert!(JOINT_HEALTH_LOST == Health::LOST.bits());
    assert!(JOINT_VERSION == number(env!("CARGO_PKG_VERSION").as_bytes()));
};

/// A version as one number, a byte for each of its three parts.
const fn number(version: &[u8]) -> u32 {
    let (mut all, mut part, mut k) = (0, 0, 0);
    while k < version.len() {
        match version[k] {
            // What marks a build of its own is no number.
            b'-' | b'+' => break,
            b'.' => (all, part) = ((all + part) << 8, 0),
            digit => part = part * 10 + (digit - b'0') as u32,
        }
        k += 1;
    }
    all + part
}

const _: () = assert!(align_of::<Own>() <= align_of::<Joint>());

/// Version of the library: equal to JOINT_VERSION where header and library belong together.
#[unsafe(no_mangle)]
pub extern "C" fn joint_version() -> u32 {
    JOINT_VERSION
}

/// Prepares a joint from a parameter block, as "joint export --format block" writes it; what follows
/// the block in memory is not looked at. The joint is at rest. Returns JOINT_OK or why the block is
/// refused, and then the joint is not initialised.
///
/// joint points to a joint_t of the caller's, block to length readable bytes; a null pointer is
/// refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn joint_init(joint: *mut Joint, block: *const u8, length: usize) -> i32 {
    let own = joint.cast::<Own>();
    if own.is_null() || !own.is_aligned() || block.is_null() {
        return JOINT_POINTER;
    }
    // SAFETY: the caller's bytes, as stated above.
    let bytes = unsafe { core::slice::from_raw_parts(block, length) };
    // SAFETY: the caller's joint_t, which has the room and is aligned; nothing there is dropped, and
    // what it held before need not be a value.
    let own = unsafe {
        own.write(Own { mark: 0, control: AnyControl::NotStarted, report: Report::default() });
        &mut *own
    };
    let read = Block::in_page(bytes).and_then(|block| own.control.read(&block, Status::default()));
    match read {
        Ok(()) => {
            own.mark = MARK;
            JOINT_OK
        }
        Err(why) => i32::from(why.code()),
    }
}

/// Advances the joint by one control period. Never blocks, and costs the same whatever the data.
/// Returns JOINT_OK, or why nothing was done.
///
/// joint points to a joint_t that was given to joint_init or is all zeros, sample to a sample; a
/// null pointer is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn joint_update(joint: *mut Joint, sample: *const Sample) -> i32 {
    let own = joint.cast::<Own>();
    if own.is_null() || !own.is_aligned() || sample.is_null() || !sample.is_aligned() {
        return JOINT_POINTER;
    }
    // SAFETY: zeros and what `joint_init` wrote are both an `Own`; nobody else holds it during the
    // call. The sample is the caller's.
    let (own, sample) = unsafe { (&mut *own, &*sample) };
    if own.mark != MARK {
        return JOINT_NOT_INITIALISED;
    }
    let measured = joint_core::telemetry::Sample {
        voltage_v: sample.voltage_v,
        current_a: sample.current_a,
        motor_counts: sample.motor_counts,
        output_counts: sample.output_counts,
    };
    own.report = own.control.tick(measured, sample.missed);
    JOINT_OK
}

/// Reads what the last update left. Returns JOINT_OK, or why nothing was read.
///
/// joint is as for joint_update, estimate points to a place for an estimate; a null pointer is
/// refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn joint_estimate(joint: *const Joint, estimate: *mut Estimate) -> i32 {
    let own = joint.cast::<Own>();
    if own.is_null() || !own.is_aligned() || estimate.is_null() || !estimate.is_aligned() {
        return JOINT_POINTER;
    }
    // SAFETY: as in `joint_update`, and nothing is changed.
    let own = unsafe { &*own };
    if own.mark != MARK {
        return JOINT_NOT_INITIALISED;
    }
    let Report { tick, status, health, estimates, deviations, .. } = &own.report;
    let read = Estimate {
        tick: *tick,
        status: status.0,
        health: *health,
        motor_velocity_rad_per_s: estimates.motor_velocity_rad_per_s,
        total_friction_at_motor_nm: estimates.total_friction_at_motor_nm,
        output_angle_rad: estimates.output_angle_rad,
        output_velocity_rad_per_s: estimates.output_velocity_rad_per_s,
        load_torque_nm: estimates.load_torque_nm,
        windup_rad: estimates.windup_rad,
        motor_velocity_std: deviations.motor_velocity_rad_per_s,
        total_friction_std: deviations.total_friction_at_motor_nm,
        output_angle_std: deviations.output_angle_rad,
        output_velocity_std: deviations.output_velocity_rad_per_s,
        load_torque_std: deviations.load_torque_nm,
        windup_std: deviations.windup_rad,
    };
    // SAFETY: the caller's place, aligned; nothing there is dropped.
    unsafe { estimate.write(read) };
    JOINT_OK
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // Never defined: what links this library has none that can be reached.
    unsafe extern "C" {
        safe fn a_panic_can_be_reached() -> !;
    }
    a_panic_can_be_reached()
}
