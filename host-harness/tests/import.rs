//! `joint import` from outside: good recordings in every way of writing, bad ones with their messages.

use std::path::Path;
use std::process::{Command, Output};

use host_harness::import::map::Map;
use host_harness::import::settings::Settings;
use host_harness::import::{Imported, import};
use host_harness::log::{Log, Need, compressed};
use proptest::prelude::*;

fn joint(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_joint")).args(arguments).current_dir(folder).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn imported(raw: &str, map: &str) -> Imported {
    let map = Map::parse(map).unwrap_or_else(|error| panic!("{error}"));
    import(raw, Path::new("raw.csv"), Some(&map), &Settings::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

const MAP: &str = "t=time:ms, i=iq:mA, motor=pos:rev";

/// The same three samples in every way of writing.
#[test]
fn every_dialect_gives_the_same_log() {
    let plain = "time,iq,pos\n0,1500,0.25\n1,-250.5,0.5\n2.5,0,0.75\n";
    let expected = imported(plain, MAP).log;
    assert_eq!(expected.time_s, [0.0, 0.001, 0.0025]);
    assert_eq!(expected.current_a, Some(vec![1.5, -0.2505, 0.0]));
    let comma = plain.replace(',', ";").replace('.', ",");
    let dialects = [
        ("semicolons", plain.replace(',', ";")),
        ("semicolons and decimal commas", comma.clone()),
        ("tabs", plain.replace(',', "\t")),
        ("tabs and decimal commas", comma.replace(';', "\t")),
        ("bars", plain.replace(',', " | ")),
        ("spaces", plain.replace(',', "   ")),
        ("spaces after commas", plain.replace(',', ", ")),
        ("a separator at the end", plain.replace('\n', ",\n")),
        ("CRLF", plain.replace('\n', "\r\n")),
        ("blank lines", plain.replace('\n', "\n\n")),
        ("comments", format!("# by hand\n{}% end\n", plain.replace("1,-", "// here\n1,-"))),
        ("a row of units", plain.replace("pos\n", "pos\nms,mA,rev\n")),
        ("a row of units in brackets", plain.replace("pos\n", "pos\n[ms],[mA],[rev]\n")),
        ("a preamble", format!("Recorder 7\nSerial number: 12\n\n{plain}")),
        ("names in a comment", format!("# {plain}")),
        (
            "quotes",
            plain.replace("time,iq,pos", "\"time\",\"iq\",\"pos\"").replace("0.25", "\"0.25\""),
        ),
        (
            "a column of text",
            plain.replace("pos\n", "pos,state\n").replace("5\n", "5,\"on, hot\"\n"),
        ),
        (
            "other columns",
            plain
                .replace("time", "x,time")
                .replace("\n0", "\n9,0")
                .replace("\n1", "\n9,1")
                .replace("\n2", "\n9,2"),
        ),
        ("exponents", plain.replace("1500", "1.5E+3").replace("0.25", "2.5e-1")),
        ("a plus sign", plain.replace("1500", "+1500")),
    ];
    for (what, text) in dialects {
        assert_eq!(imported(&text, MAP).log, expected, "{what}");
    }
}

#[test]
fn marks_encodings_and_compression_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let text = "time [µs];iq [mA];pos [°]\n0;1,5;10\n250;2,5;20\n";
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let files = [
        ("plain.csv", text.as_bytes().to_vec()),
        ("mark.csv", [b"\xef\xbb\xbf", text.as_bytes()].concat()),
        ("wide.csv", [b"\xff\xfe".as_slice(), &wide].concat()),
        ("latin.csv", latin),
        ("packed.csv.gz", compressed(text)),
        ("packed_too.csv", compressed(text)),
    ];
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        let map = "t=time, i=iq, motor=pos";
        let output =
            joint(folder.path(), &["import", name, "--map", map, "--out", "log.csv", "--force"]);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", stderr(&output));
        let log = Log::read(&folder.path().join("log.csv"), Need::Drive).unwrap().log;
        assert_eq!(log.time_s, [0.0, 0.00025], "{name}");
        assert_eq!(log.current_a, Some(vec![0.0015, 0.0025]), "{name}");
        assert_eq!(log.motor_angle_rad, [10.0_f64.to_radians(), 20.0_f64.to_radians()], "{name}");
    }
}

