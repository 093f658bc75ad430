//! The text of a recording: decompressed, decoded, and told from files that are no text.

use std::path::Path;

use crate::fault::InputError;
use crate::log::unpacked;

/// First bytes of files that hold tables but no text, with what they are and how to convert them.
const OTHERS: [(&[u8], &str, &str); 7] = [
    (
        b"PAR1",
        "a Parquet file",
        "a `joint` built with --features formats reads it; or: python -c \"import pandas; pandas.read_parquet('RAW').to_csv('raw.csv', index=False)\"",
    ),
    (
        b"MATLAB 5.0 MAT-file",
        "a MATLAB file",
        "a `joint` built with --features formats reads it; or in MATLAB: writetable(struct2table(load('RAW')), 'raw.csv')",
    ),
    (
        b"\x89HDF\r\n",
        "an HDF5 file, as MATLAB writes since 7.3",
        "save it with -v7, or as CSV in MATLAB: writetable(struct2table(load('RAW')), 'raw.csv')",
    ),
    (
        b"\x89MCAP0\r\n",
        "an MCAP file",
        "a `joint` built with --features formats reads it; or export its topics as CSV, for example with PlotJuggler",
    ),
    (b"#ROSBAG", "a ROS bag", "export its topics as CSV, for example with PlotJuggler"),
    (
        b"SQLite format 3",
        "a database, perhaps a ROS 2 bag",
        "export its topics as CSV, for example with PlotJuggler",
    ),
    (b"PK\x03\x04", "a zip file or a spreadsheet", "unpack it, or save the sheet as CSV"),
];

/// Reads a file as text: compressed or not, in UTF-8, UTF-16 with its mark, or Latin-1.
///
/// # Errors
/// It cannot be read, or it is no text.
pub fn read(path: &Path) -> Result<String, InputError> {
    decode(unpacked(path)?, path)
}

fn decode(bytes: Vec<u8>, path: &Path) -> Result<String, InputError> {
    #[cfg(feature = "formats")]
    if let Some(text) = super::formats::text(&bytes, path)? {
        return Ok(text);
    }
    if let Some((_, what, how)) = OTHERS.iter().find(|(magic, ..)| bytes.starts_with(magic)) {
        return Err(InputError::new(path, format!("is {what}, and this reads text")).help(
            format!("convert it to CSV first: {}", how.replace("RAW", &path.display().to_string())),
        ));
    }
    let wide = |pair: &[u8], little: bool| match (pair, little) {
        (&[low, high], true) | (&[high, low], false) => u16::from_be_bytes([high, low]),
        _ => 0,
    };
    if let [a, b, ..] = bytes[..]
        && matches!((a, b), (0xff, 0xfe) | (0xfe, 0xff))
    {
        let units: Vec<u16> = bytes[2..].chunks(2).map(|pair| wide(pair, a == 0xff)).collect();
        return String::from_utf16(&units).map_err(|_| {
            InputError::new(path, "begins as UTF-16 text and goes on otherwise")
                .help("save it as plain CSV text")
        });
    }
    if bytes.contains(&0) {
        return Err(InputError::new(path, "holds bytes of zero and is no text")
            .help("export the recording as CSV"));
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        // Latin-1, which has the degree sign and the micro sign of recorders as single bytes.
        Err(error) => error.into_bytes().iter().map(|byte| char::from(*byte)).collect(),
    };
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> Result<String, String> {
        decode(bytes.to_vec(), Path::new("raw.csv")).map_err(|error| error.to_string())
    }

    #[test]
    fn marks_and_encodings_give_the_same_text() {
        assert_eq!(text("\u{feff}t,°\n".as_bytes()).unwrap(), "t,°\n");
        assert_eq!(text(b"t,\xb0\n").unwrap(), "t,°\n");
        assert_eq!(text(b"\xff\xfet\0,\0\xb0\0\n\0").unwrap(), "t,°\n");
        assert_eq!(text(b"\xfe\xff\0t\0,\0\xb0\0\n").unwrap(), "t,°\n");
    }

    /// With the feature `formats`, some of them are read.
    #[cfg(not(feature = "formats"))]
    #[test]
    fn files_that_are_no_text_are_named_with_the_way_to_convert_them() {
        for (magic, what, _) in OTHERS {
            let error = text(magic).unwrap_err();
            assert!(error.contains(what) && error.contains("CSV"), "{error}");
        }
        assert!(text(b"a\0b").unwrap_err().contains("no text"));
    }
}
