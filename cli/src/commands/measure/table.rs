//! The numbers as text, CSV, JSON and a plot.

use super::subject::Subject;
use crate::commands::table::columns;
use gemtrace::measure::{Conditions, Figures, Position};
use gemtrace::plot::{Curve, Panel, svg_over};
use serde_json::{Value, json};
use spectral_core::environment::Pattern;

/// The columns' names; every position has the same.
fn names(conditions: &Conditions, positions: &[Position]) -> Vec<&'static str> {
    let first = positions.first().map(|position| position.stone.named(&conditions.models));
    first.into_iter().flatten().map(|(name, _)| name).collect()
}

fn shares(conditions: &Conditions, figures: &Figures) -> impl Iterator<Item = f64> {
    figures.named(&conditions.models).into_iter().map(|(_, share)| share)
}

/// The stone's row, and the table's if it has one.
fn parts(position: &Position) -> impl Iterator<Item = (&'static str, &Figures)> {
    [("stone", &position.stone)].into_iter().chain(position.table.as_ref().map(|table| ("table", table)))
}

/// A table for people, in percent.
pub(super) fn text(conditions: &Conditions, positions: &[Position]) -> String {
    let mut rows: Vec<Vec<String>> = vec![["over", "tilt"].map(str::to_owned).to_vec()];
    rows[0].extend(names(conditions, positions).iter().map(|name| name.replace('_', " ")));
    for part in ["stone", "table"] {
        for position in positions {
            let Some((_, figures)) = parts(position).find(|(name, _)| *name == part) else { continue };
            let mut row = vec![part.to_owned(), format!("{}°", position.tilt)];
            row.extend(shares(conditions, figures).map(|share| format!("{:.2}", 100.0 * share)));
            rows.push(row);
        }
    }
    let dropped = positions.iter().map(|p| p.dropped).fold(0.0, f64::max);
    let seen = match conditions.eye {
        Some(eye) => format!("the eye {eye} mm away"),
        None => "parallel rays".to_owned(),
    };
    format!(
        "{}\n\npercent of what light of full brightness all around would bring; {seen}, a head of {}°\n\
         missing: absorbed or dropped; of the stone's light at most {:.3} % was dropped",
        columns(1, &rows),
        conditions.head,
        100.0 * dropped,
    )
}

/// One line a position, the stone's columns and then the table's, in percent.
pub(super) fn csv(conditions: &Conditions, positions: &[Position]) -> String {
    let names = names(conditions, positions);
    let mut head = vec!["tilt".to_owned()];
    for part in ["stone", "table"] {
        head.extend(names.iter().map(|name| format!("{part}_{name}")));
    }
    head.push("dropped".to_owned());
    let mut text = head.join(",") + "\n";
    for position in positions {
        let mut cells = vec![position.tilt.to_string()];
        for figures in [Some(&position.stone), position.table.as_ref()] {
            match figures {
                Some(figures) => {
                    cells.extend(shares(conditions, figures).map(|share| format!("{:.4}", 100.0 * share)));
                }
                None => cells.extend(names.iter().map(|_| String::new())),
            }
        }
        cells.push(format!("{:.4}", 100.0 * position.dropped));
        text += &(cells.join(",") + "\n");
    }
    text
}

/// Everything, as shares from 0 to 1.
pub(super) fn json(subject: &Subject, conditions: &Conditions, positions: &[Position]) -> Value {
    let figures = |figures: &Figures| {
        let mut object = json!({ "rays": figures.rays });
        for (name, share) in figures.named(&conditions.models) {
            object[name] = json!(share);
        }
        object
    };
    let positions: Vec<Value> = positions
        .iter()
        .map(|p| {
            json!({ "tilt": p.tilt, "stone": figures(&p.stone), "table": p.table.as_ref().map(figures),
                    "dropped": p.dropped })
        })
        .collect();
    let settings = &conditions.settings;
    json!({
        "subject": subject.title,
        "material": subject.stone.material.name,
        "conditions": {
            "models": conditions.models.iter().map(Pattern::name).collect::<Vec<_>>(),
            "head": conditions.head,
            "eye_mm": conditions.eye,
            "size": conditions.size,
            "about": conditions.hinge.name(),
            "wavelengths_nm": settings.wavelengths.nm(),
            "max_depth": settings.max_depth,
            "leftover": settings.leftover.name(),
            "threshold": settings.threshold,
            "polarized": settings.polarized,
        },
        "positions": positions,
        "warnings": subject.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

const COLOURS: [&str; 8] =
    ["#1b6ca8", "#c2571a", "#3a8f3a", "#8a4fa3", "#a33a3a", "#4f7f8a", "#8a7a1b", "#555555"];

/// Light return, leakage and extinction over the tilt: the stone above, its table below.
pub(super) fn plot(title: &str, conditions: &Conditions, positions: &[Position]) -> String {
    let shown = conditions.models.len() + 2;
    let names = names(conditions, positions);
    let panel = |part: &'static str| {
        let figures: Vec<(f64, &Figures)> = positions
            .iter()
            .flat_map(|p| parts(p).filter(|(name, _)| *name == part).map(|(_, f)| (p.tilt, f)))
            .collect();
        let lines = names.iter().zip(COLOURS.iter().cycle()).take(shown).enumerate();
        let lines = lines.map(|(k, (name, colour))| {
            let share = |f: &Figures| f.named(&conditions.models)[k].1;
            let points = figures.iter().map(|(tilt, f)| [*tilt, 100.0 * share(f)]).collect();
            Curve { label: (*name).to_owned(), colour, points }
        });
        (!figures.is_empty()).then(|| Panel {
            label: format!("over the {part}, %"),
            from_zero: true,
            lines: lines.collect(),
        })
    };
    let panels: Vec<Panel> = ["stone", "table"].into_iter().filter_map(panel).collect();
    svg_over("tilt, degrees", title, &panels)
}
