//! What a picture says about its making.

use crate::registry;
use serde_json::{Map, Value, json};
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Background;
use spectral_core::tracer::{DeviceInfo, Energy, TraceReport};

/// The facts that go into every header. No dates and no times: the same picture is the same file.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    facts: Map<String, Value>,
}

impl Provenance {
    /// What is known once the light has been traced.
    ///
    /// `scene_file` names the scene, `hash` is that of its text and of all files that it names. A report that is not
    /// finished makes a partial picture. Where several devices took part, their facts are joined by " + ".
    pub fn new(
        scene_file: &str,
        hash: &str,
        scene: &PreparedScene,
        devices: &[DeviceInfo],
        report: &TraceReport,
    ) -> Self {
        let all = |fact: fn(&DeviceInfo) -> &str| devices.iter().map(fact).collect::<Vec<_>>().join(" + ");
        let facts = [
            ("version", json!(env!("CARGO_PKG_VERSION"))),
            ("scene", json!(scene_file)),
            ("scene_hash", json!(hash)),
            ("backend", json!(all(|d| d.backend))),
            ("device", json!(all(|d| &d.name))),
            ("driver", json!(all(|d| &d.driver))),
            ("settings", settings(scene)),
            ("rays", json!(report.rays)),
            ("energy", energy(&report.energy)),
            ("partial", json!(!report.finished)),
        ];
        Provenance { facts: facts.into_iter().map(|(key, value)| (key.to_owned(), value)).collect() }
    }

    /// The facts that [`Provenance::to_json`] gave elsewhere.
    pub fn from_facts(facts: Map<String, Value>) -> Self {
        Provenance { facts }
    }

    /// Adds a fact, or replaces one.
    #[must_use]
    pub fn with(mut self, key: &str, value: Value) -> Self {
        self.facts.insert(key.to_owned(), value);
        self
    }

    /// Every fact by its name.
    pub fn facts(&self) -> impl Iterator<Item = (&String, &Value)> {
        self.facts.iter()
    }

    /// All facts as one JSON object.
    pub fn to_json(&self) -> Value {
        Value::Object(self.facts.clone())
    }

    /// Name and version of this program.
    pub fn software(&self) -> String {
        concat!("gemtrace ", env!("CARGO_PKG_VERSION")).to_owned()
    }
}

/// The size and settings of a prepared scene, under the names that scene files use.
pub fn settings(scene: &PreparedScene) -> Value {
    let s = &scene.settings;
    json!({
        "width": scene.width,
        "height": scene.height,
        "coverage": s.coverage.name(),
        "samples": s.samples,
        "tolerance": s.tolerance,
        "wavelengths": s.wavelengths.nm(),
        "jitter": s.jitter && s.wavelengths.can_jitter(),
        "max_depth": s.max_depth,
        "leftover": s.leftover.name(),
        "threshold": s.threshold,
        "split": s.split,
        "polarized": s.polarized,
        "spectral": s.spectral,
        "background": match scene.background {
            Background::Environment => "environment",
            Background::Transparent => "transparent",
        },
    })
}

/// A device as JSON; its memory, bytes, is null where it is not known.
pub fn device(device: &DeviceInfo) -> Value {
    json!({
        "backend": device.backend,
        "index": device.index,
        "name": device.name,
        "driver": device.driver,
        "api": (!device.api.is_empty()).then_some(device.api),
        "memory": (device.memory > 0).then_some(device.memory),
        "intersection": device.intersection,
        "hardware": device.hardware,
        "kind": registry::kind(device),
    })
}

/// Shares of the throughput that started, to seven significant digits: the account is added up in the order in which
/// passes and machines come to an end, and what that leaves in the last digits of a double must not show.
pub fn energy(energy: &Energy) -> Value {
    let share = |part: f64| if energy.started > 0.0 { rounded(part / energy.started) } else { 0.0 };
    json!({
        "dropped": rounded(energy.dropped_share()),
        "dropped_depth": share(energy.dropped_depth),
        "dropped_threshold": share(energy.dropped_threshold),
        "left_at_limit": share(energy.left_at_limit),
        "lost": share(energy.lost),
    })
}

fn rounded(share: f64) -> f64 {
    format!("{share:.6e}").parse().unwrap_or(share)
}
