//! ROS 2 messages: their definitions as text, and their bytes in the common data representation (CDR).
//!
//! A file carries the definition of every message in it, with those of the messages inside. Numbers are
//! little-endian or big-endian as the first bytes say, each at a multiple of its size.

use std::collections::HashMap;

use super::number;

/// The longest array of which every element becomes a column: a point cloud is no channel of a log.
const MOST_ELEMENTS: usize = 64;

/// The definitions of a message and of those inside it.
pub(super) struct Definitions {
    main: String,
    fields: HashMap<String, Vec<Field>>,
}

#[derive(Clone, Debug)]
struct Field {
    name: String,
    kind: String,
    count: Count,
}

#[derive(Clone, Copy, Debug)]
enum Count {
    One,
    Fixed(usize),
    Counted,
}

impl Definitions {
    /// Reads the text of a definition; `name` is that of the message.
    pub(super) fn parse(name: &str, text: &str) -> Self {
        let main = short(name);
        let mut own = main.clone();
        let mut fields: HashMap<String, Vec<Field>> = HashMap::new();
        fields.entry(own.clone()).or_default();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or("").trim();
            if let Some(name) = line.strip_prefix("MSG:") {
                own = short(name.trim());
                fields.entry(own.clone()).or_default();
                continue;
            }
            let mut words = line.split_whitespace();
            let (Some(kind), Some(name)) = (words.next(), words.next()) else { continue };
            // A constant has an equals sign; a line of them separates definitions.
            if line.starts_with('=')
                || name.contains('=')
                || words.next().is_some_and(|w| w.starts_with('='))
            {
                continue;
            }
            if let Some(list) = fields.get_mut(&own) {
                list.push(field(kind, name));
            }
        }
        Self { main, fields }
    }

    /// Every number and text in a message's bytes, under its path.
    pub(super) fn read(
        &self,
        topic: &str,
        data: &[u8],
        found: &mut Vec<(String, String)>,
    ) -> Result<(), String> {
        let Some((&[_, order, _, _], body)) = data.split_first_chunk::<4>() else {
            return Err("a message without a header".to_owned());
        };
        let mut bytes = Bytes { body, at: 0, little: order & 1 == 1 };
        self.message(&self.main, topic, &mut bytes, found)
    }

    fn message(
        &self,
        kind: &str,
        path: &str,
        bytes: &mut Bytes<'_>,
        found: &mut Vec<(String, String)>,
    ) -> Result<(), String> {
        let fields = self.fields.get(kind).or_else(|| {
            // Inside a package its own messages go without its name.
            let package = self.main.split('/').next().unwrap_or("");
            self.fields.get(&format!("{package}/{kind}")).or_else(|| {
                let ending = format!("/{kind}");
                self.fields.iter().find(|(name, _)| name.ends_with(&ending)).map(|(_, own)| own)
            })
        });
        let fields = fields.ok_or_else(|| format!("the definition of `{kind}` is missing"))?;
        for field in fields {
            let path = format!("{path}.{}", field.name);
            let count = match field.count {
                Count::One => {
                    self.value(&field.kind, &path, true, bytes, found)?;
                    continue;
                }
                Count::Fixed(count) => count,
                Count::Counted => usize::try_from(bytes.unsigned(4)?).unwrap_or(usize::MAX),
            };
            for k in 0..count {
                let kept = k < MOST_ELEMENTS;
                self.value(&field.kind, &format!("{path}.{k}"), kept, bytes, found)?;
            }
        }
        Ok(())
    }

    fn value(
        &self,
        kind: &str,
        path: &str,
        kept: bool,
        bytes: &mut Bytes<'_>,
        found: &mut Vec<(String, String)>,
    ) -> Result<(), String> {
        let text = match kind {
            "bool" | "byte" | "char" | "uint8" => bytes.unsigned(1)?.to_string(),
            "uint16" => bytes.unsigned(2)?.to_string(),
            "uint32" => bytes.unsigned(4)?.to_string(),
            "uint64" => bytes.unsigned(8)?.to_string(),
            "int8" => bytes.signed(1)?.to_string(),
            "int16" => bytes.signed(2)?.to_string(),
            "int32" => bytes.signed(4)?.to_string(),
            "int64" => bytes.signed(8)?.to_string(),
            "float32" => {
                let bits = u32::try_from(bytes.unsigned(4)?).unwrap_or_default();
                let value = f32::from_bits(bits);
                if value.is_nan() { String::new() } else { format!("{value:?}") }
            }
            "float64" => number(f64::from_bits(bytes.unsigned(8)?)),
            "string" => bytes.text()?,
            "wstring" => return Err("wide strings are not read".to_owned()),
            kind => {
                let mut inner = Vec::new();
                self.message(kind, path, bytes, &mut inner)?;
                if kept {
                    found.append(&mut inner);
                }
                return Ok(());
            }
        };
        if kept {
            found.push((path.to_owned(), text));
        }
        Ok(())
    }
}

/// `package/Type` of `package/msg/Type`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

fn field(kind: &str, name: &str) -> Field {
    let name = name.to_owned();
    let Some((kind, bound)) = kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) else {
        // A bound on a text, `string<=16`, does not show in its bytes.
        let kind = kind.split('<').next().unwrap_or(kind);
        return Field { name, kind: short(kind), count: Count::One };
    };
    let kind = short(kind.split('<').next().unwrap_or(kind));
    let count = bound.parse().map_or(Count::Counted, Count::Fixed);
    Field { name, kind, count }
}

/// The bytes of a message behind its header.
struct Bytes<'a> {
    body: &'a [u8],
    at: usize,
    little: bool,
}

impl Bytes<'_> {
    fn take(&mut self, length: usize) -> Result<&[u8], String> {
        let end = self.at.checked_add(length);
        let own = end.and_then(|end| self.body.get(self.at..end));
        let own = own.ok_or_else(|| "a message is shorter than its definition".to_owned())?;
        self.at += length;
        Ok(own)
    }

    fn unsigned(&mut self, size: usize) -> Result<u64, String> {
        self.at = self.at.next_multiple_of(size);
        let little = self.little;
        let own = self.take(size)?.iter();
        let join = |sum: u64, byte: &u8| (sum << 8) | u64::from(*byte);
        Ok(if little { own.rev().fold(0, join) } else { own.fold(0, join) })
    }

    fn signed(&mut self, size: usize) -> Result<i64, String> {
        let unused = 64 - 8 * size as u32;
        Ok(((self.unsigned(size)? << unused) as i64) >> unused)
    }

    /// A text of so many bytes, the last of them zero.
    fn text(&mut self) -> Result<String, String> {
        let length = usize::try_from(self.unsigned(4)?).unwrap_or(usize::MAX);
        let own = self.take(length)?;
        let own = own.strip_suffix(&[0]).unwrap_or(own);
        Ok(String::from_utf8_lossy(own).into_owned())
    }
}
