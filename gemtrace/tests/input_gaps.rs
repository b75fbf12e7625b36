//! Meshes that are nearly closed, and metals that need not be.

use gemtrace::scene_file::{self, LoadedScene};
use gemtrace::{Error, Session};
use std::f64::consts::TAU;
use std::fmt::Write;

/// A double pyramid of `n` sides whose crown begins `gap` further in than its pavilion ends, `more` vertices to a side of the
/// crown; `left_out` faces are missing.
fn pyramids(n: usize, gap: f64, more: usize, left_out: usize) -> String {
    let (mut text, mut faces) = (String::new(), Vec::new());
    let rim = n * more;
    let at = |k: f64, radius: f64| {
        // On the straight sides of the pavilion's rim.
        let (corner, share) = (k.floor(), k.fract());
        let point = |k: f64| [radius * (TAU * k / n as f64).cos(), radius * (TAU * k / n as f64).sin()];
        let ([ax, ay], [bx, by]) = (point(corner), point(corner + 1.0));
        [ax + share * (bx - ax), ay + share * (by - ay)]
    };
    let mut vertex = |[x, y]: [f64; 2], z: f64| writeln!(text, "v {x} {y} {z}").unwrap();
    (0..n).for_each(|k| vertex(at(k as f64, 1.0), 0.0));
    (0..rim).for_each(|k| vertex(at(k as f64 / more as f64, 1.0 - gap), 0.0));
    vertex([0.0; 2], 0.4);
    vertex([0.0; 2], -0.8);
    (0..n).for_each(|k| faces.push([(k + 1) % n, k, n + rim + 1]));
    (0..rim).for_each(|k| faces.push([n + k, n + (k + 1) % rim, n + rim]));
    for [a, b, c] in &faces[left_out..] {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    text
}

fn load(mesh: &str, keys: &str) -> Result<LoadedScene, Error> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), mesh).unwrap();
    let text = format!(
        "format = 1\ncamera = {{ position = [0, -20, 20], look_at = [0, 0, 0], fov = 6.0 }}\n\
         film = {{ width = 32, height = 32, background = 'transparent' }}\n\
         render = {{ quality = 'draft' }}\n[[stone]]\nmesh = 'a.obj'\n{keys}\n"
    );
    scene_file::parse(&text, "a.toml".as_ref(), folder.path())
}

fn said(loaded: &LoadedScene) -> String {
    loaded.warnings.iter().map(|w| w.message.clone()).collect::<Vec<_>>().join("; ")
}

#[test]
fn hairline_gaps_are_closed_and_named() {
    let whole = load(&pyramids(8, 0.0, 1, 0), "material = 'ruby'").unwrap();
    let volume = |loaded: &LoadedScene| loaded.scene.stones[0].mesh.volume();
    for (gap, more) in [(1e-6, 1), (1e-4, 1), (1e-3, 1), (1e-4, 3), (1e-3, 2), (1e-6, 2)] {
        let mended = load(&pyramids(8, gap, more, 0), "material = 'ruby'")
            .unwrap_or_else(|e| panic!("{gap} {more}: {e}"));
        assert!((volume(&mended) / volume(&whole) - 1.0).abs() < 3.0 * gap + 1e-9, "{gap} {more}");
        let warning = said(&mended);
        assert!(warning.contains("its surface had gaps, the largest"), "{gap} {more}: {warning}");
        let widest: f64 =
            warning.split("largest ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((0.5 * gap..1.1 * gap).contains(&widest), "{gap} {more}: {warning}");
    }
}

#[test]
fn wider_openings_say_how_wide_and_a_hull_closes_them() {
    for (mesh, share) in [(pyramids(8, 0.05, 1, 0), "(2.5"), (pyramids(8, 0.0, 1, 1), "% of its size)")] {
        let error = load(&mesh, "material = 'ruby'").unwrap_err().to_string();
        assert!(error.contains("open mesh: ") && error.contains("its largest opening is"), "{error}");
        assert!(error.contains(share) && error.contains("hull = true takes its convex hull"), "{error}");
        let hull = load(&mesh, "material = 'ruby'\nhull = true").unwrap();
        let stone = &hull.scene.stones[0].mesh;
        assert!(stone.is_convex() && said(&hull).is_empty(), "{}", said(&hull));
        // A regular octagon of radius 1 and 1.2 high, a little less where the crown is smaller.
        assert!((0.9..1.01).contains(&(stone.volume() / (8.0_f64.sqrt() * 1.2 / 3.0))), "{}", stone.volume());
    }
}

#[test]
fn metals_need_no_inside() {
    let open = pyramids(8, 0.0, 1, 3);
    // Three triangles at one edge.
    let fin = pyramids(8, 0.0, 1, 0) + "v 3 0 2\nf 1 19 2\n";
    let mut session = Session::open("cpu").unwrap();
    for (mesh, fault) in [(open, "open mesh"), (fin, "non-manifold mesh")] {
        assert!(load(&mesh, "material = 'ruby'").unwrap_err().to_string().contains(fault));
        let loaded = load(&mesh, "material = 'gold'").unwrap();
        assert!(
            said(&loaded).contains(fault) && said(&loaded).contains("as a thin sheet"),
            "{}",
            said(&loaded)
        );
        let picture = session.render(loaded).unwrap();
        let covered = picture.film.to_space(spectral_core::color::RgbSpace::Srgb);
        // From above and from below, gold is gold: nowhere black, nowhere lit beyond the lights.
        let gold =
            covered.iter().filter(|[r, g, b, alpha]| *alpha > 0.99 && r > g && g > b && *b > 0.0).count();
        let all = covered.iter().filter(|pixel| pixel[3] > 0.99).count();
        assert!(all > 150 && gold * 10 > all * 9, "{gold} of {all}");
    }
    // Both sides of a single triangle.
    for height in [20.0, -20.0] {
        let text = format!("v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n# {height}");
        let mut loaded = load(&text, "material = 'silver'").unwrap();
        loaded.scene.camera.position.z = height;
        let picture = session.render(loaded).unwrap();
        let bright = picture.film.to_space(spectral_core::color::RgbSpace::Srgb);
        assert!(bright.iter().filter(|p| p[3] > 0.99 && p[1] > 0.01).count() > 40, "{height}");
    }
}
