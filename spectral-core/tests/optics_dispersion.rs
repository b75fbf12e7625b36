//! Dispersion models, Cauchy fits, and the messages about impossible figures.

use spectral_core::dispersion::{Dispersion, fraunhofer};
use spectral_core::material::{Catalogue, Kind};
use spectral_core::spectrum::{Ends, Tabulated};

const VISIBLE: [f64; 2] = [380.0, 780.0];
const BDG: [f64; 3] = [fraunhofer::B, fraunhofer::D, fraunhofer::G];

fn model(name: &str) -> &'static Dispersion {
    match &Catalogue::builtin().get(name).unwrap().kind {
        Kind::Dielectric { dispersion, .. } => dispersion,
        Kind::Conductor { .. } => panic!("{name} is a metal"),
    }
}

fn sampled(truth: &Dispersion, lines: &[f64]) -> Vec<[f64; 2]> {
    lines.iter().map(|&nm| [nm, truth.index(nm)]).collect()
}

fn largest_error(fit: &Dispersion, truth: &Dispersion) -> f64 {
    (380..=780).map(|nm| (fit.index(f64::from(nm)) - truth.index(f64::from(nm))).abs()).fold(0.0, f64::max)
}

fn rejection(measured: &[[f64; 2]]) -> String {
    Dispersion::fit(measured).unwrap_err().to_string()
}

fn refusal(model: Dispersion) -> String {
    model.check(VISIBLE).unwrap_err().to_string()
}

#[test]
fn three_measurements_are_met_exactly() {
    for name in ["diamond", "corundum", "n-bk7", "moissanite"] {
        let points = sampled(model(name), &BDG);
        let (fit, warnings) = Dispersion::fit(&points).unwrap();
        assert!(warnings.is_empty());
        for [nm, n] in points {
            assert!((fit.index(nm) - n).abs() < 1e-14, "{name} at {nm}");
        }
    }
}

#[test]
fn coefficients_of_a_cauchy_curve_come_back() {
    let truth = Dispersion::Cauchy(vec![2.3805, 0.01225, 0.00018]);
    for count in [3, 4, 9, 41] {
        let lines: Vec<f64> =
            (0..count).map(|i| 380.0 + 400.0 * f64::from(i) / f64::from(count - 1)).collect();
        let (fit, _) = Dispersion::fit(&sampled(&truth, &lines)).unwrap();
        let (Dispersion::Cauchy(found), Dispersion::Cauchy(given)) = (&fit, &truth) else { panic!() };
        for (a, b) in found.iter().zip(given) {
            assert!((a - b).abs() < 1e-13, "{count} points: {found:?}");
        }
    }
}

#[test]
fn fits_are_as_good_as_published_ones() {
    // Coefficients and errors of an independent least-squares solution.
    let five = [fraunhofer::B, fraunhofer::C, fraunhofer::D, fraunhofer::F, fraunhofer::G];
    for (name, lines, coefficients, error) in [
        ("diamond", &BDG[..], [2.38048551, 0.01225398, 0.0001794], 1.2e-4),
        ("corundum", &BDG, [1.75084828, 0.00625646, -9.501e-5], 6.4e-4),
        ("corundum", &five, [1.75128619, 0.00599473, -6.196e-5], 4.3e-4),
    ] {
        let truth = model(name);
        let (fit, _) = Dispersion::fit(&sampled(truth, lines)).unwrap();
        let Dispersion::Cauchy(found) = &fit else { panic!() };
        for (a, b) in found.iter().zip(coefficients) {
            assert!((a - b).abs() < 6e-9, "{name}: {found:?}");
        }
        assert!(largest_error(&fit, truth) < error, "{name}: {}", largest_error(&fit, truth));
    }
    let (fit, _) = Dispersion::fit(&sampled(model("n-bk7"), &BDG)).unwrap();
    assert!(largest_error(&fit, model("n-bk7")) < 4.6e-4);
}

#[test]
fn the_order_of_measurements_does_not_matter() {
    let mut points = sampled(model("diamond"), &[687.0, 589.0, 540.0, 486.0, 431.0]);
    let (forward, _) = Dispersion::fit(&points).unwrap();
    points.reverse();
    let (backward, _) = Dispersion::fit(&points).unwrap();
    assert!(largest_error(&forward, &backward) < 1e-14);
}

#[test]
fn slopes_are_the_derivatives() {
    let table = Tabulated::new(vec![400.0, 600.0], vec![1.6, 1.5], Ends::Extend).unwrap();
    let models = [
        Dispersion::Constant(1.5),
        Dispersion::Cauchy(vec![1.5, 0.004, 0.0001, 1e-6]),
        model("n-bk7").clone(),
        model("moissanite").clone(),
        model("chrysoberyl").clone(),
        Dispersion::Table(table),
    ];
    for dispersion in models {
        for nm in [420.0, 550.0, 590.0] {
            let numeric = (dispersion.index(nm + 0.01) - dispersion.index(nm - 0.01)) / 0.02;
            assert!((dispersion.slope(nm) - numeric).abs() < 1e-10, "{dispersion:?} at {nm}");
        }
    }
    // Angular dispersion of a 60° prism of N-BK7 at minimum deviation: −0.0036744° per nm at d.
    let (n, half) = (model("n-bk7").index(fraunhofer::LOWER_D), 30.0_f64.to_radians());
    let by_index = 2.0 * half.sin() / (1.0 - (n * half.sin()).powi(2)).sqrt();
    let per_nm = (by_index * model("n-bk7").slope(fraunhofer::LOWER_D)).to_degrees();
    assert!((per_nm + 0.0036744).abs() < 5e-8, "{per_nm}");
}

