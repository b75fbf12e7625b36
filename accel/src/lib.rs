//! (front page to follow)

pub use glam;
pub use obvhs;

mod bounds;
mod bvh;
mod error;
mod ray;
mod sbvh;
pub mod software;
pub mod stats;
pub mod testing;
mod traverse;
mod triangle;
mod wide;

pub use bvh::{BuildOptions, Bvh, binary_tree};
pub use error::Error;
pub use ray::{Hit, Ray};

/// Largest magnitude of a coordinate: differences of two such numbers, and the slopes and products taken of
/// those, stay within range.
pub const LARGEST_COORDINATE: f32 = 1e36;
