//! The settings of the panel, and where in a scene's document each of them stands.

use super::document::Setup;
use super::lists::{Choice, Lists};
use crate::batch::sweep::overlay::lay;
use serde_json::{Map, Value as Json, json};
use spectral_core::shown;
use toml::{Table, Value};

/// Where the keys of a choice stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// The first stone.
    Stone,
    /// A table of the scene.
    Section(&'static str),
}

/// A setting that is one of a list.
struct Chosen {
    path: &'static str,
    list: fn(&Lists) -> &[Choice],
    place: Place,
    /// The keys that a choice replaces; empty: the whole table.
    keys: &'static [&'static str],
    /// What it is where the scene has none of the keys.
    default: &'static str,
}

const CHOSEN: [Chosen; 8] = [
    Chosen {
        path: "cut",
        list: |lists| &lists.cuts,
        place: Place::Stone,
        keys: &["cut", "mesh", "shape", "up"],
        default: "",
    },
    Chosen {
        path: "material",
        list: |lists| &lists.materials,
        place: Place::Stone,
        keys: &["material"],
        default: "",
    },
    Chosen {
        path: "axis",
        list: |lists| &lists.axes,
        place: Place::Stone,
        keys: &["optic_axis", "crystal_axes", "crystal"],
        default: "table",
    },
    Chosen {
        path: "light",
        list: |lists| &lists.lights,
        place: Place::Section("environment"),
        keys: &[
            "image",
            "uniform",
            "preset",
            "model",
            "head_shadow",
            "zenith",
            "below",
            "seed",
            "half_angle",
            "count",
            "radius",
        ],
        default: "studio",
    },
    Chosen {
        path: "ground",
        list: |lists| &lists.grounds,
        place: Place::Section("ground"),
        keys: &[],
        default: "none",
    },
    Chosen {
        path: "quality",
        list: |lists| &lists.qualities,
        place: Place::Section("render"),
        keys: &[
            "quality",
            "samples",
            "tolerance",
            "wavelengths",
            "jitter",
            "max_depth",
            "threshold",
            "split",
            "coverage",
        ],
        default: "normal",
    },
    Chosen {
        path: "background",
        list: |lists| &lists.backgrounds,
        place: Place::Section("film"),
        keys: &["background"],
        default: "environment",
    },
    Chosen {
        path: "tone",
        list: |lists| &lists.tones,
        place: Place::Section("film"),
        keys: &["tone"],
        default: "hue",
    },
];

/// A setting that is a number.
struct Number {
    path: &'static str,
    unit: &'static str,
    section: &'static str,
    key: &'static str,
    range: [f64; 2],
    /// From what the page shows to what the scene has, and back.
    scene: fn(f64) -> f64,
    page: fn(f64) -> f64,
}

const NUMBERS: [Number; 4] = [
    Number {
        path: "size",
        unit: "mm",
        section: "pose",
        key: "size",
        range: [0.01, 1000.0],
        scene: |v| v,
        page: |v| v,
    },
    Number {
        path: "rotation",
        unit: "°",
        section: "environment",
        key: "rotation",
        range: [-36_000.0, 36_000.0],
        scene: |v| v,
        page: |v| v,
    },
    Number {
        path: "strength",
        unit: "EV",
        section: "environment",
        key: "scale",
        range: [-16.0, 16.0],
        scene: f64::exp2,
        page: f64::log2,
    },
    Number {
        path: "exposure",
        unit: "EV",
        section: "film",
        key: "exposure",
        range: [-16.0, 16.0],
        scene: |v| v,
        page: |v| v,
    },
];

