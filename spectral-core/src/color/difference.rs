//! CIELAB and the colour difference ΔE₀₀.

/// CIELAB [L*, a*, b*] of tristimulus values under a white, both [X, Y, Z] on one scale (CIE 15:2018, §8.2.1).
///
/// ```
/// use spectral_core::color::{RgbSpace, lab};
/// let white = RgbSpace::Srgb.white_xyz();
/// assert_eq!(lab(white, white), [100.0, 0.0, 0.0]);
/// ```
pub fn lab(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    const KNEE: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > KNEE.powi(3) { t.cbrt() } else { t / (3.0 * KNEE * KNEE) + 4.0 / 29.0 };
    let [x, y, z] = [f(xyz[0] / white[0]), f(xyz[1] / white[1]), f(xyz[2] / white[2])];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The colour difference ΔE₀₀ of two CIELAB colours [L*, a*, b*], with kL = kC = kH = 1.
///
/// CIEDE2000 by Sharma, Wu & Dalal, "The CIEDE2000 color-difference formula: implementation notes, supplementary test data,
/// and mathematical observations", Color Research & Application 30 (2005), equations 2–22. A difference of 1 is just
/// noticeable for a careful observer.
pub fn delta_e_2000(first: [f64; 3], second: [f64; 3]) -> f64 {
    let pow7_ratio = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let [l1, a1, b1] = first;
    let [l2, a2, b2] = second;
    let g = 0.5 * (1.0 - pow7_ratio(0.5 * (a1.hypot(b1) + a2.hypot(b2))));
    let (a1, a2) = (a1 * (1.0 + g), a2 * (1.0 + g));
    let (c1, c2) = (a1.hypot(b1), a2.hypot(b2));
    let (h1, h2) = (hue(a1, b1), hue(a2, b2));
    let achromatic = c1 * c2 == 0.0;

    let dh = match h2 - h1 {
        _ if achromatic => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let (dl, dc) = (l2 - l1, c2 - c1);
    let dh = 2.0 * (c1 * c2).sqrt() * (0.5 * dh).to_radians().sin();

    let h = match h1 + h2 {
        sum if achromatic => sum,
        sum if (h1 - h2).abs() <= 180.0 => 0.5 * sum,
        sum if sum < 360.0 => 0.5 * (sum + 360.0),
        sum => 0.5 * (sum - 360.0),
    };
    let (l, c) = (0.5 * (l1 + l2), 0.5 * (c1 + c2));
    let cos = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cos(h - 30.0) + 0.24 * cos(2.0 * h) + 0.32 * cos(3.0 * h + 6.0)
        - 0.20 * cos(4.0 * h - 63.0);
    let offset = (l - 50.0).powi(2);
    let s_l = 1.0 + 0.015 * offset / (20.0 + offset).sqrt();
    let s_c = 1.0 + 0.045 * c;
    let s_h = 1.0 + 0.015 * c * t;
    let rotation = (60.0 * (-((h - 275.0) / 25.0).powi(2)).exp()).to_radians().sin();
    let r_t = -2.0 * pow7_ratio(c) * rotation;
    let (dl, dc, dh) = (dl / s_l, dc / s_c, dh / s_h);
    (dl * dl + dc * dc + dh * dh + r_t * dc * dh).max(0.0).sqrt()
}

/// The hue angle in degrees, 0 to 360; 0 for grey.
fn hue(a: f64, b: f64) -> f64 {
    let degrees = b.atan2(a).to_degrees();
    if degrees < 0.0 { degrees + 360.0 } else { degrees }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sharmas_published_pairs() {
        // Sharma, Wu & Dalal 2005, table 1: pairs that detect errors in the treatment of hue.
        #[rustfmt::skip]
        let pairs = [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 3.1571, -77.2803], [50.0, 0.0, -82.7485], 2.8615),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.001], 7.1792),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0011], 7.2195),
            ([50.0, -0.001, 2.49], [50.0, 0.001, -2.49], 4.8045),
            ([50.0, -0.001, 2.49], [50.0, 0.0011, -2.49], 4.7461),
            ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [61.0, -5.0, 29.0], 22.8977),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([22.7233, 20.0904, -46.694], [23.0331, 14.973, -42.5619], 2.0373),
            ([90.8027, -2.0831, 1.441], [91.1528, -1.6435, 0.0447], 1.4441),
            ([2.0776, 0.0795, -1.135], [0.9033, -0.0636, -0.5514], 0.9082),
        ];
        for (a, b, expected) in pairs {
            for found in [delta_e_2000(a, b), delta_e_2000(b, a)] {
                assert!((found - expected).abs() < 5.1e-5, "{a:?} {b:?}: {found}, published {expected}");
            }
        }
    }

    #[test]
    fn a_colour_is_no_distance_from_itself() {
        assert_eq!(delta_e_2000([50.0, 10.0, -20.0], [50.0, 10.0, -20.0]), 0.0);
    }

    #[test]
    fn dark_colours_take_the_linear_branch() {
        let [l, a, b] = lab([0.001; 3], [1.0; 3]);
        assert!((l - 0.001 * (29f64 / 3.0).powi(3)).abs() < 1e-12 && a == 0.0 && b == 0.0);
    }
}
