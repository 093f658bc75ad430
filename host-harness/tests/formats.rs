//! Tables in files that are no text, through the reader of recordings.
#![cfg(feature = "formats")]

use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::Arc;

use host_harness::import::text;
use mcap::Writer;
use mcap::records::MessageHeader;
use parquet::data_type::{DoubleType, Int64Type};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

/// The text that a file of these bytes is read as, or the error.
fn read(bytes: &[u8]) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("raw");
    std::fs::write(&path, bytes).unwrap();
    text::read(&path).map_err(|error| error.to_string())
}

#[test]
fn columns_come_by_their_names_with_missing_values_empty() {
    let schema = "message log { required int64 time_us; optional double iq; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<Int64Type>().write_batch(&[0, 250, 500], None, None).unwrap();
    column.close().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<DoubleType>().write_batch(&[1.5, -0.1], Some(&[1, 0, 1]), None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    assert_eq!(read(&bytes).unwrap(), "time_us,iq\n0,1.5\n250,\n500,-0.1\n");
    assert!(read(&bytes[..bytes.len() - 9]).is_err(), "a file cut short");
}

/// An element of a file: type, length, and the bytes filled up to a multiple of eight.
fn element(kind: u32, bytes: &[u8]) -> Vec<u8> {
    let length = u32::try_from(bytes.len()).unwrap();
    let mut all = [kind.to_le_bytes(), length.to_le_bytes()].concat();
    all.extend(bytes);
    all.resize(all.len().next_multiple_of(8), 0);
    all
}

/// A matrix of doubles by the MAT-file format, level 5: flags, dimensions, name, real part.
fn matrix(name: &str, size: [i32; 2], values: &[f64]) -> Vec<u8> {
    let flags = [6_u32.to_le_bytes(), 0_u32.to_le_bytes()].concat();
    let size: Vec<u8> = size.iter().flat_map(|n| n.to_le_bytes()).collect();
    let values: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let parts =
        [element(6, &flags), element(5, &size), element(1, name.as_bytes()), element(9, &values)];
    element(14, &parts.concat())
}

#[test]
fn vectors_and_columns_of_matrices_are_the_table() {
    let mut bytes = b"MATLAB 5.0 MAT-file, by hand".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0x00, 0x01, b'I', b'M']);
    bytes.extend(matrix("time", [3, 1], &[0.0, 0.1, 0.2]));
    bytes.extend(matrix("current", [1, 3], &[1.0, 2.0, 3.0]));
    bytes.extend(matrix("enc", [3, 2], &[1.0, 2.0, 3.0, 7.0, 8.0, f64::NAN]));
    bytes.extend(matrix("gain_value", [1, 1], &[5.0]));
    let text = read(&bytes).unwrap();
    assert_eq!(text, "time,current,enc_1,enc_2\n0.0,1.0,1.0,7.0\n0.1,2.0,2.0,8.0\n0.2,3.0,3.0,\n");
    assert!(read(&bytes[..200]).is_err(), "a file cut short");
}

fn file(schema: (&str, &str, &str), encoding: &str, messages: &[(u64, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = Writer::new(&mut bytes).unwrap();
    let (name, kind, text) = schema;
    let schema = writer.add_schema(name, kind, text.as_bytes()).unwrap();
    let channel_id = writer.add_channel(schema, "/drive", encoding, &BTreeMap::new()).unwrap();
    for (log_time, data) in messages {
        let header =
            MessageHeader { channel_id, sequence: 0, log_time: *log_time, publish_time: *log_time };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

#[test]
fn json_messages_are_rows_by_time() {
    let start = 1_700_000_000_000_000_000;
    let messages = [
        (start, br#"{"iq": 1.5, "pos": [0.25, 7]}"#.to_vec()),
        (start + 250_000, br#"{"iq": -2, "on": true}"#.to_vec()),
    ];
    let text = read(&file(("drive", "jsonschema", "{}"), "json", &messages)).unwrap();
    assert_eq!(
        text,
        "log_time [s],/drive.iq,/drive.pos.0,/drive.pos.1,/drive.on\n0.0,1.5,0.25,7,\n0.00025,-2,,,1\n"
    );
}

#[test]
fn ros_2_messages_are_read_by_their_definition() {
    let definition = "# a drive\nuint8 MODE=3\nbuiltin_interfaces/Time stamp\nstring name\nfloat64[] position\nfloat32[2] iq\nLimits limits\n================================================================================\nMSG: drive_msgs/Limits\nbool active\nint16 low -5\n================================================================================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
    // The common data representation: little-endian, every number at a multiple of its size.
    let mut data = vec![0, 1, 0, 0];
    data.extend(7_i32.to_le_bytes());
    data.extend(500_u32.to_le_bytes());
    data.extend(3_u32.to_le_bytes());
    data.extend(b"ab\0\0");
    data.extend(2_u32.to_le_bytes());
    data.extend([0; 4]);
    data.extend(0.25_f64.to_le_bytes());
    data.extend((-1.5_f64).to_le_bytes());
    data.extend(1.25_f32.to_le_bytes());
    data.extend(2.5_f32.to_le_bytes());
    data.extend([1, 0]);
    data.extend((-3_i16).to_le_bytes());
    let schema = ("drive_msgs/msg/State", "ros2msg", definition);
    let text = read(&file(schema, "cdr", &[(5, data.clone())])).unwrap();
    assert_eq!(
        text,
        "log_time [s],/drive.stamp.sec,/drive.stamp.nanosec,/drive.name,/drive.position.0,/drive.position.1,/drive.iq.0,/drive.iq.1,/drive.limits.active,/drive.limits.low\n0.0,7,500,ab,0.25,-1.5,1.25,2.5,1,-3\n"
    );
    let cut = data[..data.len() - 1].to_vec();
    assert!(read(&file(schema, "cdr", &[(5, cut)])).is_err());
    let other = read(&file(("x", "protobuf", ""), "protobuf", &[(5, vec![1])])).unwrap_err();
    assert!(other.contains("it holds no JSON or ROS 2 message, but /drive (protobuf)"), "{other}");
}

#[test]
fn big_endian_numbers_and_counts_beyond_the_message_are_read_or_refused() {
    let message = |definition: &str, data: &[u8]| {
        read(&file(("a/msg/B", "ros2msg", definition), "cdr", &[(5, data.to_vec())]))
    };
    let definition = "int16 low\nuint8[] data\n";
    let big = [0, 0, 0, 0, 0xff, 0xfe, 0, 0, 0, 0, 0, 2, 7, 8];
    let text = message(definition, &big).unwrap();
    assert!(text.ends_with("\n0.0,-2,7,8\n"), "{text}");
    let endless = [0, 1, 0, 0, 1, 0, 0, 0, 0xff, 0xff, 0xff, 0xff];
    assert!(message(definition, &endless).is_err());
    assert!(message(definition, &[0, 1]).is_err());
    assert!(message("Other other\n", &[0, 1, 0, 0]).unwrap_err().contains("`Other`"));
}
