//! Stones far apart are rendered as the reference does, or refused.

use gemtrace_tests::prelude::*;

/// Two brilliants so many mm apart, on a metal ground 20 times as wide as both together.
fn apart(distance: f64) -> Scene {
    let diamond = || gem("round-brilliant", material("diamond"));
    let width = 20.0 * (distance + 6.5);
    let low = DVec3::new(distance / 2.0 - width / 2.0, -width / 2.0, -4.0 - width / 100.0);
    let ground = stone(cuboid(low, low + DVec3::new(width, width, width / 100.0)), metal(0.2, 3.4));
    let camera = eye(DVec3::new(0.0, -20.0, 26.2), 14.0);
    scene(camera, 24, studio(), vec![diamond(), at(diamond(), [distance, 0.0, 0.0]), ground])
}

fn lines() -> RenderSettings {
    RenderSettings { threshold: 1e-3, max_depth: 24, ..settings(&[450.0, 550.0, 650.0]) }
}

#[test]
fn what_is_not_refused_is_right() {
    for distance in [10.0, 100.0, 800.0] {
        let scene = apart(distance);
        let mean = |backend| {
            let lines = render(backend, &scene, &lines()).radiances().concat();
            lines.iter().sum::<f64>() / lines.len() as f64
        };
        let (cpu, reference) = (mean(&CPU), mean(&REFERENCE));
        close(cpu / reference, 1.0, 2e-3, format!("{distance} mm apart"));
    }
}

#[test]
fn stones_too_far_apart_are_refused_by_name() {
    for distance in [1e4, 1e5, 1e6] {
        let error = PreparedScene::new(&apart(distance), &lines()).unwrap_err().to_string();
        assert!(
            error.starts_with("radius of the scene: ") && error.contains("single precision carries"),
            "{error}"
        );
    }
    // A speck that no pixel shows is not judged.
    let mut scene = apart(100.0);
    scene.stones.push(at(stone(cuboid(DVec3::ZERO, DVec3::splat(1e-3)), glass(1.5)), [9.0, 9.0, 9.0]));
    assert!(PreparedScene::new(&scene, &lines()).is_ok());
}
