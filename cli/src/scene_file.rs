//! Reads scene files.
