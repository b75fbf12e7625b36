//! Directions: Snell's law, measured with a light that shows angles, and the critical angle.

use gemtrace_tests::prelude::*;
use spectral_core::{dispersion::fraunhofer, material::Material};
use std::f64::consts::PI;

/// Entry at one face and exit at the other.
fn two_events(nm: &[f64]) -> RenderSettings {
    RenderSettings { max_depth: 2, leftover: Leftover::Drop, ..settings(nm) }
}

/// A ray in the yz plane, `slope` degrees above the +y direction, that enters the left face of a prism.
fn into_prism(apex: f64, slope: f64) -> Camera {
    let half = (apex / 2.0).to_radians();
    let entry = DVec3::new(0.11, -8.0 * half.sin(), -8.0 * half.cos());
    let (sin, cos) = slope.to_radians().sin_cos();
    let direction = DVec3::new(0.0, cos, sin);
    probe(entry - 30.0 * direction, direction, 1e-3)
}

fn through_prism(apex: f64, slope: f64, material: Material) -> Scene {
    scene(into_prism(apex, slope), 1, furnace(), vec![stone(prism(apex, 20.0), material)])
}

/// By wavelength, the angle of the exit below the +y direction in degrees.
fn descent(way: Way, scene: &Scene, nm: &[f64]) -> Vec<f64> {
    let under = |environment| {
        let scene = Scene { environment, ..scene.clone() };
        way.render(&scene, &two_events(nm)).radiances().remove(0)
    };
    let (marked, white) = (under(protractor()), under(protractor_white()));
    marked.into_iter().zip(white).map(|(m, w)| 180.0 * m / w - 90.0).collect()
}

#[test]
fn minimum_deviation_of_a_60_degree_prism() {
    // δ = 2 asin(n sin(A/2)) − A, stationary where the ray inside runs parallel to the base.
    let figures = [
        (fraunhofer::C, 1.514_322_4, 38.429_144),
        (fraunhofer::LOWER_D, 1.516_800_1, 38.646_705),
        (fraunhofer::F, 1.522_376_5, 39.138_126),
    ];
    for (nm, n, published) in figures {
        let glass = material("n-bk7");
        assert!((glass.index(nm) - n).abs() < 2e-6, "{nm} nm: {}", glass.index(nm));
        let least = 2.0 * (glass.index(nm) * 0.5).asin().to_degrees() - 60.0;
        assert!((least - published).abs() < 3e-4, "{nm} nm: {least}");
        for way in Way::ALL {
            let deviation = |off: f64| {
                let slope = least / 2.0 + off;
                slope + descent(way, &through_prism(60.0, slope, glass.clone()), &[nm])[0]
            };
            let at = deviation(0.0);
            assert!((at - least).abs() < 2e-5, "{way:?}, {nm} nm: {at} instead of {least}");
            assert!(deviation(0.5) > at + 1e-3 && deviation(-0.5) > at + 1e-3, "{way:?}: not the least");
        }
    }
}

#[test]
fn snell_across_the_fraunhofer_lines() {
    // Into a 15° prism along its face's normal: undeviated; out at asin(n sin 15°).
    let mut nm = fraunhofer::LINES.map(|(_, nm)| nm);
    nm.sort_by(f64::total_cmp);
    for name in ["diamond", "n-bk7", "corundum", "moissanite"] {
        let material = material(name);
        let scene = through_prism(15.0, -7.5, material.clone());
        for way in Way::ALL {
            for (found, nm) in descent(way, &scene, &nm).into_iter().zip(nm) {
                let out = (material.index(nm) * (15.0 * PI / 180.0).sin()).asin().to_degrees();
                let expected = out - 7.5;
                close(found, expected, way.tolerance(1e-4, 2e-5), format!("{way:?}, {name} at {nm} nm"));
            }
        }
    }
}

#[test]
fn the_critical_angle_divides_total_from_partial_reflection() {
    // Along the normal into a prism of apex A: the second face is met at A. The share that leaves is (1 − R₀)(1 − R(A))
    // below asin(1/n), and nothing above.
    for (n, critical) in [(1.5168_f64, 41.245_19), (1.76808, 34.442_94), (2.41726, 24.436_94)] {
        assert!(((1.0 / n).asin().to_degrees() - critical).abs() < 5e-6);
        let face = ((n - 1.0) / (n + 1.0)).powi(2);
        for way in Way::ALL {
            for off in [-10.0, -1.0, -0.1, -0.02, 0.02, 0.1, 1.0, 10.0] {
                let apex = (1.0 / n).asin().to_degrees() + off;
                let [s, p] = if off < 0.0 { reflectances(1.0 / n, apex) } else { [1.0; 2] };
                let reflected = (1.0 - face) * (s + p) / 2.0;
                let scene = through_prism(apex, -apex / 2.0, glass(n));
                let picture = way.render(&scene, &two_events(&[550.0]));
                let (seen, dropped) = (picture.first_line()[0], picture.report.energy.dropped_depth);
                // Near the critical angle T grows with the square root of the distance to it.
                let tolerance = way.tolerance(4e-6 / off.abs().sqrt().min(1.0), 1e-7);
                let what = format!("{way:?}, n = {n}, {off}° from critical");
                assert!((dropped - reflected).abs() < tolerance, "{what}: {dropped}, not {reflected}");
                assert!((seen - (1.0 - reflected)).abs() < tolerance, "{what}: {seen}");
                assert!(off < 0.0 || (seen - face).abs() < 1e-7, "{what}: reflection is total, but {seen}");
            }
        }
    }
}

#[test]
fn hemispherical_reflectance_of_a_sphere() {
    // With parallel rays, a sphere shows every angle with weight 2 sin θ cos θ. So its mean brightness in uniform light is
    // the hemispherical reflectance ∫R(θ) 2 sin θ cos θ dθ (Duntley 1942).
    let settings = RenderSettings { max_depth: 1, samples: 9, ..two_events(&[550.0]) };
    for (n, published) in [(1.5168, 0.094_24), (1.768, 0.129_694), (2.41726, 0.212_218)] {
        let ball = stone(sphere(1.0, 240, 480), glass(n));
        let seen = scene(parallel(DVec3::new(3.0, 2.0, 5.0), 2.02), 160, furnace(), vec![ball]);
        let picture = Way::Tree.render(&Scene { background: Background::Transparent, ..seen }, &settings);
        let bright: f64 = picture.first_line().iter().sum();
        let disc: f64 = picture.coverage().iter().sum();
        let mean = bright / disc;
        assert!((mean / published - 1.0).abs() < 3e-3, "n = {n}: {mean} instead of {published}");
    }
}
