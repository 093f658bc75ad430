//! Forty drawn joints and what discovery says of each, as a table: a change of any rule shows there.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use host_harness::score::{Row, rows};

/// The joints that are drawn, and which.
const DRAWS: &str = "40";
const SEED: &str = "40";
const TABLE: &str = include_str!("draws.txt");

fn line(row: &Row) -> String {
    let effects = row.names.iter().zip(&row.shares).zip(&row.confidences);
    let effects: Vec<String> = effects
        .map(|((name, [share, _]), confidence)| {
            format!("{name} {:.1} {confidence:.1}", share.unwrap_or(0.0))
        })
        .collect();
    let possible: Vec<String> = row.possible.iter().map(|name| format!("? {name}")).collect();
    let told = [effects, possible].concat().join(", ");
    format!("{} | {} | {} | {told}", row.case, row.truth, row.verdict)
}

/// Shares and confidences to a tenth: fits may end some bits elsewhere on another machine's mathematics.
#[test]
fn forty_draws_are_answered_as_the_table_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("scores");
    let run = Command::new(env!("CARGO_BIN_EXE_joint"))
        .args(["score", "--simulate", DRAWS, "--seed", SEED, "--out"])
        .arg(&out)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let mut table =
        String::from("case | hidden | answer | effects with share and confidence; ? possible\n");
    for row in rows(&out.join("score.json")).unwrap() {
        writeln!(table, "{}", line(&row).trim_end()).unwrap();
    }
    let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join("draws.txt");
    std::fs::write(&kept, &table).unwrap();
    let changed: Vec<String> = TABLE
        .lines()
        .zip(table.lines())
        .filter(|(was, is)| was != is)
        .map(|(was, is)| format!("was {was}\nis  {is}"))
        .collect();
    assert!(
        changed.is_empty() && TABLE.lines().count() == table.lines().count(),
        "{}\nwhere this is right, copy {} to host-harness/tests/draws.txt",
        changed.join("\n"),
        kept.display()
    );
}
