//! The paper's other joints as data: the gears of 1:125 and 1:1000, and the whole joint beyond 1:10000
//! with worm and coating. The one that its figures show, 1:1024, is [`crate::scenario::paper`].

use std::path::Path;

use crate::model::Model;

/// The models that are built in, by the name of their file.
const BUILT_IN: [(&str, &str); 3] = [
    ("gear_125", include_str!("data/gear_125.toml")),
    ("gear_1000", include_str!("data/gear_1000.toml")),
    ("joint_20480", include_str!("data/joint_20480.toml")),
];

/// Every built-in joint with the name of its file.
///
/// # Errors
/// A data file that does not read: file, place and reason.
pub fn built_in() -> Result<Vec<(&'static str, Model)>, String> {
    let read = |(file, text): (&'static str, &str)| {
        let model = Model::parse(text, Path::new(&format!("{file}.toml")));
        Ok((file, model.map_err(|error| error.to_string())?))
    };
    BUILT_IN.into_iter().map(read).collect()
}

/// Input turns for one of the output.
pub fn ratio(model: &Model) -> f64 {
    model.stages.iter().map(|stage| stage.reduction).product()
}
