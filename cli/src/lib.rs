//! (to be written)

mod error;
pub mod import;
pub mod scene_file;

pub use error::Error;
