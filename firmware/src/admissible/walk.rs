//! A walk over whatever is serialisable, which looks at every number in there.

use core::fmt;

use serde::Serialize;
use serde::ser::{self, Serializer};

use super::{LARGEST, RULES, Rule};

/// The value that is looked at: the names of the structure and the field that it is in, and its rule.
#[derive(Clone, Copy)]
pub(super) struct Walk {
    pub(super) owner: &'static str,
    pub(super) name: &'static str,
    pub(super) rule: Rule,
}

/// The name of a field that is not admissible.
#[derive(Debug)]
pub(super) struct Refused(pub(super) &'static str);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl core::error::Error for Refused {}

impl ser::Error for Refused {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self("value")
    }
}

impl Walk {
    #[inline(never)]
    fn field(self, name: &'static str) -> Self {
        let Self { owner, .. } = self;
        let mut rules = RULES.iter();
        let found = rules.find(|(of, own, _)| *own == name && (of.is_empty() || *of == owner));
        Self { owner, name, rule: found.map_or(Rule::Finite, |(_, _, rule)| *rule) }
    }

    fn judge(self, admissible: bool) -> Result<(), Refused> {
        if admissible { Ok(()) } else { Err(Refused(self.name)) }
    }

    #[inline(never)]
    fn whole(self, value: u64) -> Result<(), Refused> {
        self.judge(match self.rule {
            Rule::Whole(low, high) => (low..=high).contains(&value),
            _ => true,
        })
    }
}

macro_rules! wholes {
    ($($method:ident $t:ty,)*) => {
        $(fn $method(self, value: $t) -> Result<(), Refused> { self.whole(u64::from(value)) })*
    };
}

macro_rules! passed {
    ($($method:ident $t:ty,)*) => {
        $(fn $method(self, _: $t) -> Result<(), Refused> { Ok(()) })*
    };
}

impl Serializer for Walk {
    type Ok = ();
    type Error = Refused;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Self;
    type SerializeMap = Self;
    type SerializeStruct = Self;
    type SerializeStructVariant = Self;

    wholes! { serialize_u8 u8, serialize_u16 u16, serialize_u32 u32, serialize_u64 u64, }
    passed! {
        serialize_bool bool, serialize_i8 i8, serialize_i16 i16, serialize_i32 i32,
        serialize_i64 i64, serialize_char char, serialize_str &str, serialize_bytes &[u8],
    }

    #[inline(never)]
    fn serialize_f32(self, value: f32) -> Result<(), Refused> {
        // Comparisons with a value that is no number are false.
        let finite = (-LARGEST..=LARGEST).contains(&value);
        self.judge(
            finite
                && match self.rule {
                    Rule::Finite | Rule::Whole(..) => true,
                    Rule::NotNegative => value >= 0.0,
                    Rule::Positive => value > 0.0,
                    Rule::Between(low, high) => (low..=high).contains(&value),
                },
        )
    }

    fn serialize_f64(self, value: f64) -> Result<(), Refused> {
        // By its bits: the chip has no double precision.
        let exponent = value.to_bits() >> 52 & 0x7ff;
        self.judge(exponent != 0x7ff)
    }

    fn serialize_none(self) -> Result<(), Refused> {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Refused> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), Refused> {
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Result<(), Refused> {
        Ok(())
    }

    fn serialize_unit_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
    ) -> Result<(), Refused> {
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Refused> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        value: &T,
    ) -> Result<(), Refused> {
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_struct(self, owner: &'static str, _: usize) -> Result<Self, Refused> {
        Ok(Self { owner, ..self })
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, Refused> {
        Ok(self)
    }

    fn collect_str<T: fmt::Display + ?Sized>(self, _: &T) -> Result<(), Refused> {
        Ok(())
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

macro_rules! elements {
    ($($collection:ident $method:ident,)*) => {
        $(impl ser::$collection for Walk {
            type Ok = ();
            type Error = Refused;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Refused> {
                value.serialize(*self)
            }

            fn end(self) -> Result<(), Refused> {
                Ok(())
            }
        })*
    };
}

elements! {
    SerializeSeq serialize_element,
    SerializeTuple serialize_element,
    SerializeTupleStruct serialize_field,
    SerializeTupleVariant serialize_field,
}

macro_rules! fields {
    ($($collection:ident,)*) => {
        $(impl ser::$collection for Walk {
            type Ok = ();
            type Error = Refused;

            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                name: &'static str,
                value: &T,
            ) -> Result<(), Refused> {
                value.serialize(self.field(name))
            }

            fn end(self) -> Result<(), Refused> {
                Ok(())
            }
        })*
    };
}

fields! { SerializeStruct, SerializeStructVariant, }

impl ser::SerializeMap for Walk {
    type Ok = ();
    type Error = Refused;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, _: &T) -> Result<(), Refused> {
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Refused> {
        value.serialize(*self)
    }

    fn end(self) -> Result<(), Refused> {
        Ok(())
    }
}
