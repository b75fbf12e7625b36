//! Watertight ray–triangle intersection (Woop, Benthin & Wald 2013).
//!
//! A shear maps the ray onto a coordinate axis. A triangle is then hit if its two-dimensional image contains the origin.
//! A corner has the same image in every triangle, and the signs of the edge functions are exact (see below). So
//! neighbours agree on which side of their shared edge the ray passes: one of them is hit, or both if the ray meets the
//! edge exactly.

use glam::{DVec3, Vec3};

use crate::{Hit, Ray};

/// A triangle in the traversal's layout, with its number in the input.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    corners: [[f32; 3]; 3],
    number: u32,
}

impl Triangle {
    pub fn new(corners: [Vec3; 3], number: u32) -> Triangle {
        Triangle { corners: corners.map(|corner| corner.to_array()), number }
    }

    #[inline(always)]
    pub fn corners(&self) -> &[[f32; 3]; 3] {
        &self.corners
    }

    #[inline(always)]
    pub fn number(&self) -> u32 {
        self.number
    }
}

/// The ray-dependent part of the test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shear {
    /// Last the axis of the direction's largest component.
    axes: [usize; 3],
    origin: [f32; 3],
    /// The other two components of the direction over the largest one.
    slope: [f32; 2],
    slope_exact: [f64; 2],
    origin_exact: DVec3,
    /// 1 / the direction's largest component.
    inverse: f64,
}

impl Shear {
    /// `None` if the direction is zero or anything is not finite.
    pub fn new(ray: &Ray) -> Option<Shear> {
        ray.is_proper().then(|| Shear::of(ray))
    }

    /// For a ray that [is proper](Ray::is_proper).
    #[inline(always)]
    pub fn of(ray: &Ray) -> Shear {
        let d = ray.direction.to_array();
        let [x, y, z] = d.map(f32::abs);
        let z = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let [dx, dy, dz] = axes.map(|axis| f64::from(d[axis]));
        let slope_exact = [dx / dz, dy / dz];
        let origin = axes.map(|axis| ray.origin.to_array()[axis]);
        Shear {
            axes,
            origin,
            slope: slope_exact.map(|slope| slope as f32),
            slope_exact,
            origin_exact: origin.map(f64::from).into(),
            inverse: 1.0 / dz,
        }
    }

    /// The hit of the ray's line with the triangle, for any sign of the ray parameter.
    ///
    /// The side on which the ray passes an edge is decided in single precision. Rounding is monotonic, so the difference
    /// of two rounded products has the sign of the exact difference or is zero. If it is zero or overflows, it is
    /// computed again in double precision, in which products of single-precision numbers are exact. The parameter and
    /// the barycentric coordinates are then computed in double precision from the unrounded shear, unless that puts the
    /// ray outside by its own, smaller rounding error.
    #[inline(always)]
    pub fn intersect(&self, triangle: &Triangle) -> Option<Hit> {
        let [a, b, c] = &triangle.corners;
        let image = [self.image(a), self.image(b), self.image(c)];
        let [a, b, c] = image;
        let mut u = c[0] * b[1] - c[1] * b[0];
        let mut v = a[0] * c[1] - a[1] * c[0];
        let mut w = b[0] * a[1] - b[1] * a[0];
        // Bitwise operators: branches on the single comparisons would be unpredictable.
        if (u == 0.0) | (v == 0.0) | (w == 0.0) | !(u + v + w).is_finite() {
            [u, v, w] = edges(image.map(|p| p.map(f64::from))).map(sign);
        }
        if ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0)) {
            return None;
        }
        self.locate(triangle, &image)
    }

    #[inline(always)]
    fn image(&self, corner: &[f32; 3]) -> [f32; 2] {
        let [x, y, z] = self.axes;
        let height = corner[z] - self.origin[2];
        [
            (corner[x] - self.origin[0]) - self.slope[0] * height,
            (corner[y] - self.origin[1]) - self.slope[1] * height,
        ]
    }

    #[inline(always)]
    fn locate(&self, triangle: &Triangle, image: &[[f32; 2]; 3]) -> Option<Hit> {
        let relative = triangle
            .corners
            .map(|corner| DVec3::from(self.axes.map(|axis| f64::from(corner[axis]))) - self.origin_exact);
        let exact = relative.map(|p| {
            let DVec3 { x, y, z } = p;
            [x - self.slope_exact[0] * z, y - self.slope_exact[1] * z]
        });
        let weights = weights(edges(exact)).or_else(|| weights(edges(image.map(|p| p.map(f64::from)))))?;
        let height = weights[0] * relative[0].z + weights[1] * relative[1].z + weights[2] * relative[2].z;
        let t = (height * self.inverse) as f32;
        t.is_finite().then_some(Hit {
            t,
            triangle: triangle.number,
            u: weights[1] as f32,
            v: weights[2] as f32,
        })
    }
}

/// Twice the signed areas of the origin with the edge opposite to each corner.
#[inline(always)]
fn edges([a, b, c]: [[f64; 2]; 3]) -> [f64; 3] {
    [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]]
}

#[inline(always)]
fn sign(value: f64) -> f32 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// Barycentric coordinates, if the edge functions agree in sign and the image is not degenerate.
#[inline(always)]
fn weights(edges: [f64; 3]) -> Option<[f64; 3]> {
    let sum = edges[0] + edges[1] + edges[2];
    let weights = edges.map(|edge| edge / sum);
    (sum != 0.0 && sum.is_finite() && weights.iter().all(|&weight| weight >= 0.0)).then_some(weights)
}
