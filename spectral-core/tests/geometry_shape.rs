//! Parametric cuts against the sample designs.

use glam::DVec3;
use spectral_core::cut::{Cut, Proportions};
use spectral_core::shape::{Portuguese, RoundBrilliant, ShapeSpec, Step};

mod support;
use support::{Random, check_mesh, read_asc, sample};

/// Checks that every plane of one is a plane of the other. The designs have girdle radius 1, the shapes width 1.
fn same_planes(shape: &Cut, design: &Cut) {
    assert_eq!(shape.facets.len(), design.facets.len());
    for facet in &shape.facets {
        let near = design.facets.iter().map(|d| {
            let normal = (d.plane.normal - facet.plane.normal).abs().max_element();
            normal.max((d.plane.offset - 2.0 * facet.plane.offset).abs())
        });
        let best = near.fold(f64::INFINITY, f64::min);
        assert!(best < 1e-6, "{facet:?} is {best:e} from the nearest");
    }
}

fn design(name: &str) -> Cut {
    read_asc(&sample(name))
}

#[test]
fn round_brilliant_is_the_sample_design() {
    let shape = RoundBrilliant {
        table: 0.57,
        crown: 34.5,
        pavilion: 40.75,
        star: 0.5,
        lower_half: 0.77,
        girdle: 0.03,
        girdle_facets: 16,
        culet: 0.0,
    };
    same_planes(&shape.cut().unwrap(), &design("srb_diamond_57"));
}

#[test]
fn step_is_the_sample_design() {
    let shape = Step { pavilion_levels: Some(vec![0.66, 0.33]), ..Step::default() };
    same_planes(&shape.cut().unwrap(), &design("emerald_step_49"));
}

#[test]
fn portuguese_is_the_sample_design() {
    same_planes(&Portuguese::default().cut().unwrap(), &design("portuguese_161"));
}

#[test]
fn every_shape_closes_with_width_one_and_all_its_facets() {
    for (name, facets) in ShapeSpec::NAMES.iter().zip([57 + 64, 57, 161]) {
        let cut = ShapeSpec::by_name(name).unwrap().cut().unwrap();
        let (mesh, warnings) = cut.solid().unwrap();
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
        check_mesh(&mesh);
        assert_eq!(mesh.facets().len(), facets, "{name}");
        // Meets are exact: mesh and planes describe the same solid.
        for (triangle, &k) in mesh.triangles().iter().zip(mesh.facet_of()) {
            for &v in triangle {
                let gap = mesh.facets()[k as usize].plane.distance(mesh.positions()[v as usize]);
                assert!(gap.abs() < 1e-14, "{name}: {gap:e}");
            }
        }
        let (low, high) = mesh.bounds();
        let size = high - low;
        assert!((size.truncate().min_element() - 1.0).abs() < 1e-12, "{name}: {size}");
        assert!(
            mesh.facets().iter().any(|f| f.plane.normal == DVec3::Z && f.name.as_deref() == Some("table"))
        );
    }
}

#[test]
fn proportions_give_back_the_parameters() {
    let shape = RoundBrilliant {
        table: 0.6,
        crown: 32.0,
        pavilion: 41.5,
        culet: 0.02,
        girdle: 0.04,
        ..Default::default()
    };
    let p = Proportions::of(&shape.cut().unwrap().solid().unwrap().0);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b} in {p:?}");
    near(p.table_percent.unwrap(), 60.0);
    near(p.crown_angle.unwrap(), 32.0);
    near(p.pavilion_angle.unwrap(), 41.5);
    near(p.girdle, 0.04);
    near(p.crown_height, 0.2 * 32_f64.to_radians().tan());
    near(p.pavilion_depth, 0.49 * 41.5_f64.to_radians().tan());
    assert_eq!((p.crown_facets, p.girdle_facets, p.pavilion_facets), (33, 64, 25));
}