#[test]
fn sign_scale_offset_and_product_give_the_log_in_si_units() {
    let raw = "t_ms,duty,vbus,iq,enc,deg,tq,temp,ref\n0,50,24,100,1024,90,20,300,0.5\n1,25,24,200,2048,180,-20,310,1\n";
    let map = "t=t_ms, u=duty*vbus:V/100, i=-iq:mA*1.22+3, motor=enc:counts-1024/4096, output=-deg:deg, load=tq:mNm, bus=vbus:V, temperature=temp:K-0.85, reference=ref:rev";
    let log = imported(raw, map).log;
    assert_eq!(log.voltage_v, Some(vec![12.0, 6.0]));
    assert_eq!(log.current_a, Some(vec![-0.119, -0.241]));
    assert_eq!(log.motor_angle_rad, [0.0, std::f64::consts::FRAC_PI_2]);
    assert_eq!(log.output_angle_rad, Some(vec![-90f64.to_radians(), -180f64.to_radians()]));
    assert_eq!(log.load_torque_nm, Some(vec![0.02, -0.02]));
    // 300 - 0.85 - 273.15 = 26, in two roundings of a number below 512.
    assert!((log.temperature_c.unwrap()[0] - 26.0).abs() < 2e-13);
    assert_eq!(log.reference_angle_rad, Some(vec![std::f64::consts::PI, std::f64::consts::TAU]));
}

#[test]
fn an_angle_that_wraps_goes_on_and_stays_where_that_is_asked_for() {
    let row = |k: i32| format!("{k},0,{}\n", (350 + 7 * k) % 360);
    let raw = format!("t,i,pos\n{}", (0..40).map(row).collect::<String>());
    let map = Map::parse("t=t:ms, i=i:A, motor=pos:deg").unwrap();
    let log =
        |settings: &Settings| import(&raw, Path::new("raw.csv"), Some(&map), settings).unwrap();
    let on = log(&Settings::default());
    assert_eq!(on.signals[2].unwrapped, 1);
    assert!(on.notes.iter().any(|note| note.contains("jumps by a turn 1 times")), "{:?}", on.notes);
    for (k, angle) in on.log.motor_angle_rad.iter().enumerate() {
        // Two roundings of an angle below 16 rad.
        assert!((angle - (350.0 + 7.0 * k as f64).to_radians()).abs() < 4e-15);
    }
    let off = log(&Settings { unwrap: Some(false), ..Settings::default() });
    assert!(off.log.motor_angle_rad.iter().all(|angle| *angle < std::f64::consts::TAU));
    assert!(off.notes.iter().any(|note| note.contains("unwrap motor_angle_rad")));
}

#[test]
fn repeated_times_clocks_that_begin_anew_and_rows_without_a_value() {
    let folder = tempfile::tempdir().unwrap();
    let raw = "t,i,pos\n0,1,0\n250,,\n4294967040,2,0.1\n4294967040,2,0.1\n500,3,0.2\n";
    std::fs::write(folder.path().join("raw.csv"), raw).unwrap();
    let map = "t=t:us wrap=4294967296, i=i:A, motor=pos:rad";
    let output = joint(
        folder.path(),
        &["import", "raw.csv", "--map", map, "--out", "log.csv", "--drop-repeated", "--json"],
    );
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["samples"], 3, "{}", stderr(&output));
    let log = Log::read(&folder.path().join("log.csv"), Need::Drive).unwrap().log;
    // Doubles near 4295 s are 9.1e-13 s apart; two of them are subtracted.
    assert!((log.time_s[2] - log.time_s[1] - 756e-6).abs() < 1e-12);
    assert!(stderr(&output).contains("1 rows hold no value"), "{}", stderr(&output));
    assert!(stderr(&output).contains("1 rows repeat the time before"), "{}", stderr(&output));
}

