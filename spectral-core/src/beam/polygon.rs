//! Convex polygons in the plane of the picture.

/// A convex polygon of places (u, v), in pixels to the right of and below a reference point. Its vertices are in order, in
/// either direction.
#[derive(Debug, Clone, Copy)]
pub struct Polygon {
    count: usize,
    vertices: [[f64; 2]; Polygon::MOST],
}

impl Polygon {
    /// The most vertices. Of a polygon that would have more, the vertex is left out that changes the area least.
    pub const MOST: usize = 12;

    /// A polygon without vertices.
    pub const EMPTY: Polygon = Polygon { count: 0, vertices: [[0.0; 2]; Polygon::MOST] };

    /// The square from −`half` to `half`.
    ///
    /// ```
    /// use spectral_core::beam::Polygon;
    /// let pixel = Polygon::square(0.5);
    /// assert_eq!((pixel.area(), pixel.centroid()), (1.0, [0.0; 2]));
    /// let [left, right] = pixel.cut(|[u, _]| u - 0.25);
    /// assert_eq!((left.area(), right.centroid()), (0.75, [0.375, 0.0]));
    /// ```
    pub fn square(half: f64) -> Self {
        [[-half, -half], [half, -half], [half, half], [-half, half]].into_iter().collect()
    }

    /// The vertices, in order.
    #[inline]
    pub fn vertices(&self) -> &[[f64; 2]] {
        &self.vertices[..self.count]
    }

    /// The area, square pixels; 0 for fewer than three vertices.
    pub fn area(&self) -> f64 {
        self.moments().0
    }

    /// The centre of the area; of a polygon without area, a vertex of it.
    pub fn centroid(&self) -> [f64; 2] {
        self.moments().1
    }

    /// Area and centroid.
    #[inline]
    pub fn moments(&self) -> (f64, [f64; 2]) {
        let [first, ..] = self.vertices;
        let (mut sum, mut weight) = ([0.0; 2], 0.0);
        for ([a, b], doubled) in self.triangles() {
            // Three times the centre of a triangle with one corner at the first vertex.
            sum = [sum[0] + doubled * (a[0] + b[0]), sum[1] + doubled * (a[1] + b[1])];
            weight += doubled;
        }
        let scale = if weight == 0.0 { 0.0 } else { 1.0 / (3.0 * weight) };
        (weight.abs() / 2.0, [first[0] + sum[0] * scale, first[1] + sum[1] * scale])
    }

    /// The parts where a value is at most 0, and where it is more. The value must be linear in the place.
    pub fn cut(&self, value: impl Fn([f64; 2]) -> f64) -> [Polygon; 2] {
        let mut parts = [*self, Polygon::EMPTY];
        let [inside, outside] = &mut parts;
        inside.cut_off(value, outside);
        parts
    }

    /// Leaves of the polygon the part where a value is at most 0, and puts the rest in the place of `outside`.
    #[inline]
    pub fn cut_off(&mut self, value: impl Fn([f64; 2]) -> f64, outside: &mut Polygon) {
        let whole = *self;
        (self.count, outside.count) = (0, 0);
        let Some(&last) = whole.vertices().last() else { return };
        let mut before = (last, value(last));
        for &vertex in whole.vertices() {
            let here = (vertex, value(vertex));
            if (before.1 <= 0.0) != (here.1 <= 0.0) {
                let crossing = crossing(before, here);
                self.push(crossing);
                outside.push(crossing);
            }
            if here.1 > 0.0 {
                outside.push(vertex)
            } else {
                self.push(vertex)
            }
            before = here;
        }
    }

    /// The same polygon elsewhere.
    #[must_use]
    pub fn moved(&self, by: [f64; 2]) -> Self {
        let mut moved = *self;
        moved.shift(by);
        moved
    }

    /// Moves the polygon.
    #[inline]
    pub fn shift(&mut self, by: [f64; 2]) {
        for vertex in &mut self.vertices[..self.count] {
            *vertex = [vertex[0] + by[0], vertex[1] + by[1]];
        }
    }

