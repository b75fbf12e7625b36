//! Pixel samples, as an extensible lattice in three dimensions: pixels may stop at different numbers of samples.
//!
//! The colour of a pixel is an integral over its area and over the positions of the wavelengths in their cells. The
//! integrand jumps where rays pass from one facet to the next, and dispersion moves these edges with the wavelength. So the
//! jumps are surfaces of any slope in x, y and wavelength, and samples should be evenly distributed in all three together.
//!
//! The points are an extensible lattice sequence (Hickernell, Hong, L'Ecuyer & Lemieux 2001, "Extensible lattice sequences
//! for quasi-Monte Carlo quadrature"): point i is the centre plus φ₃(i)·g, modulo 1, with van der Corput's radical inverse
//! φ₃ in base 3 and an integer vector g. For each k, its first 3ᵏ points are the lattice of all j·g/3ᵏ:
//!
//! * they are among the points of the next lattice, so a pixel that stops there wastes nothing;
//! * each coordinate takes 3ᵏ equidistant values, each once;
//! * they are symmetric about the centre, since their number is odd. So their mean is exactly the centre, in the pixel and
//!   in the wavelength cells. With base 2 it would not be.
//!
//! The quality of a lattice is the largest distance between the parallel planes that contain its points: 1/|h| for the
//! shortest integer vector h with h·g ≡ 0 modulo their number n (the spectral test; Knuth, *The Art of Computer
//! Programming* 2, §3.3.4). g was chosen digit by digit in base 3. From 3 to 3¹¹ points |h| is at least 0.745 n^⅓ in space
//! and 0.745 n^½ in the pixel's square; the optimum for a single n is 1.12 and 1.07. Lattices of equal quality still
//! differ by about a tenth in pictures. Of two dozen, this one had the smallest error on diamond, quartz and sapphire.

/// The vector g, modulo [`POINTS`].
const GENERATOR: [u64; 3] = [1, 49_444, 121_288];

/// The number of points, 3¹¹: more than the largest number of samples a pixel.
const POINTS: u64 = 177_147;

/// Point `index` of the sequence, which repeats after 3¹¹: the position of a sample in its pixel, with the centre (0.5,
/// 0.5), and the position of its wavelengths in their cells; all in (0, 1).
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
    // In units of half the smallest step, so that the centre is an integer. An odd number is never 0 modulo an even one.
    GENERATOR.map(|g| ((2 * g * inverse + POINTS) % (2 * POINTS)) as f64 / (2 * POINTS) as f64)
}

/// The places of wavelengths that samples have in turn where there are many: 3⁵.
pub const PLACES: u32 = 243;

/// The inverse of g's last number modulo [`PLACES`].
const INVERSE: i64 = 196;

/// Where sample `index` lies in its pixel if its wavelengths are at the place of sample `index` modulo [`PLACES`].
///
/// A lattice point has its own place of the wavelengths, and its coordinates in the pixel would go ill with another. So each
/// run of [`PLACES`] samples takes its points of the lattice in the order in which they come nearest to the places of the first
/// run: they are no more than half a step from these, 1/486. 3ᵏ samples are still the 3ᵏ points of the lattice.
///
/// ```
/// use spectral_core::lattice::{PLACES, point, sharing};
/// let [x, y, _] = point(100);
/// assert_eq!(sharing(100), [x, y]);
/// ```
pub fn sharing(index: u32) -> [f64; 2] {
    let first = index - index % PLACES;
    // From a run to the first one, points move along the last coordinate by so many of its steps, to the nearest.
    let [.., start] = point(first);
    let steps = ((start - 0.5) * f64::from(PLACES)).round() as i64;
    let turned = i64::from(reversed(index % PLACES)) - steps * INVERSE;
    let [x, y, _] = point(first + reversed(turned.rem_euclid(PLACES.into()) as u32));
    [x, y]
}

/// The five digits in base 3 of a number below [`PLACES`], in the opposite order.
fn reversed(mut number: u32) -> u32 {
    (0..5).fold(0, |reversed, _| {
        let digit = number % 3;
        number /= 3;
        3 * reversed + digit
    })
}

/// Place `index` of the sequence in one dimension, for samples that differ in their wavelengths alone: the first 3ᵏ places are
/// the middles of 3ᵏ equal cells, and the first is 0.5.
///
/// ```
/// use spectral_core::lattice::place;
/// assert_eq!([0, 1, 2].map(place), [0.5, 5.0 / 6.0, 1.0 / 6.0]);
/// ```
pub fn place(index: u32) -> f64 {
    // g begins with 1.
    let [place, ..] = point(index);
    place
}

/// The number of choices at an event, 3¹⁰: so small that a product of two stays below 2³².
pub const CHOICES: u32 = 59_049;

