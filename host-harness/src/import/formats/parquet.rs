//! Parquet, as pandas and polars write it: flat columns and groups of them; lists are passed over.

use std::collections::HashMap;

use bytes::Bytes;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row};

use super::{Table, number};

pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    let told = |error: parquet::errors::ParquetError| error.to_string();
    let reader = SerializedFileReader::new(Bytes::copy_from_slice(bytes)).map_err(told)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let names: Vec<String> = schema.columns().iter().map(|column| column.path().string()).collect();
    let mut rows = Vec::new();
    for row in reader.get_row_iter(None).map_err(told)? {
        let mut fields = HashMap::new();
        flatten("", &row.map_err(told)?, &mut fields);
        rows.push(names.iter().map(|name| fields.remove(name).unwrap_or_default()).collect());
    }
    Ok(Table { names, rows })
}

fn flatten(path: &str, row: &Row, fields: &mut HashMap<String, String>) {
    for (name, field) in row.get_column_iter() {
        let name = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        match field {
            Field::Group(inner) => flatten(&name, inner, fields),
            field => {
                fields.insert(name, text(field));
            }
        }
    }
}

fn text(field: &Field) -> String {
    match field {
        Field::Bool(value) => u8::from(*value).to_string(),
        Field::Byte(value) => value.to_string(),
        Field::Short(value) => value.to_string(),
        Field::Int(value) | Field::Date(value) | Field::TimeMillis(value) => value.to_string(),
        Field::Long(value)
        | Field::TimeMicros(value)
        | Field::TimestampMillis(value)
        | Field::TimestampMicros(value) => value.to_string(),
        Field::UByte(value) => value.to_string(),
        Field::UShort(value) => value.to_string(),
        Field::UInt(value) => value.to_string(),
        Field::ULong(value) => value.to_string(),
        Field::Float16(value) => number(f64::from(value.to_f32())),
        // By way of its own shortest digits: 0.1 stays 0.1.
        Field::Float(value) if value.is_nan() => String::new(),
        Field::Float(value) => format!("{value:?}"),
        Field::Double(value) => number(*value),
        Field::Str(value) => value.clone(),
        _ => String::new(),
    }
}
