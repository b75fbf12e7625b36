//! Cuts: exact solids, sample designs and random half-spaces.

use glam::{DMat3, DVec3};
use spectral_core::cut::{Cut, CutFacet, Proportions};
use spectral_core::mesh::{Mesh, Plane};

mod support;
use support::{Random, check_mesh, read_asc, sample};

fn cut(planes: &[(DVec3, f64)]) -> Cut {
    let facets = planes.iter().map(|&(n, d)| Plane::new(n, d).unwrap().into()).collect();
    Cut { facets, ..Cut::default() }
}

fn cube() -> Vec<(DVec3, f64)> {
    [DVec3::X, DVec3::Y, DVec3::Z].iter().flat_map(|&n| [(n, 1.0), (-n, 1.0)]).collect()
}

fn solid(planes: &[(DVec3, f64)]) -> Mesh {
    let (mesh, warnings) = cut(planes).solid().unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    check_mesh(&mesh);
    mesh
}

/// Volume by the divergence theorem: a third of each facet's area times its plane's offset.
fn volume_from_planes(mesh: &Mesh) -> f64 {
    mesh.facets().iter().zip(mesh.facet_areas()).map(|(f, a)| f.plane.offset * a / 3.0).sum()
}

#[test]
fn platonic_solids_have_their_volumes() {
    let cube = solid(&cube());
    assert!((cube.volume() - 8.0).abs() < 1e-14 && (cube.area() - 24.0).abs() < 1e-13);
    assert_eq!((cube.positions().len(), cube.triangles().len(), cube.facets().len()), (8, 12, 6));

    // Corners (1,1,1), (1,-1,-1), (-1,1,-1), (-1,-1,1): volume 8/3, facets opposite the corners.
    let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
    let faces = corners.map(|c| (-DVec3::from_array(c.map(f64::from)), 1.0));
    let tetrahedron = solid(&faces);
    assert!((tetrahedron.volume() - 8.0 / 3.0).abs() < 1e-14);
    assert_eq!(tetrahedron.positions().len(), 4);

    // |x| + |y| + |z| <= 1: volume 4/3; four planes meet in each vertex.
    let signs = [1.0, -1.0];
    let faces: Vec<_> = signs
        .iter()
        .flat_map(|&x| signs.iter().flat_map(move |&y| signs.map(|z| (DVec3::new(x, y, z), 1.0))))
        .collect();
    let octahedron = solid(&faces);
    assert!((octahedron.volume() - 4.0 / 3.0).abs() < 1e-14);
    assert_eq!((octahedron.positions().len(), octahedron.triangles().len()), (6, 8));
}

#[test]
fn three_planes_meet_exactly_wherever_the_origin_is() {
    for shift in [0.0, 3.0, 1e3, 1e6, 1e8] {
        let moved: Vec<_> = cube().iter().map(|&(n, d)| (n, d + n.dot(DVec3::splat(shift)))).collect();
        let mesh = solid(&moved);
        let error = (mesh.volume() - 8.0).abs();
        assert!(error <= 1e-13 * (1.0 + shift), "{shift}: {error:e}");
    }
}

#[test]
fn sizes_from_nanometres_to_kilometres_close() {
    for size in [1e-9, 1e-3, 1e6] {
        let scaled: Vec<_> = cube().iter().map(|&(n, d)| (n, d * size)).collect();
        let mesh = solid(&scaled);
        assert!((mesh.volume() / size.powi(3) - 8.0).abs() < 1e-13);
    }
}

#[test]
fn a_missing_side_is_named() {
    let mut planes = cube();
    planes.remove(0);
    let message = cut(&planes).solid().unwrap_err().to_string();
    assert_eq!(message, "the cut does not close: no facet bounds it towards +x");
    let none = Cut::default().solid().unwrap_err().to_string();
    assert!(none.contains("-x, +x, -y, +y, -z, +z"), "{none}");
}

#[test]
fn a_facet_on_the_wrong_side_is_named() {
    let mut facets = cut(&cube()).facets;
    facets.push(CutFacet::named(Plane::new(DVec3::Z, -2.0).unwrap(), "T"));
    let message = Cut { facets, ..Cut::default() }.solid().unwrap_err().to_string();
    assert!(message.contains("facet 7 (T)") && message.contains("no solid"), "{message}");
}

#[test]
fn facets_that_miss_or_repeat_are_left_out_and_reported() {
    let mut planes = cube();
    planes.push((DVec3::ONE, 3.1));
    planes.push((DVec3::X, 1.0));
    let (mesh, warnings) = cut(&planes).solid().unwrap();
    assert_eq!(mesh.facets().len(), 6);
    for part in ["facet 8 repeats facet 1", "left out: facet 7"] {
        assert!(warnings.iter().any(|w| w.message.contains(part)), "{warnings:?}");
    }
}

#[test]
fn a_plane_far_away_changes_nothing() {
    let mut planes = cube();
    planes.push((DVec3::ONE, 1e12));
    let (mesh, warnings) = cut(&planes).solid().unwrap();
    check_mesh(&mesh);
    assert!(warnings.len() == 1 && (mesh.volume() - 8.0).abs() < 1e-14);
}

