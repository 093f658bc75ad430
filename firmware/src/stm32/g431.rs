//! STM32G431CB on ST's B-G431B-ESC1.
//!
//! Shunts of 3 mΩ in the three low sides, amplified by the chip's own OPAMPs to PA2 (ADC1 IN3), PA6
//! (ADC2 IN3) and PB1 (ADC1 IN12); the bus behind 169 kΩ and 18 kΩ at PA0 (ADC1 IN1); an encoder's A
//! and B at PB6 and PB7 (TIM4).

use stm32_metapac as pac;

use super::{Raw, wait};

/// Core and timer clock.
pub(super) const CLOCK_HZ: u32 = 170_000_000;
/// 3.3 V over 4096 counts, a gain of 9.14 with the board's dividers, 3 mΩ.
pub(super) const AMPERES_PER_COUNT: f32 = 3.3 / 4096.0 / (9.14 * 0.003);
/// 3.3 V over 4096 counts, 187 kΩ over 18 kΩ.
pub(super) const VOLTS_PER_COUNT: f32 = 3.3 / 4096.0 * (187.0 / 18.0);

/// 170 MHz from the internal 16 MHz.
pub(super) fn clocks() {
    // PWREN.
    pac::RCC.apb1enr1().modify(|w| w.0 |= 1 << 28);
    // R1MODE off: the range for more than 150 MHz.
    pac::PWR.cr5().modify(|w| w.0 &= !(1 << 8));
    // Four wait states, prefetch, both caches.
    pac::FLASH.acr().write_value(pac::flash::regs::Acr(4 | 1 << 8 | 1 << 9 | 1 << 10));
    // PLL: source HSI16, M = 4, N = 85, R = 2 and on.
    pac::RCC.pllcfgr().write_value(pac::rcc::regs::Pllcfgr(0b10 | 3 << 4 | 85 << 8 | 1 << 24));
    pac::RCC.cr().modify(|w| w.0 |= 1 << 24);
    wait(|| pac::RCC.cr().read().0 & 1 << 25 != 0);
    // At half speed first, as the manual asks.
    pac::RCC.cfgr().modify(|w| w.0 = w.0 & !(0xf << 4 | 0b11) | 0b1000 << 4 | 0b11);
    wait(|| pac::RCC.cfgr().read().0 & 0b11 << 2 == 0b11 << 2);
    cortex_m::asm::delay(200);
    pac::RCC.cfgr().modify(|w| w.0 &= !(0xf << 4));
}

/// Amplifiers, converters and the encoder's timer.
pub(super) fn sensors() {
    // GPIOA to C, ADC12; TIM1, SYSCFG; TIM4.
    pac::RCC.ahb2enr().modify(|w| w.0 |= 0b111 | 1 << 13);
    pac::RCC.apb2enr().modify(|w| w.0 |= 1 << 11 | 1);
    pac::RCC.apb1enr1().modify(|w| w.0 |= 1 << 2);

    // OPAEN, VM_SEL to the gain resistors, high speed, a gain of 16 with the bias at VINM0.
    let amplifier = pac::opamp::regs::Csr(1 | 0b10 << 5 | 1 << 7 | 0b01011 << 14);
    for opamp in [pac::OPAMP1, pac::OPAMP2, pac::OPAMP3] {
        opamp.csr().write_value(amplifier);
    }

    // Both converters from the bus clock over four.
    pac::ADC12_COMMON.ccr().write_value(pac::adccommon::regs::Ccr(0b11 << 16));
    for adc in [pac::ADC1, pac::ADC2] {
        // Out of deep power-down, regulator on, 20 µs for it.
        adc.cr().write_value(pac::adc::regs::Cr(1 << 28));
        cortex_m::asm::delay(20 * (CLOCK_HZ / 1_000_000));
        // ADCAL.
        adc.cr().write_value(pac::adc::regs::Cr(1 << 28 | 1 << 31));
        wait(|| adc.cr().read().0 & 1 << 31 == 0);
        // ADEN.
        adc.cr().modify(|w| w.0 |= 1);
        wait(|| adc.isr().read().0 & 1 != 0);
        // 12.5 cycles of sampling on IN1 and IN3, and on IN12.
        adc.smpr().write_value(pac::adc::regs::Smpr(0b010 << 3 | 0b010 << 9));
        adc.smpr2().write_value(pac::adc::regs::Smpr2(0b010 << 6));
    }
    // Injected, by the rising TIM1_TRGO: IN3, IN12, IN1; and IN3 of the other.
    let trigger = 0b01 << 7;
    pac::ADC1.jsqr().write_value(pac::adc::regs::Jsqr(2 | trigger | 3 << 9 | 12 << 15 | 1 << 21));
    pac::ADC2.jsqr().write_value(pac::adc::regs::Jsqr(trigger | 3 << 9));
    for adc in [pac::ADC1, pac::ADC2] {
        // JADSTART.
        adc.cr().modify(|w| w.0 |= 1 << 3);
    }

    // PB6 and PB7 to TIM4: alternate function 2.
    pac::GPIOB.moder().modify(|w| w.0 = w.0 & !(0b1111 << 12) | 0b1010 << 12);
    pac::GPIOB.afr(0).modify(|w| w.0 = w.0 & !(0xff << 24) | 0x22 << 24);
    super::count_encoder(pac::TIM4);
}

/// What the converters found last.
pub(super) fn read() -> Raw {
    let at = |adc: pac::adc::Adc, n| adc.jdr(n).read().0 as u16;
    Raw { phases: [at(pac::ADC1, 0), at(pac::ADC2, 0), at(pac::ADC1, 1)], bus: at(pac::ADC1, 2) }
}

/// The encoder's count.
pub(super) fn encoder() -> u16 {
    pac::TIM4.cnt().read().0 as u16
}

/// Pins of the six switches, to TIM1.
#[cfg(feature = "output")]
pub(super) fn output_pins() {
    // PA8 to PA10 and PA12: alternate function 6. PB15 and PC13: 4.
    let alternate = |moder: u32, pin: u32| moder & !(0b11 << (2 * pin)) | 0b10 << (2 * pin);
    pac::GPIOA.afr(1).modify(|w| w.0 = w.0 & !0x000f_0fff | 0x0006_0666);
    pac::GPIOB.afr(1).modify(|w| w.0 = w.0 & !0xf000_0000 | 0x4000_0000);
    pac::GPIOC.afr(1).modify(|w| w.0 = w.0 & !0x00f0_0000 | 0x0040_0000);
    pac::GPIOA.moder().modify(|w| w.0 = [8, 9, 10, 12].into_iter().fold(w.0, alternate));
    pac::GPIOB.moder().modify(|w| w.0 = alternate(w.0, 15));
    pac::GPIOC.moder().modify(|w| w.0 = alternate(w.0, 13));
}
