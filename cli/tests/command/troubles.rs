//! Items that fail cost nobody else anything, and are told by name.

use super::support::{
    Console, Interrupt, Report, SWEEP, Workplace, assert_matches, assert_refused, cut, logged,
};
use backend_cpu::CPU;
use gemtrace::batch::manifest::Event;
use gemtrace::batch::{Place, sweep};
use gemtrace::shard::Shard;
use gemtrace::{Session, registry};
use gemtrace_cli::commands::batch;
use spectral_core::tracer::{Backend, DeviceInfo, OpenOptions};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

fn failed(place: &Workplace) -> Vec<(String, String)> {
    let failed = |line| match line {
        Event::Failed { item, message, .. } => Some((item, message)),
        _ => None,
    };
    place.lines("out").into_iter().filter_map(failed).collect()
}

#[test]
fn one_broken_cut_among_fifty() {
    let good = std::fs::read_to_string(cut("srb_diamond_57.asc")).unwrap();
    let names: Vec<String> = (1..=50).map(|number| format!("\"cut{number}.asc\"")).collect();
    let place =
        Workplace::swept_by(&format!("format = 1\nbase = \"base.toml\"\ncuts = [{}]", names.join(", ")));
    for number in 1..=50 {
        // Cut off in the middle of a facet.
        let text = if number == 23 { &good[..good.len() / 2] } else { &good };
        place.write(&format!("cut{number}.asc"), text);
    }
    let report = place.batch("out", &["--size", "8x8"]).unwrap();
    let failure = report.failure.unwrap();
    assert_eq!(failure.exit_code(), 5);
    assert_matches(&failure.to_string(), "*item 'cut23' failed*cut23.asc*");
    assert_eq!((&report.json["rendered"], place.pictures("out").len()), (&49.into(), 49));
    let failed = failed(&place);
    assert!(failed.len() == 1 && failed[0].0 == "cut23" && failed[0].1.contains("cut23.asc"), "{failed:?}");
    assert_matches(&place.text("out/index.html"), "*49 pictures of 50*cut23.asc*");
    assert_refused(place.merge("out"), 5, "*1 of 50 items are missing*cut23: failed*");

    // Mended, it is the only one to be rendered.
    place.write("cut23.asc", &good);
    let report = place.batch("out", &["--size", "8x8"]).unwrap();
    assert_eq!((report.failure, &report.json["rendered"]), (None, &1.into()));
    place.merge("out").unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_costs_the_pictures_that_find_no_room() {
    let place = Workplace::swept();
    std::fs::create_dir(place.path("out")).unwrap();
    std::os::unix::fs::symlink("/dev/full", place.path("out/step-ruby-top.png")).unwrap();
    let report = place.batch("out", &[]).unwrap();
    let message = report.failure.unwrap().to_string();
    assert_matches(&message, "*item 'step-ruby-top' failed*No space left on device*");
    assert_eq!(report.json["rendered"], 11);
    assert_eq!(report.json["failed"][0]["exit_code"], 4);
    assert_eq!(failed(&place).len(), 1);
    // There is room again.
    std::fs::remove_file(place.path("out/step-ruby-top.png")).unwrap();
    assert_eq!(place.batch("out", &[]).unwrap().json["rendered"], 1);
}

#[test]
fn folders_that_cannot_be_written_are_told() {
    // Whoever may do everything may write to a read-only folder; nobody can make a folder where a file is.
    let place = Workplace::swept_by(&format!("{SWEEP}\nname = \"{{cut}}/{{material}}-{{view}}\""));
    place.write("file", "");
    assert_refused(place.batch("file", &[]), 4, "*file: this folder cannot be made*");

    std::fs::create_dir(place.path("out")).unwrap();
    place.write("out/step", "");
    let report = place.batch("out", &[]).unwrap();
    assert_eq!((&report.json["rendered"], failed(&place).len()), (&6.into(), 6));
    let message = report.failure.unwrap().to_string();
    assert_matches(&message, "*6 of 12 items failed, the first of them 'step/diamond-top'*");
    std::fs::remove_file(place.path("out/step")).unwrap();
    assert_eq!(place.batch("out", &[]).unwrap().failure, None);
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_refused_before_the_first_ray() {
    use std::os::unix::fs::PermissionsExt as _;
    let place = Workplace::swept();
    let folder = place.path("out");
    std::fs::create_dir(&folder).unwrap();
    std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser is not kept out.
    if std::fs::write(folder.join("probe"), "").is_err() {
        assert_refused(place.batch("out", &[]), 4, "*cannot be written to*");
    }
    std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn a_scene_that_makes_no_sense_is_that_items_failure() {
    let place = Workplace::swept_by(
        r#"
        format = 1
        base = "base.toml"
        variants = [
            { name = "plain", set = {} },
            { name = "deep", set = { render = { max_depth = 0 } } },
            { name = "slip", set = { render = { sampels = 4 } } },
        ]
        "#,
    );
    let report = place.batch("out", &[]).unwrap();
    assert_eq!(report.json["rendered"], 1);
    let failed = failed(&place);
    assert!(failed[0].0 == "deep" && failed[0].1.contains("max_depth"), "{failed:?}");
    assert!(failed[1].0 == "slip" && failed[1].1.contains("did you mean 'samples'?"), "{failed:?}");
}

/// How often a scene was loaded onto [`CARD`].
static LOADED: AtomicU32 = AtomicU32::new(0);

/// The processor under another name, which is lost at the third picture and at those after the sixth.
const CARD: Backend = Backend {
    name: "card",
    devices: || vec![DeviceInfo { backend: "card", name: "card".into(), ..(CPU.devices)().remove(0) }],
    open: |device, options| {
        let mut cpu = (CPU.open)(device, options)?;
        Ok(Box::new(move |scene| match LOADED.fetch_add(1, Relaxed) {
            2 | 6.. => {
                let (device, message) = ("card".to_owned(), "the device was lost".to_owned());
                Err(spectral_core::Error::Device { device, message })
            }
            _ => cpu.load(scene),
        }))
    },
    ..CPU
};

#[test]
fn a_named_device_is_asked_again_for_every_picture() {
    let place = Workplace::swept();
    let plan = sweep::load(&place.path("sweep.toml")).unwrap();
    let run = |name: &str| -> (Report, String) {
        let candidates = registry::choose_among(&[CPU, CARD], name, None).unwrap();
        let mut session = Session::new(candidates, OpenOptions::default());
        let there = Place { output: place.path("out"), shard: Shard::WHOLE };
        logged(|log| {
            let interrupt = Interrupt::default();
            let mut console = Console::new(log, &interrupt);
            batch::render(&plan, &there, &mut session, &mut console).unwrap()
        })
    };
    let (Report { json, .. }, log) = run("card");
    assert_eq!((&json["rendered"], json["failed"].as_array().unwrap().len()), (&5.into(), 7), "{log}");
    assert_eq!(json["failed"][0]["message"], "card card: the device was lost");
    assert!(log.contains("[3/12] round-brilliant-ruby-top: failed: card card: the device was lost"), "{log}");
    let (Report { json, failure, .. }, _) = run("cpu");
    assert_eq!((&json["rendered"], &json["kept"], failure), (&7.into(), &5.into(), None));
}

#[test]
fn a_request_to_stop_ends_a_batch_between_pictures_or_within_one() {
    let place = Workplace::swept();
    let plan = sweep::load(&place.path("sweep.toml")).unwrap();
    let mut session = Session::open("cpu").unwrap();
    let (mut log, interrupt) = (Vec::new(), Interrupt::default());
    interrupt.request();
    let mut console = Console::new(&mut log, &interrupt);
    let there = Place { output: place.path("out"), shard: Shard::WHOLE };
    let report = batch::render(&plan, &there, &mut session, &mut console).unwrap();
    assert_eq!((&report.json["rendered"], report.failure), (&0.into(), Some(gemtrace::Error::Interrupted)));
}
