//! A folder with a small sweep in it, and the commands called through the library.

use clap::Parser as _;
use gemtrace::Error;
use gemtrace::batch::manifest::{self, Done, Event};
use gemtrace_cli::commands::{Cli, run};
use gemtrace_cli::console::{Console, Interrupt, Report};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The scene that is changed; a few milliseconds a picture.
pub const BASE: &str = r#"
format = 1
[camera]
position = [0.0, 0.0, 40.0]
look_at = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
[film]
width = 24
height = 24
[environment]
uniform = [0.5, 0.25, 0.125]
[[stone]]
shape = "round-brilliant"
width = 6.5
material = "diamond"
[render]
samples = 1
wavelengths = { count = 4, range = [380.0, 740.0] }
threshold = 1e-2
"#;

/// Twelve pictures.
pub const SWEEP: &str = r#"
format = 1
base = "base.toml"
cuts = ["round-brilliant", "step"]
materials = ["diamond", "ruby", "quartz"]
views = [{ name = "top", elevation = 90 }, { name = "side", elevation = 40 }]
"#;

pub struct Workplace {
    pub folder: TempDir,
}

impl Workplace {
    pub fn new() -> Self {
        Self::with(SWEEP)
    }

    pub fn with(sweep: &str) -> Self {
        let place = Workplace { folder: tempfile::tempdir().unwrap() };
        place.write("base.toml", BASE);
        place.write("sweep.toml", sweep);
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// `gemtrace batch sweep.toml -o OUTPUT --backend cpu OPTIONS…`
    pub fn batch(&self, output: &str, options: &[&str]) -> Result<Report, Error> {
        let (sweep, output) = (self.path("sweep.toml"), self.path(output));
        let fixed = ["batch", sweep.to_str().unwrap(), "-o", output.to_str().unwrap(), "--backend", "cpu"];
        command(&[&fixed, options].concat())
    }

    /// `gemtrace merge NAME…`
    pub fn merge(&self, names: &[&str]) -> Result<Report, Error> {
        let paths: Vec<String> = names.iter().map(|name| self.path(name).display().to_string()).collect();
        let mut arguments = vec!["merge"];
        arguments.extend(paths.iter().map(String::as_str));
        command(&arguments)
    }

    /// All lines of all manifests.
    pub fn lines(&self, output: &str) -> Vec<Event> {
        let all = manifest::all(&self.path(output)).unwrap();
        all.iter().flat_map(|(_, path)| manifest::read(path).unwrap()).collect()
    }

    /// The items that are done, in the order in which they were.
    pub fn done(&self, output: &str) -> Vec<Done> {
        let done = |line: Event| if let Event::Done(done) = line { Some(*done) } else { None };
        self.lines(output).into_iter().filter_map(done).collect()
    }
}

/// Runs `gemtrace ARGUMENTS…` through the library.
pub fn command(arguments: &[&str]) -> Result<Report, Error> {
    let cli = Cli::try_parse_from(std::iter::once("gemtrace").chain(arguments.iter().copied())).unwrap();
    let (mut log, interrupt) = (Vec::new(), Interrupt::default());
    run(&cli.command, &mut Console { log: &mut log, quiet: false, interrupt: &interrupt })
}

/// All pictures below a folder, by their names, and nothing else but what a batch writes.
pub fn pictures(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".png") || name.ends_with(".exr") {
                found.insert(name, std::fs::read(&path).unwrap());
            } else {
                let own = ["plan.json", "index.html"].contains(&name.as_str())
                    || manifest::shard_of(&name).is_some();
                assert!(own, "{name} was left behind");
            }
        }
    }
    found
}
