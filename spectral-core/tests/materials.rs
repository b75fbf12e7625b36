//! The catalogue: independently computed indices, sources, colours and names; materials in scene files.

use spectral_core::absorption::{Absorption, Term};
use spectral_core::cie::Illuminant;
use spectral_core::color::{Response, delta_e_2000, lab, srgb_encode};
use spectral_core::crystal::{Crystal, Form};
use spectral_core::dispersion::fraunhofer;
use spectral_core::material::{Catalogue, Kind, Material, MaterialSpec};
use spectral_core::spectrum::Tabulated;
use spectral_core::wavelength::WavelengthGrid;
use spectral_core::{Error, Warning};

/// n along an axis at B, C, D, d, e, F, g, G, h to five decimals, computed by another program from the published coefficients;
/// NaN if the line lies outside the fit.
#[rustfmt::skip]
const INDICES: [(&str, usize, [f64; 9]); 34] = [
    ("apatite", 0, [1.62943, 1.63048, 1.63335, 1.63344, 1.63577, 1.64025, 1.64557, 1.64621, 1.64998]),
    ("apatite", 2, [1.62743, 1.62848, 1.63134, 1.63143, 1.63375, 1.63819, 1.64345, 1.64408, 1.64779]),
    ("beryl", 0, [1.57973, 1.5806, 1.583, 1.58307, 1.58504, 1.58882, 1.59327, 1.5938, 1.5969]),
    ("beryl", 2, [1.57376, 1.57462, 1.577, 1.57707, 1.57902, 1.58276, 1.58716, 1.58769, 1.59075]),
    ("calcite", 0, [1.65302, 1.65446, 1.65834, 1.65846, 1.6616, 1.66765, 1.67489, 1.67578, 1.68096]),
    ("calcite", 2, [1.48371, 1.48435, 1.48613, 1.48618, 1.48765, 1.49049, 1.49389, 1.4943, 1.49671]),
    ("chrysoberyl", 0, [1.73667, 1.7378, 1.74078, 1.74087, 1.74323, 1.74768, 1.75288, 1.7535, 1.75714]),
    ("chrysoberyl", 1, [1.73857, 1.73971, 1.74273, 1.74282, 1.74522, 1.74976, 1.75508, 1.75572, 1.75946]),
    ("chrysoberyl", 2, [1.7441, 1.74527, 1.74836, 1.74845, 1.75091, 1.75554, 1.76097, 1.76162, 1.76542]),
    ("corundum", 0, [1.76369, 1.76488, 1.76808, 1.76817, 1.77071, 1.77551, 1.78113, 1.7818, 1.78573]),
    ("corundum", 2, [1.7557, 1.75687, 1.76, 1.7601, 1.76258, 1.76728, 1.77279, 1.77345, 1.7773]),
    ("cubic-zirconia", 0, [2.14506, 2.1486, 2.15847, 2.15877, 2.16697, 2.18315, 2.20302, 2.20547, 2.21998]),
    ("demantoid", 0, [1.87476, 1.87827, 1.888, 1.8883, 1.89627, 1.91158, 1.9296, 1.93176, 1.94429]),
    ("diamond", 0, [2.40728, 2.40991, 2.41726, 2.41749, 2.42359, 2.43554, 2.44997, 2.45173, 2.46205]),
    ("moissanite", 0, [2.62311, 2.6295, 2.64744, 2.64799, 2.66304, 2.69299, 2.7302, f64::NAN, f64::NAN]),
    ("moissanite", 2, [2.66214, 2.66917, 2.68897, 2.68958, 2.70628, 2.73973, 2.78172, f64::NAN, f64::NAN]),
    ("n-bk7", 0, [1.51343, 1.51432, 1.51673, 1.5168, 1.51872, 1.52238, 1.52669, 1.52721, 1.53024]),
    ("quartz", 0, [1.54097, 1.54185, 1.54421, 1.54428, 1.54614, 1.54966, 1.55378, 1.55428, 1.55716]),
    ("quartz", 2, [1.54996, 1.55087, 1.55331, 1.55338, 1.55531, 1.55895, 1.56321, 1.56372, 1.5667]),
    ("rutile", 0, [2.55673, 2.57092, 2.61292, 2.61427, 2.65203, 2.73451, 2.85293, 2.86907, f64::NAN]),
    ("rutile", 2, [2.83809, 2.85588, 2.90866, 2.91035, 2.95806, 3.06304, 3.21581, 3.23682, f64::NAN]),
    ("sphene", 0, [1.88874, 1.89173, 1.9, 1.90025, 1.90703, 1.92005, 1.93537, 1.9372, 1.94786]),
    ("sphene", 1, [1.89605, 1.89906, 1.9074, 1.90765, 1.91449, 1.92761, 1.94306, 1.94491, 1.95565]),
    ("sphene", 2, [2.02107, 2.0245, 2.034, 2.03429, 2.04207, 2.05703, 2.07463, 2.07674, 2.08898]),
    ("spinel", 0, [1.7113, 1.7126, 1.7161, 1.71621, 1.71903, 1.7244, 1.73073, 1.73149, 1.73593]),
    ("strontium-titanate", 0, [2.36892, 2.37892, 2.408, 2.40892, 2.43459, 2.48973, 2.5679, 2.57853, f64::NAN]),
    ("topaz", 0, [1.60859, 1.60939, 1.61161, 1.61168, 1.61349, 1.61698, 1.62108, 1.62158, 1.62443]),
    ("topaz", 1, [1.61073, 1.61153, 1.61374, 1.6138, 1.61561, 1.61909, 1.62318, 1.62368, 1.62652]),
    ("topaz", 2, [1.61803, 1.61884, 1.62109, 1.62116, 1.623, 1.62654, 1.63071, 1.63121, 1.63411]),
    ("tourmaline", 0, [1.63999, 1.64105, 1.644, 1.64409, 1.6465, 1.65114, 1.6566, 1.65726, 1.66105]),
    ("tourmaline", 2, [1.62011, 1.62114, 1.624, 1.62409, 1.62643, 1.63092, 1.63621, 1.63684, 1.64052]),
    ("yag", 0, [1.82629, 1.82799, 1.83265, 1.83279, 1.83657, 1.84383, 1.85247, 1.85351, 1.8596]),
    ("zircon", 0, [1.91622, 1.91855, 1.925, 1.9252, 1.93048, 1.94063, 1.95258, 1.95401, 1.96232]),
    ("zircon", 2, [1.97466, 1.97714, 1.984, 1.98421, 1.98983, 2.00063, 2.01334, 2.01487, 2.0237]),
];

