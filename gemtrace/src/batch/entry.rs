//! What a batch owes, item by item, and what has come of it.

use super::manifest::Done;
use serde::Deserialize;
use serde_json::{Map, Value};

/// An item as [`Plan::FILE`](super::Plan::FILE) describes it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ExpectedItem {
    /// Its name.
    pub item: String,
    /// What sets it apart.
    pub values: Map<String, Value>,
    /// What it is made from; see [`Plan::identity`](super::Plan::identity).
    pub identity: String,
    /// Its files, below the output folder.
    pub files: Vec<String>,
}

/// An item and its outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The item.
    pub item: ExpectedItem,
    /// Its line in the manifest, or what keeps it from being there, for people.
    pub outcome: Result<Box<Done>, String>,
}
