//! The numbers as text, CSV, JSON and a plot.

use super::subject::Subject;
use crate::commands::table::columns;
use crate::measure::{Conditions, Experimental, Figures, Hinge, Position};
use crate::plot::{Line, Panel, svg_over};
use serde_json::{Value, json};
use spectral_core::environment::Pattern;
use spectral_core::settings::Leftover;

/// A column of the table: its name, and its share for the rays of a row.
struct Column {
    name: String,
    share: Box<dyn Fn(&Figures) -> f64>,
}

impl Column {
    fn new(name: impl Into<String>, share: impl Fn(&Figures) -> f64 + 'static) -> Self {
        Column { name: name.into(), share: Box::new(share) }
    }
}

fn columns_of(conditions: &Conditions) -> Vec<Column> {
    let models = conditions.models.iter().map(Pattern::name).enumerate();
    let mut columns: Vec<Column> =
        models.map(|(k, name)| Column::new(name, move |f| f.light_return[k])).collect();
    columns.extend([
        Column::new("leakage", |f| f.leakage),
        Column::new("extinction", |f| f.extinction),
        Column::new("contrast", |f| f.contrast),
        Column::new("aset_blue", |f| f.aset[0]),
        Column::new("aset_red", |f| f.aset[1]),
        Column::new("aset_green", |f| f.aset[2]),
        Column::new("missing", |f| f.missing),
    ]);
    if conditions.experimental {
        let figure =
            |of: fn(&Experimental) -> f64| move |f: &Figures| f.experimental.as_ref().map_or(f64::NAN, of);
        columns.push(Column::new("experimental_fire", figure(|e| e.fire)));
        columns.push(Column::new("experimental_scintillation", figure(|e| e.scintillation)));
    }
    columns
}

/// The stone's row, and the table's if it has one.
fn parts(position: &Position) -> impl Iterator<Item = (&'static str, &Figures)> {
    [("stone", &position.stone)].into_iter().chain(position.table.as_ref().map(|table| ("table", table)))
}

/// A table for people, in percent.
pub(super) fn text(conditions: &Conditions, positions: &[Position]) -> String {
    let all = columns_of(conditions);
    let head = ["over".to_owned(), "tilt".to_owned()];
    let mut rows = vec![head.into_iter().chain(all.iter().map(|c| c.name.replace('_', " "))).collect()];
    for part in ["stone", "table"] {
        for position in positions {
            let Some((_, figures)) = parts(position).find(|(name, _)| *name == part) else { continue };
            let mut row = vec![part.to_owned(), format!("{}°", position.tilt)];
            row.extend(all.iter().map(|column| format!("{:.2}", 100.0 * (column.share)(figures))));
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
    let all = columns_of(conditions);
    let names = ["stone", "table"].map(|part| all.iter().map(move |c| format!("{part}_{}", c.name)));
    let names: Vec<String> = ["tilt".to_owned()]
        .into_iter()
        .chain(names.into_iter().flatten())
        .chain(["dropped".to_owned()])
        .collect();
    let mut text = names.join(",") + "\n";
    for position in positions {
        let mut cells = vec![position.tilt.to_string()];
        for figures in [Some(&position.stone), position.table.as_ref()] {
            let cell = |c: &Column| figures.map_or(String::new(), |f| format!("{:.4}", 100.0 * (c.share)(f)));
            cells.extend(all.iter().map(cell));
        }
        cells.push(format!("{:.4}", 100.0 * position.dropped));
        text += &(cells.join(",") + "\n");
    }
    text
}

/// Everything, as shares from 0 to 1.
pub(super) fn json(subject: &Subject, conditions: &Conditions, positions: &[Position]) -> Value {
    let all = columns_of(conditions);
    let figures = |figures: &Figures| {
        let mut object = json!({ "rays": figures.rays });
        for column in &all {
            object[&column.name] = json!((column.share)(figures));
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
            "about": if conditions.hinge == Hinge::X { "x" } else { "y" },
            "wavelengths_nm": settings.wavelengths.nm(),
            "max_depth": settings.max_depth,
            "leftover": if settings.leftover == Leftover::Exit { "exit" } else { "drop" },
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
    let all = columns_of(conditions);
    let shown = all.iter().take(conditions.models.len() + 2);
    let panel = |part: &'static str| {
        let figures: Vec<(f64, &Figures)> = positions
            .iter()
            .flat_map(|p| parts(p).filter(|(name, _)| *name == part).map(|(_, f)| (p.tilt, f)))
            .collect();
        let lines = shown.clone().zip(COLOURS.iter().cycle()).map(|(column, colour)| Line {
            label: column.name.clone(),
            colour,
            points: figures.iter().map(|(tilt, f)| [*tilt, 100.0 * (column.share)(f)]).collect(),
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
