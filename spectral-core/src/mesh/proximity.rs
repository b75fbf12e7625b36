//! How near surfaces come to each other, and a point to a surface.

use super::bounds_of;
use glam::DVec3;

/// The corners of a triangle.
pub(super) type Corners = [DVec3; 3];

/// So many pairs of triangles are compared one by one.
const FEW: usize = 64;

/// Whether a triangle of `a` comes within `gap` of one of `b`, or crosses it. Sorts both. Halves the more numerous of
/// two sets until their boxes are apart or few triangles are left.
pub(super) fn touch(a: &mut [Corners], b: &mut [Corners], gap: f64) -> bool {
    let [(low_a, high_a), (low_b, high_b)] = [&*a, &*b].map(|set| bounds_of(set.iter().flatten().copied()));
    if a.is_empty() || b.is_empty() || (low_a - high_b).max(low_b - high_a).max_element() > gap {
        return false;
    }
    if a.len() * b.len() <= FEW {
        return a.iter().any(|a| b.iter().any(|b| near(a, b, gap)));
    }
    let (larger, other, size) =
        if a.len() >= b.len() { (a, b, high_a - low_a) } else { (b, a, high_b - low_b) };
    let (axis, half) = (size.max_position(), larger.len() / 2);
    larger.select_nth_unstable_by(half, |p, q| p[0][axis].total_cmp(&q[0][axis]));
    let (left, right) = larger.split_at_mut(half);
    touch(left, other, gap) || touch(right, other, gap)
}

/// Whether two triangles come within `gap` of each other.
fn near(a: &Corners, b: &Corners, gap: f64) -> bool {
    let edges = |t: &Corners| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let gap2 = gap * gap;
    edges(a).iter().any(|p| edges(b).iter().any(|q| between_segments(*p, *q) <= gap2))
        || edges(a).iter().any(|edge| pierces(*edge, b, gap))
        || edges(b).iter().any(|edge| pierces(*edge, a, gap))
}

/// Whether a segment comes within `gap` of the inside of a triangle: with an end, or on both of its sides.
fn pierces([from, to]: [DVec3; 2], triangle: &Corners, gap: f64) -> bool {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let [start, end] = [from, to].map(|p| normal.dot(p - a));
    let inside = |p: DVec3| {
        [[a, b], [b, c], [c, a]].iter().all(|[from, to]| (*to - *from).cross(p - *from).dot(normal) >= 0.0)
    };
    (start.abs() <= gap && inside(from))
        || (end.abs() <= gap && inside(to))
        || (start * end < 0.0 && inside(from + (to - from) * (start / (start - end))))
}

/// The distance of a point from a triangle.
pub(crate) fn distance(point: DVec3, triangle: &Corners) -> f64 {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let edges = [[a, b], [b, c], [c, a]];
    if edges.iter().all(|[from, to]| (*to - *from).cross(point - *from).dot(normal) >= 0.0)
        && normal != DVec3::ZERO
    {
        return normal.dot(point - a).abs();
    }
    edges.iter().map(|edge| between_segments([point; 2], *edge)).fold(f64::INFINITY, f64::min).sqrt()
}

/// The squared distance of two segments (Ericson 2005, Real-Time Collision Detection, 5.1.9).
fn between_segments([p, p_end]: [DVec3; 2], [q, q_end]: [DVec3; 2]) -> f64 {
    let (u, v, w) = (p_end - p, q_end - q, p - q);
    let (a, e, b, c, f) = (u.dot(u), v.dot(v), u.dot(v), u.dot(w), v.dot(w));
    let share = |numerator: f64, denominator: f64| {
        if denominator > 0.0 { (numerator / denominator).clamp(0.0, 1.0) } else { 0.0 }
    };
    let s = share(b * f - c * e, a * e - b * b);
    let t = share(b * s + f, e);
    let s = share(b * t - c, a);
    (p + u * s).distance_squared(q + v * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_near_each_other_are_known() {
        let flat = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0];
        let moved = |by: [f64; 3]| flat.map(|p| p + DVec3::from_array(by));
        let upright = |z: f64| [[0.3, 0.3, z], [0.4, 0.3, z], [0.3, 0.3, z + 9.0]].map(DVec3::from_array);
        for (other, expected) in [
            (moved([0.0, 0.0, 0.05]), true),
            (moved([0.0, 0.0, 0.2]), false),
            (moved([1.05, 1.05, 0.0]), true),
            (moved([1.3, 1.3, 0.0]), false),
            (upright(-1.0), true),
            (upright(0.05), true),
            (upright(0.2), false),
        ] {
            assert_eq!(touch(&mut [flat], &mut [other], 0.1), expected, "{other:?}");
            assert_eq!(touch(&mut [other], &mut [flat], 0.1), expected, "{other:?}");
        }
    }
}
