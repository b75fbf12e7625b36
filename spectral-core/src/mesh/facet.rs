//! Groups connected coplanar triangles into facets and fits their planes.

use glam::DVec3;

use super::topology::{NONE, Surface};
use super::{MeshOptions, Plane, cross, polygon};

/// Rounding of single-precision coordinates, as a fraction of the extent. It tilts a triangle of height `h` by about this
/// over `h`, so the slivers of a facet may deviate more than its large triangles.
pub(super) const ROUNDING: f64 = 1e-7;
/// Rounds of fitting the plane and growing the facet. The first plane, that of one triangle, is noisy.
const ROUNDS: usize = 2;

pub(super) struct Grouped {
    pub facet_of: Vec<u32>,
    pub planes: Vec<Plane>,
}

/// A triangle of the grouping.
struct Piece {
    /// Unit normal; zero for a triangle without direction.
    normal: DVec3,
    area: f64,
    /// Smallest cosine between its normal and that of its facet.
    cosine: f64,
}

/// Grows facets from the largest triangles first, since their normals are the most exact. Triangles are compared with the
/// plane of the facet and never with a neighbour, so a smooth surface does not become one facet step by step. `rounding`
/// is that of the coordinates, as a fraction of the extent.
pub(super) fn group(surface: &Surface, options: &MeshOptions, rounding: f64) -> Grouped {
    let pieces = pieces(surface, options.coplanar_angle.to_radians(), rounding);
    let mut order: Vec<u32> = (0..pieces.len() as u32).collect();
    order.sort_by(|&a, &b| pieces[b as usize].area.total_cmp(&pieces[a as usize].area));
    let mut facet_of = vec![NONE; pieces.len()];
    let (mut planes, mut members) = (Vec::new(), Vec::new());
    for seed in order {
        if facet_of[seed as usize] != NONE || pieces[seed as usize].normal == DVec3::ZERO {
            continue;
        }
        let facet = planes.len() as u32;
        facet_of[seed as usize] = facet;
        members.clear();
        members.push(seed);
        let mut plane = fit(surface, &pieces, &members);
        for _ in 0..ROUNDS {
            let before = members.len();
            grow(surface, &pieces, options, &plane, facet, &mut facet_of, &mut members);
            if members.len() == before {
                break;
            }
            plane = fit(surface, &pieces, &members);
        }
        planes.push(plane);
    }
    adopt_thin(surface, &mut facet_of, &mut planes);
    number_in_file_order(facet_of, &planes)
}

fn pieces(surface: &Surface, angle: f64, rounding: f64) -> Vec<Piece> {
    let piece = |t: &[u32; 3]| {
        let normal = cross(&surface.positions, t);
        let height = polygon::height(t.map(|v| surface.positions[v as usize]));
        let allowed = angle.max(rounding * surface.extent / height).min(1.0);
        let unit = if height > surface.thin { normal.normalize_or_zero() } else { DVec3::ZERO };
        Piece { normal: unit, area: 0.5 * normal.length(), cosine: allowed.cos() }
    };
    surface.triangles.iter().map(piece).collect()
}

/// Adds to `members` every triangle connected to them that lies in `plane`.
fn grow(
    surface: &Surface,
    pieces: &[Piece],
    options: &MeshOptions,
    plane: &Plane,
    facet: u32,
    facet_of: &mut [u32],
    members: &mut Vec<u32>,
) {
    let reach = options.coplanar_distance * surface.extent;
    let mut next = 0;
    while let Some(&t) = members.get(next) {
        next += 1;
        for u in surface.across[t as usize] {
            if u == NONE || facet_of[u as usize] != NONE {
                continue;
            }
            let piece = &pieces[u as usize];
            let near = |&v: &u32| plane.distance(surface.positions[v as usize]).abs() <= reach;
            if piece.normal.dot(plane.normal) >= piece.cosine
                && surface.triangles[u as usize].iter().all(near)
            {
                facet_of[u as usize] = facet;
                members.push(u);
            }
        }
    }
}

/// The area-weighted plane: its normal is the sum of the area vectors, which depends on the outline of the facet and not on
/// the noise inside; it contains the centre of area.
fn fit(surface: &Surface, pieces: &[Piece], members: &[u32]) -> Plane {
    let (mut normal, mut centre, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for &t in members {
        let piece = &pieces[t as usize];
        let [a, b, c] = surface.triangles[t as usize].map(|v| surface.positions[v as usize]);
        normal += piece.area * piece.normal;
        centre += piece.area * ((a + b + c) / 3.0);
        area += piece.area;
    }
    let normal = normal.normalize_or(pieces[members[0] as usize].normal);
    Plane { normal, offset: normal.dot(centre / area) }
}

/// Triangles whose corners lie on a line have no plane. Each joins the facet across its longest edge, or across another
/// edge that has one.
fn adopt_thin(surface: &Surface, facet_of: &mut [u32], planes: &mut Vec<Plane>) {
    let mut left: Vec<usize> = (0..facet_of.len()).filter(|&t| facet_of[t] == NONE).collect();
    while !left.is_empty() {
        let before = left.len();
        left.retain(|&t| {
            let corner = |k: usize| surface.positions[surface.triangles[t][k % 3] as usize];
            let facet = (0..3)
                .filter(|&k| surface.across[t][k] != NONE)
                .map(|k| (corner(k).distance_squared(corner(k + 1)), facet_of[surface.across[t][k] as usize]))
                .filter(|&(_, facet)| facet != NONE)
                .max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, facet)) = facet {
                facet_of[t] = facet;
            }
            facet.is_none()
        });
        if left.len() == before {
            break;
        }
    }
    // Thin triangles with only thin neighbours: any plane through them is as good as another.
    for t in left {
        let [a, b, _] = surface.triangles[t].map(|v| surface.positions[v as usize]);
        let normal = (b - a).normalize_or(DVec3::X).any_orthonormal_vector();
        facet_of[t] = planes.len() as u32;
        planes.push(Plane { normal, offset: normal.dot(a) });
    }
}

/// Numbers the facets by their first triangle: in the order of the file and not of the areas.
fn number_in_file_order(mut facet_of: Vec<u32>, planes: &[Plane]) -> Grouped {
    let mut number = vec![NONE; planes.len()];
    let mut ordered = Vec::with_capacity(planes.len());
    for facet in &mut facet_of {
        let slot = &mut number[*facet as usize];
        if *slot == NONE {
            *slot = ordered.len() as u32;
            ordered.push(planes[*facet as usize]);
        }
        *facet = *slot;
    }
    Grouped { facet_of, planes: ordered }
}
