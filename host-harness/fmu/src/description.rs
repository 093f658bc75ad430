//! `modelDescription.xml`: what an importing tool reads before it loads the library.

use std::fmt::Write;

use crate::fmi3;
use crate::joint::{Causality, Joint, Variable};

/// A version of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.4.
    Fmi2,
    /// FMI 3.0.2.
    Fmi3,
}

impl std::fmt::Display for Version {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Fmi2 => "FMI 2.0",
            Self::Fmi3 => "FMI 3.0",
        })
    }
}

/// Endings of names and what they mean, the longest first.
const UNITS: [(&str, &str, &str); 15] = [
    ("_v_s_per_rad", "V.s/rad", "kg=\"1\" m=\"2\" s=\"-2\" A=\"-1\" rad=\"-1\""),
    ("_nm_s_per_rad", "N.m.s/rad", "kg=\"1\" m=\"2\" s=\"-1\" rad=\"-1\""),
    ("_nm_per_rad3", "N.m/rad3", "kg=\"1\" m=\"2\" s=\"-2\" rad=\"-3\""),
    ("_nm_per_rad", "N.m/rad", "kg=\"1\" m=\"2\" s=\"-2\" rad=\"-1\""),
    ("_nm_per_a", "N.m/A", "kg=\"1\" m=\"2\" s=\"-2\" A=\"-1\""),
    ("_rad_per_s", "rad/s", "s=\"-1\" rad=\"1\""),
    ("_kg_m2", "kg.m2", "kg=\"1\" m=\"2\""),
    ("_per_s", "1/s", "s=\"-1\""),
    ("_ohm", "Ohm", "kg=\"1\" m=\"2\" s=\"-3\" A=\"-2\""),
    ("_rad", "rad", "rad=\"1\""),
    ("_nm", "N.m", "kg=\"1\" m=\"2\" s=\"-2\""),
    ("_a", "A", "A=\"1\""),
    ("_v", "V", "kg=\"1\" m=\"2\" s=\"-3\" A=\"-1\""),
    ("_h", "H", "kg=\"1\" m=\"2\" s=\"-2\" A=\"-2\""),
    ("_s", "s", "s=\"1\""),
];

fn unit(name: &str) -> Option<&'static str> {
    UNITS.iter().find(|(end, ..)| name.ends_with(end)).map(|(_, unit, _)| *unit)
}

/// The XML text; `identifier` is the shared library's name, and the same contents give the same `guid`, which
/// FMI 3.0 calls the instantiation token.
pub fn model_description(joint: &Joint, version: Version, identifier: &str, guid: &str) -> String {
    let variables = joint.variables();
    let (number, token) = match version {
        Version::Fmi2 => ("2.0", "guid"),
        Version::Fmi3 => ("3.0", "instantiationToken"),
    };
    let mut text = String::new();
    // Writing into a string does not fail.
    let _ = write!(
        text,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"{number}\" modelName=\"{}\" {token}=\"{guid}\" \
         description=\"A motor joint: motor, elastic gear stages, LuGre friction, effects\" \
         generationTool=\"joint export {}\" variableNamingConvention=\"structured\">\n  \
         <CoSimulation modelIdentifier=\"{identifier}\" \
         canHandleVariableCommunicationStepSize=\"true\" {}/>\n  \
         <UnitDefinitions>\n",
        escaped(&joint.name),
        env!("CARGO_PKG_VERSION"),
        capabilities(version, joint.period_s),
    );
    for (_, unit, base) in UNITS {
        let _ = writeln!(text, "    <Unit name=\"{unit}\"><BaseUnit {base}/></Unit>");
    }
    text.push_str("  </UnitDefinitions>\n");
    if version == Version::Fmi3 {
        let _ = writeln!(
            text,
            "  <LogCategories><Category name=\"{}\" description=\"Why a call was refused\"/>\
             </LogCategories>",
            fmi3::CATEGORY.to_string_lossy()
        );
    }
    let _ = write!(
        text,
        "  <DefaultExperiment startTime=\"0\" stopTime=\"1\" stepSize=\"{:?}\"/>\n  \
         <ModelVariables>\n",
        joint.period_s
    );
    for (reference, variable) in variables.iter().enumerate() {
        scalar_variable(&mut text, version, reference, variable);
    }
    if version == Version::Fmi3 {
        let _ = writeln!(
            text,
            "    <Float64 name=\"time\" valueReference=\"{}\" description=\"Time at the end of the \
             last communication step\" causality=\"independent\" variability=\"continuous\" unit=\"s\"/>",
            variables.len()
        );
    }
    text.push_str("  </ModelVariables>\n  <ModelStructure>\n");
    structure(&mut text, version, &variables);
    text.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
    text
}

fn capabilities(version: Version, period_s: f64) -> String {
    match version {
        Version::Fmi2 => "canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"".to_owned(),
        Version::Fmi3 => format!(
            "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" \
             fixedInternalStepSize=\"{period_s:?}\" hasEventMode=\"false\""
        ),
    }
}

/// Outputs are what the state gives: no input shows in them before the next step.
fn structure(text: &mut String, version: Version, variables: &[Variable]) {
    let outputs = |text: &mut String, line: &dyn Fn(usize) -> String| {
        for (k, variable) in variables.iter().enumerate() {
            if variable.causality == Causality::Output {
                text.push_str(&line(k));
            }
        }
    };
    match version {
        Version::Fmi2 => {
            for list in ["Outputs", "InitialUnknowns"] {
                let _ = writeln!(text, "    <{list}>");
                outputs(text, &|k| format!("      <Unknown index=\"{}\"/>\n", k + 1));
                let _ = writeln!(text, "    </{list}>");
            }
        }
        Version::Fmi3 => {
            outputs(text, &|k| format!("    <Output valueReference=\"{k}\" dependencies=\"\"/>\n"));
            outputs(text, &|k| format!("    <InitialUnknown valueReference=\"{k}\"/>\n"));
        }
    }
}

fn scalar_variable(text: &mut String, version: Version, reference: usize, variable: &Variable) {
    let kind = match variable.causality {
        Causality::Input => "causality=\"input\" variability=\"continuous\"",
        Causality::Output => {
            "causality=\"output\" variability=\"continuous\" initial=\"calculated\""
        }
        Causality::Parameter => "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"",
    };
    let start = variable.start.map_or(String::new(), |start| format!(" start=\"{start:?}\""));
    let unit = unit(&variable.name).map_or(String::new(), |unit| format!(" unit=\"{unit}\""));
    let [min, max] = ["min", "max"].map(|which| {
        let limit = variable.limits[usize::from(which == "max")];
        limit.map_or(String::new(), |limit| format!(" {which}=\"{limit:?}\""))
    });
    let own = format!(
        "name=\"{}\" valueReference=\"{reference}\" description=\"{}\" {kind}",
        escaped(&variable.name),
        escaped(&variable.description),
    );
    let value = format!("{unit}{min}{max}{start}");
    let _ = match version {
        Version::Fmi2 => {
            writeln!(text, "    <ScalarVariable {own}><Real{value}/></ScalarVariable>")
        }
        Version::Fmi3 => writeln!(text, "    <Float64 {own}{value}/>"),
    };
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
