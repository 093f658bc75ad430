//! Parts of a whole as one bar, with what each of them is below it.
//!
//! As text and boxes instead of a drawing, so that it wraps on a narrow screen and is read aloud.

use std::fmt::Write;

use super::Ink;
use super::text::{escape, per_cent};

/// A part of the whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// What it is.
    pub name: String,
    /// Its colour.
    pub ink: Ink,
    /// Its share; below zero it takes no room.
    pub share: f64,
    /// Its size, in words and units, as cells of a table.
    pub cells: Vec<String>,
}

/// A share from which on the bar says it.
const TOLD: f64 = 0.07;

/// The bar, and a table of the parts under these heads, the first of which is that of the names.
pub fn stack(heads: &[&str], parts: &[Part]) -> String {
    let whole: f64 = parts.iter().map(|part| part.share.max(0.0)).sum();
    let mut text = String::from("<div class=\"stack\" role=\"img\" aria-label=\"");
    for part in parts {
        let _ = write!(text, "{} {}; ", escape(&part.name), escape(&part.cells.join(", ")));
    }
    text.push_str("\">");
    for part in parts.iter().filter(|part| part.share > 0.0) {
        let own = part.share / whole;
        let told = if own >= TOLD { per_cent(part.share) } else { String::new() };
        let _ = write!(
            text,
            "<i class=\"{}\" style=\"width:{:.3}%\" title=\"{}\"><b>{told}</b></i>",
            part.ink.class(),
            100.0 * own,
            escape(&part.name)
        );
    }
    text.push_str("</div>\n<table class=\"parts\"><tr>");
    for (k, head) in heads.iter().enumerate() {
        let _ = write!(text, "<th{}>{}", if k > 0 { " class=n" } else { "" }, escape(head));
    }
    text.push_str("</tr>\n");
    for part in parts {
        let class = part.ink.class();
        let name = escape(&part.name);
        let _ = write!(text, "<tr><td><i class=\"key block {class}\"></i>{name}");
        for cell in &part.cells {
            let _ = write!(text, "<td class=n>{}", escape(cell));
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</table>\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_is_as_long_as_its_parts_together_and_none_is_negative() {
        let part = |share| Part { name: "a<b".into(), ink: Ink::After, share, cells: Vec::new() };
        let text = stack(&["part"], &[part(0.75), part(-0.5), part(0.75)]);
        assert_eq!(text.matches("width:50.000%").count(), 2);
        assert!(text.contains("a&lt;b") && !text.contains("a<b"));
        assert_eq!(text.matches("<tr><td>").count(), 3, "all parts are listed");
    }
}
