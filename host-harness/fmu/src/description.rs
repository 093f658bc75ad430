//! `modelDescription.xml`: what an importing tool reads before it loads the library.

use std::fmt::Write;

use crate::joint::{Causality, Joint, Variable};

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

/// The XML text of FMI 2.0.4; `identifier` is the shared library's name, and the same contents give
/// the same `guid`.
pub fn model_description(joint: &Joint, identifier: &str, guid: &str) -> String {
    let variables = joint.variables();
    let mut text = String::new();
    // Writing into a string does not fail.
    let _ = write!(
        text,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" guid=\"{guid}\" \
         description=\"A motor joint: motor, elastic gear stages, LuGre friction, effects\" \
         generationTool=\"joint export {}\" variableNamingConvention=\"structured\">\n  \
         <CoSimulation modelIdentifier=\"{identifier}\" \
         canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUstate=\"true\" \
         canSerializeFMUstate=\"true\"/>\n  \
         <UnitDefinitions>\n",
        escaped(&joint.name),
        env!("CARGO_PKG_VERSION"),
    );
    for (_, unit, base) in UNITS {
        let _ = writeln!(text, "    <Unit name=\"{unit}\"><BaseUnit {base}/></Unit>");
    }
    let _ = write!(
        text,
        "  </UnitDefinitions>\n  <DefaultExperiment startTime=\"0\" stopTime=\"1\" \
         stepSize=\"{:?}\"/>\n  <ModelVariables>\n",
        joint.period_s
    );
    for (reference, variable) in variables.iter().enumerate() {
        scalar_variable(&mut text, reference, variable);
    }
    text.push_str("  </ModelVariables>\n  <ModelStructure>\n");
    for list in ["Outputs", "InitialUnknowns"] {
        let _ = writeln!(text, "    <{list}>");
        for (k, variable) in variables.iter().enumerate() {
            if variable.causality == Causality::Output {
                let _ = writeln!(text, "      <Unknown index=\"{}\"/>", k + 1);
            }
        }
        let _ = writeln!(text, "    </{list}>");
    }
    text.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
    text
}

fn scalar_variable(text: &mut String, reference: usize, variable: &Variable) {
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
    let _ = writeln!(
        text,
        "    <ScalarVariable name=\"{}\" valueReference=\"{reference}\" description=\"{}\" {kind}>\
         <Real{unit}{min}{max}{start}/></ScalarVariable>",
        escaped(&variable.name),
        escaped(&variable.description),
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