fn material(name: &str) -> &'static Material {
    Catalogue::builtin().get(name).unwrap()
}

fn spec(text: &str) -> MaterialSpec {
    toml::from_str(text).unwrap()
}

fn build(text: &str) -> Result<(Material, Vec<Warning>), Error> {
    spec(text).build("sample", |file| Tabulated::from_csv("nm,1/mm\n400,0.1\n700,0.3\n", file))
}

fn message(text: &str) -> String {
    build(text).map(|_| ()).unwrap_err().to_string()
}

#[test]
fn indices_at_the_fraunhofer_lines() {
    for (name, axis, expected) in INDICES {
        let material = material(name);
        for ((line, nm), n) in fraunhofer::LINES.into_iter().zip(expected).filter(|(_, n)| !n.is_nan()) {
            let found = material.indices(nm)[axis];
            assert!((found - n).abs() < 5.1e-6, "{name}, axis {axis}, at {line}: {found} instead of {n}");
        }
    }
    // Coloured varieties share their host's index.
    for (variety, host) in [
        ("ruby", "corundum"),
        ("sapphire", "corundum"),
        ("pink-sapphire", "corundum"),
        ("colour-change-sapphire", "corundum"),
        ("alexandrite", "chrysoberyl"),
        ("amethyst", "quartz"),
        ("citrine", "quartz"),
        ("emerald", "beryl"),
        ("aquamarine", "beryl"),
        ("blue-topaz", "topaz"),
        ("blue-zircon", "zircon"),
        ("pink-tourmaline", "tourmaline"),
        ("green-tourmaline", "tourmaline"),
    ] {
        for nm in [400.0, 550.0, 700.0] {
            assert_eq!(material(variety).indices(nm), material(host).indices(nm), "{variety}");
        }
        assert_eq!(material(host).absorptions(550.0), [0.0; 3]);
        assert!(material(variety).absorptions(550.0).iter().all(|alpha| *alpha > 0.0), "{variety}");
    }
    // Malitson 1965, table 1: fused silica at 20 °C.
    let silica = material("fused-silica");
    for (nm, n) in [(404.656, 1.46962), (486.133, 1.46313), (587.561, 1.45846), (656.272, 1.45637)] {
        assert!((silica.index(nm) - n).abs() < 6e-6, "fused silica at {nm}: {}", silica.index(nm));
    }
}

