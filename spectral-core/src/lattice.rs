//! Samples of pixels that may stop at different numbers of them: an extensible lattice in three dimensions.
//!
//! What a pixel shows is an integral over its area and over the places of the wavelengths in their cells. Its integrand
//! jumps where a ray passes from one facet to the next, and dispersion moves these edges with the wavelength: they are
//! surfaces in x, y and wavelength, of any slope. So samples should lie evenly in all three at once, seen from any side.
//!
//! The points are an extensible lattice sequence (Hickernell, Hong, L'Ecuyer & Lemieux 2001, "Extensible lattice sequences
//! for quasi-Monte Carlo quadrature"): point i is the centre plus φ₃(i)·g, modulo 1, with van der Corput's radical inverse
//! φ₃ in base 3 and a vector g of whole numbers. Its first 3ᵏ points are the lattice of all j·g/3ᵏ, for each k:
//!
//! * they are among the points of the next, so that a pixel may stop there and has lost nothing;
//! * each coordinate takes 3ᵏ values, equally far apart, each once;
//! * they are symmetric about the centre, the number being odd: their mean is the centre exactly, in the pixel and in
//!   the wavelength cells. A base of 2 would not have this.
//!
//! The quality of a lattice is how far apart the planes are at most on which its points lie: 1/|h| for the shortest of the
//! whole vectors h with h·g ≡ 0 modulo their number n (the spectral test; Knuth, *The Art of Computer Programming* 2,
//! §3.3.4). g was found digit by digit in base 3, so that from 3 to 3¹¹ points |h| is at least 0.745 n^⅓ in space and
//! 0.745 n^½ in the pixel's square, of 1.12 and 1.07 that are possible at a single n. Lattices alike in this still differ
//! by some tenth in a picture: of two dozen the one was taken that had the least error on diamond, quartz and sapphire.

/// The vector g, modulo [`POINTS`].
const GENERATOR: [u64; 3] = [1, 49_444, 121_288];

/// The points that there are, 3¹¹: more than the most samples a pixel.
const POINTS: u64 = 177_147;

/// Point `index` of the sequence, which repeats after 3¹¹: where a sample lies in its pixel, (0.5, 0.5) being the centre,
/// and by which part of their cells its wavelengths lie above the cells' lower ends; all in (0, 1).
///
/// ```
/// use spectral_core::lattice::point;
/// assert_eq!(point(0), [0.5; 3]);
/// assert_eq!(point(1), [5.0 / 6.0; 3]);
/// ```
pub fn point(index: u32) -> [f64; 3] {
    let (mut inverse, mut place, mut rest) = (0, POINTS, u64::from(index));
    while rest > 0 {
        place /= 3;
        inverse += rest % 3 * place;
        rest /= 3;
    }
    // In halves of the smallest step, which make the centre a whole number. An odd number is never 0 modulo an even one.
    GENERATOR.map(|g| ((2 * g * inverse + POINTS) % (2 * POINTS)) as f64 / (2 * POINTS) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_times_as_many_points_each_time_are_even_in_every_coordinate_and_symmetric() {
        for k in 0..=9 {
            let count = 3u32.pow(k);
            let n = f64::from(count);
            for axis in 0..3 {
                let mut values: Vec<f64> = (0..count).map(|i| point(i)[axis]).collect();
                assert!(values.iter().all(|v| (0.0..1.0).contains(v) && *v > 0.0));
                assert!((values.iter().sum::<f64>() / n - 0.5).abs() < 1e-12, "{count}");
                values.sort_by(f64::total_cmp);
                let even = |(j, v): (usize, &f64)| (v - (j as f64 + 0.5) / n).abs() < 1e-12;
                assert!(values.iter().enumerate().all(even), "{count}");
            }
            // Mirrored at the centre, they are the same points.
            let whole = |p: [f64; 3]| p.map(|v| (v * n * 2.0).round() as i64);
            let mut points: Vec<_> = (0..count).map(|i| whole(point(i))).collect();
            let mut mirrored: Vec<_> = (0..count).map(|i| whole(point(i).map(|v| 1.0 - v))).collect();
            points.sort_unstable();
            mirrored.sort_unstable();
            assert_eq!(points, mirrored, "{count}");
        }
    }

    #[test]
    fn points_lie_on_no_few_planes_in_space_nor_lines_in_the_pixel() {
        const LEAST: f64 = 0.745;
        let [gx, gy, gz] = GENERATOR.map(|g| g as i64);
        for k in 1..=11 {
            let n = 3i64.pow(k);
            // Whether a vector h is one of those that set the distance of planes, and too short.
            let poor = |h: [i64; 3], dimensions: f64| {
                let length = ((h[0] * h[0] + h[1] * h[1] + h[2] * h[2]) as f64).sqrt();
                let planes = (h[0] * gx + h[1] * gy + h[2] * gz) % n == 0 && h != [0; 3];
                planes && length < LEAST * (n as f64).powf(1.0 / dimensions)
            };
            let reach = |dimensions: f64| (LEAST * (n as f64).powf(1.0 / dimensions)) as i64;
            let (flat, deep) = (reach(2.0), reach(3.0));
            let lines = (0..=flat).flat_map(|x| (-flat..=flat).map(move |y| [x, y, 0]));
            assert_eq!(lines.into_iter().find(|h| poor(*h, 2.0)), None, "{n}");
            let square = (0..=deep).flat_map(|x| (-deep..=deep).map(move |y| [x, y]));
            let mut planes = square.flat_map(|[x, y]| (-deep..=deep).map(move |z| [x, y, z]));
            assert_eq!(planes.find(|h| poor(*h, 3.0)), None, "{n}");
        }
    }
}
