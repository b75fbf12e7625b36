//! Shards, which share nothing but the output folder.

use super::support::{Workplace, assert_matches, assert_refused, done};
use gemtrace::batch::manifest::{Done, read};
use std::path::Path;

/// All that a line says but for how long it took.
fn timeless(done: Done) -> serde_json::Value {
    let mut value = serde_json::to_value(done).unwrap();
    value.as_object_mut().unwrap().remove("seconds");
    value
}

#[test]
fn shards_make_what_one_machine_makes() {
    let place = Workplace::swept();
    place.batch("one", &["--threads", "2"]).unwrap();
    for shard in ["3/5", "1/5", "5/5", "2/5", "4/5"] {
        let report = place.batch("many", &["--shard", shard, "--threads", "1"]).unwrap();
        assert_eq!((report.failure, &report.json["shard"]), (None, &shard.into()));
    }
    assert!(!place.path("many/index.html").exists() && !place.path("many/manifest.jsonl").exists());
    let report = place.merge("many").unwrap();
    assert_eq!(report.json["batches"][0]["manifests"].as_array().unwrap().len(), 5);
    assert!(place.pictures("many") == place.pictures("one"));
    // The joined manifest is that of the one machine, item by item.
    let items =
        |name: &str| -> Vec<_> { done(read(&place.path(name)).unwrap()).into_iter().map(timeless).collect() };
    assert_eq!(items("many/manifest.jsonl"), items("one/manifest.jsonl"));
    assert!(place.path("many/index.html").exists());
    // Another number of shards finds what is there, and merging again changes nothing.
    assert_eq!(place.batch("many", &["--shard", "1/2"]).unwrap().json["rendered"], 0);
    place.merge("many").unwrap();
}

#[test]
fn what_is_missing_is_told_with_its_shard() {
    let place = Workplace::swept();
    place.batch("out", &["--shard", "1/3"]).unwrap();
    place.batch("out", &["--shard", "3/3"]).unwrap();
    std::fs::remove_file(place.path("out/round-brilliant-diamond-top.png")).unwrap();
    let message = "*5 of 12 items are missing; without a manifest: shard 2/3*\
        round-brilliant-diamond-top (shard 1/3): round-brilliant-diamond-top.png is gone*\
        round-brilliant-diamond-side (shard 2/3): never begun*";
    assert_refused(place.merge("out"), 5, message);
    assert!(!place.path("out/manifest.jsonl").exists());
    for shard in ["1/3", "2/3"] {
        place.batch("out", &["--shard", shard]).unwrap();
    }
    place.merge("out").unwrap();

    // Shards of another version of the sweep do not count.
    let sweep = place.text("sweep.toml");
    place.write("sweep.toml", sweep.replace("elevation = 40", "elevation = 41"));
    place.batch("out", &["--shard", "1/3"]).unwrap();
    let message = "*(shard 2/3): rendered from another version of the scene*";
    assert_refused(place.merge("out"), 5, message);
}

#[test]
fn folders_without_a_batch_are_told() {
    let place = Workplace::swept();
    let found = |name: &str| place.merge(name).unwrap_err().to_string();
    assert_matches(&found("."), "*there is no plan.json here*");
    assert_matches(&found("base.toml"), "*neither a folder nor a part of a picture*");
}

/// `gemtrace ARGUMENTS…` in an environment; its JSON.
fn scheduled(place: &Workplace, variables: &[(&str, &str)], arguments: &[&str]) -> serde_json::Value {
    let mut command = place.gemtrace(arguments);
    command.args(["--backend", "cpu", "--json"]).envs(variables.iter().copied());
    let output = command.output().unwrap();
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn schedulers_say_which_share() {
    let place = Workplace::swept();
    let batch = ["batch", "sweep.toml", "-o", "out"];
    for index in ["0", "1", "2"] {
        let job = [("JOB_COMPLETION_INDEX", index), ("GEMTRACE_SHARDS", "3")];
        assert_eq!(scheduled(&place, &job, &batch)["items"], 4);
    }
    place.merge("out").unwrap();
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
