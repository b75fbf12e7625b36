//! Things worth telling a person that do not stop the work.

/// One remark about an input that was accepted: what was found and what was done about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// A whole sentence for a person, naming the item it is about.
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