#[test]
fn gem_dispersion_is_that_of_textbooks() {
    for (name, textbook) in
        [("diamond", 0.044), ("corundum", 0.018), ("cubic-zirconia", 0.060), ("yag", 0.028)]
    {
        let Kind::Dielectric { dispersion, .. } = &material(name).kind else { panic!("{name} is no metal") };
        let found = dispersion.dispersion_bg();
        assert!((found - textbook).abs() < 1e-3, "{name}: {found}");
    }
    let Kind::Dielectric { dispersion, .. } = &material("n-bk7").kind else { panic!() };
    assert!((dispersion.abbe_number() - 64.17).abs() < 0.01);
}

#[test]
fn every_material_has_sources_and_passes_its_check() {
    for material in Catalogue::builtin().materials() {
        let warnings = material.check([380.0, 780.0]).unwrap();
        let known = |figure: &str| material.sources.iter().filter(|s| s.figure == figure).count() == 1;
        assert!(known("dispersion"), "{}", material.name);
        let range = material.sources.iter().find_map(|s| s.range).unwrap();
        assert_eq!(warnings.is_empty(), range[0] <= 380.0 && range[1] >= 780.0, "{warnings:?}");
        assert_eq!(known("density"), material.density.is_some(), "{}", material.name);
        if let Kind::Dielectric { absorption, .. } = &material.kind {
            assert_eq!(known("absorption"), !absorption.is_none(), "{}", material.name);
        }
        for source in &material.sources {
            assert!(source.source.len() > 10 && !source.licence.is_empty(), "{source:?}");
        }
        assert_eq!(material.ray, ["isotropic", "ordinary", "alpha"][material.axes.len()]);
    }
}

#[test]
fn every_expected_material_is_there() {
    let catalogue = Catalogue::builtin();
    let names = "diamond moissanite corundum ruby sapphire spinel quartz amethyst citrine beryl emerald topaz zircon \
        cubic-zirconia yag n-bk7 gold silver platinum copper rose-gold";
    for name in names.split(' ') {
        assert_eq!(catalogue.get(name).unwrap().name, name);
    }
    for (alias, name) in
        [("CZ", "cubic-zirconia"), ("bk7", "n-bk7"), ("N_BK7", "n-bk7"), ("Sapphire Blue", "sapphire")]
    {
        assert_eq!(catalogue.get(alias).unwrap().name, name);
    }
    let error = catalogue.get("saphire").unwrap_err().to_string();
    assert_eq!(error, "unknown material 'saphire'; did you mean 'sapphire'?");
    assert!(catalogue.get("granite").unwrap_err().to_string().contains("valid: alexandrite, amethyst"));
}

