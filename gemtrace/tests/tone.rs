//! Colours that a screen cannot show keep their hue in PNGs.

use gemtrace::Session;
use gemtrace::output::Picture;
use gemtrace::scene_file::{self, LoadedScene, Override};
use spectral_core::color::{Oklab, RgbSpace, Tone, lab, matrix::apply, srgb_decode};
use spectral_core::environment::{Environment, LatLong};
use spectral_core::settings::Quality;

const PRISM: &str =
    "v -4 -1 0\nv -4 1 0\nv -4 0 1.7320508075688772\nv 4 -1 0\nv 4 1 0\nv 4 0 1.7320508075688772
f 1 2 3\nf 4 6 5\nf 1 4 5 2\nf 2 5 6 3\nf 3 6 4 1\n";

const SCENE: &str = "format = 1
camera = { position = [0, -30, -7.168476], look_at = [0, 0, 0.87], fov = 3.3 }
film = { width = 3, height = 200 }
render = { samples = 9, wavelengths = { count = 48 } }
[[stone]]
mesh = 'prism.obj'
material = 'X'
[material.X]
cauchy = [1.48, 0.004, 0.0]
";

/// A bright slit behind a prism.
fn prism() -> LoadedScene {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("prism.obj"), PRISM).unwrap();
    let mut loaded = scene_file::parse(SCENE, "prism.toml".as_ref(), folder.path()).unwrap();
    let mut texels = vec![[0.0; 3]; 8 * 1800];
    texels[8 * 1117..8 * 1118].fill([50.0; 3]);
    loaded.scene.environment = Environment::image(LatLong::new(8, 1800, texels).unwrap().0);
    loaded
}

/// Linear sRGB of what a PNG shows, with alpha 1, row by row.
fn shown(picture: &Picture) -> Vec<[f64; 3]> {
    let linear = |[r, g, b, _]: [u8; 4]| [r, g, b].map(|c| srgb_decode(f64::from(c) / 255.0));
    picture.rgba().into_iter().map(linear).collect()
}

fn hue([_, a, b]: [f64; 3]) -> f64 {
    b.atan2(a).to_degrees().rem_euclid(360.0)
}

#[test]
fn the_hues_of_a_spectrum_never_turn_back() {
    let mut session = Session::open("cpu").unwrap();
    let mut picture = session.render(prism()).unwrap();
    let oklab = Oklab::of(RgbSpace::Srgb);
    for tone in [Tone::Hue, Tone::Neutral, Tone::Clip] {
        let mut back = 0.0_f64;
        for stops in [-4.0, -2.0, 0.0, 2.0, 4.0] {
            (picture.options.exposure, picture.options.tone) = (stops, Some(tone));
            let column: Vec<[f64; 3]> = shown(&picture).into_iter().skip(1).step_by(3).collect();
            let coloured = column.iter().map(|rgb| oklab.of_rgb(*rgb));
            // Of darker and paler colours, 8 bits do not hold the hue.
            let hues: Vec<f64> =
                coloured.filter(|[l, a, b]| *l > 0.2 && a.hypot(*b) > 0.05).map(hue).collect();
            // From violet, over blue, cyan, green and yellow, to red.
            assert!(
                tone == Tone::Clip || hues[0] > 290.0 && hues[hues.len() - 1] < 40.0,
                "{stops}: {hues:?}"
            );
            let turned = hues.iter().scan(f64::INFINITY, |least, hue| {
                *least = least.min(*hue);
                Some(hue - *least)
            });
            back = turned.fold(back, f64::max);
        }
        // Neutral moves towards white in a straight line, on which blue turns a little to violet.
        let most = if tone == Tone::Hue { 2.0 } else { 8.0 };
        assert_eq!(back < most, tone != Tone::Clip, "{}: {back}°", tone.name());
    }
}

#[test]
fn no_colour_of_the_first_picture_changes_its_hue() {
    let mut loaded = scene_file::load("../scenes/brilliant.toml".as_ref()).unwrap();
    let change = Override { quality: Some(Quality::Draft), size: Some([200, 200]), ..Override::default() };
    change.apply(&mut loaded);
    let mut session = Session::open("cpu").unwrap();
    let mut picture = session.render(loaded).unwrap();
    let oklab = Oklab::of(RgbSpace::Srgb);
    let white = RgbSpace::Srgb.white_xyz();
    let mut moved = |tone| {
        picture.options.tone = Some(tone);
        let pairs = picture.film.to_space(RgbSpace::Srgb).into_iter().zip(shown(&picture));
        let coloured = pairs.filter(|(_, shown)| {
            let [_, a, b] = lab(apply(&RgbSpace::Srgb.to_xyz(), *shown), white);
            a.hypot(b) > 10.0
        });
        let turns = coloured.map(|([r, g, b, _], shown)| {
            let [given, found] = [[r, g, b].map(f64::from), shown].map(|rgb| hue(oklab.of_rgb(rgb)));
            (given - found + 540.0).rem_euclid(360.0) - 180.0
        });
        turns.fold((0.0_f64, 0), |(most, count), turn| (most.max(turn.abs()), count + 1))
    };
    let ((most, count), (clipped, _)) = (moved(Tone::Hue), moved(Tone::Clip));
    // What is left is the rounding of dark colours to 8 bits.
    assert!(most < 4.0 && count > 10_000, "{most}° in {count} pixels");
    assert!(clipped > 60.0, "{clipped}°");
}
