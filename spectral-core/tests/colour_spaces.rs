//! The RGB spaces against matrices computed independently from the standards' primaries.

use spectral_core::color::matrix::{IDENTITY, Matrix, apply, product};
use spectral_core::color::{RgbSpace, rgb_to_xyz};

/// A space, its RGB → XYZ under its own white, and its RGB → linear sRGB with Bradford adaptation.
///
/// Computed in float64 by an independent program from the primaries and whites of IEC 61966-2-1, SMPTE EG 432-1, ITU-R
/// BT.2020 and S-2014-004. The XYZ matrices agree with those of the standards to the digits printed.
const PUBLISHED: [(RgbSpace, Matrix, Matrix); 4] = [
    (
        RgbSpace::Srgb,
        [
            [0.4123907992659594, 0.35758433938387796, 0.1804807884018343],
            [0.2126390058715103, 0.7151686787677559, 0.07219231536073371],
            [0.019330818715591825, 0.11919477979462596, 0.9505321522496607],
        ],
        IDENTITY,
    ),
    (
        RgbSpace::P3,
        [
            [0.4865709486482161, 0.26566769316909306, 0.19821728523436247],
            [0.22897456406974875, 0.6917385218365063, 0.07928691409374498],
            [0.0, 0.04511338185890263, 1.0439443689009757],
        ],
        [
            [1.2249401762805596, -0.22494017628055943, 0.0],
            [-0.04205695470968804, 1.042056954709688, 0.0],
            [-0.01963755459033445, -0.07863604555063178, 1.098273600140966],
        ],
    ),
    (
        RgbSpace::Rec2020,
        [
            [0.6369580483012911, 0.14461690358620838, 0.16888097516417208],
            [0.262700212011267, 0.677998071518871, 0.05930171646986195],
            [0.0, 0.028072693049087438, 1.0609850577107909],
        ],
        [
            [1.660491002108434, -0.5876411387885491, -0.07284986331988486],
            [-0.12455047452159054, 1.1328998971259598, -0.008349422604369475],
            [-0.018150763354905234, -0.10057889800800737, 1.1187296613629125],
        ],
    ),
    (
        RgbSpace::AcesCg,
        [
            [0.6624541811085053, 0.13400420645643313, 0.15618768700490782],
            [0.27222871678091454, 0.6740817658111484, 0.05368951740793706],
            [-0.005574649490394108, 0.004060733528982826, 1.0103391003129973],
        ],
        [
            [1.7050509926579829, -0.6217921206570044, -0.0832588720009786],
            [-0.13025641750704353, 1.1408047365754013, -0.010548319068358064],
            [-0.024003356804618032, -0.12896897606497051, 1.1529723328695884],
        ],
    ),
];

fn assert_close(found: &Matrix, expected: &Matrix, what: &str) {
    for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((a - b).abs() < 1e-13, "{what}: {a} {b}");
    }
}

#[test]
fn matrices_are_the_published_ones() {
    for (space, to_xyz, to_srgb) in PUBLISHED {
        assert_close(&space.native_to_xyz(), &to_xyz, space.name());
        assert_close(&space.to_linear_srgb(), &to_srgb, space.name());
        assert_close(&rgb_to_xyz(space.primaries(), space.white_xyz()).unwrap(), &to_xyz, space.name());
    }
}

#[test]
fn white_is_white_in_every_space_and_each_matrix_undoes_its_inverse() {
    let white = RgbSpace::Srgb.white_xyz();
    for space in RgbSpace::ALL {
        assert_close(&product(&space.to_xyz(), &space.from_xyz()), &IDENTITY, space.name());
        assert_close(&product(&space.to_linear_srgb(), &space.from_linear_srgb()), &IDENTITY, space.name());
        let shown = apply(&space.from_xyz(), white);
        let expected = if space == RgbSpace::Xyz { white } else { [1.0; 3] };
        assert!((0..3).all(|c| (shown[c] - expected[c]).abs() < 1e-14), "{}: {shown:?}", space.name());
    }
}
