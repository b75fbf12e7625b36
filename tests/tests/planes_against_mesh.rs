//! The same cut by its facet planes and by the hierarchy of triangles.

use gemtrace_tests::prelude::*;

fn view(cut: &str) -> Scene {
    let camera = eye(DVec3::new(3.0, -11.0, 30.0), 13.0);
    scene(camera, 128, studio(), vec![gem(cut, tinted(2.0, 0.03))])
}

/// A small stone far behind the camera: the stone is no longer alone.
fn with_crumb(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let crumb = Stone { width: Some(1e-3), position: DVec3::new(9.0, 20.0, 60.0), ..scene.stones[0].clone() };
    scene.stones.push(crumb);
    scene
}

fn agree(planes: &Picture, mesh: &Picture, what: &str) {
    let difference = Difference::of_stones(planes, mesh);
    println!("{what}: {difference}");
    assert!(difference.samples > 10_000, "{what}: {difference}");
    assert!(difference.median < 1e-5, "{what}: {difference}");
    assert!(difference.over_1_percent <= 5e-3, "{what}: {difference}");
}

#[test]
fn each_cut_looks_the_same_both_ways() {
    for cut in CUTS {
        for polarized in [true, false] {
            let settings = RenderSettings { polarized, threshold: 1e-6, ..settings(&[450.0, 600.0]) };
            let scene = view(cut);
            let planes = Way::Planes.render(&scene, &settings);
            let what = format!("{cut}, polarised {polarized}");
            agree(&planes, &Way::Tree.render(&scene, &settings), &format!("{what}, a speck inside"));
            let beside = render(&CPU, &with_crumb(&scene), &settings);
            agree(&planes, &beside, &format!("{what}, a crumb far away"));
        }
    }
}
