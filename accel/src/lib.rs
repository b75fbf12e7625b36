//! A split bounding volume hierarchy over triangles, with a traversal that loses no hit.
//!
//! A path through a gemstone meets tens of facets. A ray that slips through the edge shared by two of them carries
//! its energy to the wrong place. The crate therefore promises exactness: [`Bvh::closest`] returns, bit for bit, what
//! testing every triangle would return ([`Bvh::closest_of_all`]), and no ray passes through a closed mesh.
//!
//! ```
//! use accel::{BuildOptions, Bvh, Ray, glam::Vec3, testing};
//!
//! let mesh = testing::icosphere(4);
//! let bvh = Bvh::build(&mesh.positions, &mesh.triangles, &BuildOptions::default())?;
//!
//! // From above towards the centre. The ray enters at the pole, a vertex where several triangles meet.
//! let ray = Ray::new(Vec3::new(0.0, 0.0, 3.0), -Vec3::Z);
//! let entry = bvh.closest(&ray, |_| true).expect("the centre is inside");
//! assert!((entry.t - 2.0).abs() < 1e-6);
//!
//! // From there to the other side. The interval starts a little behind the surface, and only back faces count:
//! // at an edge or a vertex, excluding only the triangle that was hit is not enough.
//! let inside = Ray { origin: ray.at(entry.t), t_min: -1e-6, ..ray };
//! let leaves = |triangle: u32| {
//!     let [a, b, c] = mesh.corners(triangle as usize);
//!     (b - a).cross(c - a).dot(ray.direction) > 0.0
//! };
//! let exit = bvh.closest(&inside, |hit| leaves(hit.triangle)).expect("a sphere is closed");
//! assert!((exit.t - 2.0).abs() < 1e-6);
//! # Ok::<(), accel::Error>(())
//! ```
//!
//! # Method
//! **The tree** is an SBVH (Stich, Friedrich & Dietrich, *Spatial splits in bounding volume hierarchies*, HPG
//! 2009). An ordinary hierarchy assigns each triangle to one child. Where triangles are long and oblique, as the
//! facets of a stone and their slivers are, boxes are mostly empty and overlap. An SBVH may instead cut space by a
//! plane: a triangle that straddles the plane is referenced on both sides, each time with the box of its part there.
//! The surface area heuristic decides between the two at each node: a line that meets a convex body meets a convex
//! part of it with probability `A(part)/A(body)`, so a split into `l` and `r` costs `A(l)·N(l) + A(r)·N(r)`.
//! Candidates are found by binning: object splits by the centroids of the references, spatial splits by planes, with
//! each reference clipped to every bin it reaches. A straddling reference stays undivided where that costs less.
//!
//! **The budget** of references ([`BuildOptions::budget`]) is never exceeded. Each node owns the part of the array
//! that the references of its subtree may fill. Its spare room is divided between the children in proportion to the
//! areas of their references. So subtrees are built independently and in place, and the result does not depend on the
//! number of threads.
//!
//! **The wide tree** is the compressed eight-way form of Ylitie, Karras & Laine (*Efficient incoherent ray traversal
//! on GPUs through compressed wide BVHs*, HPG 2017), in the layout of the crate [`obvhs`]: 80 bytes a node, with the
//! child boxes as bytes on a grid. The CPU and the GPU read the same nodes.
//!
//! **The triangle test** is that of Woop, Benthin & Wald (*Watertight ray/triangle intersection*, JCGT 2013).
//! Neighbours compute a shared edge from the same numbers, and the sign of each edge function is exact. Points on an
//! edge belong to both sides. The ray parameter is computed in double precision and rounded once.
//!
//! **The box test** is conservative. Each rounding error between the exact box of a reference and the slab test is
//! bounded, and boxes are widened by the sum of the bounds; see the derivation in `traverse.rs`. The interval of
//! parameters may begin below zero, and no epsilon is built in. The test uses the best [`Instructions`] of the machine;
//! the hits are the same in all of them.
//!
//! [`stats`] gives costs and counts. The example `against_obvhs` compares cost and build time with `obvhs`'s own
//! builds: on slivers the tree costs about a third less than the best of them, and no more on well-shaped meshes.

pub use glam;
pub use obvhs;

mod bounds;
mod bvh;
mod error;
mod instructions;
pub mod lanes;
pub mod packet;
mod ray;
mod sbvh;
mod slabs;
pub mod software;
mod stack;
pub mod stats;
pub mod testing;
mod traverse;
mod triangle;
mod wide;

pub use bvh::{BuildOptions, Bvh, binary_tree};
pub use error::Error;
pub use instructions::{Instructions, Task};
pub use ray::{Hit, Ray};

/// Largest magnitude of a coordinate: differences, slopes and products of such numbers do not overflow.
pub const LARGEST_COORDINATE: f32 = 1e36;