/// Sign, birefringence at 589.3 nm, and 2V in degrees of biaxial crystals, computed by another program.
#[rustfmt::skip]
const CRYSTALS: [(&str, char, f64, f64); 19] = [
    ("corundum", '-', 0.00807, f64::NAN),
    ("beryl", '-', 0.006, f64::NAN),
    ("quartz", '+', 0.0091, f64::NAN),
    ("tourmaline", '-', 0.02, f64::NAN),
    ("zircon", '+', 0.059, f64::NAN),
    ("moissanite", '+', 0.04153, f64::NAN),
    ("rutile", '+', 0.29574, f64::NAN),
    ("calcite", '-', 0.17221, f64::NAN),
    ("benitoite", '+', 0.047, f64::NAN),
    ("apatite", '-', 0.00201, f64::NAN),
    ("topaz", '+', 0.00948, 56.8),
    ("peridot", '+', 0.036, 87.1),
    ("chrysoberyl", '+', 0.00758, 61.1),
    ("tanzanite", '+', 0.008, 41.6),
    ("iolite", '-', 0.009, 82.1),
    ("andalusite", '-', 0.009, 83.4),
    ("kunzite", '+', 0.016, 62.8),
    ("sphene", '+', 0.134, 28.5),
    ("diopside", '+', 0.03, 62.9),
];

#[test]
fn crystals_have_their_sign_birefringence_and_optic_angle() {
    for (name, sign, birefringence, optic_angle) in CRYSTALS {
        let indices = material(name).indices(589.3);
        let (least, most) =
            (indices.into_iter().fold(9.0, f64::min), indices.into_iter().fold(0.0, f64::max));
        assert!((most - least - birefringence).abs() < 1.1e-5, "{name}: {indices:?}");
        let crystal = Crystal::new(indices, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let about_z = crystal.optic_angle().to_degrees();
        assert_eq!(about_z < 90.0, sign == '+', "{name}: 2V_z {about_z}");
        match crystal.form() {
            Form::Uniaxial(_) => assert!(optic_angle.is_nan(), "{name} is uniaxial"),
            Form::Biaxial(_) => {
                let acute = about_z.min(180.0 - about_z);
                assert!((acute - optic_angle).abs() < 0.3, "{name}: 2V {acute}");
                assert!(indices.is_sorted(), "{name}: {indices:?}");
            }
        }
        // Its single index is the ordinary one, or β; its absorption the mean.
        assert_eq!(material(name).isotropic().index(589.3), indices[material(name).axes.len() - 1], "{name}");
        let [x, y, z] = material(name).absorptions(550.0);
        assert!((material(name).isotropic().absorption(550.0) - (x + y + z) / 3.0).abs() < 1e-14, "{name}");
        assert!(!material(name).isotropic().is_crystal());
    }
}

/// Colours along the axes, computed by another program from the same bands.
#[test]
fn crystals_have_their_colours_along_each_axis() {
    let text = include_str!("data/materials/axes.csv");
    let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0).unwrap();
    let response = Response::new(&grid).unwrap();
    let mut names = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().unwrap();
        let (material, mm, axis) = (material(cells[0]), number(1), number(2) as usize);
        for (first, light) in [(3, Illuminant::D65), (6, Illuminant::A)] {
            let through = |share: &dyn Fn(f64) -> f64| {
                response.to_xyz(&grid.nm().iter().map(|&nm| light.at(nm) * share(nm)).collect::<Vec<f64>>())
            };
            let found = through(&|nm| (-mm * material.absorptions(nm)[axis]).exp());
            let expected = [number(first), number(first + 1), number(first + 2)];
            let apart = delta_e_2000(lab(found, through(&|_| 1.0)), expected);
            assert!(apart < 0.1, "{line}: {apart}");
        }
        names.push(cells[0]);
    }
    names.dedup();
    assert_eq!(names.len(), 15);
}