/// From the recorder's file to a log that the other verbs read, with the map kept for the next one.
#[test]
fn a_recording_becomes_a_log_and_its_map_serves_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let row = |k: i32| format!("{};{};{};{},5\n", k * 2, 100 + k, 4000 + 10 * k, k);
    let raw = format!("time_ms;iq;pos;out_deg\n{}", (0..50).map(row).collect::<String>());
    std::fs::write(folder.path().join("raw.csv"), &raw).unwrap();
    let map = "t=time_ms, i=iq:mA*1.22, motor=pos:counts/4096, output=out_deg";
    let first = joint(
        folder.path(),
        &["import", "raw.csv", "--map", map, "--out", "log.csv.gz", "--save-map", "map.toml"],
    );
    assert_eq!(first.status.code(), Some(0), "{}", stderr(&first));
    let told = String::from_utf8(first.stdout.clone()).unwrap();
    assert!(told.starts_with("log.csv.gz: 50 samples, 0.098 s at 500 Hz"), "{told}");
    let second =
        joint(folder.path(), &["import", "raw.csv", "--map", "map.toml", "--out", "two.csv"]);
    assert_eq!(second.status.code(), Some(0), "{}", stderr(&second));
    let read = |name: &str| Log::read(&folder.path().join(name), Need::Drive).unwrap();
    assert_eq!(read("log.csv.gz"), read("two.csv"));
    let log = read("two.csv");
    assert_eq!(log.warnings, Vec::<String>::new());
    assert_eq!(log.log.len(), 50);
    // 1.22 has no exact double: one rounding each of the product and of the quotient.
    assert!((log.log.current_a.unwrap()[7] - 0.13054).abs() < 1e-16);
    assert_eq!(log.log.output_angle_rad.unwrap()[2], 2.5_f64.to_radians());
    let again =
        joint(folder.path(), &["import", "raw.csv", "--map", "map.toml", "--out", "two.csv"]);
    assert_eq!(again.status.code(), Some(2), "an earlier log is not replaced");
    let resampled = joint(
        folder.path(),
        &["import", "raw.csv", "--map", "map.toml", "--out", "even.csv", "--resample", "1000"],
    );
    assert_eq!(resampled.status.code(), Some(0), "{}", stderr(&resampled));
    assert_eq!(read("even.csv").log.len(), 99);
}

/// A command of the worked example, as the page has it.
fn documented(verb: &str) -> Vec<String> {
    let page = include_str!("../../docs/import.md");
    let example = page.split("# A worked example").nth(1).unwrap();
    let start = format!("joint {verb} ");
    let line = example.lines().find(|line| line.starts_with(&start)).unwrap();
    // A shell's quotes, as far as the page uses them: pairs of double ones.
    let parts = line.split('"').enumerate();
    let words = parts.flat_map(|(k, part)| match k % 2 {
        0 => part.split_whitespace().map(str::to_owned).collect(),
        _ => vec![part.to_owned()],
    });
    words.skip(1).collect()
}

