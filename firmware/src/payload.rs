//! The payload of a parameter block as the chip reads it: postcard's encoding, and of that what the
//! parameters are made of.
//!
//! A block is several hundred numbers. Read by postcard itself, every one of them brings a bounds
//! check and a way out along, for each number of stages anew: 12,640 bytes more of flash on the
//! STM32G431, where the drive then does not fit, 19,252 on the F405, 2,916 in `replay`. Postcard with a
//! source that never ends still takes 9,484, 12,744 and 1,444 more. A flat block would need no reader,
//! but blocks of version 1 would, and drives in the field hold them. Here a number is one call: past
//! the end it is zero, and that the end was passed is asked once, when all has been read.

use core::fmt;

use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer,
    SeqAccess, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;

/// Puts the first value of a payload into a place and gives what comes after it. What is large is to
/// stand on the stack no more often than it must.
///
/// # Errors
/// [`Unreadable`] where the bytes are not what `T` looks like; the place then holds nothing of use.
#[inline(never)]
pub(crate) fn take_into<'a, T: DeserializeOwned>(
    bytes: &'a [u8],
    place: &mut Option<T>,
) -> Result<&'a [u8], Unreadable> {
    let mut payload = Payload { rest: bytes, complete: true };
    *place = Some(T::deserialize(&mut payload)?);
    if payload.complete { Ok(payload.rest) } else { Err(Unreadable) }
}

/// The bytes are not what the type looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unreadable;

impl fmt::Display for Unreadable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("unreadable payload")
    }
}

impl core::error::Error for Unreadable {}

impl Error for Unreadable {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self
    }
}

struct Payload<'a> {
    rest: &'a [u8],
    complete: bool,
}

impl Payload<'_> {
    #[inline(never)]
    fn bytes<const BYTES: usize>(&mut self) -> [u8; BYTES] {
        match self.rest.split_first_chunk() {
            Some((bytes, rest)) => {
                self.rest = rest;
                *bytes
            }
            None => {
                self.complete = false;
                [0; BYTES]
            }
        }
    }

    #[inline(never)]
    fn real(&mut self) -> f32 {
        f32::from_le_bytes(self.bytes())
    }

    fn byte(&mut self) -> u8 {
        let [byte] = self.bytes();
        byte
    }

    /// A number of seven bits a byte, the lowest first; the eighth says that more follow.
    #[inline(never)]
    fn varint(&mut self) -> u64 {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte();
            let bits = u64::from(byte & 0x7f);
            self.complete &= bits << shift >> shift == bits;
            value |= bits << shift;
            if byte < 0x80 {
                return value;
            }
        }
        self.complete = false;
        value
    }

    fn narrow<T: TryFrom<u64>>(&mut self) -> Result<T, Unreadable> {
        T::try_from(self.varint()).map_err(|_| Unreadable)
    }

    /// Zigzag: the lowest bit is the sign.
    fn signed<T: TryFrom<i64>>(&mut self) -> Result<T, Unreadable> {
        let value = self.varint();
        T::try_from((value >> 1) as i64 ^ -((value & 1) as i64)).map_err(|_| Unreadable)
    }

    fn flag(&mut self) -> Result<bool, Unreadable> {
        match self.byte() {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(Unreadable),
        }
    }
}

/// Numbers: how one is read, and how it is handed on.
macro_rules! values {
    ($payload:ident: $($method:ident $visit:ident $value:expr,)*) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
            let $payload = self;
            visitor.$visit($value)
        })*
    };
}

/// What is written as one part after the other.
macro_rules! elements {
    ($($method:ident($($ignored:ty),*),)*) => {
        $(fn $method<V: Visitor<'de>>(
            self,
            $(_: $ignored,)*
            visitor: V,
        ) -> Result<V::Value, Unreadable> {
            visitor.visit_seq(Elements(self))
        })*
    };
}