    /// Twice the signed areas of the triangles that the first vertex spans with each edge, and the edge as seen from it:
    /// of small polygons far from the reference no digits are lost.
    fn triangles(&self) -> impl Iterator<Item = ([[f64; 2]; 2], f64)> + '_ {
        let first = self.vertices[0];
        let edges = self.vertices().windows(2).skip(1);
        edges.map(move |edge| {
            let [a, b] = [edge[0], edge[1]].map(|v| [v[0] - first[0], v[1] - first[1]]);
            ([a, b], a[0] * b[1] - b[0] * a[1])
        })
    }

    #[inline]
    fn push(&mut self, vertex: [f64; 2]) {
        if self.count < Self::MOST {
            self.vertices[self.count] = vertex;
            self.count += 1;
        } else {
            self.push_beyond(vertex);
        }
    }

    /// Puts a vertex more than there is room for.
    #[cold]
    fn push_beyond(&mut self, vertex: [f64; 2]) {
        // The new one closes the polygon, or rounding has bent it.
        let all = |k: usize| if k < Self::MOST { self.vertices[k] } else { vertex };
        let doubled = |k: usize| {
            let [a, b, c] = [k + Self::MOST, k, k + 1].map(|k| all(k % (Self::MOST + 1)));
            ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
        };
        let least = (0..=Self::MOST).min_by(|&a, &b| doubled(a).total_cmp(&doubled(b)));
        if let Some(least) = least.filter(|&least| least < Self::MOST) {
            self.vertices.copy_within(least + 1.., least);
            self.vertices[Self::MOST - 1] = vertex;
        }
    }
}

impl PartialEq for Polygon {
    /// By its vertices: what is behind the last one is left from cuts.
    fn eq(&self, other: &Self) -> bool {
        self.vertices() == other.vertices()
    }
}

impl FromIterator<[f64; 2]> for Polygon {
    /// The polygon of these vertices.
    fn from_iter<I: IntoIterator<Item = [f64; 2]>>(vertices: I) -> Self {
        let mut polygon = Polygon::EMPTY;
        vertices.into_iter().for_each(|vertex| polygon.push(vertex));
        polygon
    }
}

/// Where the value between two vertices is 0. The same from both sides, so that two parts have this point in common, and so
/// that it does not matter in which order a polygon has its vertices.
#[inline]
fn crossing(a: ([f64; 2], f64), b: ([f64; 2], f64)) -> [f64; 2] {
    let ((p, from), (q, to)) = if a.1 <= 0.0 { (a, b) } else { (b, a) };
    let share = from / (from - to);
    [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square cut by `count` lines around it: a regular polygon about `middle`.
    fn regular(count: u32, middle: [f64; 2]) -> Polygon {
        let side = |k: u32| (f64::from(k) / f64::from(count) * std::f64::consts::TAU).sin_cos();
        (0..count)
            .map(side)
            .fold(Polygon::square(1.0), |rest, (sin, cos)| rest.cut(|[u, v]| cos * u + sin * v - 0.5)[0])
            .moved(middle)
    }

    #[test]
    fn parts_make_up_the_whole() {
        let whole = regular(7, [0.3, -0.1]);
        for (a, b, c) in [(1.0, 0.0, 0.2), (0.3, -0.7, 0.01), (1.0, 1.0, 2.0), (-1e-9, 1e-9, 0.0)] {
            let parts = whole.cut(|[u, v]| a * u + b * v - c);
            let [inside, outside] = parts.map(|part| part.area());
            assert!((inside + outside - whole.area()).abs() < 1e-15, "{inside} {outside}");
            for k in 0..2 {
                let moment: f64 = parts.iter().map(|part| part.area() * part.centroid()[k]).sum();
                assert!((moment / whole.area() - whole.centroid()[k]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_small_polygon_far_away_keeps_its_digits() {
        let near = regular(6, [0.0; 2]);
        let far = near.moved([1e6, -1e6]);
        assert!((far.area() / near.area() - 1.0).abs() < 1e-9);
        assert!((far.centroid()[0] - 1e6).abs() < 1e-9 && (far.centroid()[1] + 1e6).abs() < 1e-9);
    }

    #[test]
    fn of_many_vertices_the_least_are_left_out() {
        let round = regular(60, [0.0; 2]);
        assert_eq!(round.vertices().len(), Polygon::MOST);
        // The circle that it goes around has a radius of 0.5.
        assert!((round.area() / (std::f64::consts::PI * 0.25) - 1.0).abs() < 0.06, "{}", round.area());
        assert!(round.centroid().iter().all(|c| c.abs() < 0.02));
    }

    #[test]
    fn nothing_is_left_of_what_lies_beyond() {
        let [inside, outside] = Polygon::square(0.5).cut(|_| 1.0);
        assert_eq!((inside.area(), inside.vertices().len(), outside), (0.0, 0, Polygon::square(0.5)));
        assert_eq!(inside.cut(|_| 1.0), [Polygon::EMPTY; 2]);
    }
}
