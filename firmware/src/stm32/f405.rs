//! STM32F405 as on ODrive v3.6, first motor.
//!
//! Shunts of 0.5 mΩ in the low sides of B and C behind the DRV8301's gain of 10, at PC0 (IN10) and
//! PC1 (IN11); A is what the two leave. The bus behind a divider of 19 at PA6 (IN6); an encoder's A
//! and B at PB4 and PB5 (TIM3). The gate driver's EN_GATE (PB12) is left alone: it is off, and with
//! it its amplifiers, until firmware with an output stage raises it.

use stm32_metapac as pac;

use super::{Raw, wait};

/// Core and timer clock.
pub(super) const CLOCK_HZ: u32 = 168_000_000;
/// 3.3 V over 4096 counts, a gain of 10, 0.5 mΩ.
pub(super) const AMPERES_PER_COUNT: f32 = 3.3 / 4096.0 / (10.0 * 0.0005);
/// 3.3 V over 4096 counts, the board's divider.
pub(super) const VOLTS_PER_COUNT: f32 = 3.3 / 4096.0 * 19.0;
/// The middle of the converter's range, where the amplifiers rest.
const MIDDLE: u16 = 2048;

/// 168 MHz from the internal 16 MHz.
pub(super) fn clocks() {
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

/// The converter and the encoder's timer.
pub(super) fn sensors() {
    // GPIOA to C; TIM1, ADC1; TIM3.
    pac::RCC.ahb1enr().modify(|w| w.0 |= 0b111);
    pac::RCC.apb2enr().modify(|w| w.0 |= 1 | 1 << 8);
    pac::RCC.apb1enr().modify(|w| w.0 |= 1 << 1);

    // PC0, PC1 and PA6 are analog.
    pac::GPIOC.moder().modify(|w| w.0 |= 0b1111);
    pac::GPIOA.moder().modify(|w| w.0 |= 0b11 << 12);
    // ADCPRE: 84 MHz over four.
    pac::ADC123_COMMON.ccr().write_value(pac::adccommon::regs::Ccr(0b01 << 16));
    // SCAN.
    pac::ADC1.cr1().write_value(pac::adc::regs::Cr1(1 << 8));
    // 15 cycles of sampling on IN10, IN11 and IN6.
    pac::ADC1.smpr1().write_value(pac::adc::regs::Smpr1(0b001 | 0b001 << 3));
    pac::ADC1.smpr2().write_value(pac::adc::regs::Smpr2(0b001 << 18));
    // Three injected conversions, which stand in the last three places: IN10, IN11, IN6.
    pac::ADC1.jsqr().write_value(pac::adc::regs::Jsqr(2 << 20 | 10 << 5 | 11 << 10 | 6 << 15));
    // ADON; JEXTSEL TIM1_TRGO, JEXTEN rising.
    pac::ADC1.cr2().write_value(pac::adc::regs::Cr2(1 | 0b0001 << 16 | 0b01 << 20));

    // PB4 and PB5 to TIM3: alternate function 2.
    pac::GPIOB.moder().modify(|w| w.0 = w.0 & !(0b1111 << 8) | 0b1010 << 8);
    pac::GPIOB.afr(0).modify(|w| w.0 = w.0 & !(0xff << 16) | 0x22 << 16);
    super::count_encoder(pac::TIM3);
}

/// What the converter found last.
pub(super) fn read() -> Raw {
    let at = |n| pac::ADC1.jdr(n).read().0 as u16;
    let (b, c) = (at(0), at(1));
    // The three currents sum to nothing.
    let a = (3 * MIDDLE).saturating_sub(b.saturating_add(c));
    Raw { phases: [a, b, c], bus: at(2) }
}

/// The encoder's count.
pub(super) fn encoder() -> u16 {
    pac::TIM3.cnt().read().0 as u16
}

/// Pins of the six switches, to TIM1, and the gate driver on.
#[cfg(feature = "output")]
pub(super) fn output_pins() {
    // PA8 to PA10 and PB13 to PB15: alternate function 1.
    pac::GPIOA.afr(1).modify(|w| w.0 = w.0 & !0x0fff | 0x0111);
    pac::GPIOB.afr(1).modify(|w| w.0 = w.0 & !0xfff0_0000 | 0x1110_0000);
    pac::GPIOA.moder().modify(|w| w.0 = w.0 & !(0x3f << 16) | 0x2a << 16);
    pac::GPIOB.moder().modify(|w| w.0 = w.0 & !(0x3f << 26) | 0x2a << 26);
    // EN_GATE, PB12, is an output and high.
    pac::GPIOB.bsrr().write_value(pac::gpio::regs::Bsrr(1 << 12));
    pac::GPIOB.moder().modify(|w| w.0 = w.0 & !(0b11 << 24) | 0b01 << 24);
}