/// The page's own commands on a recording of a joint like its own, with cogging: the log is what the
/// joint did, to half a count and to the digits of the recorder.
#[test]
fn the_worked_example_gives_a_model_and_a_log_that_belong_together() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[String]| {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = joint(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
    };
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let path = |name: &str| folder.path().join(name);
    run(&documented("new"));
    let nominal = std::fs::read_to_string(path("arm.toml")).unwrap();
    let cogging =
        "\n[[effect]]\nkind = \"cogging\"\nlocation = \"motor\"\norder = 12\namplitude_nm = 1e-3\n";
    std::fs::write(path("truth.toml"), nominal + cogging).unwrap();
    let voltage = |k: u32| 6.0 * (f64::from(k) * 2e-4 * 9.0).sin();
    let inputs: String =
        (0..1500).map(|k| format!("{},{:.1},0\n", f64::from(k) * 2e-4, voltage(k))).collect();
    std::fs::write(path("in.csv"), format!("t_s,u_v,motor_angle_rad\n{inputs}")).unwrap();
    run(&words("simulate --model truth.toml --input in.csv --out did.csv"));
    let mut did = csv::Reader::from_path(path("did.csv")).unwrap();
    let header = did.headers().unwrap().clone();
    let at = |name: &str| header.iter().position(|own| own == name).unwrap();
    let names = ["t_s", "u_v", "current_a", "motor_angle_rad", "stage1_angle_rad"].map(at);
    let did: Vec<[f64; 5]> = did
        .records()
        .map(|row| {
            let row = row.unwrap();
            names.map(|at| row[at].parse().unwrap())
        })
        .collect();
    let counts = |angle: f64, turn: f64| (angle / std::f64::consts::TAU * turn).round();
    let mut raw = String::from("time_ms;u;iq;pos;out\n");
    for [t, u, i, motor, output] in &did {
        let (t, i) = (t * 1e3, i * 1e3);
        let (motor, output) = (counts(*motor, 4096.0), counts(*output, 65536.0));
        raw.push_str(&format!("{t:.1};{u:.1};{i:.1};{motor};{output}\n").replace('.', ","));
    }
    std::fs::write(path("raw.csv"), raw).unwrap();
    run(&documented("import"));
    let log = Log::read(&path("log.csv"), Need::Drive).unwrap();
    assert_eq!(log.warnings, Vec::<String>::new());
    let log = log.log;
    let (current, output) = (log.current_a.unwrap(), log.output_angle_rad.unwrap());
    assert!(did.iter().any(|own| own[3].abs() > 10.0), "the joint has turned");
    for (k, [t, _, i, motor, out]) in did.iter().enumerate() {
        assert!((log.time_s[k] - t).abs() < 1e-12);
        // Half of the last digit, 0.05 mA, and half a count, with a rounding to spare.
        assert!((current[k] - i).abs() < 0.051e-3, "{k}");
        let half_count = std::f64::consts::PI / 4096.0;
        assert!((log.motor_angle_rad[k] - motor).abs() < 1.001 * half_count, "{k}");
        assert!((output[k] - out).abs() < 1.001 * half_count / 16.0, "{k}");
    }
    run(&words("simulate --model arm.toml --input log.csv --out simulated.csv"));
}

