//! Errors of the builder.

/// Why a hierarchy could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A vertex is NaN, infinite, or too large for single precision to take differences and products of.
    #[error(
        "vertex {index} is ({}, {}, {}): every coordinate must be a finite number of at most {:e} in magnitude",
        value[0], value[1], value[2], crate::LARGEST_COORDINATE
    )]
    Position {
        /// Index of the first such vertex.
        index: usize,
        /// Its coordinates.
        value: [f32; 3],
    },
    /// A triangle index without a vertex.
    #[error("triangle {triangle} names vertex {vertex}, but there are {count} vertices, numbered from 0")]
    Index {
        /// Index of the first such triangle.
        triangle: usize,
        /// The index.
        vertex: u32,
        /// The number of vertices given.
        count: usize,
    },
    /// More triangles than the node format can number.
    #[error("{count} triangles: one hierarchy holds at most {limit}; split the mesh")]
    Count {
        /// The number of triangles given.
        count: usize,
        /// The largest number that is accepted.
        limit: usize,
    },
    /// A build option outside its range.
    #[error("build option `{name}` is {value}: it must be {expected}")]
    Option {
        /// The option's field name in [`crate::BuildOptions`].
        name: &'static str,
        /// The value given.
        value: f32,
        /// What would be accepted, in words.
        expected: &'static str,
    },
}
