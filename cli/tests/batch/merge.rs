//! Shards, which share nothing but the output folder.

use super::support::{Workplace, pictures};
use gemtrace::batch::manifest::{Done, Event, read};
use std::path::Path;
use std::process::Command;

/// All that a line says but for how long it took.
fn timeless(done: Done) -> serde_json::Value {
    let mut value = serde_json::to_value(done).unwrap();
    value.as_object_mut().unwrap().remove("seconds");
    value
}

#[test]
fn shards_make_what_one_machine_makes() {
    let place = Workplace::new();
    place.batch("one", &["--threads", "2"]).unwrap();
    for shard in ["3/5", "1/5", "5/5", "2/5", "4/5"] {
        let report = place.batch("many", &["--shard", shard, "--threads", "1"]).unwrap();
        assert_eq!((report.failure, &report.json["shard"]), (None, &shard.into()));
    }
    assert!(!place.path("many/index.html").exists() && !place.path("many/manifest.jsonl").exists());
    let report = place.merge(&["many"]).unwrap();
    assert_eq!(report.json["batches"][0]["manifests"].as_array().unwrap().len(), 5);
    assert!(pictures(&place.path("many")) == pictures(&place.path("one")));
    // The joined manifest is that of the one machine, item by item.
    let items = |name: &str| -> Vec<_> {
        let done = |line| {
            if let Event::Done(done) = line { Some(timeless(*done)) } else { None }
        };
        read(&place.path(name)).unwrap().into_iter().filter_map(done).collect()
    };
    assert_eq!(items("many/manifest.jsonl"), items("one/manifest.jsonl"));
    assert!(place.path("many/index.html").exists());
    // Another number of shards finds what is there, and merging again changes nothing.
    assert_eq!(place.batch("many", &["--shard", "1/2"]).unwrap().json["rendered"], 0);
    place.merge(&["many"]).unwrap();
}

#[test]
fn what_is_missing_is_told_with_its_shard() {
    let place = Workplace::new();
    place.batch("out", &["--shard", "1/3"]).unwrap();
    place.batch("out", &["--shard", "3/3"]).unwrap();
    std::fs::remove_file(place.path("out/round-brilliant-diamond-top.png")).unwrap();
    let error = place.merge(&["out"]).unwrap_err();
    assert_eq!(error.exit_code(), 5);
    let message = error.to_string();
    for part in [
        "5 of 12 items are missing; without a manifest: shard 2/3",
        "round-brilliant-diamond-top (shard 1/3): round-brilliant-diamond-top.png is gone",
        "round-brilliant-diamond-side (shard 2/3): never begun",
    ] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!place.path("out/manifest.jsonl").exists());
    for shard in ["1/3", "2/3"] {
        place.batch("out", &["--shard", shard]).unwrap();
    }
    place.merge(&["out"]).unwrap();

    // Shards of another version of the sweep do not count.
    let sweep = std::fs::read_to_string(place.path("sweep.toml")).unwrap();
    place.write("sweep.toml", &sweep.replace("elevation = 40", "elevation = 41"));
    place.batch("out", &["--shard", "1/3"]).unwrap();
    let message = place.merge(&["out"]).unwrap_err().to_string();
    assert!(message.contains("(shard 2/3): rendered from another version of the scene"), "{message}");
}

#[test]
fn folders_without_a_batch_are_told() {
    let place = Workplace::new();
    let message = place.merge(&["."]).unwrap_err().to_string();
    assert!(message.contains("there is no plan.json here"), "{message}");
    let message = place.merge(&["base.toml"]).unwrap_err().to_string();
    assert!(message.contains("neither a folder nor a part of a picture"), "{message}");
}

/// `gemtrace ARGUMENTS…` in an environment; its JSON.
fn scheduled(place: &Workplace, variables: &[(&str, &str)], arguments: &[&str]) -> serde_json::Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gemtrace"));
    command.current_dir(place.folder.path()).args(arguments).args(["--backend", "cpu", "--json"]);
    let output = command.envs(variables.iter().copied()).output().unwrap();
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn schedulers_say_which_share() {
    let place = Workplace::new();
    let batch = ["batch", "sweep.toml", "-o", "out"];
    for index in ["0", "1", "2"] {
        let job = [("JOB_COMPLETION_INDEX", index), ("GEMTRACE_SHARDS", "3")];
        assert_eq!(scheduled(&place, &job, &batch)["items"], 4);
    }
    place.merge(&["out"]).unwrap();
    let task = |id: &'static str| {
        [
            ("SLURM_ARRAY_TASK_ID", id),
            ("SLURM_ARRAY_TASK_MIN", "4"),
            ("SLURM_ARRAY_TASK_STEP", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "2"),
        ]
    };
    assert_eq!(scheduled(&place, &task("6"), &batch)["shard"], "2/2");
    // A single picture is shared out only if one asks for it.
    let render = ["render", "base.toml", "-o", "a.exr"];
    assert_eq!(scheduled(&place, &task("6"), &render)["outputs"][0]["path"], "a.exr");
    let shared = scheduled(&place, &task("6"), &[&render[..], &["--shard", "auto"]].concat());
    assert_eq!(shared["outputs"][0]["path"], "a.part-2-of-2.exr");
    let wrong = scheduled(&place, &task("5"), &batch);
    assert_eq!(wrong["failure"]["exit_code"], 2, "{wrong}");
}

#[test]
fn the_kubernetes_job_says_how_many_shares_there_are() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/cluster/job.yaml");
    let text = std::fs::read_to_string(file).unwrap();
    let after = |key: &str| {
        let (_, rest) = text.split_once(key).unwrap();
        rest.split(|c: char| !c.is_ascii_digit()).find(|part| !part.is_empty()).unwrap()
    };
    assert_eq!(after("completions:"), after("GEMTRACE_SHARDS"));
}