impl<'de> Deserializer<'de> for &mut Payload<'_> {
    type Error = Unreadable;

    fn is_human_readable(&self) -> bool {
        false
    }

    /// The bytes do not say what they are.
    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Unreadable> {
        Err(Unreadable)
    }

    forward_to_deserialize_any! {
        i128 u128 char str string bytes byte_buf map identifier ignored_any
    }

    values! { payload:
        deserialize_f32 visit_f32 payload.real(),
        deserialize_f64 visit_f64 f64::from_le_bytes(payload.bytes()),
        deserialize_bool visit_bool payload.flag()?,
        deserialize_u8 visit_u8 payload.byte(),
        deserialize_u16 visit_u16 payload.narrow()?,
        deserialize_u32 visit_u32 payload.narrow()?,
        deserialize_u64 visit_u64 payload.varint(),
        deserialize_i8 visit_i8 payload.byte() as i8,
        deserialize_i16 visit_i16 payload.signed()?,
        deserialize_i32 visit_i32 payload.signed()?,
        deserialize_i64 visit_i64 payload.signed()?,
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        if self.flag()? { visitor.visit_some(self) } else { visitor.visit_none() }
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_unit()
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        visitor.visit_unit()
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        let left = self.narrow()?;
        visitor.visit_seq(Counted { payload: self, left })
    }

    elements! {
        deserialize_tuple(usize),
        deserialize_tuple_struct(&'static str, usize),
        deserialize_struct(&'static str, &'static [&'static str]),
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        visitor.visit_enum(self)
    }
}

/// The parts of a value that knows how many it has.
struct Elements<'p, 'a>(&'p mut Payload<'a>);

impl<'de> SeqAccess<'de> for Elements<'_, '_> {
    type Error = Unreadable;

    #[inline(always)]
    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Unreadable> {
        seed.deserialize(&mut *self.0).map(Some)
    }
}

struct Counted<'p, 'a> {
    payload: &'p mut Payload<'a>,
    left: u32,
}

impl<'de> SeqAccess<'de> for Counted<'_, '_> {
    type Error = Unreadable;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Unreadable> {
        let Some(left) = self.left.checked_sub(1) else { return Ok(None) };
        self.left = left;
        seed.deserialize(&mut *self.payload).map(Some)
    }
}

impl<'de> EnumAccess<'de> for &mut Payload<'_> {
    type Error = Unreadable;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(
        self,
        seed: V,
    ) -> Result<(V::Value, Self), Unreadable> {
        let variant: u32 = self.narrow()?;
        let variant =
            seed.deserialize(IntoDeserializer::<Unreadable>::into_deserializer(variant))?;
        Ok((variant, self))
    }
}

impl<'de> VariantAccess<'de> for &mut Payload<'_> {
    type Error = Unreadable;

    fn unit_variant(self) -> Result<(), Unreadable> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<T::Value, Unreadable> {
        seed.deserialize(self)
    }

    elements! { tuple_variant(usize), struct_variant(&'static [&'static str]), }
}

#[cfg(test)]
mod tests {
    use serde::{Deserialize, Serialize};

    use super::*;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    enum Shape {
        Nothing,
        One(i32),
        Two(u8, f32),
        Named { wide: u32, narrow: u16, short: i16, long: i64, tiny: i8 },
    }

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Everything {
        reals: [f32; 3],
        wide: f64,
        pair: (bool, i32),
        maybe: Option<f32>,
        not: Option<u16>,
        place: usize,
        part: u64,
        many: heapless::Vec<Shape, 4>,
    }

    fn everything() -> Everything {
        let shapes = [
            Shape::Nothing,
            Shape::One(i32::MIN),
            Shape::Two(200, -0.0),
            Shape::Named { wide: u32::MAX, narrow: 300, short: -77, long: i64::MIN, tiny: -128 },
        ];
        Everything {
            reals: [f32::NAN.copysign(1.0), f32::MIN_POSITIVE, -3.5],
            wide: 1e300,
            pair: (true, i32::MAX),
            maybe: Some(2.5),
            not: None,
            place: 300,
            part: u64::MAX - 1,
            many: shapes.into_iter().collect(),
        }
    }

    fn take(bytes: &[u8]) -> Result<(Everything, &[u8]), Unreadable> {
        let mut place = None;
        let rest = take_into(bytes, &mut place)?;
        Ok((place.unwrap(), rest))
    }

    #[test]
    fn what_postcard_wrote_is_read() {
        let (value, mut bytes) = (everything(), [0; 128]);
        let length = postcard::to_slice(&value, &mut bytes).unwrap().len();
        let (read, rest) = take(&bytes[..length + 2]).unwrap();
        assert_eq!(format!("{read:?}"), format!("{value:?}"));
        assert_eq!(rest, [0, 0]);
    }

    #[test]
    fn a_payload_cut_short_is_refused_at_every_length() {
        let mut bytes = [0; 128];
        let length = postcard::to_slice(&everything(), &mut bytes).unwrap().len();
        for short in 0..length {
            assert_eq!(take(&bytes[..short]).unwrap_err(), Unreadable, "{short}");
        }
    }

    #[test]
    fn damaged_bytes_are_read_as_postcard_reads_them_or_refused() {
        let mut bytes = [0; 128];
        let length = postcard::to_slice(&everything(), &mut bytes).unwrap().len();
        for place in 0..length {
            for value in 0..=u8::MAX {
                let mut damaged = bytes;
                damaged[place] = value;
                let damaged = &damaged[..length];
                let own = take(damaged).ok();
                let theirs = postcard::take_from_bytes::<Everything>(damaged).ok();
                assert_eq!(format!("{own:?}"), format!("{theirs:?}"), "byte {place} as {value}");
            }
        }
    }
}
