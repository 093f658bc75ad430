//! Reading and writing logs.

use std::path::Path;

use host_harness::log::{Log, Need, compressed};
use proptest::prelude::*;

fn parse(text: &str) -> Result<(Log, Vec<String>), String> {
    Log::parse(text.as_bytes(), Path::new("log.csv"), Need::Drive)
        .map(|loaded| (loaded.log, loaded.warnings))
        .map_err(|error| error.to_string())
}

fn error(text: &str) -> String {
    parse(text).expect_err("a malformed log was taken")
}

const PLAIN: &str = "t_s,u_v,motor_angle_rad\n0,1,0\n0.1,2,0.5\n";

#[test]
fn columns_are_found_by_name_in_any_order() {
    let (log, warnings) = parse("motor_angle_rad,t_s,u_v\n0,0,1\n0.5,0.1,2\n").unwrap();
    assert_eq!(log, parse(PLAIN).unwrap().0);
    assert_eq!(log.time_s, [0.0, 0.1]);
    assert_eq!(log.voltage_v, Some(vec![1.0, 2.0]));
    assert!(warnings.is_empty());
}

#[test]
fn byte_order_mark_crlf_and_padding_change_nothing() {
    let text = "\u{feff}t_s , u_v,motor_angle_rad\r\n 0,1 ,0\r\n0.1, 2,0.5\r\n";
    assert_eq!(parse(text).unwrap().0, parse(PLAIN).unwrap().0);
}

#[test]
fn a_compressed_log_is_read_whatever_its_name() {
    let loaded = Log::parse(PLAIN.as_bytes(), Path::new("log.csv"), Need::Drive).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for name in ["log.csv.gz", "log.csv"] {
        let path = folder.path().join(name);
        std::fs::write(&path, compressed(PLAIN)).unwrap();
        assert_eq!(Log::read(&path, Need::Drive).unwrap(), loaded);
    }
}

#[test]
fn a_compressed_log_cut_short_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv.gz");
    let bytes = compressed(PLAIN);
    std::fs::write(&path, &bytes[..bytes.len() - 6]).unwrap();
    let error = Log::read(&path, Need::Drive).unwrap_err().to_string();
    assert!(error.contains("log.csv.gz: cannot be decompressed"), "{error}");
}

#[test]
fn an_empty_field_is_a_missing_value() {
    let (log, _) = parse("t_s,u_v,i_a,motor_angle_rad\n0,1,,0\n0.1,,2,\n").unwrap();
    assert!(log.current_a.unwrap()[0].is_nan());
    assert!(log.voltage_v.unwrap()[1].is_nan());
    assert!(log.motor_angle_rad[1].is_nan());
}

#[test]
fn unknown_and_empty_columns_are_named_once_and_ignored() {
    let text = "t_s,u_v,i_a,motor_angle_rad,note,rpm\n0,1,,0,hello,1\n1,1,,0,\"a,b\",2\n";
    let (log, warnings) = parse(text).unwrap();
    assert_eq!(log.current_a, None);
    assert_eq!(
        warnings,
        ["unknown columns are ignored: note, rpm", "column i_a holds no value and is ignored"]
    );
}

#[test]
fn without_voltage_and_current_a_log_serves_only_who_needs_neither() {
    let text = "t_s,motor_angle_rad\n0,0\n1,0\n";
    assert_eq!(
        error(text),
        "log.csv: neither u_v nor i_a is there, so nothing says what was put in\n  \
         help: add the voltage as u_v or the current as i_a"
    );
    assert!(Log::parse(text.as_bytes(), Path::new("log.csv"), Need::Nothing).is_ok());
}

#[test]
fn a_field_that_is_no_number_is_named_by_line_and_column() {
    let help = "\n  help: write a number with a decimal point, or leave the field empty";
    let cases = [
        ("abc", "`abc` is not a number"),
        ("0x10", "`0x10` is not a number"),
        ("NaN", "`NaN` is not a finite number"),
        ("-inf", "`-inf` is not a finite number"),
        ("1e999", "`1e999` is not a finite number"),
        ("1e300", "`1e300` is larger than any measurement"),
    ];
    for (field, what) in cases {
        let text = format!("t_s,u_v,motor_angle_rad\r\n0,1,0\r\n0.1,{field},0\r\n");
        assert_eq!(error(&text), format!("log.csv:3: column u_v: {what}{help}"));
    }
}

#[test]
fn time_must_be_there_and_rise() {
    assert_eq!(
        error("t_s,u_v,motor_angle_rad\n0,1,0\n\n0,1,0\n"),
        "log.csv:4: column t_s: 0 does not rise above 0\n  \
         help: time must rise strictly; sort the rows and remove repeated times"
    );
    assert_eq!(
        error("t_s,u_v,motor_angle_rad\n0,1,0\n,1,0\n"),
        "log.csv:3: column t_s: the time is missing\n  \
         help: every row needs a time; remove the row or give it one"
    );
}