#[test]
fn figures_that_are_not_finite_are_refused() {
    let mut bad = cut(&cube());
    bad.facets[2].plane.offset = f64::NAN;
    assert!(bad.solid().unwrap_err().to_string().starts_with("facet 3: NaN"));
    let mut bad = cut(&cube());
    bad.facets[2].plane.normal = DVec3::new(0.0, f64::INFINITY, 0.0);
    assert!(bad.solid().unwrap_err().to_string().starts_with("facet 3"));
    assert!(Plane::new(DVec3::ZERO, 1.0).is_err() && Plane::new(DVec3::NAN, 1.0).is_err());
}

#[test]
fn short_edges_are_contracted_and_long_ones_kept() {
    // A fourth plane over the corner (1,1,1) leaves a triangle with sides sqrt(2)·gap.
    for (gap, facets) in [(1e-9, 6), (1e-7, 6), (1e-5, 7), (1e-3, 7)] {
        let mut planes = cube();
        planes.push((DVec3::ONE, 3.0 - gap));
        let (mesh, _) = cut(&planes).solid().unwrap();
        check_mesh(&mesh);
        assert_eq!(mesh.facets().len(), facets, "gap {gap:e}");
    }
}

#[test]
fn sample_designs_close_with_their_facets() {
    for (name, facets) in
        [("srb_diamond_57", 57 + 16), ("emerald_step_49", 49 + 8), ("portuguese_161", 145 + 16)]
    {
        let cut = read_asc(&sample(name));
        let (mesh, warnings) = cut.solid().unwrap();
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
        check_mesh(&mesh);
        assert_eq!(mesh.facets().len(), facets, "{name}");
        // Ten decimals in the file.
        let (by_mesh, by_planes) = (mesh.volume(), volume_from_planes(&mesh));
        assert!((by_mesh / by_planes - 1.0).abs() < 1e-8, "{name}: {by_mesh} {by_planes}");
        for (facet, designed) in mesh.facets().iter().zip(&cut.facets) {
            assert_eq!(facet.plane, designed.plane, "{name}");
        }
    }
}

#[test]
fn proportions_are_those_of_the_design() {
    let (mesh, _) = read_asc(&sample("srb_diamond_57")).solid().unwrap();
    let p = Proportions::of(&mesh);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b} in {p:?}");
    near(p.width, 2.0);
    near(p.length, 2.0);
    near(p.table_percent.unwrap(), 57.0);
    near(p.crown_angle.unwrap(), 34.5);
    near(p.pavilion_angle.unwrap(), 40.75);
    near(p.girdle, 0.06);
    near(p.crown_height + p.girdle + p.pavilion_depth, p.total_depth);
    assert!((100.0 * p.total_depth / p.width - 60.86).abs() < 0.005);
    assert_eq!((p.crown_facets, p.girdle_facets, p.pavilion_facets), (33, 16, 24));

    let (mesh, _) = read_asc(&sample("emerald_step_49")).solid().unwrap();
    let p = Proportions::of(&mesh);
    assert!((p.length / p.width - 1.4).abs() < 1e-9 && (p.table_percent.unwrap() - 61.0).abs() < 1e-6);
    assert!((p.pavilion_angle.unwrap() - 43.0).abs() < 1e-6);
    assert_eq!((p.crown_facets, p.girdle_facets, p.pavilion_facets), (25, 8, 24));
}

#[test]
fn a_cone_of_many_facets_meets_in_a_point() {
    let cone = |error: f64| {
        let mut random = Random(7);
        let mut facets: Vec<CutFacet> = (0..200)
            .map(|k| {
                Plane::from_angles(-41.0, 360.0 * f64::from(k) / 200.0, 0.7 + error * random.unit()).into()
            })
            .collect();
        facets.push(Plane::from_angles(0.0, 0.0, 0.3).into());
        let (mesh, _) = Cut { facets, ..Cut::default() }.solid().unwrap();
        check_mesh(&mesh);
        assert_eq!(mesh.facets().len(), 201);
        mesh.positions().len()
    };
    assert_eq!(cone(0.0), 201);
    // With ten decimals: the neighbours, 1.8° apart, miss the apex by more than their error.
    assert!(cone(1e-10) < 205);
}

#[test]
fn a_sphere_of_two_thousand_planes_closes() {
    let mut random = Random(11);
    let planes: Vec<_> = (0..2000).map(|_| (random.direction(), 1.0)).collect();
    let (mesh, _) = cut(&planes).solid().unwrap();
    check_mesh(&mesh);
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    assert!(mesh.volume() > ball && mesh.volume() < 1.01 * ball);
}

