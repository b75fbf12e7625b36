//! `gemtrace devices`.

use super::{Report, table};
use crate::registry;
use serde_json::json;
use spectral_core::tracer::{Backend, DeviceInfo};

/// Arguments of `devices`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Lists every backend with its devices.
pub fn run(_: &Args) -> Report {
    let found: Vec<(&Backend, Vec<DeviceInfo>)> =
        registry::backends().iter().map(|backend| (backend, (backend.devices)())).collect();
    let json: Vec<_> = found
        .iter()
        .map(|(backend, devices)| {
            let devices: Vec<_> = devices.iter().map(describe).collect();
            json!({ "backend": backend.name, "about": backend.about, "devices": devices })
        })
        .collect();
    let mut rows = vec![["backend", "device", "name", "intersection"].map(str::to_owned).to_vec()];
    for (backend, devices) in &found {
        rows.extend(devices.iter().map(|d| {
            vec![backend.name.to_owned(), d.index.to_string(), d.name.clone(), d.intersection.to_owned()]
        }));
        if devices.is_empty() {
            rows.push(vec![backend.name.to_owned(), "–".to_owned(), "none on this machine".to_owned()]);
        }
    }
    Report::new(table::columns(4, &rows), json!({ "backends": json }))
}

/// A device for scripts.
pub fn describe(device: &DeviceInfo) -> serde_json::Value {
    json!({
        "backend": device.backend,
        "index": device.index,
        "name": device.name,
        "driver": device.driver,
        "memory": device.memory,
        "intersection": device.intersection,
        "hardware": device.hardware,
    })
}