#[test]
fn a_header_that_lacks_a_column_is_explained() {
    let cases = [
        (
            "time,u_v,motor_angle_rad\n0,1,0\n",
            "log.csv:1: column t_s is missing\n  help: name the columns as in docs/log-format.md; \
             found: time, u_v, motor_angle_rad",
        ),
        (
            "0,1,0\n1,1,0\n",
            "log.csv:1: column t_s is missing\n  help: the first row must name the columns",
        ),
        (
            "t_s;u_v;motor_angle_rad\n0;1;0\n",
            "log.csv:1: column t_s is missing\n  help: columns are separated by commas",
        ),
        (
            "t_s,u_v\n0,1\n1,1\n",
            "log.csv:1: column motor_angle_rad is missing\n  help: name the columns as in \
             docs/log-format.md; found: t_s, u_v",
        ),
        (
            "t_s,u_v,u_v,motor_angle_rad\n0,1,1,0\n1,1,1,0\n",
            "log.csv:1: column u_v is there twice\n  help: rename or remove one",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(error(text), expected);
    }
}

#[test]
fn a_log_without_enough_rows_is_an_error() {
    let header = "t_s,u_v,motor_angle_rad\n";
    assert_eq!(error(""), "log.csv: is empty\n  help: a log is one header row and then numbers");
    let help = "\n  help: a log needs at least two samples";
    assert_eq!(error(header), format!("log.csv: has a header and no rows{help}"));
    assert_eq!(error(&format!("{header}0,1,0\n")), format!("log.csv: has only one row{help}"));
}

#[test]
fn a_row_cut_short_is_an_error() {
    assert_eq!(
        error("t_s,u_v,motor_angle_rad\n0,1,0\n0.1,2\n"),
        "log.csv:3: the row has 2 fields, the header 3\n  \
         help: complete the row, with empty fields where values are missing"
    );
}

#[test]
fn a_file_that_is_no_text_is_an_error_and_no_panic() {
    let bytes = b"t_s,u_v,motor_angle_rad\n0,\xff\xfe,0\n";
    let error = Log::parse(bytes, Path::new("log.csv"), Need::Drive).unwrap_err();
    assert_eq!(
        error.to_string(),
        "log.csv:2: is not UTF-8 text\n  help: save the log as plain CSV text"
    );
}

fn values(rows: usize) -> impl Strategy<Value = Vec<f64>> {
    let field = prop_oneof![
        // What single precision holds is taken.
        4 => (prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO)
            .prop_map(|value| value % 1e38),
        1 => Just(f64::NAN),
    ];
    // A column without any value is not kept, so the first one is there.
    (-1e3..1e3, prop::collection::vec(field, rows - 1))
        .prop_map(|(first, rest)| std::iter::once(first).chain(rest).collect())
}

prop_compose! {
    fn logs()(steps in prop::collection::vec(1e-9..10.0, 2..20), start in -1e3..1e3)(
        time_s in Just(steps.iter().scan(start, |t, step| { *t += step; Some(*t) }).collect::<Vec<f64>>()),
        current_a in values(steps.len()),
        motor_angle_rad in values(steps.len()),
        optional in prop::collection::vec(prop::option::of(values(steps.len())), 6),
    ) -> Log {
        let mut optional = optional.into_iter();
        let mut next = || optional.next().flatten();
        Log {
            time_s,
            voltage_v: next(),
            current_a: Some(current_a),
            motor_angle_rad,
            output_angle_rad: next(),
            load_torque_nm: next(),
            bus_v: next(),
            temperature_c: next(),
            reference_angle_rad: next(),
        }
    }
}

/// The columns with their values as bits, so that NaN equals NaN and −0 is not 0.
fn bits(log: &Log) -> Vec<(&'static str, Vec<Option<u64>>)> {
    let bits = |values: &[f64]| {
        values.iter().map(|v| (!v.is_nan()).then(|| v.to_bits())).collect::<Vec<_>>()
    };
    log.columns().into_iter().map(|(name, values)| (name, bits(values))).collect()
}

proptest! {
    #[test]
    fn reading_what_was_written_gives_the_same_log(log in logs()) {
        let (back, warnings) = parse(&log.to_csv()).map_err(TestCaseError::fail)?;
        prop_assert_eq!(bits(&back), bits(&log));
        prop_assert_eq!(warnings, Vec::<String>::new());
    }

    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = Log::parse(&bytes, Path::new("log.csv"), Need::Drive);
        let mut text = b"t_s,i_a,motor_angle_rad\n".to_vec();
        text.extend(&bytes);
        let _ = Log::parse(&text, Path::new("log.csv"), Need::Nothing);
    }
}
