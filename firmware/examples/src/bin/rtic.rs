//! The observer in an RTIC program: a control task at 20 kHz, and a task below it that sends frames.
//!
//! On an STM32F405, with frames at USART1's TX (PA9, 2 Mbaud) for `joint monitor`. A joint stands in
//! for converter and encoder, so that a bare board will do, and QEMU's netduinoplus2; where
//! `StandIn::read` is called, a drive reads its own. On a drive PA9 mostly belongs to the output
//! stage: take another port there.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[rtic::app(device = stm32_metapac, peripherals = false, dispatchers = [EXTI0])]
mod app {
    #![allow(missing_docs)]

    use heapless::spsc::{Consumer, Producer, Queue};
    use joint_core::telemetry::{Message, Report, frame};
    use joint_examples::REPORT_EVERY;
    use joint_examples::estimator::{Estimator, HELLO};
    use joint_examples::stand_in::StandIn;

    use crate::board;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        sensors: StandIn,
        estimator: Estimator,
        out: Producer<'static, Report>,
        reports: Consumer<'static, Report>,
    }

    #[init(local = [queue: Queue<Report, 16> = Queue::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (Ok(sensors), Ok(estimator)) = (StandIn::start(), Estimator::start()) else {
            // Only where the parameters were changed by hand.
            loop {
                cortex_m::asm::wfi();
            }
        };
        let (out, reports) = cx.local.queue.split();
        board::start();
        telemetry::spawn().ok();
        (Shared {}, Local { sensors, estimator, out, reports })
    }

    /// Every 50 µs.
    #[task(binds = TIM2, priority = 2, local = [sensors, estimator, out])]
    fn control(cx: control::Context) {
        board::period_began();
        let (current_a, motor_counts) = cx.local.sensors.read();
        let report = cx.local.estimator.period(current_a, motor_counts);
        // Here the control law uses report.estimates.
        if report.tick.is_multiple_of(REPORT_EVERY) {
            // Where there is no room it is dropped, and seen as a gap in the ticks.
            cx.local.out.enqueue(report).ok();
            telemetry::spawn().ok();
        }
    }

    /// Whenever a report waits, below the control task.
    #[task(priority = 1, local = [reports, sequence: u32 = 0])]
    async fn telemetry(cx: telemetry::Context) {
        let telemetry::LocalResources { reports, sequence, .. } = cx.local;
        if *sequence == 0 {
            send(&Message::Hello(HELLO), sequence);
        }
        while let Some(report) = reports.dequeue() {
            send(&Message::Report(report), sequence);
        }
    }

    fn send(message: &Message, sequence: &mut u32) {
        frame::encode(message, *sequence).iter().for_each(|byte| board::send(*byte));
        *sequence = sequence.wrapping_add(1);
    }
}

/// Clock, timer and serial port. A HAL's would do as well, but none starts in QEMU.
#[cfg(target_os = "none")]
mod board {
    use stm32_metapac as pac;

    /// Of TIM2 at a core clock of 168 MHz.
    const TIMER_HZ: u32 = 84_000_000;
    const CONTROL_HZ: u32 = 20_000;
    const BAUD: u32 = 2_000_000;

    /// Starts the control interrupt.
    pub(crate) fn start() {
        clock();
        // GPIOA; TIM2; USART1.
        pac::RCC.ahb1enr().modify(|w| w.0 |= 1);
        pac::RCC.apb1enr().modify(|w| w.0 |= 1);
        pac::RCC.apb2enr().modify(|w| w.0 |= 1 << 4);
        // PA9 to USART1: alternate function 7.
        pac::GPIOA.afr(1).modify(|w| w.0 = w.0 & !0xf0 | 0x70);
        pac::GPIOA.moder().modify(|w| w.0 = w.0 & !(0b11 << 18) | 0b10 << 18);
        pac::USART1.brr().write_value(pac::usart::regs::Brr(TIMER_HZ / BAUD));
        // UE, TE.
        pac::USART1.cr1().write_value(pac::usart::regs::Cr1(1 << 13 | 1 << 3));
        pac::TIM2.arr().write_value(TIMER_HZ / CONTROL_HZ - 1);
        // UIE; CEN.
        pac::TIM2.dier().write_value(pac::timer::regs::DierGp16(1));
        pac::TIM2.cr1().write_value(pac::timer::regs::Cr1Gp16(1));
    }

    /// Takes note of the timer's interrupt.
    pub(crate) fn period_began() {
        pac::TIM2.sr().write_value(pac::timer::regs::SrGp16(0));
    }

    /// Sends a byte, as soon as there is room for it.
    pub(crate) fn send(byte: u8) {
        // TXE.
        wait(|| pac::USART1.sr().read().0 & 1 << 7 != 0);
        pac::USART1.dr().write_value(pac::usart::regs::Dr(u32::from(byte)));
    }

    /// 168 MHz from the internal 16 MHz.
    fn clock() {
        // Five wait states, prefetch, both caches.
        pac::FLASH.acr().write_value(pac::flash::regs::Acr(5 | 1 << 8 | 1 << 9 | 1 << 10));
        // PLL: source HSI, M = 8, N = 168, P = 2, Q = 7.
        pac::RCC.pllcfgr().write_value(pac::rcc::regs::Pllcfgr(8 | 168 << 6 | 7 << 24));
        pac::RCC.cr().modify(|w| w.0 |= 1 << 24);
        wait(|| pac::RCC.cr().read().0 & 1 << 25 != 0);
        // APB1 over four, APB2 over two, then the PLL.
        pac::RCC.cfgr().write_value(pac::rcc::regs::Cfgr(0b101 << 10 | 0b100 << 13 | 0b10));
        wait(|| pac::RCC.cfgr().read().0 & 0b11 << 2 == 0b10 << 2);
    }

    /// Waits for a register, but not for ever.
    fn wait(mut until: impl FnMut() -> bool) {
        for _ in 0..100_000 {
            if until() {
                return;
            }
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("rtic runs on a board: build it for thumbv7em-none-eabihf with its feature");
}
