//! The boards that the firmware is for, and what of a parameter block they take.

use clap::ValueEnum;
use firmware::block::{Block, PAGE_ADDRESS_F405, PAGE_ADDRESS_G431, PAGE_BYTES};

use crate::export::block::accepted;

/// A board's chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Chip {
    /// STM32G431CB, on ST's B-G431B-ESC1
    Stm32g431,
    /// STM32F405RG, as on ODrive v3 and VESC
    Stm32f405,
}

impl Chip {
    /// Its name in debug tools.
    pub fn name(self) -> &'static str {
        match self {
            Chip::Stm32g431 => "STM32G431CBUx",
            Chip::Stm32f405 => "STM32F405RGTx",
        }
    }

    /// Where its parameter page is.
    pub fn page_address(self) -> u64 {
        u64::from(match self {
            Chip::Stm32g431 => PAGE_ADDRESS_G431,
            Chip::Stm32f405 => PAGE_ADDRESS_F405,
        })
    }

    /// Most gear stages that its firmware runs.
    pub fn stages(self) -> u8 {
        match self {
            Chip::Stm32g431 => 2,
            Chip::Stm32f405 => 3,
        }
    }

    /// Whether its firmware would accept this block, by the firmware's own code; gives the block's
    /// checksum.
    ///
    /// # Errors
    /// Why it would not.
    pub fn takes(self, block: &[u8]) -> Result<u32, String> {
        accepted(block).map_err(|error| error.to_string())?;
        let read = Block::check(block).map_err(|error| error.to_string())?;
        let (stages, most) = (read.stages, self.stages());
        if stages > most {
            return Err(format!("{stages} stages: the firmware of {} runs {most}", self.name()));
        }
        if block.len() > PAGE_BYTES {
            return Err(format!("{} bytes: the page has {PAGE_BYTES}", block.len()));
        }
        Ok(read.crc)
    }
}
