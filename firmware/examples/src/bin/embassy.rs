//! The observer in an embassy program: in the interrupt of a converter that a timer triggers at
//! 20 kHz; telemetry is a task.
//!
//! It only listens: TIM1 paces the converter, and no pin of an output stage is touched. The board is
//! ST's B-G431B-ESC1 (`embassy-g431`, frames at the virtual serial port of its debugger) or one wired
//! as ODrive v3.6's first motor (`embassy-f405`, frames at PA0, its GPIO1), 2 Mbaud each, for
//! `joint monitor`.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[cfg_attr(feature = "embassy-g431", path = "embassy/g431.rs")]
#[cfg_attr(feature = "embassy-f405", path = "embassy/f405.rs")]
mod board;

#[cfg(target_os = "none")]
mod app {
    use core::cell::RefCell;

    use embassy_executor::Spawner;
    use embassy_stm32::adc::InjectedAdc;
    use embassy_stm32::interrupt::{InterruptExt, Priority};
    use embassy_stm32::mode::Async;
    use embassy_stm32::peripherals::{ADC1, TIM1};
    use embassy_stm32::time::Hertz;
    use embassy_stm32::timer::low_level::{MasterMode, RoundTo, Timer};
    use embassy_stm32::timer::qei::Qei;
    use embassy_stm32::usart::UartTx;
    use embassy_stm32::{Peri, interrupt};
    use embassy_sync::blocking_mutex::Mutex;
    use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
    use embassy_sync::channel::Channel;
    use joint_core::telemetry::{Message, Report, frame};
    use joint_examples::REPORT_EVERY;
    use joint_examples::estimator::{Estimator, HELLO};

    use crate::board::{self, AMPERES_PER_COUNT, EncoderTimer};

    /// What the program takes of a board.
    pub(crate) struct Parts {
        pub(crate) converter: InjectedAdc<'static, ADC1, 2>,
        pub(crate) encoder: Qei<'static, EncoderTimer>,
        pub(crate) tim1: Peri<'static, TIM1>,
        pub(crate) port: UartTx<'static, Async>,
    }

    /// Periods over which the zero of the current sensors is taken at the start.
    const ZERO_PERIODS: u32 = 4_096;

    /// What the interrupt owns.
    struct Control {
        converter: InjectedAdc<'static, ADC1, 2>,
        encoder: Qei<'static, EncoderTimer>,
        pace: Timer<'static, TIM1>,
        estimator: Estimator,
        zero: [u32; 2],
        zeroed: u32,
        seen: u16,
        counts: i32,
    }

    static CONTROL: Mutex<CriticalSectionRawMutex, RefCell<Option<Control>>> =
        Mutex::new(RefCell::new(None));
    static REPORTS: Channel<CriticalSectionRawMutex, Report, 8> = Channel::new();

    impl Control {
        fn period(&mut self) -> Report {
            let raw = self.converter.read_injected_samples();
            let now = self.encoder.count();
            let moved = now.wrapping_sub(self.seen).cast_signed();
            self.seen = now;
            self.counts = self.counts.wrapping_add(i32::from(moved));
            let current_a = self.current(raw);
            self.estimator.period(current_a, self.counts)
        }

        /// DC-equivalent current while the first phase sources and the second sinks; which pair
        /// conducts is your commutation's to know.
        fn current(&mut self, raw: [u16; 2]) -> f32 {
            if self.zeroed < ZERO_PERIODS {
                self.zero.iter_mut().zip(raw).for_each(|(zero, raw)| *zero += u32::from(raw));
                self.zeroed += 1;
                return 0.0;
            }
            let zero = self.zero.map(|sum| sum as f32 / ZERO_PERIODS as f32);
            let [first, second] = raw.map(f32::from);
            0.5 * AMPERES_PER_COUNT * ((first - zero[0]) - (second - zero[1]))
        }
    }

    /// Every 50 µs, when the converter is done.
    fn control() {
        CONTROL.lock(|control| {
            let mut control = control.borrow_mut();
            let Some(control) = control.as_mut() else { return };
            let report = control.period();
            // Here the control law uses report.estimates.
            if report.tick.is_multiple_of(REPORT_EVERY) {
                // Where there is no room it is dropped, and seen as a gap in the ticks.
                REPORTS.try_send(report).ok();
            }
        });
    }

    #[cfg(feature = "embassy-g431")]
    #[interrupt]
    fn ADC1_2() {
        control();
    }

    #[cfg(feature = "embassy-f405")]
    #[interrupt]
    fn ADC() {
        control();
    }

    #[embassy_executor::task]
    async fn telemetry(mut port: UartTx<'static, Async>) {
        let mut sequence = 0_u32;
        let mut message = Message::Hello(HELLO);
        loop {
            // A frame that the port refuses is seen as a gap in the sequence.
            port.write(&frame::encode(&message, sequence)).await.ok();
            sequence = sequence.wrapping_add(1);
            message = Message::Report(REPORTS.receive().await);
        }
    }

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        let Parts { converter, encoder, tim1, port } = board::start();
        let pace = Timer::new(tim1);
        pace.set_frequency(Hertz::hz(20_000), RoundTo::Slower);
        pace.set_master_mode(MasterMode::UPDATE);
        let Ok(estimator) = Estimator::start() else { return };
        let control = Control {
            seen: encoder.count(),
            converter,
            encoder,
            estimator,
            zero: [0; 2],
            zeroed: 0,
            counts: 0,
            pace,
        };
        if let Ok(task) = telemetry(port) {
            spawner.spawn(task);
        }
        CONTROL.lock(|place| {
            let mut place = place.borrow_mut();
            place.insert(control).pace.start();
        });
        board::CONVERTED.set_priority(Priority::P1);
        // SAFETY: what the handler uses is in place, and no critical section is left early by it.
        #[allow(unsafe_code)]
        unsafe {
            board::CONVERTED.enable();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("embassy runs on a board: build it for thumbv7em-none-eabihf with a board's feature");
}