#[test]
fn presets_read_what_their_drives_write() {
    let vesc = "ms_today;input_voltage;temp_mos_max;temp_motor;current_motor;d_axis_current;q_axis_current;erpm;duty_cycle;tachometer;encoder_position;d_axis_voltage;q_axis_voltage;\n80069026;55.3;24;26.9;0;0;1.0;0;0;69465;359.4;0.001;2.0;\n80069126;55.3;24;26.9;0;0;2.0;0;0;69465;1.4;0.001;-1.0;\n80069126;55.3;24;26.9;0;0;2.0;0;0;69465;1.4;0.001;-1.0;\n80069226;55.3;24;26.9;0;0;2.0;0;0;69465;2.4;0.001;-1.0;\n";
    let odrive = "time,odrv0.axis0.motor.foc.Iq_measured,odrv0.axis0.pos_estimate,odrv0.vbus_voltage\n0,1,0.5,24\n0.01,2,0.75,24\n";
    let moteus = "timestamp,servo_stats.q_A,servo_stats.position,servo_control.q_V\n0,1,0.5,2\n0.01,2,0.75,2\n";
    let simplefoc = "0.0\t2.0\t0\t1000\t0\t0.1\t0.5\n0.0\t1.0\t0\t2000\t0\t0.1\t0.75\n";
    let folder = tempfile::tempdir().unwrap();
    let log = |preset: &str, raw: &str, more: &[&str]| {
        std::fs::write(folder.path().join("raw.csv"), raw).unwrap();
        let arguments = ["import", "raw.csv", "--preset", preset, "--out", "log.csv", "--force"];
        let output = joint(folder.path(), &[&arguments[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{preset}: {}", stderr(&output));
        Log::read(&folder.path().join("log.csv"), Need::Drive).unwrap().log
    };
    let half_root_three = 0.866_025_403_784_438_6;
    let current = Some(vec![half_root_three, 2.0 * half_root_three]);
    let turns = vec![std::f64::consts::PI, 1.5 * std::f64::consts::PI];
    assert_eq!(log("odrive", odrive, &[]).current_a, current);
    assert_eq!(log("odrive", odrive, &[]).motor_angle_rad, turns);
    assert_eq!(log("moteus", moteus, &[]).current_a, current);
    assert_eq!(log("moteus", moteus, &[]).voltage_v, Some(vec![2.0 * 3f64.sqrt(); 2]));
    let monitor = log("simplefoc", simplefoc, &["--rate", "100"]);
    assert_eq!((monitor.time_s, monitor.current_a), (vec![0.0, 0.01], current));
    assert_eq!(monitor.motor_angle_rad, [0.5, 0.75]);
    let vesc = log("vesc", vesc, &[]);
    assert_eq!(vesc.time_s.len(), 3, "a repeated row is left out");
    assert!((vesc.time_s[2] - 0.2).abs() < 1e-9, "80,069 s have a spacing of 1.5e-11 s");
    assert!((vesc.motor_angle_rad[1] - 361.4_f64.to_radians()).abs() < 1e-14, "wrapped");
}

/// Every bad import with its message, as a person sees it. `UPDATE_SNAPSHOTS=1 cargo test -p
/// host-harness --test import` writes the table anew; its diff is what to read. With the feature
/// `formats`, some of the files are read.
#[cfg(not(feature = "formats"))]
#[test]
fn every_bad_import_says_where_it_is_wrong_and_what_to_do() {
    let mut table = String::new();
    let cases = cases();
    assert!(cases.len() >= 40);
    for (title, raw, arguments) in cases {
        let folder = tempfile::tempdir().unwrap();
        if let Some(raw) = raw {
            std::fs::write(folder.path().join("raw.csv"), raw).unwrap();
        }
        std::fs::write(folder.path().join("map.toml"), BAD_MAP_FILE).unwrap();
        let output = joint(folder.path(), &[&["import", "raw.csv"], &arguments[..]].concat());
        assert_eq!(output.status.code(), Some(2), "{title}: {}", stderr(&output));
        assert!(output.stdout.is_empty(), "{title}");
        assert!(!folder.path().join("log.csv").exists(), "{title}");
        let text = stderr(&output);
        assert!(text.contains("help:") || text.contains("For more information"), "{title}: {text}");
        table.push_str(&format!("== {title}\n{text}\n"));
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/bad_imports.txt");
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(&path, &table).unwrap();
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    for (own, known) in table.lines().zip(known.lines()) {
        assert_eq!(own, known, "differs from {}", path.display());
    }
    assert_eq!(table.len(), known.len(), "differs from {}", path.display());
}

#[cfg(not(feature = "formats"))]
const BAD_MAP_FILE: &str =
    "[settings]\nseparator = \"dot\"\n[[signal]]\nname = \"t\"\ncolumn = \"t\"\n";

#[cfg(not(feature = "formats"))]
type Case = (&'static str, Option<Vec<u8>>, Vec<&'static str>);

#[cfg(not(feature = "formats"))]
fn cases() -> Vec<Case> {
    const GOOD: &str = "t=t:ms, i=i:A, motor=pos:deg";
    let raw = "t,i,pos\n0,1,2\n1,2,3\n2,3,4\n";
    let with = |title, raw: &str, map| {
        (title, Some(raw.as_bytes().to_vec()), vec!["--out", "log.csv", "--map", map])
    };
    let bytes =
        |title, raw: &[u8]| (title, Some(raw.to_vec()), vec!["--out", "log.csv", "--map", GOOD]);
    let more = |title, more: &[&'static str]| {
        let arguments = [&["--out", "log.csv"], more].concat();
        (title, Some(raw.as_bytes().to_vec()), arguments)
    };
    vec![
        ("no file", None, vec!["--out", "log.csv", "--map", GOOD]),
        with("an empty file", "", GOOD),
        with("comments alone", "# nothing\n% here\n", GOOD),
        with("a header alone", "t,i,pos\n", GOOD),
        with("one row", "t,i,pos\n0,1,2\n", GOOD),
        with("a page of text", "<html>\n<body>\nno table\n</body>\n", GOOD),
        bytes("a Parquet file", b"PAR1\x15\x04"),
        bytes("a MATLAB file", b"MATLAB 5.0 MAT-file, Platform: GLNXA64"),
        bytes("a MATLAB file since 7.3", b"\x89HDF\r\n\x1a\n"),
        bytes("an MCAP file", b"\x89MCAP0\r\n"),
        bytes("a spreadsheet", b"PK\x03\x04\x14"),
        bytes("bytes of zero", b"t,i,pos\n0,1,\x00\n"),
        bytes("a compressed file cut short", &compressed(raw)[..20]),
        more("no map and no name of a log's", &[]),
        with("an empty map", raw, ""),
        with("an unknown signal", raw, "t=t:ms, torque=i:A, motor=pos:deg"),
        with("a signal without a name", raw, "t=t:ms, =i:A, motor=pos:deg"),
        with("a signal without a column", raw, "t=t:ms, i, motor=pos:deg"),
        with("a signal with an empty column", raw, "t=t:ms, i=:A, motor=pos:deg"),
        with("a signal mapped twice", raw, "t=t:ms, i=i:A, motor=pos:deg, i=pos:A"),
        with("a quote that is not closed", raw, "t=t:ms, i='i:A, motor=pos:deg"),
        with("text behind a quote", raw, "t=t:ms, i='i'x:A, motor=pos:deg"),
        with("an unknown unit", raw, "t=t:ms, i=i:A, motor=pos:degg"),
        with("a unit of something else", raw, "t=t:ms, i=i:deg, motor=pos:deg"),
        with("a unit in the wrong case", raw, "t=t:MS, i=i:A, motor=pos:deg"),
        with("an empty unit", raw, "t=t:ms, i=i:, motor=pos:deg"),
        with("counts without the counts of a turn", raw, "t=t:ms, i=i:A, motor=pos:counts"),
        with("a scale without a number", raw, "t=t:ms, i=i:A*, motor=pos:deg"),
        with("a scale of zero", raw, "t=t:ms, i=i:A*0, motor=pos:deg"),
        with("a scale that is no number", raw, "t=t:ms, i=i:A*two, motor=pos:deg"),
        with("an operation that is none", raw, "t=t:ms, i=i:A*2^3, motor=pos:deg"),
        with("a period of zero", raw, "t=t:ms, i=i:A, motor=pos:deg wrap=0"),
        with("a period of a current", raw, "t=t:ms, i=i:A wrap=5, motor=pos:deg"),
        with("a column that is not there", raw, "t=t:ms, i=iq:A, motor=pos:deg"),
        with("a column in another case", raw, "t=t:ms, i=I:A, motor=pos:deg"),
        with("a column past the last", raw, "t=t:ms, i=#4:A, motor=pos:deg"),
        with("a second factor that is not there", raw, "t=t:ms, u=i*vbus:V, motor=pos:deg"),
        with("a name that fits two columns", "t,a.i,b.i,pos\n0,1,1,2\n1,1,2,3\n", GOOD),
        with("no time", raw, "i=i:A, motor=pos:deg"),
        with("no rotor angle", raw, "t=t:ms, i=i:A, output=pos:deg"),
        with("neither voltage nor current", raw, "t=t:ms, motor=pos:deg"),
        with("a current without a value", "t,i,pos\n0,,2\n1,,3\n2,,4\n", GOOD),
        with("text for a number", "t,i,pos\n0,1,2\n1,hot,3\n2,3,4\n", GOOD),
        with("an infinite number", "t,i,pos\n0,1,2\n1,inf,3\n2,3,4\n", GOOD),
        with("a time of day", "t,i,pos\n0:00:01.5,1,2\n0:00:02.5,1,3\n0:00:03.5,3,4\n", GOOD),
        with("thousands between commas", "t;i;pos\n0;1.5;2\n1;1,500;3\n2;3;4\n", GOOD),
        with("a point and a comma", "t;i;pos\n0;1;2\n1;1.500,5;3\n2;3;4\n", GOOD),
        with(
            "decimal commas between commas",
            "t,i,pos\n0,0,1,5,2,0\n1,0,1,5,3,0\n2,0,1,5,3,0\n",
            GOOD,
        ),
        with("a row too short", "t,i,pos\n0,1,2\n\n1,2\n2,3,4\n", GOOD),
        with("a row too long", "t;i;pos\n0;1;2\n1;2;3;4\n2;3;4\n", GOOD),
        with("a time that is missing", "t,i,pos\n0,1,2\n,2,3\n2,3,4\n", GOOD),
        with("a time that stands still", "t,i,pos\n0,1,2\n0,2,3\n2,3,4\n", GOOD),
        with("a time that runs back", "t,i,pos\n0,1,2\n5,2,3\n# reset\n2,3,4\n", GOOD),
        more("another separator than stated", &["--map", GOOD, "--separator", "tab"]),
        more("a separator that is none", &["--map", GOOD, "--separator", "dot"]),
        more("fewer names than columns", &["--map", GOOD, "--names", "t,i"]),
        more("another drive's preset", &["--preset", "vesc"]),
        more("a preset of several names", &["--preset", "odrive", "--map", "t=t:s,i=i:A"]),
        more("a preset that is none", &["--preset", "odrivee"]),
        more("a rate beside a time", &["--map", GOOD, "--rate", "100"]),
        more("a rate of zero", &["--map", "i=i:A, motor=pos:deg", "--rate", "0"]),
        more("resampled to nothing", &["--map", GOOD, "--resample", "nan"]),
        more("a map file that is not there", &["--map", "none.toml"]),
        more("a map file with a wrong setting", &["--map", "map.toml"]),
        ("no place to write to", Some(raw.as_bytes().to_vec()), vec!["--map", GOOD]),
        ("a folder to write to", Some(raw.as_bytes().to_vec()), vec!["--map", GOOD, "--out", "."]),
        (
            "a preset without a header that fits",
            Some(b"1\t2\t3\n2\t3\t4\n".to_vec()),
            vec!["--preset", "simplefoc", "--rate", "100", "--out", "log.csv"],
        ),
    ]
}

/// Numbers as measured ones are: of many sizes, none of them a turn apart.
fn angles(samples: usize) -> impl Strategy<Value = Vec<f64>> + Clone {
    prop::collection::vec(-0.5..0.5_f64, samples).prop_map(|steps| {
        let mut angle = 0.0;
        steps
            .into_iter()
            .map(|step| {
                angle += step;
                angle
            })
            .collect()
    })
}

fn measured(samples: usize) -> impl Strategy<Value = Vec<f64>> + Clone {
    let value = prop_oneof![8 => -1e3..1e3_f64, 1 => -1e-6..1e-6_f64, 1 => Just(0.0)];
    prop::collection::vec(value, samples)
}

fn logs() -> impl Strategy<Value = Log> {
    (2..60_usize).prop_flat_map(|samples| {
        let steps = prop::collection::vec(1e-6..1.0_f64, samples);
        let optional = prop::option::of(measured(samples));
        let angle = prop::option::of(angles(samples));
        let rest = (optional.clone(), optional.clone(), optional, angle.clone(), angle);
        (steps, measured(samples), angles(samples), rest, -5.0..5.0_f64).prop_map(
            |(steps, current, motor, (voltage, load, bus, output, reference), start)| {
                let mut time = start;
                Log {
                    time_s: steps
                        .into_iter()
                        .map(|step| {
                            time += step;
                            time
                        })
                        .collect(),
                    current_a: Some(current),
                    voltage_v: voltage,
                    motor_angle_rad: motor,
                    output_angle_rad: output,
                    load_torque_nm: load,
                    bus_v: bus,
                    temperature_c: None,
                    reference_angle_rad: reference,
                }
            },
        )
    })
}

proptest! {
    #[test]
    fn a_log_that_is_exported_and_imported_is_the_same(log in logs()) {
        let back = import(&log.to_csv(), Path::new("log.csv"), None, &Settings::default()).unwrap();
        prop_assert_eq!(&back.log, &log);
        let units = back.notes.iter().any(|note| note.contains("taken as"));
        prop_assert!(!units, "a log's own names have their units: {:?}", back.notes);
    }

    /// Whatever the text, an import ends in a log or in an error that names the file.
    #[test]
    fn no_text_is_a_panic(raw in "[0-9a-z.,;\\-#\\t\\n \"]{0,200}", map in "[a-z=:,*'/+0-9 -]{0,60}") {
        if let Ok(map) = Map::parse(&map) {
            let _ = import(&raw, Path::new("raw.csv"), Some(&map), &Settings::default());
        }
        let good = Map::parse("t=#1:ms, i=#2:A, motor=#3:deg").unwrap();
        if let Err(error) = import(&raw, Path::new("raw.csv"), Some(&good), &Settings::default()) {
            prop_assert!(error.to_string().starts_with("raw.csv"));
        }
    }
}
