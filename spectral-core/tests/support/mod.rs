//! Shared by the tests: a reader for the sample cuts, a mesh checker and random numbers.
#![allow(dead_code)] // Each test binary uses a part.

use std::collections::HashMap;

use glam::DVec3;
use spectral_core::cut::{Cut, CutFacet};
use spectral_core::mesh::{Mesh, Plane};

/// The text of a sample cut.
pub fn sample(name: &str) -> String {
    let path = format!("{}/data/cuts/{name}.asc", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

/// Reads the `g` and `a` lines of a well-formed GemCad file: `a angle rho { index [ n name ] } [ G text ]`.
pub fn read_asc(text: &str) -> Cut {
    let mut gear = 96.0;
    let mut facets = Vec::new();
    for line in text.lines() {
        let mut tokens = line.split_whitespace();
        match tokens.next() {
            Some("g") => gear = tokens.next().unwrap().parse().unwrap(),
            Some("a") => {
                let angle: f64 = tokens.next().unwrap().parse().unwrap();
                let rho: f64 = tokens.next().unwrap().parse().unwrap();
                while let Some(token) = tokens.next() {
                    match token {
                        "n" => {
                            tokens.next();
                            continue;
                        }
                        "G" => break,
                        _ => {}
                    }
                    let index: f64 = token.parse().unwrap();
                    facets.push(CutFacet::from(Plane::from_angles(angle, 360.0 * index / gear, rho)));
                }
            }
            _ => {}
        }
    }
    Cut { facets, ..Cut::default() }
}

/// Checks that a convex mesh is closed, has Euler characteristic 2, and agrees with its planes.
pub fn check_mesh(mesh: &Mesh) {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for &[a, b, c] in mesh.triangles() {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *edges.entry((a, b)).or_default() += 1;
        }
    }
    assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)), "not closed");
    let euler = mesh.positions().len() as i64 - edges.len() as i64 / 2 + mesh.triangles().len() as i64;
    assert_eq!(euler, 2);
    assert!(mesh.is_convex() && mesh.volume() > 0.0);
    assert_eq!(mesh.facet_of().len(), mesh.triangles().len());
    let (low, high) = mesh.bounds();
    let slack = 2e-6 * (high - low).max_element();
    for p in mesh.positions() {
        assert!(p.is_finite() && mesh.facets().iter().all(|f| f.plane.distance(*p) < slack));
    }
    let mut used = vec![false; mesh.facets().len()];
    for (triangle, &k) in mesh.triangles().iter().zip(mesh.facet_of()) {
        used[k as usize] = true;
        for &v in triangle {
            assert!(mesh.facets()[k as usize].plane.distance(mesh.positions()[v as usize]).abs() < slack);
        }
    }
    assert!(used.iter().all(|u| *u));
}

/// SplitMix64 (Steele, Lea & Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// Uniform on the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.unit() - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * self.unit()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

/// Three perpendicular unit vectors, right-handed.
pub fn orientation(random: &mut Random) -> [[f64; 3]; 3] {
    let z = random.direction();
    let x = z.cross(random.direction()).normalize();
    [x, z.cross(x), z].map(|axis| axis.to_array())
}

/// Asserts that two numbers differ by at most `tolerance`.
pub fn near(actual: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((actual - expected).abs() <= tolerance, "{what}: {actual} instead of {expected}");
}
