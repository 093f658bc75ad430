//! The constants of joints side by side, from those of each.
//!
//! How a joint's constants follow from its parameters is written once, in plain numbers. So joints that
//! differ by their numbers alone are written down as they would travel to a drive, and read back side by
//! side as one joint whose numbers have lanes.

use std::fmt;

use serde::de::value::F64Deserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer,
    SeqAccess, VariantAccess, Visitor,
};
use serde::{Serialize, forward_to_deserialize_any};

use super::number::{LANES, NAME};

/// The constants of something as they travel.
pub(super) fn constants<T: Serialize>(of: &T) -> Option<Vec<u8>> {
    postcard::to_extend(of, Vec::new()).ok()
}

/// Share by which the rates over one step and over two may differ, and what rounding makes of a number.
const SMOOTH: f64 = 1e-3;
const ROUNDING: f64 = 1e-14;

/// Reads constants side by side, those of one joint for each lane.
///
/// # Errors
/// They are not alike: another number of laws, or another count of steps.
pub(super) fn woven<T: DeserializeOwned>(lanes: Vec<&[u8]>) -> Result<T, Unlike> {
    T::deserialize(&mut Threads { lanes, agreeing: false })
}

/// Whether constants move smoothly: by one step and by two at the same rate.
pub(super) fn is_smooth<T: DeserializeOwned>([here, one, two]: [&[u8]; 3]) -> bool {
    let lanes = [[here, one, two].as_slice(), &[here; LANES - 3]].concat();
    T::deserialize(&mut Threads { lanes, agreeing: true }).is_ok()
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
    lanes: Vec<&'a [u8]>,
    /// Whether the second and third are to show the same rate.
    agreeing: bool,
}

impl Threads<'_> {
    fn byte(&mut self) -> Result<u8, Unlike> {
        let mut common = None;
        for lane in &mut self.lanes {
            let (byte, left) = lane.split_first().ok_or(Unlike)?;
            *lane = left;
            if *common.get_or_insert(*byte) != *byte {
                return Err(Unlike);
            }
        }
        common.ok_or(Unlike)
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

    /// A real number of every lane.
    fn real(&mut self) -> Result<[f64; LANES], Unlike> {
        let mut parts = [0.0; LANES];
        for (part, lane) in parts.iter_mut().zip(&mut self.lanes) {
            let (bytes, left) = lane.split_first_chunk().ok_or(Unlike)?;
            *lane = left;
            *part = f64::from_le_bytes(*bytes);
        }
        let [here, one, two, ..] = parts;
        // What is infinite in both does not move.
        let rate = |there: f64, steps| if there == here { 0.0 } else { (there - here) / steps };
        let (one, two) = (rate(one, 1.0), rate(two, 2.0));
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
            return visitor.visit_seq(Reals { lanes: self.real()?, next: 0 });
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

/// The lanes of one number.
struct Reals {
    lanes: [f64; LANES],
    next: usize,
}

impl<'de> SeqAccess<'de> for Reals {
    type Error = Unlike;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Unlike> {
        let Some(part) = self.lanes.get(self.next) else { return Ok(None) };
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
