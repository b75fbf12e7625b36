//! Remarks about accepted input.

/// A remark about an input that was accepted: what was found and what was done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// A sentence that names the item concerned.
    pub message: String,
}

impl Warning {
    /// A warning from a sentence.
    pub fn new(message: impl Into<String>) -> Self {
        Warning { message: message.into() }
    }
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}
