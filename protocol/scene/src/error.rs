//! Errors of input, each naming file, line, key, value, what is allowed and what to do.

use std::ops::Range;

use miette::{Diagnostic, LabeledSpan, SourceCode};
use protocol::printable::{printable, printable_in_place};

/// What a check of a scene gives.
pub(crate) type Check = Result<(), SceneError>;

/// What is wrong in a scene, and where.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}: {message}", self.place())]
pub struct SceneError {
    /// File as the user named it.
    pub file: String,
    /// Line, from 1; 0 when the fault has no place in the text (a missing file, say).
    pub line: usize,
    /// Dotted key, `grains[0].radius`; empty for a fault of syntax.
    pub key: String,
    /// What is wrong, with the value and what is allowed.
    pub message: String,
    /// What to do.
    pub remedy: String,
    /// Bytes of the text to mark.
    pub span: Range<usize>,
    /// The whole text.
    pub text: String,
}

impl SceneError {
    /// An error that has no place in a text.
    pub fn of_file(file: &str, message: String, remedy: &str) -> Self {
        Self {
            file: file.to_owned(),
            line: 0,
            key: String::new(),
            message,
            remedy: remedy.to_owned(),
            span: 0..0,
            text: String::new(),
        }
    }

    /// The same for a terminal.
    pub fn printable(&self) -> Self {
        let shown = |text: &str| printable(text).into_owned();
        Self {
            file: shown(&self.file),
            key: shown(&self.key),
            message: shown(&self.message),
            remedy: shown(&self.remedy),
            text: printable_in_place(&self.text),
            ..self.clone()
        }
    }

    /// `file:line: key`, as far as each is known.
    pub fn place(&self) -> String {
        let mut place = self.file.clone();
        if self.line > 0 {
            place += &format!(":{}", self.line);
        }
        if !self.key.is_empty() {
            place += &format!(": {}", self.key);
        }
        place
    }
}

impl Diagnostic for SceneError {
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        Some(Box::new(&self.remedy))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        (self.line > 0).then_some(&self.text as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        (self.line > 0).then(|| {
            let label = LabeledSpan::new_with_span(Some("here".into()), self.span.clone());
            Box::new(std::iter::once(label)) as Box<dyn Iterator<Item = LabeledSpan>>
        })
    }
}
