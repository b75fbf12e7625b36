//! The solids that a mesh of several shells is the union of.
//!
//! Transport crosses a stone's surface in turn, in and out, which is right while its shells are apart or nested as
//! cavities are. Shells that overlap or touch are separate solids of one stone instead, like stones of one material.

use super::proximity::{Corners, touch};
use super::topology::{NONE, Surface, flip};
use super::{bounds_of, solid_angle, volume_about};
use crate::Warning;
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Shells nearer than this fraction of the extent touch, as stones do.
const CONTACT: f64 = 1e-5;

/// Some triangles of a surface, with their box and signed volume.
struct Part {
    triangles: Vec<u32>,
    low: DVec3,
    high: DVec3,
    volume: f64,
}

impl Part {
    fn new(surface: &Surface, triangles: Vec<u32>) -> Self {
        let (low, high) = bounds_of(triangles.iter().flat_map(|&t| corners(surface, t)));
        let list: Vec<[u32; 3]> = triangles.iter().map(|&t| surface.triangles[t as usize]).collect();
        let volume = volume_about((low, high), &list, |v| surface.positions[v as usize]);
        Part { triangles, low, high, volume }
    }

    fn is_near(&self, other: &Part, gap: f64) -> bool {
        (self.low - other.high).max(other.low - self.high).max_element() <= gap
    }

    /// Whether some vertex of `other` lies inside.
    fn holds(&self, surface: &Surface, other: &Part) -> bool {
        let point = corners(surface, other.triangles[0])[0];
        let angle = |&t: &u32| solid_angle(corners(surface, t).map(|p| p - point));
        (point - self.low).min_element() > 0.0
            && (self.high - point).min_element() > 0.0
            && self.triangles.iter().map(angle).sum::<f64>() > std::f64::consts::TAU
    }

    /// Whether two parts share space or touch.
    fn meets(&self, surface: &Surface, other: &Part, gap: f64) -> bool {
        let near = |part: &Part, other: &Part| -> Vec<Corners> {
            let box_of = |t: &u32| bounds_of(corners(surface, *t).into_iter());
            let reaches =
                |(low, high): (DVec3, DVec3)| (low - other.high).max(other.low - high).max_element() <= gap;
            let near = part.triangles.iter().filter(|t| reaches(box_of(t)));
            near.map(|&t| corners(surface, t)).collect()
        };
        touch(&mut near(self, other), &mut near(other, self), gap)
            || self.holds(surface, other)
            || other.holds(surface, self)
    }
}

fn corners(surface: &Surface, triangle: u32) -> Corners {
    surface.triangles[triangle as usize].map(|v| surface.positions[v as usize])
}

/// Sorts the triangles by solid if shells overlap or touch; returns the end of each solid's triangles. Turns shells that
/// face inwards and lie in no other.
pub(super) fn separate(surface: &mut Surface, warnings: &mut Vec<Warning>) -> Vec<u32> {
    let whole = vec![surface.triangles.len() as u32];
    if surface.shells < 2 {
        return whole;
    }
    let parts = components(surface).into_iter().map(|triangles| Part::new(surface, triangles)).collect();
    let solids = with_cavities(surface, parts, warnings);
    let meeting = meeting(surface, &solids, CONTACT * surface.extent);
    if meeting == 0 {
        return whole;
    }
    warnings.push(Warning::new(format!(
        "{meeting} of the mesh's {} solids overlap or touch others; they are taken for one, without surfaces between them",
        solids.len()
    )));
    sort(surface, &solids)
}

