//! GemCad text.

use super::Cut;
use indicatrix_formats::asc::{self, AscTier};
use spectral_core::cut::CutFacet;
use spectral_core::mesh::Plane;
use spectral_core::{Warning, shown};

pub(super) fn read(bytes: &[u8]) -> Result<(Cut, Vec<Warning>), String> {
    let text = asc::decode_asc_bytes(bytes);
    let text = joined(&text);
    let schedule = asc::parse_asc(&text).map_err(|e| format!("not a GemCad design: {e}"))?;
    if schedule.gemcad_version.is_empty() {
        return Err("not a GemCad design: it does not begin with 'GemCad'".into());
    }
    let mut warnings: Vec<Warning> = schedule.warnings.iter().map(Warning::new).collect();
    warnings.extend(negative_zeros(&text));
    let gear = f64::from(schedule.gear_teeth);
    let mut facets = Vec::new();
    for (number, tier) in schedule.tiers.iter().enumerate() {
        if tier.mast == 0.0 {
            let tier = label(number, tier);
            warnings
                .push(Warning::new(format!("{tier} goes through the centre (distance 0) and is ignored")));
            continue;
        }
        let azimuth = |index: f64| 360.0 * (index - schedule.gear_reference_angle) / gear;
        facets.extend(tier_facets(tier, azimuth));
        if facets.len() > Cut::MAX_FACETS {
            return Err(format!("more than {} facets", Cut::MAX_FACETS));
        }
    }
    let cut = Cut {
        facets,
        title: schedule.headers,
        footnotes: schedule.footnotes,
        gear: Some(schedule.gear_teeth),
        index_of_refraction: Some(schedule.refractive_index),
        colour: None,
    };
    Ok((cut, warnings))
}

fn label(number: usize, tier: &AscTier) -> String {
    if tier.name.is_empty() {
        format!("tier {}", number + 1)
    } else {
        format!("tier '{}'", shown(&tier.name))
    }
}

fn tier_facets(tier: &AscTier, azimuth: impl Fn(f64) -> f64) -> Vec<CutFacet> {
    // Either sign may say that a facet belongs to the pavilion: the angle's or the distance's.
    let angle = if tier.mast < 0.0 { -tier.angle_deg.abs() } else { tier.angle_deg };
    let flat = angle == 0.0;
    // A level facet is the same at every index.
    let indices = match tier.indices.as_slice() {
        [] => &[0.0],
        all if flat => &all[..1],
        all => all,
    };
    let instructions = Some(tier.notes.clone()).filter(|n| !n.is_empty());
    let shared = tier.names().first().map(|n| (*n).to_owned());
    indices
        .iter()
        .enumerate()
        .map(|(position, index)| {
            let own = tier.index_names.iter().find(|(at, _)| *at == position).map(|(_, name)| name.clone());
            CutFacet {
                plane: Plane::from_angles(angle, if flat { 0.0 } else { azimuth(*index) }, tier.mast.abs()),
                name: own.or_else(|| shared.clone()),
                instructions: instructions.clone(),
            }
        })
        .collect()
}

/// GemCad wraps its stream of words anywhere; the crate joins lines that begin with a number, `n` or `G`,
/// which leaves those that break between `n` and the name. Lines keep their numbers.
fn joined(text: &str) -> String {
    let mut joined = String::with_capacity(text.len());
    let mut gap = String::new();
    for line in text.lines() {
        joined.push_str(line);
        let mut words = line.split_whitespace();
        // A mirror flag may be an n, too, and prose may end with one.
        let closed = matches!(words.next(), Some("y" | "H" | "F" | "G")) || words.any(|w| w == "G");
        if !closed && line.split_whitespace().last() == Some("n") {
            joined.push(' ');
            gap.push('\n');
        } else {
            joined.push('\n');
            joined.push_str(&gap);
            gap.clear();
        }
    }
    joined
}

