//! The hierarchy over a triangle mesh.

use glam::{DVec3, Vec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::cwbvh::node::CwBvhNode;
use rayon::prelude::*;

use crate::instructions::Found;
use crate::stats::{self, Counter, Stats, Weights};
use crate::traverse::{Closest, Search};
use crate::triangle::{Shear, Triangle};
use crate::{Error, Hit, LARGEST_COORDINATE, Ray, sbvh, wide};

/// Most references of a hierarchy: the wide conversion numbers, in 32 bits, seven decisions for each of the two binary
/// nodes per reference.
const MOST_REFERENCES: usize = 1 << 28;
const MOST_TRIANGLES: usize = MOST_REFERENCES / 2;

/// How a hierarchy is built.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions {
    /// The reference budget: the most references per triangle, from 1 (no spatial splits) to 4.
    pub budget: f32,
    /// A spatial split is tried where the sides of the best object split overlap by more than this share of
    /// the root's area (α of Stich et al. 2009, section 4.5); at least 0. A smaller value gives a better tree in more
    /// time. The overlap is the area of the two sides in excess of a clean cut.
    pub overlap: f32,
    /// The share of nodes, from 0 to 1, that `obvhs`'s reinsertion optimiser then moves. 0: no optimisation.
    pub reinsertion: f32,
}

impl Default for BuildOptions {
    /// Budget 2.5, overlap 10⁻⁴, no reinsertion. (Stich et al. take 10⁻⁵, which gives the same tree on slivers and
    /// stones, and on random triangles the same cost for a sixth more work.)
    fn default() -> Self {
        BuildOptions { budget: 2.5, overlap: 1e-4, reinsertion: 0.0 }
    }
}

impl BuildOptions {
    fn check(&self) -> Result<(), Error> {
        let checks = [
            ("budget", self.budget, (1.0..=4.0).contains(&self.budget), "from 1 to 4"),
            ("overlap", self.overlap, self.overlap >= 0.0, "0 or more"),
            ("reinsertion", self.reinsertion, (0.0..=1.0).contains(&self.reinsertion), "from 0 to 1"),
        ];
        match checks.into_iter().find(|&(_, _, valid, _)| !valid) {
            None => Ok(()),
            Some((name, value, _, expected)) => Err(Error::Option { name, value, expected }),
        }
    }
}

/// A split bounding volume hierarchy over triangles, in its wide, compressed form.
///
/// It keeps its own copy of the triangles in traversal order. The same mesh and options give the same hierarchy, bit
/// for bit, on any number of threads.
///
/// ```
/// use accel::{Bvh, BuildOptions, Ray, glam::Vec3};
///
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
/// let bvh = Bvh::build(&corners, &[[0, 1, 2]], &BuildOptions::default())?;
/// let ray = Ray::new(Vec3::new(0.25, 0.5, 3.0), -Vec3::Z);
/// let hit = bvh.closest(&ray, |_| true).expect("it passes through the triangle");
/// assert_eq!((hit.t, hit.triangle, hit.u, hit.v), (3.0, 0, 0.25, 0.5));
/// # Ok::<(), accel::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(crate) nodes: Vec<CwBvhNode>,
    pub(crate) references: Vec<Triangle>,
    /// Builder's units per unit of the mesh, a power of two. The nodes use the builder's units.
    pub(crate) scale: f32,
    bounds: Aabb,
    triangles: usize,
    degenerate: usize,
    instructions: Found,
}

impl Bvh {
    /// Builds the hierarchy over `triangles`, each three indices into `positions` (any unit, any winding).
    ///
    /// Triangles without area are left out; an empty mesh gives a hierarchy that no ray hits.
    ///
    /// # Errors
    /// A coordinate that is not finite or beyond [`LARGEST_COORDINATE`]; an index without a vertex; more than
    /// 2²⁷ triangles; an option outside its range.
    pub fn build(positions: &[Vec3], triangles: &[[u32; 3]], options: &BuildOptions) -> Result<Bvh, Error> {
        let Built { nodes, scale, live } = build(positions, triangles, options)?;
        let wide = if options.reinsertion > 0.0 {
            wide::convert_packed(&packed(nodes, options))
        } else {
            wide::convert(&nodes)
        };
        let gather =
            |&number: &u32| Triangle::new(triangles[number as usize].map(|i| positions[i as usize]), number);
        Ok(Bvh {
            references: wide.triangles.par_iter().map(gather).collect(),
            nodes: wide.nodes,
            scale,
            bounds: wide.bounds,
            triangles: live,
            degenerate: triangles.len() - live,
            instructions: Found::best(),
        })
    }

    /// The nearest hit with a parameter in `[ray.t_min, ray.t_max]` for which `accept` returns true.
    ///
    /// Of hits with equal parameters, the one with the lowest triangle index wins. So the result is that of testing
    /// every triangle ([`Bvh::closest_of_all`]), whatever the tree. For this, the result of `accept` must depend on the
    /// hit alone. It is called in no particular order and may see a triangle more than once.
    ///
    /// `None` if nothing is hit, the direction is zero, or the origin or direction is not finite.
    pub fn closest(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        self.closest_counted(ray, accept, &mut ())
    }

