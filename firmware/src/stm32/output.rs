//! The output stage: six-step by single switches, off unless asked for again and again.
//!
//! It exists only in firmware built with the feature `output`, and even there nothing moves before a
//! command asks for it. The command must be repeated: a host that has gone away leaves a motor that
//! floats.

use stm32_metapac as pac;

use super::{HALF_PERIOD, chip};
use crate::six_step::{Leg, TABLE};

/// Control periods after which a command that is not repeated is forgotten: 100 ms.
const WATCHDOG: u32 = 2_000;
/// Largest share of the bus voltage: the low-side shunts need their time.
const LARGEST_DUTY: f32 = 0.9;
/// Dead time in timer counts: 0.6 µs.
const DEAD_TIME: u32 = 100;
/// MOE.
const ENABLED: u32 = 1 << 15;
/// OSSR, OSSI: switches that are off are driven off.
const HELD_OFF: u32 = 1 << 11 | 1 << 10;

/// The stage and what was asked of it.
#[derive(Debug)]
pub(super) struct Output {
    asked: f32,
    left: u32,
    pins: bool,
}

impl Output {
    /// Off, its pins untouched.
    pub(super) const fn off() -> Self {
        Self { asked: 0.0, left: 0, pins: false }
    }

    /// Asks for a share of the bus voltage; zero, or no number, lets go.
    pub(super) fn ask(&mut self, duty: f32) {
        let sound = (-1.0..=1.0).contains(&duty);
        self.asked = if sound { duty } else { 0.0 };
        self.left = if self.asked == 0.0 { 0 } else { WATCHDOG };
        if self.left > 0 && !self.pins {
            chip::output_pins();
            self.pins = true;
        }
    }

    /// Sets the six switches for a sector, or lets go; gives the share of the bus voltage that is
    /// put out.
    pub(super) fn drive(&mut self, sector: usize, ready: bool) -> f32 {
        use pac::timer::regs;
        self.left = self.left.saturating_sub(1);
        let Some(legs) = TABLE.get(sector).filter(|_| ready && self.left > 0) else {
            pac::TIM1.bdtr().write(|w| w.0 = DEAD_TIME | HELD_OFF);
            return 0.0;
        };
        let reversed = self.asked < 0.0;
        let share = self.asked.abs();
        let share = if share < LARGEST_DUTY { share } else { LARGEST_DUTY };
        let compare = (share * f32::from(HALF_PERIOD)) as u16;
        // Output modes of the three channels, eight bits each, and their enables, four.
        let (mut modes, mut enables) = (0_u32, 0_u32);
        for (phase, leg) in legs.iter().enumerate() {
            let (mode, enable) = match (leg, reversed) {
                (Leg::Float, _) => (0, 0),
                // PWM mode 1, preloaded, both switches.
                (Leg::Source, false) | (Leg::Sink, true) => (0b110 << 4 | 1 << 3, 0b0101),
                // Forced low: the lower switch conducts.
                (Leg::Sink, false) | (Leg::Source, true) => (0b100 << 4, 0b0101),
            };
            modes |= mode << (8 * phase);
            enables |= enable << (4 * phase);
            pac::TIM1.ccr(phase).write_value(regs::Ccr1ch(u32::from(compare)));
        }
        pac::TIM1.ccmr_output(0).write(|w| w.0 = modes & 0xffff);
        pac::TIM1.ccmr_output(1).write(|w| w.0 = modes >> 16);
        pac::TIM1.ccer().write_value(regs::CcerAdv(enables));
        pac::TIM1.bdtr().write(|w| w.0 = DEAD_TIME | HELD_OFF | ENABLED);
        if reversed { -share } else { share }
    }
}