/// The triangles of each shell; shells that share an edge are one.
fn components(surface: &Surface) -> Vec<Vec<u32>> {
    let mut shared: FxHashMap<(u32, u32), Vec<u32>> = FxHashMap::default();
    let edge = |t: usize, k: usize| {
        let triangle = &surface.triangles[t];
        let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
        (a.min(b), a.max(b))
    };
    for (t, across) in surface.across.iter().enumerate() {
        for k in (0..3).filter(|&k| across[k] == NONE) {
            shared.entry(edge(t, k)).or_default().push(t as u32);
        }
    }
    let mut seen = vec![false; surface.triangles.len()];
    let mut components = Vec::new();
    for seed in 0..seen.len() {
        if std::mem::replace(&mut seen[seed], true) {
            continue;
        }
        let (mut members, mut next) = (vec![seed as u32], 0);
        while let Some(&t) = members.get(next) {
            next += 1;
            for (k, &u) in surface.across[t as usize].iter().enumerate() {
                let beside = std::slice::from_ref(&u);
                let beside = if u == NONE { shared[&edge(t as usize, k)].as_slice() } else { beside };
                let new = beside.iter().filter(|&&u| !std::mem::replace(&mut seen[u as usize], true));
                members.extend(new);
            }
        }
        members.sort_unstable();
        components.push(members);
    }
    components
}

/// Adds each shell that faces inwards to the smallest that holds it. One that lies in no other is turned.
fn with_cavities(surface: &mut Surface, parts: Vec<Part>, warnings: &mut Vec<Warning>) -> Vec<Part> {
    let (mut solids, inward): (Vec<Part>, Vec<Part>) = parts.into_iter().partition(|p| p.volume >= 0.0);
    let outward = solids.len();
    let mut turned = 0;
    for mut cavity in inward {
        let holders = (0..outward).filter(|&k| solids[k].holds(surface, &cavity));
        let holder = holders.min_by(|&a, &b| solids[a].volume.total_cmp(&solids[b].volume));
        if let Some(k) = holder {
            solids[k].triangles.append(&mut cavity.triangles);
            continue;
        }
        for &t in &cavity.triangles {
            flip(&mut surface.triangles[t as usize], &mut surface.across[t as usize]);
        }
        turned += 1;
        solids.push(Part { volume: -cavity.volume, ..cavity });
    }
    if turned > 0 {
        warnings.push(Warning::new(format!(
            "{turned} shells of the mesh faced inwards, though no other is around them, and were turned"
        )));
    }
    solids.iter_mut().for_each(|solid| solid.triangles.sort_unstable());
    solids.sort_by_key(|solid| solid.triangles[0]);
    solids
}

/// How many solids overlap or touch another.
fn meeting(surface: &Surface, solids: &[Part], gap: f64) -> usize {
    let mut order: Vec<usize> = (0..solids.len()).collect();
    order.sort_by(|&a, &b| solids[a].low.x.total_cmp(&solids[b].low.x));
    let mut meets = vec![false; solids.len()];
    for (place, &a) in order.iter().enumerate() {
        let later = order[place + 1..].iter().take_while(|&&b| solids[b].low.x <= solids[a].high.x + gap);
        for &b in later.filter(|&&b| solids[a].is_near(&solids[b], gap)) {
            if !(meets[a] && meets[b]) && solids[a].meets(surface, &solids[b], gap) {
                (meets[a], meets[b]) = (true, true);
            }
        }
    }
    meets.iter().filter(|meets| **meets).count()
}

/// Brings the triangles into the order of their solids.
fn sort(surface: &mut Surface, solids: &[Part]) -> Vec<u32> {
    let order: Vec<u32> = solids.iter().flat_map(|solid| solid.triangles.iter().copied()).collect();
    let mut number = vec![0; order.len()];
    order.iter().enumerate().for_each(|(new, &old)| number[old as usize] = new as u32);
    let renumbered = |t: u32| if t == NONE { NONE } else { number[t as usize] };
    surface.across = order.iter().map(|&t| surface.across[t as usize].map(renumbered)).collect();
    surface.triangles = order.iter().map(|&t| surface.triangles[t as usize]).collect();
    let ends = |end: &mut u32, solid: &Part| {
        *end += solid.triangles.len() as u32;
        Some(*end)
    };
    solids.iter().scan(0, ends).collect()
}
