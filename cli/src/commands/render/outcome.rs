//! The report of a finished render.

use crate::console::Report;
use gemtrace::Error;
use gemtrace::output::{self, Written};
use gemtrace::quantity::{count, percent, seconds};
use gemtrace::registry;
use gemtrace::session::Rendered;
use serde_json::{Value, json};
use spectral_core::prepare::PreparedScene;
use std::sync::Arc;
use std::time::Duration;

/// A render that is over, with its pictures written as far as they could be.
pub struct Outcome {
    pub scene: Arc<PreparedScene>,
    pub rendered: Rendered,
    pub written: Vec<Written>,
    pub warnings: Vec<String>,
    pub elapsed: Duration,
}

impl Outcome {
    pub fn report(&self) -> Report {
        Report { text: self.line(), json: self.json(), failure: self.failure() }
    }

    /// A picture that is not where it should be counts for more than one that is not finished.
    fn failure(&self) -> Option<Error> {
        let mut failures: Vec<&Error> = self.written.iter().filter_map(|w| w.failure.as_ref()).collect();
        match failures.as_mut_slice() {
            [] if self.rendered.traced.finished => None,
            [] => Some(self.rendered.failure.clone().unwrap_or(Error::Interrupted)),
            [Error::Output { path, message }, rest @ ..] => {
                let rest: String = rest.iter().map(|e| format!("; {e}")).collect();
                Some(Error::output(path.clone(), format!("{message}{rest}")))
            }
            [first, ..] => Some(first.clone()),
        }
    }

    fn paths(&self) -> Vec<String> {
        self.written.iter().filter_map(|w| w.path.as_ref()).map(|path| path.display().to_string()).collect()
    }

    /// The closing line.
    fn line(&self) -> String {
        let paths = self.paths();
        let places = if paths.is_empty() { "no file".to_owned() } else { paths.join(", ") };
        let kind = if self.rendered.traced.finished { "wrote" } else { "wrote what was finished:" };
        let energy = &self.rendered.traced.energy;
        let share = |part: f64| percent(if energy.started > 0.0 { part / energy.started } else { 0.0 });
        let by =
            self.rendered.devices.last().map_or(String::new(), |d| format!(" by {}", registry::label(d)));
        let mut line = format!(
            "{kind} {places} – {} rays in {}{by}, {} of the energy dropped",
            count(self.rendered.traced.rays),
            seconds(self.elapsed),
            percent(energy.dropped_share())
        );
        if energy.left_at_limit > 0.0 {
            line += &format!(", {} let out at the depth limit", share(energy.left_at_limit));
        }
        if energy.lost > 0.0 {
            line += &format!(", {} leaked through damaged surfaces", share(energy.lost));
        }
        line
    }

    fn json(&self) -> Value {
        let outputs: Vec<Value> = self
            .written
            .iter()
            .map(|w| {
                json!({
                    "path": w.path.as_ref().map(|path| path.display().to_string()),
                    "bytes": w.bytes,
                    "error": w.failure.as_ref().map(ToString::to_string),
                })
            })
            .collect();
        json!({
            "outputs": outputs,
            "partial": !self.rendered.traced.finished,
            "rays": self.rendered.traced.rays,
            "energy": output::energy(&self.rendered.traced.energy),
            "seconds": {
                "total": self.elapsed.as_secs_f64(),
                "build": self.rendered.traced.build.as_secs_f64(),
                "trace": self.rendered.traced.trace.as_secs_f64(),
            },
            "choice": self.rendered.reason,
            "device": self.rendered.devices.last().map(output::device),
            "devices": self.rendered.devices.iter().map(output::device).collect::<Vec<_>>(),
            "settings": output::settings(self.rendered.shown(&self.scene)),
            "warnings": self.warnings,
        })
    }
}
