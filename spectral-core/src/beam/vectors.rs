//! Wave vectors in a crystal that are linear in the place in the picture.

use super::Pencil;
use crate::crystal::Crystal;
use glam::DVec3;

/// The wave vectors N = k/k₀ that go with the rays of a [`Pencil`] in a crystal, to first order. All are of one mode, so on one
/// sheet of the surface of wave vectors ([`Crystal::sheet`]).
///
/// At a plane surface the tangential part of N is the same for all waves, and N' of a wave that is sent on stays on its sheet,
/// whose normal is the ray ŝ':
///
/// ```text
/// ∂N' = ∂q + ∂ζ' n,  ∂q = ∂N − (n·∂N) n,  ŝ'·∂N' = 0  so  ∂ζ' = −(ŝ'·∂q)/(ŝ'·n)
/// ```
///
/// The rays turn with N by the curvature of the sheet: [`Crystal::ray_by`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vectors {
    /// N of the pencil's ray.
    pub vector: DVec3,
    /// Its derivatives by u and v, 1 a pixel.
    pub by: [DVec3; 2],
}

impl Vectors {
    /// Those of rays in air, where N is the direction.
    pub fn in_air(pencil: &Pencil) -> Self {
        Vectors { vector: pencil.direction, by: pencil.direction_by }
    }

    /// Those of a wave that a plane surface with this unit normal makes of them, given by its N and its unit ray.
    #[must_use]
    pub fn sent(&self, normal: DVec3, vector: DVec3, ray: DVec3) -> Self {
        let by = self.by.map(|by| {
            let tangential = by - normal * normal.dot(by);
            tangential - normal * (ray.dot(tangential) / ray.dot(normal))
        });
        Vectors { vector, by }
    }

    /// The same wave vectors about that of another place, which is (0, 0) from then on. N is put back on its sheet, which is
    /// curved.
    #[must_use]
    pub fn about(&self, [u, v]: [f64; 2], crystal: &Crystal, sheet: usize) -> Self {
        let vector = self.vector + u * self.by[0] + v * self.by[1];
        let gradient = DVec3::from(crystal.gradient(sheet, vector.to_array()));
        let size = vector.dot(gradient).sqrt();
        let (vector, gradient) = (vector / size, gradient / size);
        let by = self.by.map(|by| by - vector * gradient.dot(by));
        Vectors { vector, by }
    }
}

impl Pencil {
    /// The rays of a mode with these wave vectors, beginning where these rays begin.
    #[must_use]
    pub fn of_mode(&self, crystal: &Crystal, sheet: usize, vectors: &Vectors) -> Self {
        let vector = vectors.vector.to_array();
        let turned = |by: DVec3| DVec3::from(crystal.ray_by(sheet, vector, by.to_array()));
        let direction = DVec3::from(crystal.gradient(sheet, vector)).normalize();
        Pencil { direction, direction_by: vectors.by.map(turned), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Projection, View};

    const N: DVec3 = DVec3::new(0.36, -0.48, 0.8);

    fn view() -> View {
        let [position, look_at] = [DVec3::new(3.0, -2.0, 9.0), DVec3::new(0.2, 0.1, -0.3)];
        let projection = Projection::Perspective { fov: 30.0 };
        Camera { position, look_at, up: DVec3::Y, projection }.view(80, 60).unwrap()
    }

    fn crystals() -> [Crystal; 2] {
        let axes = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
        [Crystal::uniaxial([1.92, 1.70], [0.6, 0.0, 0.8]), Crystal::new([1.6, 1.65, 1.75], axes)]
    }

    /// Mode `first` of the entry, which the plane z = −2 reflects as mode `second`: the rays and wave vectors of a place.
    fn followed(crystal: &Crystal, place: [f64; 2], [first, second]: [usize; 2]) -> (Pencil, Vectors) {
        let pencil = Pencil::of_camera(&view(), place).at_plane(N, 1.5);
        let sent = |pencil: &Pencil, vectors: &Vectors, n: DVec3, side: f64, mode: usize| {
            let q = vectors.vector - n * n.dot(vectors.vector);
            let wave = crystal.waves(q.to_array(), n.to_array(), side)[mode];
            let vectors = vectors.sent(n, wave.wave_vector().into(), wave.ray().into());
            (pencil.of_mode(crystal, mode, &vectors), vectors)
        };
        let (pencil, vectors) = sent(&pencil, &Vectors::in_air(&pencil), -N, 1.0, first);
        sent(&pencil.at_plane(DVec3::Z, -2.0), &vectors, -DVec3::Z, -1.0, second)
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        const STEP: f64 = 1e-4;
        for crystal in crystals() {
            for modes in [[0, 0], [0, 1], [1, 0], [1, 1]] {
                let place = [11.5, 47.25];
                let (pencil, vectors) = followed(&crystal, place, modes);
                for k in 0..2 {
                    let at = |sign: f64| {
                        let mut place = place;
                        place[k] += sign * STEP;
                        followed(&crystal, place, modes)
                    };
                    let ((p, n), (q, m)) = (at(1.0), at(-1.0));
                    let same = |by: DVec3, a: DVec3, b: DVec3| {
                        assert!(
                            by.abs_diff_eq((a - b) / (2.0 * STEP), 1e-8),
                            "{modes:?}: {by} {}",
                            (a - b) / (2.0 * STEP)
                        );
                    };
                    same(pencil.origin_by[k], p.origin, q.origin);
                    same(pencil.direction_by[k], p.direction, q.direction);
                    same(vectors.by[k], n.vector, m.vector);
                }
            }
        }
    }

    #[test]
    fn wave_vectors_about_another_place_are_the_same_ones() {
        for crystal in crystals() {
            for modes in [[0, 1], [1, 0]] {
                let (_, vectors) = followed(&crystal, [40.0, 30.0], modes);
                let (pencil, there) = followed(&crystal, [40.04, 29.97], modes);
                let moved = vectors.about([0.04, -0.03], &crystal, modes[1]);
                assert!(moved.vector.abs_diff_eq(there.vector, 1e-6), "{} {}", moved.vector, there.vector);
                assert!(moved.by.iter().all(|by| by.dot(pencil.direction).abs() < 1e-6));
            }
        }
    }
}