#[test]
fn scene_files_name_shapes() {
    let parse = |text: &str| toml::from_str::<ShapeSpec>(text).map_err(|e| e.message().to_owned());
    let spec = parse("name = 'round-brilliant'\ncrown = 35").unwrap();
    assert_eq!(spec, ShapeSpec::RoundBrilliant(RoundBrilliant { crown: 35.0, ..Default::default() }));
    assert!(matches!(parse("name = 'emerald'\ncrown = [40, 30.5]").unwrap(), ShapeSpec::Step(_)));
    assert!(matches!(parse("name = 'portuguese'").unwrap(), ShapeSpec::Portuguese(_)));
    assert!(parse("name = 'round-brilliant'\ntabel = 0.5").unwrap_err().contains("tabel"));
    assert!(parse("name = 'marquise'").unwrap_err().contains("marquise"));
    assert!(parse("crown = 34").unwrap_err().contains("name"));
}

#[test]
fn parameters_out_of_range_are_refused_with_the_range() {
    let message = |cut: Result<Cut, spectral_core::Error>| cut.unwrap_err().to_string();
    let brilliant = RoundBrilliant::default;
    let wrong = [
        (RoundBrilliant { table: f64::NAN, ..brilliant() }, "table"),
        (RoundBrilliant { crown: 90.0, ..brilliant() }, "crown"),
        (RoundBrilliant { pavilion: -40.0, ..brilliant() }, "pavilion"),
        (RoundBrilliant { star: 0.01, ..brilliant() }, "star"),
        (RoundBrilliant { lower_half: 1.0, ..brilliant() }, "lower_half"),
        (RoundBrilliant { girdle: -0.1, ..brilliant() }, "girdle"),
        (RoundBrilliant { girdle_facets: 20, ..brilliant() }, "girdle_facets"),
        (RoundBrilliant { culet: 0.5, ..brilliant() }, "culet"),
    ];
    for (shape, name) in wrong {
        let message = message(shape.cut());
        assert!(message.starts_with(&format!("{name}: ")), "{message}");
    }
    let step = Step { crown: vec![30.0, 40.0], ..Step::default() };
    assert_eq!(message(step.cut()), "crown[1]: 40 is not valid; it must lie between 0 and 30");
    let step = Step { pavilion_levels: Some(vec![0.5]), ..Step::default() };
    assert!(message(step.cut()).contains("3 rows meet at 2 levels"));
    let portuguese = Portuguese { crown: vec![], ..Portuguese::default() };
    assert!(message(portuguese.cut()).starts_with("crown: 0 angles"));
}

#[test]
fn every_valid_parameter_set_closes() {
    let mut random = Random(5);
    let mut made = [0; 3];
    for _ in 0..3000 {
        let mut r = |low: f64, high: f64| low + (high - low) * random.unit();
        let mut falling = |high: f64, n: usize| {
            let mut angles: Vec<f64> = (0..n).map(|_| r(5.0, high)).collect();
            angles.sort_by(|a, b| b.total_cmp(a));
            angles
        };
        let (crown, pavilion) = (falling(70.0, 3), falling(70.0, 4));
        let brilliant = RoundBrilliant {
            table: r(0.05, 0.95),
            crown: r(5.0, 80.0),
            pavilion: r(5.0, 80.0),
            star: r(0.0, 1.0),
            lower_half: r(0.0, 1.0),
            girdle: (r(-0.1, 0.2)).max(0.0),
            girdle_facets: [16, 32, 64, 96][r(0.0, 4.0) as usize],
            culet: r(-0.1, 0.1).max(0.0),
        };
        let (length, corner, table) = (r(1.0, 3.0), r(-0.1, 0.5).max(0.0), r(0.05, 0.95));
        let girdle = r(-0.05, 0.1).max(0.0);
        let step = Step {
            length,
            corner,
            table,
            girdle,
            crown: crown.clone(),
            pavilion: pavilion.clone(),
            crown_levels: None,
            pavilion_levels: None,
        };
        let portuguese = Portuguese { facets: 16, crown, pavilion, girdle };
        for (k, cut) in [brilliant.cut(), step.cut(), portuguese.cut()].into_iter().enumerate() {
            let Ok(cut) = cut else { continue };
            let (mesh, _) =
                cut.solid().unwrap_or_else(|e| panic!("{e}: {brilliant:?} {step:?} {portuguese:?}"));
            check_mesh(&mesh);
            made[k] += 1;
        }
    }
    assert!(made[0] > 1000 && made[1] == 3000 && made[2] > 100, "{made:?}");
}
