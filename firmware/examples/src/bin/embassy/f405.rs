//! STM32F405 as on ODrive v3.6, first motor: shunts of 0.5 mΩ behind the gate driver's amplifiers.

use embassy_stm32::adc::{Adc, AdcChannel, SampleTime};
use embassy_stm32::interrupt::{Interrupt, Priority};
use embassy_stm32::pac::adc::vals::Exten;
use embassy_stm32::peripherals::{DMA1_CH4, TIM3};
use embassy_stm32::timer::qei::{self, Qei};
use embassy_stm32::usart::{self, UartTx};
use embassy_stm32::{Config, bind_interrupts, dma, rcc, triggers};

use crate::app::Parts;

bind_interrupts!(struct Irqs {
    DMA1_STREAM4 => dma::InterruptHandler<DMA1_CH4>;
});

/// The timer that counts the encoder's edges.
pub(crate) type EncoderTimer = TIM3;
/// The converter's interrupt.
pub(crate) const CONVERTED: Interrupt = Interrupt::ADC;
/// 3.3 V over 4096 counts, a gain of 10, 0.5 mΩ.
pub(crate) const AMPERES_PER_COUNT: f32 = 3.3 / 4096.0 / (10.0 * 0.0005);

/// 168 MHz, the converter waiting for TIM1, the encoder counting.
pub(crate) fn start() -> Parts {
    let mut config = Config::default();
    config.rcc.pll_src = rcc::PllSource::HSI;
    config.rcc.pll = Some(rcc::Pll {
        prediv: rcc::PllPreDiv::DIV8,
        mul: rcc::PllMul::MUL168,
        divp: Some(rcc::PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.sys = rcc::Sysclk::PLL1_P;
    config.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    config.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    // Below the converter's.
    config.dma_interrupt_priority = Priority::P6;
    let p = embassy_stm32::init(config);
    let converter = Adc::new(p.ADC1).setup_injected_conversions(
        [(p.PC0.degrade_adc(), SampleTime::CYCLES15), (p.PC1.degrade_adc(), SampleTime::CYCLES15)],
        triggers::TIM1_TRGO,
        Exten::RISING_EDGE,
        true,
    );
    let mut serial = usart::Config::default();
    serial.baudrate = 2_000_000;
    let Ok(port) = UartTx::new(p.UART4, p.PA0, p.DMA1_CH4, Irqs, serial) else {
        unreachable!("42 MHz divides to 2 Mbaud")
    };
    let encoder = Qei::new(p.TIM3, p.PB4, p.PB5, qei::Config::default());
    Parts { converter, encoder, tim1: p.TIM1, port }
}
