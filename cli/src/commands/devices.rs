//! `gemtrace devices`.

use super::table;
use crate::console::Report;
use gemtrace::{output, registry};
use serde_json::{Value, json};
use spectral_core::tracer::{Backend, DeviceInfo, Unusable};

/// Arguments of `devices`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Lists every backend with its devices, and with what it cannot use.
pub fn run(_: &Args) -> Report {
    list(registry::backends())
}

/// Lists backends: their devices, and what they cannot use with the reason.
pub fn list(backends: &[Backend]) -> Report {
    let titles = ["backend", "device", "name", "driver", "api", "memory", "kind", "intersection"];
    let mut rows = vec![titles.map(str::to_owned).to_vec()];
    let mut json = Vec::new();
    for backend in backends {
        let (devices, unusable) = ((backend.devices)(), (backend.unusable)());
        rows.extend(devices.iter().map(|device| row(backend, device)));
        rows.extend(unusable.iter().map(|unusable| unusable_row(backend, unusable)));
        if devices.is_empty() && unusable.is_empty() {
            let none = Unusable { name: "–".to_owned(), reason: "none on this machine".to_owned() };
            rows.push(unusable_row(backend, &none));
        }
        json.push(json!({
            "backend": backend.name,
            "about": backend.about,
            "devices": devices.iter().map(output::device).collect::<Vec<_>>(),
            "unusable": unusable.iter().map(describe_unusable).collect::<Vec<_>>(),
        }));
    }
    Report::new(table::columns(titles.len(), &rows), json!({ "backends": json }))
}

fn row(backend: &Backend, device: &DeviceInfo) -> Vec<String> {
    let or_dash = |text: String| if text.is_empty() { "–".to_owned() } else { text };
    vec![
        backend.name.to_owned(),
        device.index.to_string(),
        device.name.clone(),
        or_dash(device.driver.clone()),
        or_dash(device.api.to_owned()),
        memory(device.memory),
        registry::kind(device).to_owned(),
        device.intersection.to_owned(),
    ]
}

fn unusable_row(backend: &Backend, unusable: &Unusable) -> Vec<String> {
    let reason = format!("unusable: {}", unusable.reason);
    [backend.name, "–", &unusable.name, "–", "–", "–", "–", &reason].map(str::to_owned).to_vec()
}

fn memory(bytes: u64) -> String {
    if bytes == 0 { "–".to_owned() } else { format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30)) }
}

fn describe_unusable(unusable: &Unusable) -> Value {
    json!({ "name": unusable.name, "reason": unusable.reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_used_is_listed_with_its_reason() {
        let unusable = || {
            vec![Unusable {
                name: "Old Card".to_owned(),
                reason: "it has Vulkan 1.1; 1.3 is needed".to_owned(),
            }]
        };
        let without = Backend { name: "without", devices: Vec::new, unusable, ..backend_cpu::CPU };
        let empty = Backend { name: "empty", devices: Vec::new, ..backend_cpu::CPU };
        let report = list(&[backend_cpu::CPU, without, empty]);
        let lines: Vec<_> = report.text.lines().collect();
        assert!(
            lines[1].starts_with("cpu      0       ") && lines[1].contains("processor"),
            "{}",
            report.text
        );
        assert!(lines[2].starts_with("without  –       Old Card"), "{}", report.text);
        assert!(lines[2].ends_with("unusable: it has Vulkan 1.1; 1.3 is needed"), "{}", report.text);
        assert!(lines[3].ends_with("none on this machine"), "{}", report.text);
        let json = &report.json["backends"];
        assert_eq!(json[1]["unusable"][0]["name"], "Old Card");
        assert_eq!(json[0]["devices"][0]["memory"], Value::Null);
    }
}