#[test]
fn impossible_measurements_are_refused() {
    let good = [[430.0, 1.53], [589.0, 1.517]];
    let with = |nm, n| rejection(&[good[0], good[1], [nm, n]]);
    for (nm, n, expected) in [
        (f64::NAN, 1.5, "finite"),
        (650.0, f64::INFINITY, "finite"),
        (0.65, 1.51, "micrometres: 0.65 µm = 650 nm"),
        (6500.0, 1.51, "ångströms: 6500 Å = 650 nm"),
        (1.51, 650.0, "the wavelength comes first"),
        (150.0, 1.51, "from 200 to 2000"),
        (-650.0, 1.51, "from 200 to 2000"),
        (650.0, 1.0, "greater than 1"),
        (650.0, 0.51, "greater than 1"),
        (589.0, 1.517, "measured[1] has the same wavelength"),
        (650.0, 1.0, "measured[2]: [650, 1]"),
    ] {
        assert!(with(nm, n).contains(expected), "{nm}, {n}: {}", with(nm, n));
    }
    assert!(rejection(&good).contains("2 measurements is not valid; Cauchy's formula needs three"));
    assert!(rejection(&[]).contains("needs three"));
    let near = with(575.0, 1.518);
    assert!(near.contains("575 nm and 589 nm") && near.contains("20 nm apart"), "{near}");
    // Close lines beside three well-spaced ones do no harm.
    assert!(Dispersion::fit(&[good[0], good[1], [587.56, 1.51705], [656.0, 1.5143]]).is_ok());
}

#[test]
fn questionable_measurements_give_warnings() {
    let (_, warnings) = Dispersion::fit(&[[486.13, 1.5224], [587.56, 1.5168], [656.27, 1.5143]]).unwrap();
    assert!(warnings.len() == 1 && warnings[0].message.contains("below 450 nm"), "{warnings:?}");
    let (_, warnings) =
        Dispersion::fit(&[[430.0, 1.527], [486.0, 1.5224], [540.0, 1.529], [589.0, 1.517], [656.0, 1.514]])
            .unwrap();
    assert!(warnings.len() == 1 && warnings[0].message.contains("540 nm"), "{warnings:?}");
}

#[test]
fn implausible_models_are_refused() {
    // Falls between the measurements, rises beyond them: a C that is far too negative.
    let rising = Dispersion::Cauchy(vec![1.5, 0.02, -0.003]);
    let message = rising.check(VISIBLE).unwrap_err().to_string();
    assert!(message.contains("slope of the index at 380 nm") && message.contains("380–780 nm"), "{message}");
    assert!(rising.check([560.0, 780.0]).is_ok());
    let (swapped, _) = Dispersion::fit(&[[430.0, 1.51], [589.0, 1.52], [656.0, 1.53]]).unwrap();
    assert!(refusal(swapped).contains("falls as wavelength grows"));
    for (coefficients, expected) in [
        (vec![0.9, 0.02], "greater than 1"),
        (vec![1.5046, 4200.0], "divided by 10⁶"),
        (vec![], "at least one"),
        (vec![1.5, f64::NAN], "finite"),
    ] {
        assert!(refusal(Dispersion::Cauchy(coefficients)).contains(expected), "{expected}");
    }
    assert!(Dispersion::Cauchy(vec![1.5]).check(VISIBLE).is_ok(), "a constant has no slope to be wrong");
}

#[test]
fn constants_and_resonances() {
    assert!(Dispersion::Constant(1.0).check(VISIBLE).is_ok(), "air");
    for n in [0.99, -1.5, f64::NAN, f64::INFINITY, 11.0] {
        assert!(Dispersion::Constant(n).check(VISIBLE).is_err(), "{n}");
    }
    let resonant = Dispersion::Sellmeier { a0: 0.0, terms: vec![[1.0, 0.25]] };
    let message = refusal(resonant);
    assert!(message.contains("(500 nm)") && message.contains("resonance"), "{message}");
    let imaginary = Dispersion::Sellmeier { a0: -3.0, terms: vec![[1.0, 0.01]] };
    assert!(refusal(imaginary).contains("no real index"));
    let pole = Dispersion::Pole { a: 2.0, b: 0.1, c: 0.36, d: 0.0, squared_numerator: false };
    assert!(refusal(pole).contains("(600 nm)"));
    assert!(model("diamond").check([780.0, 380.0]).unwrap_err().to_string().contains("the shorter first"));
    assert!(model("diamond").check([f64::NAN, 380.0]).is_err());
}

#[test]
fn tables() {
    let table = |nm: &[f64], n: &[f64]| {
        Dispersion::Table(Tabulated::new(nm.to_vec(), n.to_vec(), Ends::Extend).unwrap())
    };
    let short = table(&[400.0, 500.0, 700.0], &[1.53, 1.52, 1.51]);
    assert!((short.index(450.0) - 1.525).abs() < 1e-15);
    assert_eq!(short.index(380.0), 1.53);
    let warnings = short.check(VISIBLE).unwrap();
    assert!(warnings.len() == 1 && warnings[0].message.contains("400–700 nm"), "{warnings:?}");
    assert!(short.check([400.0, 700.0]).unwrap().is_empty());
    let bumpy = table(&[380.0, 500.0, 780.0], &[1.52, 1.53, 1.51]);
    assert!(bumpy.check(VISIBLE).unwrap()[0].message.contains("rises"));
    assert!(table(&[380.0, 780.0], &[1.5, 0.9]).check(VISIBLE).is_err());
}
