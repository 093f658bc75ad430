//! STM32G431CB on ST's B-G431B-ESC1: shunts of 3 mΩ amplified by the chip's own amplifiers.

use cortex_m::singleton;
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, SampleTime};
use embassy_stm32::interrupt::{Interrupt, Priority};
use embassy_stm32::opamp::{OpAmp, OpAmpGain, OpAmpSpeed};
use embassy_stm32::pac::adc::vals::Exten;
use embassy_stm32::peripherals::{DMA1_CH1, OPAMP1, OPAMP3, TIM4};
use embassy_stm32::timer::qei::{self, Qei};
use embassy_stm32::usart::{self, UartTx};
use embassy_stm32::{Config, bind_interrupts, dma, rcc, triggers};

use crate::app::Parts;

bind_interrupts!(struct Irqs {
    DMA1_CHANNEL1 => dma::InterruptHandler<DMA1_CH1>;
});

/// The timer that counts the encoder's edges.
pub(crate) type EncoderTimer = TIM4;
/// The converter's interrupt.
pub(crate) const CONVERTED: Interrupt = Interrupt::ADC1_2;
/// 3.3 V over 4096 counts, a gain of 9.14 with the board's dividers, 3 mΩ.
pub(crate) const AMPERES_PER_COUNT: f32 = 3.3 / 4096.0 / (9.14 * 0.003);

/// 170 MHz, the converter waiting for TIM1, the encoder counting.
pub(crate) fn start() -> Parts {
    let mut config = Config::default();
    config.rcc.pll = Some(rcc::Pll {
        source: rcc::PllSource::HSI,
        prediv: rcc::PllPreDiv::DIV4,
        mul: rcc::PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(rcc::PllRDiv::DIV2),
    });
    config.rcc.sys = rcc::Sysclk::PLL1_R;
    config.rcc.boost = true;
    config.rcc.mux.adc12sel = rcc::mux::Adcsel::SYS;
    // Below the converter's.
    config.bdma_interrupt_priority = Priority::P6;
    let p = embassy_stm32::init(config);
    // They stay with the converter for good.
    let amplifiers = (
        singleton!(: OpAmp<'static, OPAMP1> = OpAmp::new(p.OPAMP1, OpAmpSpeed::HighSpeed)),
        singleton!(: OpAmp<'static, OPAMP3> = OpAmp::new(p.OPAMP3, OpAmpSpeed::HighSpeed)),
    );
    let (Some(first), Some(third)) = amplifiers else { unreachable!("the board starts once") };
    let a = first.pga_biased_ext(p.PA1, p.PA3, p.PA2, OpAmpGain::Mul16);
    let c = third.pga_biased_ext(p.PB0, p.PB2, p.PB1, OpAmpGain::Mul16);
    let converter = Adc::new(p.ADC1, AdcConfig::default()).setup_injected_conversions(
        [(a.degrade_adc(), SampleTime::CYCLES12_5), (c.degrade_adc(), SampleTime::CYCLES12_5)],
        triggers::TIM1_TRGO,
        Exten::RISING_EDGE,
        true,
    );
    let mut serial = usart::Config::default();
    serial.baudrate = 2_000_000;
    let Ok(port) = UartTx::new(p.USART2, p.PB3, p.DMA1_CH1, Irqs, serial) else {
        unreachable!("170 MHz divides to 2 Mbaud")
    };
    let encoder = Qei::new(p.TIM4, p.PB6, p.PB7, qei::Config::default());
    Parts { converter, encoder, tim1: p.TIM1, port }
}
