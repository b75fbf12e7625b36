//! The picture does not depend on position, orientation and unit of length.

use gemtrace_tests::prelude::*;

const SIZE: u32 = 40;

fn quick() -> RenderSettings {
    RenderSettings { threshold: 1e-3, max_depth: 12, ..settings(&[450.0, 600.0]) }
}

fn brilliant() -> Scene {
    let stones = vec![gem("round-brilliant", tinted(2.417, 0.05))];
    scene(eye(DVec3::new(5.0, -13.0, 17.0), 24.0), SIZE, studio(), stones)
}

fn group() -> Scene {
    let star = at(stone(star(7, 1.0, 2.4, 1.2), tinted(1.77, 0.2)), [-1.5, 0.4, 0.0]);
    let ring = at(stone(torus(1.5, 0.5, 16, 8), tinted(1.5, 0.4)), [2.0, -0.5, 0.3]);
    scene(eye(DVec3::new(5.0, -13.0, 17.0), 24.0), SIZE, studio(), vec![star, ring])
}

/// The scene's stones and camera after x → scale · rotation · x + shift; the light stays.
fn moved(original: &Scene, rotation: DMat3, scale: f64, shift: DVec3) -> Scene {
    let place = |p: DVec3| scale * (rotation * p) + shift;
    let c = &original.camera;
    let projection = match c.projection {
        Projection::Orthographic { height } => Projection::Orthographic { height: scale * height },
        perspective => perspective,
    };
    let camera =
        Camera { position: place(c.position), look_at: place(c.look_at), up: rotation * c.up, projection };
    let stones = original.stones.iter().map(|stone| {
        let mesh = stone.placed().and_then(|m| m.transformed(rotation, scale, shift)).expect("a valid place");
        Stone::new(stone.name.clone(), Arc::new(mesh), stone.material.clone())
    });
    Scene { camera, stones: stones.collect(), ..original.clone() }
}

/// Checks that both pictures are the same by every algorithm: the median within the precision of the arithmetic, and few
/// pixels on the other side of an edge.
fn same(original: &Scene, changed: &Scene, what: &str) {
    for way in Way::ALL {
        let (before, after) = (way.render(original, &quick()), way.render(changed, &quick()));
        let difference = Difference::of_stones(&before, &after);
        println!("{what}, {way:?}: {difference}");
        assert!(difference.samples > 200, "{what}: {difference}");
        assert!(difference.median <= way.tolerance(1e-5, 1.2e-7), "{what}, {way:?}: {difference}");
        assert!(difference.over_1_percent < way.tolerance(5e-3, 1e-3), "{what}, {way:?}: {difference}");
    }
}

#[test]
fn turning_everything_about_z() {
    // Lights, stones and camera turn counter-clockwise seen from +z.
    for original in [brilliant(), group()] {
        for degrees in [33.0, 90.0, -157.5_f64] {
            let mut turned = moved(&original, DMat3::from_rotation_z(degrees.to_radians()), 1.0, DVec3::ZERO);
            turned.environment.rotation = degrees;
            same(&original, &turned, &format!("turned by {degrees}°"));
        }
    }
}

#[test]
fn turning_everything_in_uniform_light() {
    // In uniform light, absorption shows the lengths of paths.
    let turn = DMat3::from_axis_angle(DVec3::new(0.3, 0.5, -0.8).normalize(), 1.2345);
    for original in [brilliant(), group()] {
        let original = Scene { environment: furnace(), ..original };
        same(&original, &moved(&original, turn, 1.0, DVec3::ZERO), "turned about a skew axis");
    }
}

#[test]
fn scaling_everything() {
    // Optical depth is absorption × length: a stone s times as large with 1/s of the absorption looks the same.
    for original in [brilliant(), group()] {
        for scale in [1e-3, 0.37, 250.0] {
            let mut scaled = moved(&original, DMat3::IDENTITY, scale, DVec3::ZERO);
            for stone in &mut scaled.stones {
                let (n, absorption) = (stone.material.index(550.0), stone.material.absorption(550.0));
                stone.material = Arc::new(tinted(n, absorption / scale));
            }
            same(&original, &scaled, &format!("scaled by {scale}"));
        }
    }
}

#[test]
fn moving_everything_far_away() {
    // At 10⁶ mm double precision resolves 1e-10 mm; this rounding happens before rendering.
    for original in [brilliant(), group()] {
        let far = moved(&original, DMat3::IDENTITY, 1.0, DVec3::new(1e6, -7e5, 3e5));
        same(&original, &far, "moved by a kilometre");
    }
}

#[test]
fn a_stone_placed_by_its_own_fields_is_the_stone_moved() {
    // stone = R·(scale·file) + position; R turns about x, then y, then z, right-handed.
    let mut placed = brilliant();
    placed.stones[0].rotation = DVec3::new(20.0, -35.0, 50.0);
    placed.stones[0].position = DVec3::new(0.4, -0.3, 0.2);
    let radians = placed.stones[0].rotation * std::f64::consts::PI / 180.0;
    let rotation = DMat3::from_rotation_z(radians.z)
        * DMat3::from_rotation_y(radians.y)
        * DMat3::from_rotation_x(radians.x);
    let mut by_hand = brilliant();
    let mesh = by_hand.stones[0].placed().expect("a valid place");
    let mesh = mesh.transformed(rotation, 1.0, placed.stones[0].position).expect("a rotation");
    by_hand.stones[0] = Stone::new("by hand", Arc::new(mesh), by_hand.stones[0].material.clone());
    let (a, b) = (render(&REFERENCE, &placed, &quick()), render(&REFERENCE, &by_hand, &quick()));
    let difference = Difference::of_stones(&a, &b);
    assert!(difference.median < 1e-7 && difference.over_1_percent < 1e-3, "{difference}");
}
