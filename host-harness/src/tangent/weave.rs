//! The constants of a joint with their derivatives, from those of joints a little apart.
//!
//! How a joint's constants follow from its parameters is written once, in plain numbers. So their
//! derivatives are taken from outside: joints that differ by a step in one parameter each are
//! written down as they would travel to a drive, and read back side by side as one joint whose
//! numbers have derivatives.

use std::fmt;

use serde::de::value::F64Deserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer,
    SeqAccess, VariantAccess, Visitor,
};
use serde::{Serialize, forward_to_deserialize_any};

use super::dual::{LANES, NAME};

/// The constants of something as they travel.
pub(super) fn constants<T: Serialize>(of: &T) -> Option<Vec<u8>> {
    postcard::to_extend(of, Vec::new()).ok()
}

/// Share by which the rates over one step and over two may differ, and what rounding makes of a number.
const SMOOTH: f64 = 1e-3;
const ROUNDING: f64 = 1e-14;

/// Constants written down, and one over the step at which they stand from others.
pub(super) type Apart<'a> = (&'a [u8], f64);

/// Reads constants with the derivatives that others a step apart show.
///
/// # Errors
/// The others are not alike: another number of laws, or another count of steps.
pub(super) fn woven<T: DeserializeOwned>(base: &[u8], apart: &[Apart<'_>]) -> Result<T, Unlike> {
    let mut threads = Threads { base, apart: apart.to_vec(), agreeing: false };
    T::deserialize(&mut threads)
}

/// Whether constants move smoothly: by one step and by two at the same rate.
pub(super) fn is_smooth<T: DeserializeOwned>(base: &[u8], one: &[u8], two: &[u8]) -> bool {
    let mut threads = Threads { base, apart: vec![(one, 1.0), (two, 0.5)], agreeing: true };
    T::deserialize(&mut threads).is_ok()
}

/// Constants that differ by more than numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unlike;

impl fmt::Display for Unlike {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the joints differ by more than their numbers")
    }
}

impl std::error::Error for Unlike {}

impl Error for Unlike {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self
    }
}

/// The same place in several writings.
struct Threads<'a> {
    base: &'a [u8],
    apart: Vec<Apart<'a>>,
    /// Whether the first two are to show the same derivatives.
    agreeing: bool,
}

impl Threads<'_> {
    fn byte(&mut self) -> Result<u8, Unlike> {
        let take = |rest: &mut &[u8]| {
            let (byte, left) = rest.split_first().ok_or(Unlike)?;
            *rest = left;
            Ok(*byte)
        };
        let byte = take(&mut self.base)?;
        for (other, _) in &mut self.apart {
            if take(other)? != byte {
                return Err(Unlike);
            }
        }
        Ok(byte)
    }

    /// Seven bits a byte, the lowest first; the eighth says that more follow.
    fn whole<T: TryFrom<u64>>(&mut self) -> Result<T, Unlike> {
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return T::try_from(value).map_err(|_| Unlike);
            }
        }
        Err(Unlike)
    }

    fn flag(&mut self) -> Result<bool, Unlike> {
        Ok(self.byte()? != 0)
    }

    /// A real number and its derivatives.
    fn real(&mut self) -> Result<[f64; 1 + LANES], Unlike> {
        let take = |rest: &mut &[u8]| {
            let (bytes, left) = rest.split_first_chunk().ok_or(Unlike)?;
            *rest = left;
            Ok(f64::from_le_bytes(*bytes))
        };
        let mut parts = [0.0; 1 + LANES];
        let here = take(&mut self.base)?;
        parts[0] = here;
        for ((other, per_step), slope) in self.apart.iter_mut().zip(&mut parts[1..]) {
            let there = take(other)?;
            // What is infinite in both does not move.
            *slope = if there == here { 0.0 } else { (there - here) * *per_step };
        }
        let [_, one, two, ..] = parts;
        let rounding = ROUNDING * here.abs();
        if self.agreeing && (one - two).abs() > SMOOTH * one.abs().max(two.abs()) + rounding {
            return Err(Unlike);
        }
        Ok(parts)
    }
}

impl<'de> Deserializer<'de> for &mut Threads<'_> {
    type Error = Unlike;

    fn is_human_readable(&self) -> bool {
        false
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Unlike> {
        Err(Unlike)
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i64 i128 u128 f32 char str string bytes byte_buf map identifier ignored_any
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unlike> {
        visitor.visit_f64(self.real()?[0])
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unlike> {
        visitor.visit_bool(self.flag()?)
    }

    fn deserialize_u8<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unlike> {
        visitor.visit_u8(self.byte()?)
    }

    fn deserialize_u16<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unlike> {
        visitor.visit_u16(self.whole()?)
    }

    fn deserialize_u32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unlike> {
        visitor.visit_u32(self.whole()?)
    }

    fn deserialize_u64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unlike> {
        visitor.visit_u64(self.whole()?)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unlike> {
        if self.flag()? { visitor.visit_some(self) } else { visitor.visit_none() }
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unlike> {
        visitor.visit_unit()
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Unlike> {
        visitor.visit_unit()
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Unlike> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unlike> {
        let left = self.whole()?;
        visitor.visit_seq(Elements { threads: self, left })
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        left: usize,
        visitor: V,
    ) -> Result<V::Value, Unlike> {
        visitor.visit_seq(Elements { threads: self, left })
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        left: usize,
        visitor: V,
    ) -> Result<V::Value, Unlike> {
        if name == NAME {
            return visitor.visit_seq(Reals { parts: self.real()?, next: 0 });
        }
        visitor.visit_seq(Elements { threads: self, left })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unlike> {
        visitor.visit_seq(Elements { threads: self, left: fields.len() })
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unlike> {
        visitor.visit_enum(self)
    }
}

struct Elements<'t, 'a> {
    threads: &'t mut Threads<'a>,
    left: usize,
}

impl<'de> SeqAccess<'de> for Elements<'_, '_> {
    type Error = Unlike;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Unlike> {
        let Some(left) = self.left.checked_sub(1) else { return Ok(None) };
        self.left = left;
        seed.deserialize(&mut *self.threads).map(Some)
    }
}

/// The parts of one number.
struct Reals {
    parts: [f64; 1 + LANES],
    next: usize,
}

impl<'de> SeqAccess<'de> for Reals {
    type Error = Unlike;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Unlike> {
        let Some(part) = self.parts.get(self.next) else { return Ok(None) };
        self.next += 1;
        seed.deserialize(F64Deserializer::new(*part)).map(Some)
    }
}

impl<'de> EnumAccess<'de> for &mut Threads<'_> {
    type Error = Unlike;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Unlike> {
        let variant: u32 = self.whole()?;
        Ok((seed.deserialize(IntoDeserializer::<Unlike>::into_deserializer(variant))?, self))
    }
}

impl<'de> VariantAccess<'de> for &mut Threads<'_> {
    type Error = Unlike;

    fn unit_variant(self) -> Result<(), Unlike> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Unlike> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, left: usize, visitor: V) -> Result<V::Value, Unlike> {
        visitor.visit_seq(Elements { threads: self, left })
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unlike> {
        visitor.visit_seq(Elements { threads: self, left: fields.len() })
    }
}
