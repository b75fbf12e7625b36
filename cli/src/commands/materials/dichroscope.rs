//! What a crystal is known by: its optical character, and the colours of its rays, as a dichroscope shows them side by side.

use super::appearance::Colour;
use crate::commands::table;
use gemtrace::Error;
use serde_json::{Value, json};
use spectral_core::cie::Illuminant;
use spectral_core::crystal::{Crystal, Form, Wave};
use spectral_core::dispersion::fraunhofer;
use spectral_core::material::Material;

/// The axes of a crystal's own frame.
const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A crystal's optical character at sodium's D line.
pub struct Character {
    /// "uniaxial" or "biaxial".
    pub form: &'static str,
    /// '+' or '−'.
    pub sign: char,
    /// The largest difference of its indices.
    pub birefringence: f64,
    /// 2V, the acute angle between the optic axes, degrees; of biaxial crystals only.
    pub optic_angle: Option<f64>,
}

impl Character {
    /// None of what is isotropic.
    pub fn of(material: &Material) -> Option<Self> {
        let crystal = at(material, fraunhofer::D)?;
        let indices = crystal.indices();
        let about_z = crystal.optic_angle().to_degrees();
        let sign = if about_z < 90.0 { '+' } else { '−' };
        let [least, most] = [f64::min, f64::max].map(|pick| indices.into_iter().fold(indices[0], pick));
        let (form, optic_angle) = match crystal.form() {
            Form::Uniaxial(_) => ("uniaxial", None),
            Form::Biaxial(_) => ("biaxial", Some(about_z.min(180.0 - about_z))),
        };
        Some(Character { form, sign, birefringence: most - least, optic_angle })
    }
}

/// A crystal whose axes are those of the frame; none of what is isotropic.
fn at(material: &Material, nm: f64) -> Option<Crystal> {
    material.is_crystal().then(|| Crystal::new(material.indices(nm), AXES))
}

/// Whether it absorbs visible light.
pub fn is_coloured(material: &Material) -> bool {
    let absorbs = |nm: i32| material.absorptions(f64::from(nm)).iter().any(|alpha| *alpha > 0.0);
    (380..=780).step_by(5).any(absorbs)
}

/// One window: light polarised along one axis.
pub struct Window {
    /// The axis' name.
    pub axis: &'static str,
    /// Its colour by D65 and by illuminant A.
    pub colours: [Colour; 2],
}

/// A view through the crystal.
pub struct View {
    /// The direction, in words.
    pub along: String,
    /// The two windows.
    pub windows: [Window; 2],
}

/// The views along the axes through `mm` of a crystal: along and across the optic axis, or along x, y and z.
pub fn views(material: &Material, mm: f64) -> Result<Vec<View>, Error> {
    let directions: &[(&str, usize)] = match material.axes.len() {
        0 => &[],
        1 => &[("along the optic axis", 2), ("across it", 0)],
        _ => &[("along x", 0), ("along y", 1), ("along z", 2)],
    };
    let view = |&(along, direction): &(&str, usize)| {
        let [first, second] = [0, 1].map(|which| window(material, direction, which, mm));
        Ok(View { along: along.to_owned(), windows: [first?, second?] })
    };
    directions.iter().map(view).collect()
}

/// One of the two waves in a direction.
fn window(material: &Material, direction: usize, which: usize, mm: f64) -> Result<Window, Error> {
    let wave = |nm: f64| {
        at(material, nm).map(|crystal| (crystal, crystal.waves([0.0; 3], AXES[direction], 1.0)[which]))
    };
    let share = |nm: f64| {
        wave(nm)
            .map_or(1.0, |(crystal, wave)| (-mm * crystal.absorption(&wave, material.absorptions(nm))).exp())
    };
    let [day, lamp] = [Illuminant::D65, Illuminant::A].map(|light| Colour::of(&light, share));
    let axis = wave(fraunhofer::D).map_or("", |(_, wave)| polarisation(material, &wave));
    Ok(Window { axis, colours: [day?, lamp?] })
}

/// The axis that a wave's electric field lies along.
fn polarisation(material: &Material, wave: &Wave) -> &'static str {
    let along = |k: usize| wave.electric[k].re.abs();
    let names = material.axis_names();
    let nearest = names.iter().max_by(|a, b| along(a.1).total_cmp(&along(b.1)));
    // Across the optic axis every direction is o's.
    let across = material.axes.len() == 1 && along(2) < 0.5 * along(0).max(along(1));
    if across { names[0].0 } else { nearest.map_or("", |(name, _)| name) }
}

/// For JSON: null of what is isotropic.
pub fn facts(material: &Material, lines: &[(String, f64)], mm: f64) -> Result<Value, Error> {
    let Some(character) = Character::of(material) else { return Ok(Value::Null) };
    let axis = |&(name, k): &(&str, usize)| {
        let figures = lines.iter().map(|(line, nm)| {
            json!({ "line": line, "nm": nm, "n": material.indices(*nm)[k],
                    "absorption_per_mm": material.absorptions(*nm)[k] })
        });
        json!({ "axis": name, "lines": figures.collect::<Vec<_>>() })
    };
    let window = |window: &Window| {
        let [day, lamp] = window.colours;
        json!({ "axis": window.axis, "d65": { "srgb": day.hex(), "linear_srgb": day.0 },
                "a": { "srgb": lamp.hex(), "linear_srgb": lamp.0 } })
    };
    let views = views(material, mm)?;
    let views = views
        .iter()
        .map(|view| json!({ "view": view.along, "windows": view.windows.each_ref().map(window) }));
    Ok(json!({
        "form": character.form,
        "sign": if character.sign == '+' { "+" } else { "-" },
        "birefringence": character.birefringence,
        "two_v_deg": character.optic_angle,
        "axes": material.axis_names().iter().map(axis).collect::<Vec<_>>(),
        "dichroscope": { "thickness_mm": mm, "views": views.collect::<Vec<_>>() },
    }))
}

/// For people: the figures of the axes, then the colours.
pub fn describe(material: &Material, mm: f64) -> Result<String, Error> {
    let Some(character) = Character::of(material) else { return Ok(String::new()) };
    let Character { form, sign, birefringence, optic_angle } = character;
    let mut text = format!("\n\n{form} {sign}, birefringence {birefringence:.4}");
    if let Some(angle) = optic_angle {
        text += &format!(", 2V {angle:.0}°");
    }
    if !is_coloured(material) {
        return Ok(text);
    }
    let mut rows = vec![["", "window", "by D65", "by lamplight (A)"].map(str::to_owned).to_vec()];
    for view in views(material, mm)? {
        for (i, Window { axis, colours: [day, lamp] }) in view.windows.iter().enumerate() {
            let along = if i == 0 { view.along.clone() } else { String::new() };
            rows.push(vec![along, (*axis).to_owned(), day.hex(), lamp.hex()]);
        }
    }
    Ok(text + &format!("\n\nthrough a dichroscope, {mm} mm:\n{}", table::columns(4, &rows)))
}