    /// [`Bvh::closest`], with each step reported to `counter`.
    ///
    /// ```
    /// # use accel::{Bvh, BuildOptions, Ray, glam::Vec3, stats::Steps};
    /// # let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    /// # let bvh = Bvh::build(&corners, &[[0, 1, 2]], &BuildOptions::default())?;
    /// let mut steps = Steps::default();
    /// let ray = Ray::new(Vec3::new(0.25, 0.5, 3.0), -Vec3::Z);
    /// bvh.closest_counted(&ray, |_| true, &mut steps);
    /// assert_eq!((steps.nodes, steps.triangles), (1, 1));
    /// # Ok::<(), accel::Error>(())
    /// ```
    pub fn closest_counted(
        &self,
        ray: &Ray,
        accept: impl FnMut(&Hit) -> bool,
        counter: &mut impl Counter,
    ) -> Option<Hit> {
        self.instructions.run(Closest { bvh: self, ray, accept, counter })
    }

    /// The result that [`Bvh::closest`] must give, by testing every triangle: the reference for tests.
    pub fn closest_of_all(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        let shear = Shear::new(ray)?;
        let mut search = Search::new(ray, accept);
        for triangle in &self.references {
            if let Some(hit) = shear.intersect(triangle) {
                search.offer(hit);
            }
        }
        search.best
    }

    /// Size, depth and cost of the hierarchy.
    pub fn stats(&self) -> Stats {
        Stats {
            triangles: self.triangles,
            degenerate: self.degenerate,
            references: self.references.len(),
            nodes: self.nodes.len(),
            depth: stats::depth(&self.nodes),
            cost: stats::cost(&self.nodes, &self.bounds, Weights::WIDE),
        }
    }
}

/// The binary tree before the wide conversion, for measurements: one reference a leaf, boxes in the builder's units, in
/// which the largest coordinate of the mesh lies between 1/2 and 1.
///
/// # Errors
/// As [`Bvh::build`].
pub fn binary_tree(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    options: &BuildOptions,
) -> Result<Bvh2, Error> {
    build(positions, triangles, options).map(|built| packed(built.nodes, options))
}

fn packed(nodes: Vec<sbvh::Node>, options: &BuildOptions) -> Bvh2 {
    let mut tree = wide::binary(&nodes);
    drop(nodes);
    wide::reinsert(&mut tree, options.reinsertion);
    tree
}

struct Built {
    nodes: Vec<sbvh::Node>,
    scale: f32,
    /// Triangles with area.
    live: usize,
}

fn build(positions: &[Vec3], triangles: &[[u32; 3]], options: &BuildOptions) -> Result<Built, Error> {
    options.check()?;
    check(positions, triangles)?;
    let numbers: Vec<u32> = (0..triangles.len() as u32)
        .into_par_iter()
        .filter(|&number| has_area(triangles[number as usize].map(|i| positions[i as usize])))
        .collect();
    let live = numbers.len();
    let budget = ((live as f64 * f64::from(options.budget)) as usize).min(MOST_REFERENCES);
    let mesh = sbvh::Mesh { positions, triangles, scale: scale(positions) };
    let nodes = sbvh::build(&mesh, numbers, &sbvh::Settings { budget, alpha: options.overlap });
    Ok(Built { nodes, scale: mesh.scale, live })
}

/// Whether the corners span a plane. In double precision the test is exact for all but extreme ranges.
fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(DVec3::from);
    (b - a).cross(c - a) != DVec3::ZERO
}

fn check(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), Error> {
    let valid = |p: &Vec3| p.is_finite() && p.abs().max_element() <= LARGEST_COORDINATE;
    if let Some(index) = positions.par_iter().position_first(|p| !valid(p)) {
        return Err(Error::Position { index, value: positions[index].into() });
    }
    if triangles.len() > MOST_TRIANGLES {
        return Err(Error::Count { count: triangles.len(), limit: MOST_TRIANGLES });
    }
    let count = positions.len();
    let outside = |triangle: &[u32; 3]| triangle.iter().copied().find(|&i| i as usize >= count);
    if let Some(triangle) = triangles.par_iter().position_first(|t| outside(t).is_some()) {
        let vertex = outside(&triangles[triangle]).unwrap_or_default();
        return Err(Error::Index { triangle, vertex, count });
    }
    Ok(())
}

/// The power of two that brings the largest coordinate into `[1/2, 1)`: scaling by it rounds nothing.
fn scale(positions: &[Vec3]) -> f32 {
    let largest = positions.par_iter().map(|p| p.abs().max_element()).reduce(|| 0.0, f32::max);
    let exponent = (largest.to_bits() >> 23) as i32 - 126;
    f32::from_bits(((127 - exponent).clamp(1, 253) as u32) << 23)
}