/// Level facets written `-0.0` with a positive distance: the sign puts them on the pavilion here and in most
/// programs, while GemCad's author's own ray tracer reads them as tables.
fn negative_zeros(text: &str) -> Vec<Warning> {
    let number = |w: &str| w.parse::<f64>().ok();
    text.lines()
        .enumerate()
        .filter_map(|(i, line)| {
            let mut words = line.split_whitespace();
            let (tier, angle, distance) = (words.next()?, words.next()?, number(words.next()?)?);
            (tier == "a" && angle.starts_with('-') && number(angle)? == 0.0 && distance > 0.0).then(|| {
                Warning::new(format!("line {}: the angle {angle} is taken for a culet, by its sign", i + 1))
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn design(body: &str) -> Result<(Cut, Vec<Warning>), String> {
        read(format!("GemCad 5.0\ng 96 0.0\ny 4 n\nI 1.54\n{body}").as_bytes())
    }

    fn planes(body: &str) -> Vec<Plane> {
        design(body).unwrap().0.facets.iter().map(|f| f.plane).collect()
    }

    #[test]
    fn indices_turn_clockwise_from_plus_y_unless_the_gear_is_negative() {
        let normal = |text: &str| read(text.as_bytes()).unwrap().0.facets[0].plane.normal;
        let text = "GemCad 5.0\ng 96 0.0\ny 1 n\nI 1.54\na 90 1 24\n";
        assert!(normal(text).abs_diff_eq(DVec3::X, 1e-15));
        assert!(normal(&text.replace("g 96", "g -96")).abs_diff_eq(-DVec3::X, 1e-15));
        assert!(normal(&text.replace("g 96 0.0", "g96 48.0")).abs_diff_eq(-DVec3::X, 1e-15));
    }

    #[test]
    fn index_lists_may_wrap_anywhere() {
        let one_line = planes("a -40 0.7 96 n P1 24 48 n P2 72 G cut to centre\n");
        for body in [
            "a -40 0.7 96 n P1 24\n48 n P2\n72 G cut to centre\n",
            "a -40 0.7 96 n\nP1 24 48 n\nP2 72\nG cut to centre\n",
            "a\n-40 0.7\n96 n P1 24 48\nn P2 72\nG cut to centre\n",
        ] {
            assert_eq!(planes(body), one_line, "{body}");
            let (cut, warnings) = design(body).unwrap();
            assert!(warnings.is_empty(), "{warnings:?}");
            let names: Vec<_> = cut.facets.iter().map(|f| f.name.as_deref().unwrap()).collect();
            assert_eq!((names[0], names[2]), ("P1", "P2"));
            assert_eq!(cut.facets[0].instructions.as_deref(), Some("cut to centre"));
        }
    }

    #[test]
    fn a_culet_is_known_by_either_sign() {
        let down = Plane { normal: -DVec3::Z, offset: 0.5 };
        assert_eq!(planes("a 0.00 -0.5 0\n"), [down]);
        assert_eq!(planes("a -0.000000 0.5 96 24 48\n"), [down]);
        let (_, warnings) = design("a -0.000000 0.5 96\n").unwrap();
        assert!(warnings[0].message.starts_with("line 5: the angle -0.000000 is taken for a culet"));
        assert_eq!(planes("a 0 0.5\n"), [Plane { normal: DVec3::Z, offset: 0.5 }]);
        assert!(planes("a 30 -0.5 96\n")[0].normal.z < 0.0);
    }

    #[test]
    fn facets_through_the_centre_are_ignored() {
        let (cut, warnings) = design("a 30 0 96 n C1 48\na 0 0.5 96\n").unwrap();
        assert_eq!(cut.facets.len(), 1);
        assert!(warnings[0].message.contains("tier 'C1' goes through the centre"), "{warnings:?}");
    }

    #[test]
    fn what_cannot_be_a_design_is_refused() {
        let text = "GemCad 5.0\ng 96 0.0\ny 1 n\nI 1.54\na 90 1 24\n";
        for (from, to, message) in [
            ("g 96", "g 0", "line 2"),
            ("g 96", "g 100000", "720"),
            ("I 1.54", "I 0.9", "line 4"),
            ("a 90", "a nan", "line 5"),
            ("1 24", "1e999 24", "line 5"),
            ("1 24", "1 inf", "line 5"),
            ("a 90", "a ninety", "line 5"),
            ("GemCad 5.0", "", "does not begin with 'GemCad'"),
        ] {
            let error = read(text.replace(from, to).as_bytes()).unwrap_err();
            assert!(error.contains(message), "{to}: {error}");
        }
        assert!(read(b"").unwrap_err().contains("empty"));
    }

    #[test]
    fn old_encodings_and_line_ends_are_read() {
        let text = b"GemCad 5.0\rg 96 0.0\ry 1 n\rI 1.54\rH 41\xb0 cut\ra 90 1 24\r";
        let (cut, _) = read(text).unwrap();
        assert_eq!((cut.title[0].as_str(), cut.facets.len()), ("41° cut", 1));
    }
}
