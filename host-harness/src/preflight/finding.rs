//! What a check has to say.

use serde::Serialize;

/// How grave a finding is; errors come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Log and model cannot both be right: no fit should be made.
    Error,
    /// A fit may be biased by it.
    Warning,
    /// Measured, and told.
    Note,
}

impl Severity {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Note => "note",
        }
    }
}

/// One finding: what, where, and what to do.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The check that found it.
    pub check: &'static str,
    /// How grave it is.
    pub severity: Severity,
    /// What is found and where.
    pub message: String,
    /// What to do about it; empty for most notes.
    pub help: String,
    /// The row of the log where it begins, from 0, where it is about one.
    pub row: Option<usize>,
    /// Whether it is about the model's file and not about the log's.
    pub of_model: bool,
}

impl Finding {
    pub(super) fn new(severity: Severity, message: impl Into<String>) -> Self {
        Self {
            check: "",
            severity,
            message: message.into(),
            help: String::new(),
            row: None,
            of_model: false,
        }
    }

    pub(super) fn error(message: impl Into<String>) -> Self {
        Self::new(Severity::Error, message)
    }

    pub(super) fn warning(message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, message)
    }

    pub(super) fn note(message: impl Into<String>) -> Self {
        Self::new(Severity::Note, message)
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = help.into();
        self
    }

    pub(super) fn at(mut self, row: usize) -> Self {
        self.row = Some(row);
        self
    }

    pub(super) fn of_model(mut self) -> Self {
        self.of_model = true;
        self
    }

    pub(super) fn of(mut self, check: &'static str) -> Self {
        self.check = check;
        self
    }
}
