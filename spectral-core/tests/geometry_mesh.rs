//! Meshes from loose triangles: repairs, refusals, facets, convexity, and mutated input.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use spectral_core::mesh::{Mesh, MeshOptions};
use spectral_core::shape::RoundBrilliant;
use spectral_core::{Error, Warning};

mod support;
use support::{Random, check_mesh};

type Triangles = (Vec<DVec3>, Vec<[u32; 3]>);

fn build((positions, triangles): &Triangles) -> Result<(Mesh, Vec<Warning>), Error> {
    Mesh::from_triangles(positions.clone(), triangles.clone(), &MeshOptions::default())
}

fn message(mesh: &Triangles) -> String {
    build(mesh).unwrap_err().to_string()
}

/// The cube from 0 to 1.
fn cube() -> Triangles {
    let corner = |k: u32| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

/// Each triangle with its own vertices, as STL has them.
fn soup((positions, triangles): &Triangles) -> Triangles {
    let loose: Vec<DVec3> = triangles.iter().flatten().map(|&v| positions[v as usize]).collect();
    let count = triangles.len() as u32;
    (loose, (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
}

fn joined(a: &Triangles, b: &Triangles) -> Triangles {
    let shift = a.0.len() as u32;
    let triangles = a.1.iter().copied().chain(b.1.iter().map(|t| t.map(|v| v + shift))).collect();
    ([a.0.clone(), b.0.clone()].concat(), triangles)
}

fn inverted(mesh: &Triangles) -> Triangles {
    (mesh.0.clone(), mesh.1.iter().map(|&[a, b, c]| [a, c, b]).collect())
}

fn moved(mesh: &Triangles, scale: f64, shift: DVec3) -> Triangles {
    (mesh.0.iter().map(|p| scale * *p + shift).collect(), mesh.1.clone())
}

/// A grid of `n` by `m` points wrapped both ways round, mapped by `point`.
fn wrapped(n: u32, m: u32, point: impl Fn(f64, f64) -> DVec3) -> Triangles {
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    let mut mesh = (Vec::new(), Vec::new());
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        mesh.0.push(point(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        mesh.1.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

fn torus(n: u32, m: u32) -> Triangles {
    wrapped(n, m, |u, v| {
        let ring = 2.0 + 0.5 * (TAU * v).cos();
        DVec3::new(ring * (TAU * u).cos(), ring * (TAU * u).sin(), 0.5 * (TAU * v).sin())
    })
}

/// An octahedron with each side divided into `n`, projected onto the unit sphere, after which `shape` moves each vertex.
fn ball(n: u32, shape: impl Fn(DVec3) -> DVec3) -> Triangles {
    let mut mesh = (Vec::new(), Vec::new());
    for octant in 0..8_u32 {
        let sign = |k: u32| if octant >> k & 1 == 0 { 1.0 } else { -1.0 };
        let axes = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
        let first = mesh.0.len() as u32;
        let at = |i: u32, j: u32| first + i * (2 * n + 3 - i) / 2 + j;
        for i in 0..=n {
            for j in 0..=n - i {
                let [a, b, c] = [i, j, n - i - j].map(f64::from);
                mesh.0.push(shape((a * axes[0] + b * axes[1] + c * axes[2]).normalize()));
                let odd = octant.count_ones() % 2 == 1;
                let mut push = |t: [u32; 3]| mesh.1.push(if odd { [t[0], t[2], t[1]] } else { t });
                if i + j < n {
                    push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                }
                if i + j + 1 < n {
                    push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    mesh
}

fn warned(warnings: &[Warning], part: &str) -> bool {
    warnings.iter().any(|w| w.message.contains(part))
}

#[test]
fn a_cube_has_six_facets_whether_shared_or_loose() {
    for mesh in
        [cube(), soup(&cube()), moved(&cube(), 1e-6, DVec3::splat(3.0)), moved(&cube(), 1e9, DVec3::ZERO)]
    {
        let (cube, warnings) = build(&mesh).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!((cube.facets().len(), cube.positions().len(), cube.shells()), (6, 8, 1));
        check_mesh(&cube);
        let (low, high) = cube.bounds();
        let side = (high - low).x;
        assert!((cube.volume() / side.powi(3) - 1.0).abs() < 1e-9);
        assert!((cube.area() / side.powi(2) - 6.0).abs() < 1e-8);
    }
}

#[test]
fn rounding_between_loose_triangles_is_closed() {
    let mut loose = soup(&ball(8, |p| p));
    let mut random = Random(2);
    for p in &mut loose.0 {
        *p = (*p + 3e-8 * random.direction()).as_vec3().as_dvec3();
    }
    let (mesh, warnings) = build(&loose).unwrap();
    assert!(warned(&warnings, "were joined"), "{warnings:?}");
    assert_eq!((mesh.positions().len(), mesh.triangles().len()), (4 * 64 + 2, 8 * 64));
}

#[test]
fn the_planes_of_a_brilliant_are_recovered_from_nine_decimals() {
    let (exact, _) = RoundBrilliant::default().cut().unwrap().solid().unwrap();
    let round = |x: f64| (x * 2e9).round() / 2e9;
    for digits in [false, true] {
        let place = |p: &DVec3| if digits { DVec3::new(round(p.x), round(p.y), round(p.z)) } else { *p };
        let loose = (exact.positions().iter().map(place).collect(), exact.triangles().to_vec());
        let (mesh, warnings) = build(&soup(&loose)).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        check_mesh(&mesh);
        assert_eq!(mesh.facets().len(), 57 + 64);
        let tolerance = if digits { 1e-7 } else { 1e-12 };
        for facet in mesh.facets() {
            let error = |f: &spectral_core::mesh::Facet| {
                let tilt = (f.plane.normal - facet.plane.normal).length();
                tilt.max((f.plane.offset - facet.plane.offset).abs())
            };
            let best = exact.facets().iter().map(error).fold(f64::INFINITY, f64::min);
            assert!(best < tolerance, "{facet:?}: {best:e}");
        }
        assert!((mesh.volume() / exact.volume() - 1.0).abs() < 1e-8);
    }
}

#[test]
fn a_noisy_subdivided_cube_still_has_six_facets() {
    // Like a scan: 25 × 25 points a face, each up to 1e-6 of the side from its plane.
    let mut random = Random(4);
    let mut square = (Vec::new(), Vec::new());
    let n = 24_u32;
    let noise: Vec<f64> = (0..(n + 1) * (n + 1)).map(|_| 1e-6 * (random.unit() - 0.5)).collect();
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let inner = i > 0 && j > 0 && i < n && j < n;
        let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
        square.0.push(DVec3::new(x, y, if inner { noise[(i * (n + 1) + j) as usize] } else { 0.0 }));
        if i < n && j < n {
            let a = i * (n + 1) + j;
            square.1.extend([[a, a + n + 1, a + n + 2], [a, a + n + 2, a + 1]]);
        }
    }
    let sides = cube();
    let mut mesh = (Vec::new(), Vec::new());
    for quad in sides.1.chunks(2) {
        let [a, b, d] = [quad[0][0], quad[0][1], quad[1][2]].map(|v| sides.0[v as usize]);
        let (u, v) = (b - a, d - a);
        let face = square.0.iter().map(|p| a + p.x * u + p.y * v + p.z * u.cross(v)).collect();
        mesh = joined(&mesh, &(face, square.1.clone()));
    }
    let (mesh, _) = build(&mesh).unwrap();
    assert_eq!(mesh.facets().len(), 6);
    for facet in mesh.facets() {
        assert!(facet.plane.normal.abs().max_element() > 1.0 - 1e-12);
    }
}

#[test]
fn triangles_of_smooth_surfaces_are_separate_facets() {
    // Asymmetric, so that no two triangles are coplanar by symmetry; some still are within 0.1° by chance.
    let (stone, _) = build(&ball(60, |p| p * (1.0 + 0.2 * p.x + 0.1 * p.y * p.z))).unwrap();
    let (facets, triangles) = (stone.facets().len(), stone.triangles().len());
    assert!(facets > triangles * 9 / 10, "{facets} of {triangles}");
    let mut members = vec![0; facets];
    stone.facet_of().iter().for_each(|&k| members[k as usize] += 1);
    assert!(members.iter().all(|&m| m <= 2));
}

/// Parallels and meridians: every quadrangle is planar, so the polyhedron is convex.
fn globe(n: u32, m: u32, shape: impl Fn(DVec3) -> DVec3) -> Triangles {
    let mut mesh = (vec![shape(DVec3::Z), shape(-DVec3::Z)], Vec::new());
    let at = |i: u32, j: u32| 2 + (i - 1) * m + j % m;
    for i in 1..n {
        for j in 0..m {
            let (a, b) = (PI * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m));
            mesh.0.push(shape(DVec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos())));
            if i + 1 < n {
                mesh.1.extend([
                    [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                    [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
                ]);
            }
        }
    }
    for j in 0..m {
        mesh.1.extend([[0, at(1, j), at(1, j + 1)], [1, at(n - 1, j + 1), at(n - 1, j)]]);
    }
    mesh
}

#[test]
fn a_sphere_is_convex_and_a_torus_a_dent_and_two_stones_are_not() {
    assert!(build(&globe(40, 80, |p| p)).unwrap().0.is_convex());
    assert!(!build(&torus(40, 20)).unwrap().0.is_convex());
    // A flat end with a shallow hollow: between neighbours the surface bends by much less than the tolerance. Only the rim
    // relative to the other side of the hollow shows it.
    let hollow = |depth: f64| {
        move |p: DVec3| {
            let r2 = (p.x * p.x + p.y * p.y) / 0.75;
            if p.z < 0.5 { p } else { DVec3::new(p.x, p.y, 0.5 - depth * (1.0 - r2)) }
        }
    };
    let flat = globe(900, 8, hollow(0.0));
    assert!(build(&flat).unwrap().0.is_convex());
    let (dented, _) = build(&globe(900, 8, hollow(1e-4))).unwrap();
    assert!(!dented.is_convex());
    let two = joined(&cube(), &moved(&cube(), 1.0, DVec3::X * 3.0));
    let (two, _) = build(&two).unwrap();
    assert!(!two.is_convex() && two.shells() == 2 && (two.volume() - 2.0).abs() < 1e-14);
}

#[test]
fn volumes_of_smooth_solids_converge() {
    let sphere = build(&ball(100, |p| p)).unwrap().0;
    assert!((sphere.volume() / (4.0 / 3.0 * PI) - 1.0).abs() < 3e-4);
    let torus = build(&torus(400, 200)).unwrap().0;
    assert!((torus.volume() / (2.0 * PI * PI * 2.0 * 0.25) - 1.0).abs() < 3e-4);
}

#[test]
fn inverted_meshes_and_triangles_are_turned() {
    let (mesh, warnings) = build(&inverted(&cube())).unwrap();
    assert!(warned(&warnings, "inside out") && (mesh.volume() - 1.0).abs() < 1e-15);
    check_mesh(&mesh);
    let mut some = cube();
    some.1[3].swap(0, 1);
    some.1[8].swap(1, 2);
    let (mesh, warnings) = build(&some).unwrap();
    assert!(warned(&warnings, "2 triangles were wound against"), "{warnings:?}");
    check_mesh(&mesh);
}

#[test]
fn a_cavity_stays_a_cavity() {
    let hollow = joined(&cube(), &inverted(&moved(&cube(), 0.5, DVec3::splat(0.25))));
    let (mesh, warnings) = build(&hollow).unwrap();
    assert!(warned(&warnings, "taken as cavities") && !mesh.is_convex());
    assert!((mesh.volume() - 0.875).abs() < 1e-15);
}

#[test]
fn shells_may_touch_in_a_point_along_an_edge_and_along_a_face() {
    for shift in [DVec3::ONE, DVec3::new(1.0, 1.0, 0.0), DVec3::X] {
        let (mesh, _) = build(&joined(&cube(), &moved(&cube(), 1.0, shift))).unwrap();
        assert!(shift == DVec3::X || mesh.shells() == 2, "{shift}");
        assert!((mesh.volume() - 2.0).abs() < 1e-14 && !mesh.is_convex());
    }
}

#[test]
fn triangles_without_area_are_left_out() {
    let mut mesh = cube();
    mesh.0.push(DVec3::new(0.5, 0.0, 0.0));
    mesh.1.extend([[0, 0, 1], [0, 1, 8], [7, 7, 7]]);
    let (mesh, warnings) = build(&mesh).unwrap();
    assert!(warned(&warnings, "3 triangles without area were left out"), "{warnings:?}");
    check_mesh(&mesh);
    assert_eq!(mesh.triangles().len(), 12);

    let mut twice = cube();
    twice.1.push([4, 6, 0]);
    let (mesh, warnings) = build(&twice).unwrap();
    assert!(warned(&warnings, "1 triangle given more than once was taken once"), "{warnings:?}");
    check_mesh(&mesh);
}

#[test]
fn a_triangle_that_fills_a_t_junction_is_kept() {
    // One face has a vertex in the middle of an edge, its neighbour has not. A triangle without area lies between them.
    let mut mesh = cube();
    mesh.0.push(DVec3::new(0.5, 0.0, 0.0));
    let side = mesh.1.iter().position(|t| t.contains(&0) && t.contains(&1) && t.contains(&5)).unwrap();
    assert_eq!(mesh.1[side], [0, 1, 5]);
    mesh.1[side] = [0, 8, 5];
    mesh.1.extend([[8, 1, 5], [0, 1, 8]]);
    let (mesh, warnings) = build(&mesh).unwrap();
    assert!(warned(&warnings, "1 triangle whose corners lie on a line was kept"), "{warnings:?}");
    assert_eq!(mesh.facets().len(), 6);
    check_mesh(&mesh);
}

#[test]
fn open_and_non_manifold_meshes_are_refused_with_the_place() {
    let mut open = cube();
    open.1.pop();
    let text = message(&open);
    assert!(text.starts_with("open mesh: 3 edges have a triangle on one side only"), "{text}");
    assert!(text.contains("the first between (0, 0, 1) and"), "{text}");

    let mut fin = cube();
    fin.0.push(DVec3::new(0.5, -1.0, 0.5));
    fin.1.push([0, 1, 8]);
    let text = message(&fin);
    assert!(text.contains("non-manifold mesh") && text.contains("(0, 0, 0) and (1, 0, 0)"), "{text}");
    assert!(matches!(build(&fin), Err(Error::Solid { place: Some([0.5, 0.0, 0.0]), .. })));
}

#[test]
fn one_sided_surfaces_are_refused() {
    // An immersed Klein bottle: wrapping in the second direction reverses the first.
    let (n, m) = (24, 12_u32);
    let mut bottle = wrapped(n, m, |u, v| {
        let (a, b) = (TAU * u, TAU * (v + 0.5 / f64::from(m)));
        let ring = 2.0 + (a / 2.0).cos() * b.sin() - (a / 2.0).sin() * (2.0 * b).sin();
        DVec3::new(
            ring * a.cos(),
            ring * a.sin(),
            (a / 2.0).sin() * b.sin() + (a / 2.0).cos() * (2.0 * b).sin(),
        )
    });
    for triangle in &mut bottle.1[(2 * (n - 1) * m) as usize..] {
        for v in triangle.iter_mut().filter(|v| **v < m) {
            *v = m - 1 - *v;
        }
    }
    let text = message(&bottle);
    assert!(text.contains("cannot be oriented"), "{text}");
}

#[test]
fn bad_figures_are_named() {
    let mut bad = cube();
    bad.0[5].y = f64::NAN;
    assert_eq!(
        message(&bad),
        "vertex 5, y: NaN is not valid; coordinates must be finite and at most 1e12 in size"
    );
    bad.0[5].y = f64::NEG_INFINITY;
    assert!(message(&bad).starts_with("vertex 5, y: -inf"));
    let mut bad = cube();
    bad.1[7][1] = 8;
    assert_eq!(message(&bad), "triangle 7: vertex 8 is not valid; the mesh has vertices 0 to 7");
    assert!(message(&(Vec::new(), Vec::new())).starts_with("mesh: no triangles"));
    assert!(message(&(cube().0, vec![[0, 0, 1], [0, 1, 1]])).contains("no triangle with an area"));
    let flat = (cube().0, vec![[0, 1, 3], [3, 1, 0], [0, 3, 2], [2, 3, 0]]);
    assert!(message(&flat).contains("no volume"));
    let options = MeshOptions { weld: -1.0, ..MeshOptions::default() };
    let error = Mesh::from_triangles(cube().0, cube().1, &options).unwrap_err();
    assert!(error.to_string().starts_with("weld: -1"));
}

#[test]
fn mutated_meshes_never_panic() {
    let (stone, _) =
        RoundBrilliant { girdle_facets: 16, ..Default::default() }.cut().unwrap().solid().unwrap();
    let stone = (stone.positions().to_vec(), stone.triangles().to_vec());
    let seeds = [cube(), soup(&cube()), torus(5, 4), stone];
    let odd = [f64::NAN, f64::INFINITY, 0.0, -0.0, 1e300, -1e12, 1e-300, 5e-324, 1.0, 1e-7];
    let mut random = Random(9);
    let mut good = 0;
    for round in 0..100_000 {
        // The stone is the largest: one time in ten.
        let which = if round % 10 == 0 { 3 } else { random.below(3) };
        let mut mesh = seeds[which].clone();
        for _ in 0..1 + random.below(4) {
            let (v, t) = (random.below(mesh.0.len()), random.below(mesh.1.len()));
            match random.below(8) {
                0 => mesh.0[v][random.below(3)] = odd[random.below(odd.len())],
                1 => mesh.0[v] = mesh.0[random.below(seeds[which].0.len().min(mesh.0.len()))],
                2 => mesh.1[t][random.below(3)] = random.below(mesh.0.len() + 1) as u32,
                3 => mesh.1[t].swap(0, 1),
                4 if mesh.1.len() > 1 => drop(mesh.1.swap_remove(t)),
                5 => mesh.1.push(mesh.1[t]),
                6 => mesh.0[v] += 10_f64.powf(-12.0 * random.unit()) * random.direction(),
                _ => mesh = moved(&mesh, 10_f64.powf(24.0 * random.unit() - 12.0), random.direction()),
            }
        }
        good += usize::from(build(&mesh).is_ok());
    }
    assert!(good > 10_000, "only {good} were accepted");
}

#[test]
fn a_million_triangles_take_about_a_second() {
    let mesh = ball(354, |p| p);
    assert!(mesh.1.len() > 1_000_000);
    let start = std::time::Instant::now();
    let (sphere, _) = build(&mesh).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    println!("{} triangles, {} facets: {seconds:.2} s", sphere.triangles().len(), sphere.facets().len());
    // A busy machine may be several times slower than an idle one; quadratic time would be hours.
    assert!(seconds < 60.0 && sphere.is_convex());
}