/// Encoded sRGB (0–1, clipped) and luminance of D65 through `mm` of a stone, without surfaces; of a crystal the mean of its axes.
fn slab(material: &Material, mm: f64) -> ([f64; 3], f64) {
    let grid = WavelengthGrid::stepped(380.0, 780.0, 1.0).unwrap();
    let share = |nm: f64| material.absorptions(nm).map(|alpha| (-alpha * mm).exp()).iter().sum::<f64>() / 3.0;
    let light: Vec<f64> = grid.nm().iter().map(|&nm| Illuminant::D65.at(nm) * share(nm)).collect();
    let response = Response::new(&grid).unwrap();
    let rgb = response.to_linear_srgb(&light).map(|c| srgb_encode(c.clamp(0.0, 1.0)));
    (rgb, response.to_xyz(&light)[1])
}

/// Hue in degrees: 0 red, 60 yellow, 120 green, 180 cyan, 240 blue, 300 magenta.
fn hue([r, g, b]: [f64; 3]) -> f64 {
    f64::atan2(3.0_f64.sqrt() * (g - b), 2.0 * r - g - b).to_degrees().rem_euclid(360.0)
}

#[test]
fn five_millimetres_have_the_colour_of_the_gem() {
    // Hues a gemmologist would accept; saturation (max − min)/max, of the mean of the axes, which is paler than the strongest.
    for (name, from, to, saturation) in [
        ("ruby", 325.0, 360.0, 0.9),
        ("sapphire", 220.0, 250.0, 0.5),
        ("emerald", 130.0, 160.0, 0.8),
        ("amethyst", 290.0, 320.0, 0.3),
        ("citrine", 35.0, 55.0, 0.9),
        ("aquamarine", 170.0, 210.0, 0.15),
        ("blue-topaz", 185.0, 210.0, 0.2),
        ("blue-zircon", 180.0, 210.0, 0.3),
        ("pink-tourmaline", 300.0, 330.0, 0.3),
        ("peridot", 55.0, 80.0, 0.4),
        ("tanzanite", 200.0, 240.0, 0.15),
        ("demantoid", 70.0, 100.0, 0.9),
    ] {
        let (rgb, luminance) = slab(material(name), 5.0);
        let [max, min] = [rgb.into_iter().fold(0.0, f64::max), rgb.into_iter().fold(1.0, f64::min)];
        assert!((from..=to).contains(&hue(rgb)), "{name}: {rgb:?} has the hue {:.0}°", hue(rgb));
        assert!((max - min) / max > saturation, "{name}: {rgb:?}");
        assert!(luminance > 0.04 && max > 0.5, "{name} is too dark: {rgb:?}");
    }
    for name in ["diamond", "corundum", "spinel", "quartz", "beryl", "topaz", "zircon", "n-bk7"] {
        let (rgb, _) = slab(material(name), 5.0);
        assert!(rgb.iter().all(|c| (c - 1.0).abs() < 1e-12), "{name}: {rgb:?}");
    }
}

#[test]
fn a_scene_s_own_material() {
    let (glass, warnings) = build(
        "cauchy = [1.5046, 0.0042]\nabsorption = [{ centre = 553.0, sigma = 38.0, peak = 0.9 }, { constant = 0.015 }]",
    )
    .unwrap();
    assert!(warnings.is_empty() && glass.sources.is_empty());
    assert!((glass.index(500.0) - (1.5046 + 0.0042 / 0.25)).abs() < 1e-14);
    assert!((glass.absorption(591.0) - (0.9 * (-0.5_f64).exp() + 0.015)).abs() < 1e-14);

    let measured = "measured = [[486.13, 1.5224], [587.56, 1.5168], [656.27, 1.5143]]";
    let (glass, warnings) = build(measured).unwrap();
    for (nm, n) in [(486.13, 1.5224), (587.56, 1.5168), (656.27, 1.5143)] {
        assert!((glass.index(nm) - n).abs() < 1e-14);
    }
    assert!(warnings[0].message.contains("material 'sample'") && warnings[0].message.contains("486.13 nm"));

    let sellmeier = "sellmeier = { b = [1.03961212, 0.231792344, 1.01046945], c = [0.00600069867, 0.0200179144, 103.560653] }";
    assert!((build(sellmeier).unwrap().0.index(587.5618) - 1.5168).abs() < 1e-6);

    let (table, _) = build("index = 1.6\nabsorption = \"table.csv\"").unwrap();
    assert!((table.absorption(550.0) - 0.2).abs() < 1e-15);
}

