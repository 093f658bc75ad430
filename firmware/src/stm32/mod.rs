//! The boards: clocks, the timer that paces the control period, sensors, and, where it was built
//! in, the output stage.
//!
//! Registers are written by their bits, each with the name that the reference manual gives it:
//! six-step needs every switch of a half bridge on its own, which no HAL offers, and what is left is
//! little. One timer, TIM1, does it all: its update starts the converter, and its fourth channel
//! raises the control interrupt when the converter is done.

mod log;
#[cfg(feature = "output")]
mod output;

#[cfg(feature = "stm32f405")]
mod f405;
#[cfg(feature = "stm32g431")]
mod g431;
#[cfg(feature = "stm32f405")]
use f405 as chip;
#[cfg(feature = "stm32g431")]
use g431 as chip;

#[cfg(all(feature = "stm32g431", feature = "stm32f405"))]
compile_error!("one board at a time: stm32g431 or stm32f405");

use joint_core::telemetry::{Command, Sample, Status};
use stm32_metapac as pac;

use crate::block::PAGE_BYTES;
use crate::parameters::Sensing;
use crate::six_step;

pub use log::RTT;
#[cfg(feature = "output")]
use output::Output;

/// Control periods a second.
const RATE_HZ: u32 = 20_000;
/// TIM1 counts from a turn of its direction to the other.
const HALF_PERIOD: u16 = (chip::CLOCK_HZ / RATE_HZ / 2) as u16;
/// Periods over which the zero of the current sensors is taken at the start.
const ZERO_PERIODS: u32 = 4_096;

/// What the converter has found, in its own units.
#[derive(Clone, Copy, Debug, Default)]
struct Raw {
    phases: [u16; 3],
    bus: u16,
}

/// A board under way.
#[derive(Debug)]
pub struct Board {
    zero: [u32; 3],
    zeroed: u32,
    encoder: u16,
    counts: i32,
    per_electrical_turn: u32,
    duty: f32,
    #[cfg(feature = "output")]
    output: Output,
}

impl Board {
    /// Starts clocks, timer and sensors. The output stage stays off.
    pub fn start(sensing: &Sensing) -> Self {
        chip::clocks();
        chip::sensors();
        pace();
        Self {
            zero: [0; 3],
            zeroed: 0,
            encoder: chip::encoder(),
            counts: 0,
            per_electrical_turn: sensing.motor_counts_per_turn / sensing.pole_pairs.max(1),
            duty: 0.0,
            #[cfg(feature = "output")]
            output: Output::off(),
        }
    }

    /// Takes note of a control interrupt and gives what was measured before it.
    pub fn sample(&mut self) -> Sample {
        pac::TIM1.sr().write_value(pac::timer::regs::SrAdv(!CC4));
        let raw = chip::read();
        let encoder = chip::encoder();
        let moved = encoder.wrapping_sub(self.encoder).cast_signed();
        self.encoder = encoder;
        self.counts = self.counts.wrapping_add(i32::from(moved));
        let bus_v = f32::from(raw.bus) * chip::VOLTS_PER_COUNT;
        Sample {
            voltage_v: self.duty * bus_v,
            current_a: self.current(raw.phases),
            motor_counts: self.counts,
            output_counts: 0,
        }
    }

    /// DC-equivalent current: what the sourcing phase carries in and the sinking one out.
    fn current(&mut self, phases: [u16; 3]) -> f32 {
        if self.zeroed < ZERO_PERIODS {
            for (zero, phase) in self.zero.iter_mut().zip(phases) {
                *zero += u32::from(phase);
            }
            self.zeroed += 1;
            return 0.0;
        }
        let mut sum = 0.0;
        let legs = six_step::TABLE.get(self.sector()).copied();
        let rows = phases.into_iter().zip(self.zero).zip(legs.unwrap_or([six_step::Leg::Float; 3]));
        for ((phase, zero), leg) in rows {
            let amperes =
                (f32::from(phase) - zero as f32 / ZERO_PERIODS as f32) * chip::AMPERES_PER_COUNT;
            match leg {
                six_step::Leg::Source => sum += amperes,
                six_step::Leg::Sink => sum -= amperes,
                six_step::Leg::Float => {}
            }
        }
        0.5 * sum
    }

    fn sector(&self) -> usize {
        let turn = self.per_electrical_turn.clamp(1, 1 << 24);
        six_step::sector(self.counts.rem_euclid(turn as i32).unsigned_abs(), turn)
    }

    /// The board's own commands; without an output stage there are none.
    #[cfg_attr(not(feature = "output"), expect(unused_variables))]
    pub fn command(&mut self, command: Command) {
        #[cfg(feature = "output")]
        if let Command::Duty(duty) = command {
            self.output.ask(duty);
        }
    }

    /// Puts out what was asked for, if anything was, and says so.
    pub fn drive(&mut self) -> Status {
        #[cfg(feature = "output")]
        {
            let sector = self.sector();
            self.duty = self.output.drive(sector, self.zeroed >= ZERO_PERIODS);
            if self.duty != 0.0 {
                return Status::OUTPUT_ON;
            }
        }
        Status::default()
    }
}

/// TIM1's fourth channel in its interrupt and status registers.
const CC4: u32 = 1 << 4;

/// TIM1 up and down at the control rate.
fn pace() {
    use pac::timer::regs;
    let tim = pac::TIM1;
    tim.arr().write_value(regs::ArrCore(u32::from(HALF_PERIOD)));
    // One update in two turns.
    tim.rcr().write(|w| w.0 = 1);
    // 3 µs behind the turn at the top: the converter is done by then.
    tim.ccr(3).write_value(regs::Ccr1ch(u32::from(
        HALF_PERIOD - (chip::CLOCK_HZ / 1_000_000 * 3) as u16,
    )));
    // MMS: the update is the trigger.
    tim.cr2().write_value(regs::Cr2Adv(0b010 << 4));
    tim.egr().write_value(regs::EgrAdv(1));
    tim.sr().write_value(regs::SrAdv(0));
    tim.dier().write_value(regs::DierAdv(CC4));
    // CMS: both ways, compare flags on the way down. ARPE, CEN.
    tim.cr1().write_value(regs::Cr1Gp16(0b01 << 5 | 1 << 7 | 1));
}

/// A general timer as a counter of both edges of an encoder's A and B.
fn count_encoder(tim: pac::timer::TimGp16) {
    use pac::timer::regs;
    // CC1S and CC2S to their inputs, each filtered over six samples.
    tim.ccmr_input(0).write_value(regs::CcmrInput2ch(1 | 0b0100 << 4 | 1 << 8 | 0b0100 << 12));
    tim.arr().write_value(regs::ArrCore(0xffff));
    // SMS: both edges of both.
    tim.smcr().write_value(regs::SmcrGp16(0b011));
    tim.cr1().write_value(regs::Cr1Gp16(1));
}

/// Waits for a register, but not for ever: a converter that never comes up reads as zero and is
/// flagged, a drive that hangs at its start says nothing.
fn wait(mut until: impl FnMut() -> bool) {
    for _ in 0..1_000_000 {
        if until() {
            return;
        }
    }
}

/// The flash page with the parameters.
#[allow(unsafe_code)]
pub fn parameter_page() -> &'static [u8] {
    unsafe extern "C" {
        /// From `memory.x`.
        static _parameter_page: [u8; PAGE_BYTES];
    }
    // SAFETY: the page is flash that nothing writes while the program runs, and every byte is a
    // value.
    unsafe { &_parameter_page }
}
