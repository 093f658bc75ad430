//! MATLAB's files of version 5 to 7: numeric arrays, of which the longest of a length are the table.
//!
//! A vector is a column of its name; a matrix gives `name_1`, `name_2` for its columns. Structures,
//! and what Simulink logs in them, are passed over: `save` their fields as arrays.

use matfile::{Array, MatFile, NumericData};

use super::{Table, number};

pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    let file = MatFile::parse(bytes).map_err(|error| error.to_string())?;
    let length = file.arrays().iter().map(rows).max().unwrap_or(0);
    if length < 2 {
        return Err("it holds no numeric array of more than one value".to_owned());
    }
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    for array in file.arrays().iter().filter(|array| rows(array) == length) {
        let values = values(array.data());
        let name = array.name();
        match values.len() / length {
            1 => columns.push((name.to_owned(), values)),
            _ => {
                let parts = values.chunks(length).enumerate();
                columns.extend(parts.map(|(k, own)| (format!("{name}_{}", k + 1), own.to_vec())));
            }
        }
    }
    let row = |k: usize| {
        let own = columns.iter().map(|(_, values)| values.get(k).copied().unwrap_or(f64::NAN));
        own.map(number).collect()
    };
    let rows = (0..length).map(row).collect();
    Ok(Table { names: columns.into_iter().map(|(name, _)| name).collect(), rows })
}

/// Samples of an array: its length where it is a vector, else its rows.
fn rows(array: &Array) -> usize {
    match array.size()[..] {
        [1, columns] => columns,
        [rows, ..] => rows,
        [] => 0,
    }
}

fn values(data: &NumericData) -> Vec<f64> {
    match data {
        NumericData::Int8 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::UInt8 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::Int16 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::UInt16 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::Int32 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::UInt32 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::Int64 { real, .. } => real.iter().map(|v| *v as f64).collect(),
        NumericData::UInt64 { real, .. } => real.iter().map(|v| *v as f64).collect(),
        NumericData::Single { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::Double { real, .. } => real.clone(),
    }
}