/// The multiplier a of Korobov's rule for the choices.
pub const MULTIPLIER: u32 = 229;

/// All choices are shifted by so many of their smallest steps: in symmetrical stones two rays often have the same weight, and
/// rounding must not decide between them.
pub const SHIFT: u32 = 17;

/// By what sample `index` chooses one of two rays at surface event `event`, in (0, 1): the first one if this is below its
/// share of their weight.
///
/// The further dimensions of the lattice, one for each event: a point near the centre plus φ₃(i)·aᵉ, modulo 1 (Korobov's choice
/// of the vector). Every pixel and every wavelength chooses alike, so a choice is no noise; and over 3ᵏ samples each dimension takes
/// 3ᵏ equidistant values. Sample 0 follows the heavier ray. a is the multiplier with the best spectral test of the pairs
/// among five successive dimensions.
///
/// ```
/// use spectral_core::lattice::choice;
/// assert!((choice(0, 7) - 0.5).abs() < 1e-3);
/// let mean = (0..27).map(|i| choice(i, 3)).sum::<f64>() / 27.0;
/// assert!((mean - 0.5).abs() < 1e-3);
/// ```
pub fn choice(index: u32, event: u32) -> f64 {
    chosen(order(index), power(event))
}

/// φ₃ of sample `index`, in units of 3⁻¹⁰: the sample's part of its [`choice`].
///
/// ```
/// use spectral_core::lattice::{choice, chosen, order, power};
/// assert_eq!(chosen(order(5), power(7)), choice(5, 7));
/// ```
pub fn order(index: u32) -> u32 {
    let (mut inverse, mut place, mut rest) = (0, CHOICES, index % CHOICES);
    while rest > 0 {
        place /= 3;
        inverse += rest % 3 * place;
        rest /= 3;
    }
    inverse
}

/// aᵉ modulo 3¹⁰: the surface event's part of a [`choice`].
pub fn power(event: u32) -> u32 {
    let (mut product, mut square, mut rest) = (1, MULTIPLIER, event);
    while rest > 0 {
        if rest & 1 == 1 {
            product = product * square % CHOICES;
        }
        square = square * square % CHOICES;
        rest >>= 1;
    }
    product
}

/// The place of the choices of a part of a beam, from `place`, that of the whole beam (`order`·aᵉ in [`choice`]). `side` is the number of
/// the facet's side beyond which the part lies. So parts choose differently, and what a part chooses does not depend on the other
/// parts. Two sides are the golden section of all places apart.
pub fn part(place: u32, side: usize) -> u32 {
    const STEP: usize = 36_494;
    (place + ((side + 1) * STEP % CHOICES as usize) as u32) % CHOICES
}

/// The [`choice`] of which these are the parts, for those who keep them.
pub fn chosen(order: u32, power: u32) -> f64 {
    let place = order * power % CHOICES + SHIFT;
    f64::from((2 * place + CHOICES) % (2 * CHOICES)) / f64::from(2 * CHOICES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_lattice_is_even_in_every_coordinate_and_symmetric() {
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
            // Reflection at the centre gives the same points.
            let whole = |p: [f64; 3]| p.map(|v| (v * n * 2.0).round() as i64);
            let mut points: Vec<_> = (0..count).map(|i| whole(point(i))).collect();
            let mut mirrored: Vec<_> = (0..count).map(|i| whole(point(i).map(|v| 1.0 - v))).collect();
            points.sort_unstable();
            mirrored.sort_unstable();
            assert_eq!(points, mirrored, "{count}");
        }
    }

    #[test]
    fn samples_that_share_wavelengths_are_the_points_with_the_nearest_places() {
        let bits = |[x, y]: [f64; 2]| [x.to_bits(), y.to_bits()];
        for run in 0..27 {
            let indices = run * PLACES..(run + 1) * PLACES;
            let places: std::collections::HashMap<_, _> =
                indices.clone().map(point).map(|[x, y, place]| (bits([x, y]), place)).collect();
            let mut taken = std::collections::HashSet::new();
            for index in indices {
                let key = bits(sharing(index));
                let [.., shared] = point(index % PLACES);
                let apart = (places[&key] - shared + 0.5).rem_euclid(1.0) - 0.5;
                assert!(taken.insert(key) && apart.abs() < 0.5001 / f64::from(PLACES), "{index}: {apart}");
            }
        }
    }

    #[test]
    fn points_do_not_lie_on_few_planes_in_space_or_lines_in_the_pixel() {
        const LEAST: f64 = 0.745;
        let [gx, gy, gz] = GENERATOR.map(|g| g as i64);
        for k in 1..=11 {
            let n = 3i64.pow(k);
            // Whether a vector h determines a distance of planes and is too short.
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
