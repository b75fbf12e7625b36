//! A split bounding volume hierarchy over triangles, with a traversal that loses no hit.
//!
//! A path through a gemstone meets tens of facets, and a ray that slips between two of them at the shared edge
//! carries its energy to the wrong place. So the one promise of this crate is exactness: what
//! [`Bvh::closest`] returns is, bit for bit, what testing every triangle would return
//! ([`Bvh::closest_of_all`]), and a closed mesh lets no ray through.
//!
//! ```
//! use accel::{BuildOptions, Bvh, Ray, glam::Vec3, testing};
//!
//! let mesh = testing::icosphere(4);
//! let bvh = Bvh::build(&mesh.positions, &mesh.triangles, &BuildOptions::default())?;
//!
//! // From above down to the centre: in through the pole, a corner where several triangles meet…
//! let ray = Ray::new(Vec3::new(0.0, 0.0, 3.0), -Vec3::Z);
//! let entry = bvh.closest(&ray, |_| true).expect("the centre is inside");
//! assert!((entry.t - 2.0).abs() < 1e-6);
//!
//! // …and on from there. The interval starts a little behind the surface, and only faces that the ray leaves by
//! // count: at an edge or a corner it is not enough to leave out the triangle that was hit.
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
//! 2009). Ordinary hierarchies share triangles out; where those are long and lie askew, as facets of a stone
//! and their slivers do, every box is mostly empty and boxes overlap. An SBVH may instead cut space by a plane,
//! and lists a triangle that straddles it on both sides, each time with the box of the part there. Which of
//! the two to do is decided at each node by the surface area heuristic: a line that meets a convex body meets
//! a convex part of it with probability `A(part)/A(body)`, so that a split into `l` and `r` costs
//! `A(l)·N(l) + A(r)·N(r)`. Candidates are found by binning: object splits by the references' centres, spatial
//! splits by planes, with each reference clipped to every bin that it reaches. A straddling reference goes
//! undivided to one side where that costs less.
//!
//! **The budget** of references ([`BuildOptions::budget`]) is never exceeded. Each node owns the array that its
//! subtree's references may come to fill, and the spare room in it passes to the children in proportion to
//! their references' areas, so that subtrees are built independently, in place, and the same whatever the
//! number of threads.
//!
//! **The wide tree** is the compressed eight-way form of Ylitie, Karras & Laine (*Efficient incoherent ray
//! traversal on GPUs through compressed wide BVHs*, HPG 2017), made by the crate [`obvhs`]: 80 bytes a node,
//! child boxes as bytes on a grid. The same nodes serve the processor and, later, graphics cards.
//!
//! **The triangle test** is that of Woop, Benthin & Wald (*Watertight ray/triangle intersection*, JCGT 2013):
//! neighbours see a shared edge through the very same numbers, and the sign of each edge function is exact.
//! Points on edges belong to both sides. The ray parameter is computed in double precision and rounded once.
//!
//! **The box test** is conservative. Each source of rounding between a reference's exact box and the slab test
//! is bounded, and boxes are widened by the sum of the bounds; the derivation stands at the head of
//! `traverse.rs`. The interval of parameters may begin below zero, and no epsilon is built in. It runs in the best
//! [`Instructions`] that the machine has, with the same hits in all of them.
//!
//! # What it is good for
//! [`stats`] gives costs and counts; the examples `sah_ratio` and `build_ratio` compare both with `obvhs`'s own
//! builds. On slivers the tree costs about a third less than the best of those, and it costs no more on
//! well-shaped meshes.

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
pub mod stats;
pub mod testing;
mod traverse;
mod triangle;
mod wide;

pub use bvh::{BuildOptions, Bvh, binary_tree};
pub use error::Error;
pub use instructions::{Instructions, Task};
pub use ray::{Hit, Ray};

/// Largest magnitude of a coordinate: differences of two such numbers, and the slopes and products taken of
/// those, stay within range.
pub const LARGEST_COORDINATE: f32 = 1e36;
