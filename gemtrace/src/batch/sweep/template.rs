//! How the files of an item are named.

use super::axis::{Axes, Axis, Choice};
use crate::Error;
use crate::scene_file::fields::{Entry, either};
use spectral_core::shown;

/// `"{cut}/{material}-{size}mm"`, taken apart.
pub struct Template(Vec<Part>);

enum Part {
    Text(String),
    Choice(Axis),
    /// The item's number from 1, with at least this many digits.
    Number(usize),
}

impl Template {
    /// Takes a template apart; `listed` says that items are listed, which may choose along any axis.
    pub fn read(entry: &Entry, axes: &Axes, listed: bool) -> Result<Self, Error> {
        let text = entry.text("a template such as \"{cut}-{material}\"")?;
        let mut parts = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            parts.push(Part::Text(before.to_owned()));
            let (key, after) = after
                .split_once('}')
                .ok_or_else(|| entry.error(format!("'{}' has a '{{' without '}}'", shown(text))))?;
            parts.push(placeholder(key, |axis| listed || axes.has(axis)).map_err(|e| entry.error(e))?);
            rest = after;
        }
        parts.push(Part::Text(rest.to_owned()));
        Ok(Template(parts))
    }

    /// The name of an item, counted from 0.
    pub fn fill(&self, number: usize, picked: &[&Choice]) -> Result<String, String> {
        let part = |part: &Part| match part {
            Part::Text(text) => Ok(text.clone()),
            Part::Number(digits) => Ok(format!("{:0digits$}", number + 1)),
            Part::Choice(axis) => {
                let choice = picked.iter().find(|choice| choice.axis == *axis);
                let lacking =
                    || format!("item {} has no {}, which the template asks for", number + 1, axis.name());
                choice.map(|choice| choice.name.clone()).ok_or_else(lacking)
            }
        };
        self.0.iter().map(part).collect()
    }
}

fn placeholder(key: &str, given: impl Fn(Axis) -> bool) -> Result<Part, String> {
    if let Some(digits) = key.strip_prefix("number") {
        return match digits.strip_prefix(':').map_or(Ok(4), str::parse) {
            Ok(digits @ 1..=9) if digits == 4 || key != "number" => Ok(Part::Number(digits)),
            _ => Err(format!(
                "'{{{}}}' is not valid: expected {{number}} or {{number:1}} to {{number:9}}",
                shown(key)
            )),
        };
    }
    match Axis::ALL.into_iter().find(|axis| axis.name() == key) {
        Some(axis) if given(axis) => Ok(Part::Choice(axis)),
        Some(_) => Err(format!("'{{{key}}}' is not swept here")),
        None => Err(format!("'{{{}}}' is unknown; valid: 'number', {}", shown(key), either(&Axis::NAMES))),
    }
}

/// The name where there is no template: that of every choice.
pub fn joined(picked: &[&Choice]) -> String {
    let names: Vec<&str> = picked.iter().map(|choice| choice.name.as_str()).collect();
    names.join("-")
}
