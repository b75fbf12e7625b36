//! A folder with a small scene or a small sweep in it, and the commands called as the binary calls them.

pub use super::messages::assert_matches;
use clap::Parser as _;
use gemtrace::Error;
use gemtrace::batch::manifest::{self, Done, Event};
pub use gemtrace_cli::commands::{Cli, run};
pub use gemtrace_cli::console::{Console, Interrupt, Report};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A diamond that fills a third of 24 × 16 pixels, in uniform light.
pub const SCENE: &str = include_str!("../data/tiny.toml");
/// The scene that sweeps change; a few milliseconds a picture.
pub const BASE: &str = include_str!("../data/base.toml");
/// Twelve pictures.
pub const SWEEP: &str = include_str!("../data/sweep.toml");

/// A folder that vanishes.
pub struct Workplace {
    pub folder: TempDir,
}

impl Workplace {
    /// With [`SCENE`] as `tiny.toml`.
    pub fn new() -> Self {
        Self::with(SCENE)
    }

    /// With another scene.
    pub fn with(scene: &str) -> Self {
        Self::holding(&[("tiny.toml", scene)])
    }

    /// With [`BASE`] as `base.toml` and [`SWEEP`] as `sweep.toml`.
    pub fn swept() -> Self {
        Self::swept_by(SWEEP)
    }

    /// With another sweep of [`BASE`].
    pub fn swept_by(sweep: &str) -> Self {
        Self::holding(&[("base.toml", BASE), ("sweep.toml", sweep)])
    }

    pub fn holding(files: &[(&str, &str)]) -> Self {
        let place = Workplace { folder: tempfile::tempdir().unwrap() };
        files.iter().for_each(|(name, text)| place.write(name, text));
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The path of a file, as an argument.
    pub fn name(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    /// Names in the folder, sorted, but for the scene's.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.retain(|name| name != "tiny.toml");
        names.sort();
        names
    }

    /// The binary, in this folder.
    pub fn gemtrace(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gemtrace"));
        command.args(arguments).current_dir(self.folder.path());
        command
    }

    /// `gemtrace render tiny.toml -o OUTPUT… OPTIONS…`
    pub fn render(&self, outputs: &[&str], options: &[&str]) -> Result<Report, Error> {
        self.render_with(outputs, options, &Interrupt::default())
    }

    pub fn render_with(
        &self,
        outputs: &[&str],
        options: &[&str],
        interrupt: &Interrupt,
    ) -> Result<Report, Error> {
        let scene = self.name("tiny.toml");
        let outputs: Vec<String> =
            outputs.iter().map(|name| format!("--output={}", self.name(name))).collect();
        let mut arguments = vec!["render", &scene];
        arguments.extend(outputs.iter().map(String::as_str));
        arguments.extend(options);
        command_with(&arguments, interrupt).0
    }

    /// `gemtrace batch sweep.toml -o OUTPUT --backend cpu OPTIONS…`
    pub fn batch(&self, output: &str, options: &[&str]) -> Result<Report, Error> {
        let (sweep, output) = (self.name("sweep.toml"), self.name(output));
        command(&[&["batch", &sweep, "-o", &output, "--backend", "cpu"], options].concat())
    }

    /// `gemtrace merge NAME`
    pub fn merge(&self, name: &str) -> Result<Report, Error> {
        command(&["merge", &self.name(name)])
    }

    /// All lines of all manifests.
    pub fn lines(&self, output: &str) -> Vec<Event> {
        let all = manifest::all(&self.path(output)).unwrap();
        all.iter().flat_map(|(_, path)| manifest::read(path).unwrap()).collect()
    }

    /// The items that are done, in the order in which they were finished.
    pub fn done(&self, output: &str) -> Vec<Done> {
        done(self.lines(output))
    }

    /// All pictures below a folder, by their names. Nothing else is there but what a batch writes.
    pub fn pictures(&self, folder: &str) -> BTreeMap<String, Vec<u8>> {
        let folder = self.path(folder);
        let mut found = BTreeMap::new();
        let mut folders = vec![folder.clone()];
        while let Some(next) = folders.pop() {
            for entry in std::fs::read_dir(&next).unwrap() {
                let path = entry.unwrap().path();
                let name = path.strip_prefix(&folder).unwrap().display().to_string();
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
}

/// The items of a manifest that are done.
pub fn done(lines: Vec<Event>) -> Vec<Done> {
    let done = |line: Event| if let Event::Done(done) = line { Some(*done) } else { None };
    lines.into_iter().filter_map(done).collect()
}

/// Runs `gemtrace ARGUMENTS…` through the library.
pub fn command(arguments: &[&str]) -> Result<Report, Error> {
    command_with(arguments, &Interrupt::default()).0
}

/// The same, with what went to the log.
pub fn command_with(arguments: &[&str], interrupt: &Interrupt) -> (Result<Report, Error>, String) {
    let cli = Cli::try_parse_from(std::iter::once(&"gemtrace").chain(arguments)).unwrap();
    logged(|log| run(&cli.command, &mut Console { quiet: cli.quiet, ..Console::new(log, interrupt) }))
}

/// What a function returns that writes to a log, and the log.
pub fn logged<T>(work: impl FnOnce(&mut Vec<u8>) -> T) -> (T, String) {
    let mut log = Vec::new();
    let result = work(&mut log);
    (result, String::from_utf8(log).unwrap())
}

/// Fails unless a command ends with this exit code and a message of this pattern.
#[track_caller]
pub fn assert_refused(result: Result<Report, Error>, code: u8, pattern: &str) {
    let error = result.expect_err(pattern);
    assert_matches(&error.to_string(), pattern);
    assert_eq!(i32::from(error.exit_code()), i32::from(code), "{error}");
}

/// A sample cut of the repository.
pub fn cut(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../spectral-core/data/cuts");
    folder.join(name).display().to_string()
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}