/// Half-spaces in general position, repeated, parallel, through one point, or nearly equal.
fn random_planes(random: &mut Random) -> Vec<(DVec3, f64)> {
    let count = 1 + (random.unit() * 40.0) as usize;
    let kind = (random.unit() * 5.0) as u32;
    let mut planes: Vec<(DVec3, f64)> = Vec::new();
    for _ in 0..count {
        let n = random.direction();
        let coarse = (n * 2.0).round();
        let near = 10_f64.powf(-16.0 * random.unit());
        let previous = planes.last().copied().unwrap_or((DVec3::Z, 1.0));
        planes.push(match kind {
            0 => (n, random.unit()),
            1 if coarse != DVec3::ZERO => (coarse, coarse.length()),
            2 => (n, n.dot(DVec3::new(0.3, 0.2, 0.1)) + if random.unit() < 0.5 { 1.0 } else { near }),
            3 => (previous.0 + near * n, previous.1 + near * random.unit()),
            _ => (n, 3.0 * random.unit() - 1.0),
        });
    }
    if random.unit() < 0.7 {
        planes.extend(cube());
    }
    planes
}

#[test]
fn random_half_spaces_close_or_give_a_reason() {
    let mut random = Random(1);
    let (mut closed, mut confused) = (0, 0);
    for _ in 0..10_000 {
        match cut(&random_planes(&mut random)).solid() {
            Ok((mesh, _)) => {
                closed += 1;
                check_mesh(&mesh);
            }
            Err(e) => {
                let message = e.to_string();
                confused += usize::from(message.contains("nearly the same"));
            }
        }
    }
    println!("closed {closed}, confused {confused}");
    assert!(closed > 3000, "only {closed} closed");
    assert!(confused <= 10, "{confused} of 10000 could not be told apart");
}

#[test]
fn published_designs_with_small_errors_close() {
    // Rounded offsets and angles, so that meets are off by 1e-10 to 1e-2.
    let mut random = Random(3);
    for name in ["srb_diamond_57", "emerald_step_49", "portuguese_161"] {
        let exact = read_asc(&sample(name));
        for k in 0..200 {
            let error = 10_f64.powf(-10.0 + 8.0 * f64::from(k) / 200.0);
            let mut cut = exact.clone();
            for facet in &mut cut.facets {
                facet.plane.offset += error * (random.unit() - 0.5);
            }
            let (mesh, _) = cut.solid().unwrap_or_else(|e| panic!("{name} with {error:e}: {e}"));
            check_mesh(&mesh);
        }
    }
}

#[test]
fn the_solid_turns_with_its_planes() {
    let (mesh, _) = read_asc(&sample("srb_diamond_57")).solid().unwrap();
    let rotation = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(1.1);
    let moved = mesh.transformed(rotation, 3.25, DVec3::new(1.0, -2.0, 5.0)).unwrap();
    check_mesh(&moved);
    assert!((moved.volume() / mesh.volume() / 3.25_f64.powi(3) - 1.0).abs() < 1e-12);
    assert!(mesh.transformed(rotation, 0.0, DVec3::ZERO).is_err());
    assert!(mesh.transformed(-DMat3::IDENTITY, 1.0, DVec3::ZERO).is_err());
    assert!(mesh.transformed(rotation, 1.0, DVec3::NAN).is_err());
}

#[test]
fn the_largest_cut_takes_seconds() {
    let mut random = Random(13);
    let planes: Vec<_> =
        (0..Cut::MAX_FACETS).map(|_| (random.direction(), 1.0 + 1e-4 * random.unit())).collect();
    let start = std::time::Instant::now();
    let (mesh, _) = cut(&planes).solid().unwrap();
    println!("{} facets: {:.1} s", mesh.facets().len(), start.elapsed().as_secs_f64());
    assert!(start.elapsed().as_secs() < 120);
    let mut more = cut(&planes);
    more.facets.push(more.facets[0].clone());
    assert!(more.solid().unwrap_err().to_string().starts_with("facets: 10001 is not valid"));
}

#[test]
fn mutated_cuts_never_panic() {
    let designs = ["srb_diamond_57", "emerald_step_49"].map(|name| read_asc(&sample(name)));
    let odd = [f64::NAN, f64::INFINITY, 0.0, -0.0, 1e300, -1e12, 1e12, 1e-300, 5e-324, -1.0];
    let mut random = Random(17);
    let mut closed = 0;
    for _ in 0..10_000 {
        let mut cut = designs[random.below(2)].clone();
        for _ in 0..1 + random.below(5) {
            let (k, value) = (random.below(cut.facets.len()), odd[random.below(odd.len())]);
            let other = cut.facets[random.below(cut.facets.len())].plane;
            let plane = &mut cut.facets[k].plane;
            match random.below(8) {
                0 => plane.offset = value,
                1 => plane.normal[random.below(3)] = value,
                2 => plane.normal = -plane.normal,
                3 => *plane = other,
                4 => plane.offset *= 1.0 + 10_f64.powf(-14.0 * random.unit()),
                5 => {
                    plane.normal =
                        (other.normal + 10_f64.powf(-14.0 * random.unit()) * random.direction()).normalize()
                }
                6 => cut.facets.iter_mut().for_each(|f| f.plane.offset *= value.abs()),
                _ => drop(cut.facets.swap_remove(k)),
            }
            if cut.facets.is_empty() {
                break;
            }
        }
        if let Ok((mesh, _)) = cut.solid() {
            closed += 1;
            check_mesh(&mesh);
        }
    }
    assert!(closed > 2000, "only {closed} closed");
}
