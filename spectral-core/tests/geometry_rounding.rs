//! Convex stones as files have them: with few digits, in single precision, turned, and in any unit.

use glam::{DMat3, DVec3};
use spectral_core::mesh::{Mesh, MeshOptions};
use spectral_core::shape::ShapeSpec;

mod support;
use support::{Random, check_mesh};

type Triangles = (Vec<DVec3>, Vec<[u32; 3]>);

fn build((positions, triangles): &Triangles) -> Mesh {
    Mesh::from_triangles(positions.clone(), triangles.clone(), &MeshOptions::default()).unwrap().0
}

/// How a program writes a coordinate.
#[derive(Debug, Clone, Copy)]
enum Digits {
    /// Digits after the point.
    Decimals(usize),
    /// Significant digits.
    Significant(usize),
    /// Single precision.
    Single,
}

impl Digits {
    const ALL: [Digits; 9] = [
        Digits::Decimals(3),
        Digits::Decimals(4),
        Digits::Decimals(5),
        Digits::Decimals(6),
        Digits::Significant(4),
        Digits::Significant(5),
        Digits::Significant(6),
        Digits::Significant(7),
        Digits::Single,
    ];

    fn round(self, number: f64) -> f64 {
        match self {
            Digits::Decimals(digits) => format!("{number:.digits$}").parse().unwrap(),
            Digits::Significant(digits) => format!("{number:.*e}", digits - 1).parse().unwrap(),
            Digits::Single => f64::from(number as f32),
        }
    }

    fn of(self, (positions, triangles): &Triangles) -> Triangles {
        let rounded = |p: &DVec3| DVec3::from_array(p.to_array().map(|v| self.round(v)));
        (positions.iter().map(rounded).collect(), triangles.clone())
    }
}

/// The hull of points in general position: every triangle with all other points behind it.
fn hull(points: Vec<DVec3>) -> Triangles {
    let mut triangles = Vec::new();
    let n = points.len();
    for (a, b, c) in (0..n).flat_map(|a| (a + 1..n).flat_map(move |b| (b + 1..n).map(move |c| (a, b, c)))) {
        let normal = (points[b] - points[a]).cross(points[c] - points[a]);
        let side = |p: &DVec3| normal.dot(*p - points[a]);
        let beside =
            || points.iter().enumerate().filter(|(k, _)| ![a, b, c].contains(k)).map(|(_, p)| side(p));
        let corners = [a, b, c].map(|v| v as u32);
        if beside().all(|d| d < 0.0) {
            triangles.push(corners);
        } else if beside().all(|d| d > 0.0) {
            triangles.push([corners[0], corners[2], corners[1]]);
        }
    }
    (points, triangles)
}

fn cut(name: &str) -> Triangles {
    let (mesh, _) = ShapeSpec::by_name(name).unwrap().cut().unwrap().solid().unwrap();
    (mesh.positions().to_vec(), mesh.triangles().to_vec())
}

fn stones() -> Vec<(String, Triangles)> {
    let mut random = Random(7);
    let mut stones: Vec<_> = ShapeSpec::NAMES.map(|name| (name.to_owned(), cut(name))).into();
    for n in [12, 40, 90] {
        let points = (0..n).map(|_| random.direction() * DVec3::new(0.5, 0.4, 0.3)).collect();
        stones.push((format!("hull of {n}"), hull(points)));
    }
    stones
}

#[test]
fn stones_written_with_few_digits_are_convex() {
    let turns = [DMat3::IDENTITY, DMat3::from_euler(glam::EulerRot::ZYX, 0.4, 0.9, 0.2)];
    let mut wrong = Vec::new();
    for (name, (positions, triangles)) in stones() {
        for (size, turn) in [1.0, 2.0, 6.5, 9.7].into_iter().flat_map(|size| turns.map(|turn| (size, turn))) {
            let exact: Triangles =
                (positions.iter().map(|p| size * (turn * *p)).collect(), triangles.clone());
            let expected = build(&exact);
            assert!(expected.is_convex(), "{name}");
            for digits in Digits::ALL {
                // Three decimals of a stone 1 wide are no more than a thousand places.
                if matches!(digits, Digits::Decimals(3)) && size < 5.0 {
                    continue;
                }
                let mesh = build(&digits.of(&exact));
                let volume = mesh.volume() / expected.volume() - 1.0;
                if !mesh.is_convex() || volume.abs() > 2e-3 {
                    wrong
                        .push(format!("{name}, {size} wide, {digits:?}: {volume:.1e}, {}", mesh.is_convex()));
                } else {
                    check_mesh(&mesh);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong: {wrong:#?}", wrong.len());
}

/// A box from −1 to 1 whose top is folded along its diagonal, outwards if `height` is positive.
fn folded(height: f64) -> Triangles {
    let top = 1.0 + height;
    let corners = [
        [-1.0, -1.0, -1.0],
        [1.0, -1.0, -1.0],
        [1.0, 1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, top],
        [1.0, -1.0, 1.0],
        [1.0, 1.0, top],
        [-1.0, 1.0, 1.0],
    ];
    let sides = [[0, 3, 2, 1], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [6, 7, 4, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (corners.map(DVec3::from_array).into(), triangles)
}

#[test]
fn a_fold_outwards_is_convex_at_any_height_and_one_inwards_is_not() {
    for exponent in 0..=70 {
        let height = 10_f64.powf(-1.0 - 0.1 * f64::from(exponent));
        let rounded = format!("{height:.7}").parse().unwrap();
        for height in [height, rounded] {
            let mesh = build(&folded(height));
            assert!(mesh.is_convex(), "{height}");
            assert!((mesh.volume() / (8.0 + 8.0 / 3.0 * height) - 1.0).abs() < 2e-5, "{height}");
            let dented = build(&folded(-height));
            assert!(!dented.is_convex() || height < 8e-5, "{height}");
        }
    }
}
