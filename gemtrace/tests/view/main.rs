//! The protocol of the live view, spoken without a browser.

mod answers;
mod security;
mod state;
mod support;