#[test]
fn like_a_catalogue_material() {
    let (pink, _) = build("like = \"diamond\"\nabsorption = [{ constant = 0.02 }]").unwrap();
    assert_eq!(pink.index(500.0), material("diamond").index(500.0));
    assert_eq!(pink.absorption(500.0), 0.02);
    assert_eq!(pink.density, Some(3.52));
    assert!(pink.sources.iter().all(|s| s.figure != "absorption"));
    let (clear, _) = build("like = \"ruby\"\nabsorption = []").unwrap();
    assert_eq!(clear.absorption(550.0), 0.0);
    let (recut, _) = build("like = \"ruby\"\nindex = 1.76").unwrap();
    assert_eq!(
        (recut.index(500.0), recut.absorption(550.0)),
        (1.76, material("ruby").isotropic().absorption(550.0))
    );
    // What is like a crystal is one, with another absorption on every axis; an index of its own makes it isotropic.
    let (clear, _) = build("like = \"tanzanite\"\nabsorption = [{ constant = 0.1 }]").unwrap();
    assert_eq!(clear.absorptions(550.0), [0.1; 3]);
    let message_of = message("like = \"tanzanite\"\nextraordinary = { index = 1.7 }");
    assert!(message_of.contains("'tanzanite' is biaxial"), "{message_of}");
    let (red, _) = build("like = \"ruby\"").unwrap();
    assert_eq!(red.absorptions(550.0), material("ruby").absorptions(550.0));
    assert!(message("like = \"dimond\"").contains("did you mean 'diamond'?"));
    assert!(message("like = \"gold\"\nabsorption = []").contains("metal"));
}

#[test]
fn conductors() {
    let (metal, _) = build("conductor = { table = [[400.0, 1.0, 3.0], [700.0, 2.0, 4.0]] }").unwrap();
    assert!(metal.is_conductor());
    assert_eq!((metal.index(550.0), metal.extinction(550.0)), (1.5, 3.5));
    assert!(message("conductor = { table = [[400.0, 0.0, 3.0]] }").contains("conductor.table[0]"));
    assert!(message("conductor = { table = [[400.0, 1.0, -3.0]] }").contains("k at least 0"));
    assert!(message("conductor = { table = [] }").contains("table"));
    assert!(
        message("conductor = { table = [[500.0, 1.0, 1.0]] }\nabsorption = []").contains("leave this out")
    );
}

#[test]
fn impossible_descriptions_are_explained() {
    for (text, part) in [
        ("", "give one of index, cauchy"),
        ("index = 1.5\ncauchy = [1.5]", "index and cauchy is not valid; give one of them only"),
        ("index = 1.5\nabsorption = [{ constant = -1.0 }]", "absorption[0].constant: -1"),
        ("index = 1.5\nabsorption = [{ constant = nan }]", "NaN"),
        ("index = 1.5\nabsorption = [{ centre = 500.0, sigma = 0.0, peak = 1.0 }]", "absorption[0].sigma"),
        ("index = 1.5\nabsorption = [{ centre = 500.0, peak = 1.0 }]", "{ centre, peak }"),
        ("index = 1.5\nabsorption = [{ centre = 500.0, sigma = 9.0, peak = inf }]", "absorption[0].peak"),
        ("index = 1.5\ndensity = 0.0", "g/cm³"),
        ("sellmeier = { b = [1.0, 2.0], c = [0.01] }", "2 in b and 1 in c"),
        ("index_table = [[500.0, 1.5], [400.0, 1.6]]", "table entry 2"),
        ("measured = [[486.13, 1.5224], [587.56, 1.5168]]", "2 measurements"),
    ] {
        let found = message(text);
        assert!(found.contains(part) && found.contains("material 'sample'"), "{text}: {found}");
    }
    for (text, part) in [
        ("indx = 1.5", "unknown field `indx`"),
        ("index = 1.5\nabsorption = [{ center = 500.0 }]", "unknown field `center`"),
        ("index = 1.5\nabsorption = 3", "a list of bands"),
    ] {
        let found = toml::from_str::<MaterialSpec>(text).unwrap_err().to_string();
        assert!(found.contains(part), "{text}: {found}");
    }
}

