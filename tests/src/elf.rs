//! What a linked program takes, and what it calls: read from its ELF file.

use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SectionKind};

/// What a program takes of a chip's memories, and the names in it.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// Bytes in flash: code, constants, and the start values of what lies in RAM.
    pub flash_bytes: u64,
    /// Bytes of RAM besides the stack.
    pub ram_bytes: u64,
    /// Its symbols' names.
    pub symbols: Vec<String>,
}

impl Program {
    /// Reads a linked program.
    ///
    /// # Panics
    /// The file is no ELF file.
    pub fn read(elf: &Path) -> Self {
        let bytes = std::fs::read(elf).unwrap();
        let file = object::File::parse(&*bytes).unwrap();
        let mut program = Self::default();
        for section in file.sections() {
            let size = section.size();
            match section.kind() {
                SectionKind::Text | SectionKind::ReadOnlyData | SectionKind::ReadOnlyString => {
                    program.flash_bytes += size;
                }
                SectionKind::Data => {
                    program.flash_bytes += size;
                    program.ram_bytes += size;
                }
                SectionKind::UninitializedData => program.ram_bytes += size,
                _ => {}
            }
        }
        let names = file.symbols().filter_map(|symbol| symbol.name().ok().map(str::to_owned));
        program.symbols = names.collect();
        program
    }

    /// Symbols of what a Cortex-M4F does in software: double precision, and single without its FPU.
    pub fn soft_float(&self) -> Vec<&str> {
        let arithmetic = |name: &str| {
            let own = name.strip_prefix("__aeabi_").unwrap_or_default();
            let (double, single) = (own.starts_with('d'), own.starts_with('f'));
            // Such as __adddf3, __mulsf3, __fixdfsi, __extendsfdf2.
            let gnu = name.starts_with("__")
                && ["df2", "df3", "sf2", "sf3", "dfsi", "dfdi", "sfsi", "sfdi", "sidf", "didf"]
                    .iter()
                    .any(|end| name.ends_with(end));
            double || single || gnu || own.ends_with("2d") || own.ends_with("2f")
        };
        self.symbols.iter().map(String::as_str).filter(|name| arithmetic(name)).collect()
    }

    /// Symbols of an allocator.
    pub fn allocator(&self) -> Vec<&str> {
        let heap =
            ["__rust_alloc", "__rust_realloc", "__rg_alloc", "malloc", "_sbrk", "__rdl_alloc"];
        let names = self.symbols.iter().map(String::as_str);
        names.filter(|name| heap.iter().any(|own| name.contains(own))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soft_float_is_told_by_its_names_and_nothing_else_is() {
        let program = |names: &[&str]| Program {
            symbols: names.iter().map(|name| (*name).to_owned()).collect(),
            ..Program::default()
        };
        let soft = ["__aeabi_dmul", "__adddf3", "__mulsf3", "__aeabi_f2d", "__aeabi_i2d"];
        assert_eq!(program(&soft).soft_float(), soft);
        let hard = ["__aeabi_memcpy", "__aeabi_uldivmod", "memset", "__aeabi_lmul", "main"];
        assert!(program(&hard).soft_float().is_empty());
    }
}