impl Chosen {
    fn section<'a>(&self, setup: &'a Setup) -> Option<&'a Table> {
        match self.place {
            Place::Stone => setup.stone(),
            Place::Section(name) => setup.section(name),
        }
    }

    fn concerns(&self, key: &str) -> bool {
        self.keys.is_empty() || self.keys.contains(&key)
    }

    /// The keys of a scene that a choice would replace.
    fn now(&self, setup: &Setup) -> Table {
        let all = self.section(setup).into_iter().flatten();
        all.filter(|(key, _)| self.concerns(key)).map(|(key, value)| (key.clone(), value.clone())).collect()
    }

    fn id<'a>(&self, setup: &Setup, lists: &'a Lists) -> Option<&'a str> {
        let now = self.now(setup);
        let list = (self.list)(lists);
        let same = list.iter().find(|choice| choice.keys == now);
        let same = same.or_else(|| list.iter().find(|choice| now.is_empty() && choice.id == self.default));
        same.map(|choice| choice.id.as_str())
    }

    fn set(&self, setup: &mut Setup, choice: &Choice) -> Result<(), String> {
        lay(&mut setup.draft.table, &choice.besides);
        if let Place::Section(name) = self.place
            && self.keys.is_empty()
        {
            setup.draft.table.remove(name);
        }
        if choice.keys.is_empty() && self.section(setup).is_none() {
            return Ok(());
        }
        let section = match self.place {
            Place::Stone => setup.stone_mut(),
            Place::Section(name) => setup.section_mut(name),
        };
        let section = section.ok_or("the scene has something else in this place")?;
        section.retain(|key, _| !self.concerns(key));
        lay(section, &choice.keys);
        Ok(())
    }
}

/// Changes a setting. Returns what the change is called.
///
/// # Errors
/// Why the value is not one.
pub fn set(setup: &mut Setup, lists: &Lists, path: &str, value: &Json) -> Result<String, String> {
    if let Some(chosen) = CHOSEN.iter().find(|chosen| chosen.path == path) {
        let id = value.as_str().ok_or_else(|| format!("{path} is the id of one of its list"))?;
        let choice = (chosen.list)(lists).iter().find(|choice| choice.id == id);
        let choice = choice.ok_or_else(|| format!("there is no {path} '{}'", shown(id)))?;
        chosen.set(setup, choice)?;
        return Ok(format!("{path} {}", choice.label));
    }
    let number = NUMBERS.iter().find(|number| number.path == path);
    let number = number.ok_or_else(|| format!("there is no setting '{}'", shown(path)))?;
    let [least, most] = number.range;
    let given = value.as_f64().filter(|v| (least..=most).contains(v));
    let given = given.ok_or_else(|| {
        format!(
            "{path} is a number from {least} to {most} {}, not {}",
            number.unit,
            shown(&value.to_string())
        )
    })?;
    setup.draft = setup.draft.with(number.section, number.key, (number.scene)(given));
    Ok(path.to_owned())
}

/// Makes what a scene has one of the choices, so that it can be chosen again: a material of its own, say.
pub fn register(setup: &Setup, lists: &mut Lists, name: &str) {
    for chosen in &CHOSEN {
        let keys = chosen.now(setup);
        let list = match chosen.path {
            "cut" => &mut lists.cuts,
            "material" => &mut lists.materials,
            "light" => &mut lists.lights,
            "ground" => &mut lists.grounds,
            "axis" => &mut lists.axes,
            "background" => &mut lists.backgrounds,
            _ => continue,
        };
        if keys.is_empty() || list.iter().any(|choice| choice.keys == keys) {
            continue;
        }
        let own = keys.get("material").and_then(Value::as_str).filter(|_| chosen.path == "material");
        let definition = own.and_then(|own| Some((own, setup.section("material")?.get(own)?.clone())));
        let label = own.map_or_else(|| format!("As in {name}"), str::to_owned);
        let besides = definition.map(|(own, table)| {
            Table::from_iter([(
                "material".to_owned(),
                Value::Table(Table::from_iter([(own.to_owned(), table)])),
            )])
        });
        let id = format!("own:{}:{}", list.len(), label);
        list.insert(0, Choice { id, label, group: "This scene", keys, besides: besides.unwrap_or_default() });
    }
}

/// All settings of a side; null for what the lists do not have.
pub fn all(setup: &Setup, lists: &Lists, width: f64) -> Map<String, Json> {
    let mut all = Map::new();
    for chosen in &CHOSEN {
        all.insert(chosen.path.to_owned(), json!(chosen.id(setup, lists)));
    }
    for number in &NUMBERS {
        let default = match number.path {
            "size" => width,
            "strength" => 1.0,
            _ => 0.0,
        };
        let value = setup.draft.number(number.section, number.key).unwrap_or(default);
        all.insert(number.path.to_owned(), json!((number.page)(value)));
    }
    all
}