#[test]
fn absorption_terms() {
    let band = Term::GaussianWavenumber { centre: 500.0, fwhm_cm1: 2000.0, peak: 0.8 };
    // 500 nm is 20 000 cm⁻¹; half the maximum lies 1000 cm⁻¹ to either side.
    for nm in [1e7 / 21_000.0, 1e7 / 19_000.0] {
        assert!((band.coefficient(nm) - 0.4).abs() < 1e-15);
    }
    let sum = Absorption::new(vec![band.clone(), Term::Constant(0.1)]).unwrap();
    assert!((sum.coefficient(500.0) - 0.9).abs() < 1e-15);
    assert_eq!(sum.transmittance(500.0, 0.0), 1.0);
    let negative = Tabulated::from_csv("400,0.1\n500,-0.1\n", "t").unwrap();
    let error = Absorption::new(vec![Term::Table(negative)]).unwrap_err().to_string();
    assert!(error.contains("500 nm") && error.contains("cannot add light"), "{error}");
}

#[test]
fn rose_gold_is_the_mean_of_its_metals_permittivities_by_volume() {
    // Mass in parts of 1000 and density, g/cm³.
    let parts = [("gold", 750.0, 19.30), ("silver", 45.0, 10.49), ("copper", 205.0, 8.96)];
    let volume: f64 = parts.iter().map(|(_, mass, density)| mass / density).sum();
    let alloy = material("rose-gold");
    assert!(alloy.is_conductor() && alloy.is_approximate());
    // At rows of the table, since n and k are interpolated linearly between them, but not their squares.
    for nm in [381.5, 450.9, 520.9, 582.1, 659.5, 756.0] {
        let square = |m: &Material| {
            let (n, k) = (m.index(nm), m.extinction(nm));
            [n * n - k * k, 2.0 * n * k]
        };
        let mut mean = [0.0; 2];
        for (name, mass, density) in parts {
            let share = mass / density / volume;
            mean = [0, 1].map(|i| mean[i] + share * square(material(name))[i]);
        }
        let found = square(alloy);
        // n and k have four decimals.
        let rounding = 2.0 * 5e-5 * (alloy.index(nm) + alloy.extinction(nm));
        for i in 0..2 {
            assert!((found[i] - mean[i]).abs() <= rounding, "{nm} nm: {found:?}, {mean:?}");
        }
    }
}

#[test]
fn the_metals_of_settings_have_their_colours() {
    let reflected = |name: &str| {
        let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0).unwrap();
        let share = |nm: f64| {
            let (n, k) = (material(name).index(nm), material(name).extinction(nm));
            ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k)
        };
        let light: Vec<f64> = grid.nm().iter().map(|&nm| Illuminant::D65.at(nm) * share(nm)).collect();
        Response::new(&grid).unwrap().to_linear_srgb(&light)
    };
    let [gold, rose, copper] = ["gold", "rose-gold", "copper"].map(reflected);
    // From yellow to pink there is more and more blue.
    assert!(gold[2] / gold[0] < rose[2] / rose[0] && rose[2] / rose[0] < copper[2] / copper[0]);
    for (name, least) in [("silver", 0.9), ("platinum", 0.55)] {
        let [r, g, b] = reflected(name);
        assert!(b > least && r / b < 1.25 && g / b < 1.15, "{name}: {r} {g} {b}");
    }
}
