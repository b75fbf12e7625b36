//! Meshes of several shells: the union of those that overlap, cavities, and shells that face the wrong way.

use glam::DVec3;
use spectral_core::mesh::{Mesh, MeshOptions};

/// An axis-aligned box; turned inside out if `inward`.
#[derive(Clone, Copy)]
struct Block {
    low: [f64; 3],
    high: [f64; 3],
    inward: bool,
}

fn block(low: [f64; 3], high: [f64; 3]) -> Block {
    Block { low, high, inward: false }
}

fn cavity(low: [f64; 3], high: [f64; 3]) -> Block {
    Block { low, high, inward: true }
}

/// One mesh of all blocks, and its warnings.
fn mesh(blocks: &[Block]) -> (Mesh, Vec<String>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for Block { low, high, inward } in blocks {
        let first = positions.len() as u32;
        let corner =
            |k: usize| DVec3::from_array([0, 1, 2].map(|a| if k >> a & 1 == 1 { high[a] } else { low[a] }));
        positions.extend((0..8).map(corner));
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for [a, b, c, d] in quads.map(|quad| quad.map(|v: u32| v + first)) {
            let pair = [[a, b, c], [a, c, d]];
            triangles.extend(if *inward { pair.map(|[a, b, c]| [a, c, b]) } else { pair });
        }
    }
    let (mesh, warnings) = Mesh::from_triangles(positions, triangles, &MeshOptions::default()).unwrap();
    (mesh, warnings.into_iter().map(|w| w.message).collect())
}

#[test]
fn shells_that_overlap_or_touch_are_solids_of_their_own() {
    let one = block([-1.0; 3], [1.0; 3]);
    let cases: [(&str, Vec<Block>, usize, f64, f64); 9] = [
        ("apart", vec![one, block([2.0; 3], [3.0; 3])], 1, 9.0, 30.0),
        ("a cavity", vec![one, cavity([-0.5; 3], [0.5; 3])], 1, 7.0, 30.0),
        (
            "an island in a cavity",
            vec![one, cavity([-0.5; 3], [0.5; 3]), block([-0.2; 3], [0.2; 3])],
            1,
            7.064,
            30.96,
        ),
        ("overlapping", vec![one, block([0.5, -0.5, -0.5], [1.5, 0.5, 0.5])], 2, 8.5, 26.0),
        ("with flush sides", vec![one, block([0.5, -1.0, -1.0], [1.5, 1.0, 1.0])], 2, 10.0, 28.0),
        ("one in the other", vec![one, block([-0.5; 3], [0.5; 3])], 2, 8.0, 24.0),
        ("touching", vec![one, block([1.0, -0.5, -0.5], [2.0, 0.5, 0.5])], 2, 9.0, 28.0),
        ("three in a row", vec![one, block([0.5; 3], [2.0; 3]), block([1.5; 3], [3.0; 3])], 3, 14.5, 48.0),
        ("with a cavity", vec![one, cavity([-0.5; 3], [0.0; 3]), block([0.5; 3], [2.0; 3])], 2, 11.125, 37.5),
    ];
    for (what, blocks, solids, volume, area) in cases {
        let (mesh, warnings) = mesh(&blocks);
        assert_eq!(mesh.solids().len(), solids, "{what}: {warnings:?}");
        assert_eq!(
            warnings.iter().any(|w| w.contains("overlap or touch")),
            solids > 1,
            "{what}: {warnings:?}"
        );
        assert_eq!(mesh.shells(), blocks.len(), "{what}");
        assert!((mesh.volume() - volume).abs() < 1e-6, "{what}: volume {}", mesh.volume());
        assert!((mesh.area() - area).abs() < 1e-6, "{what}: area {}", mesh.area());
        let covered: Vec<u32> = mesh.solids().flatten().collect();
        assert_eq!(covered, (0..mesh.triangles().len() as u32).collect::<Vec<_>>(), "{what}");
        // The facets of a solid follow each other.
        for solid in mesh.solids() {
            let facets = &mesh.facet_of()[solid.start as usize..solid.end as usize];
            let others = mesh.facet_of().iter().enumerate().filter(|(t, _)| !solid.contains(&(*t as u32)));
            let (low, high) = (facets.iter().min().unwrap(), facets.iter().max().unwrap());
            assert!(others.into_iter().all(|(_, f)| f < low || f > high), "{what}");
        }
    }
}

#[test]
fn a_shell_that_faces_inwards_alone_is_turned() {
    let (mesh, warnings) = mesh(&[block([-1.0; 3], [1.0; 3]), cavity([2.0; 3], [3.0; 3])]);
    assert!(warnings.iter().any(|w| w.contains("were turned")), "{warnings:?}");
    assert!((mesh.volume() - 9.0).abs() < 1e-12, "{}", mesh.volume());
}
