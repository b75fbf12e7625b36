//! A small scene, and the commands called as the binary calls them.

use clap::Parser as _;
use gemtrace::Error;
use gemtrace_cli::commands::{Cli, run};
use gemtrace_cli::console::{Console, Interrupt, Report};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder that vanishes, with a scene in it.
pub struct Workplace {
    pub folder: TempDir,
}

/// A diamond that fills a third of 24 × 16 pixels, in uniform light.
pub const SCENE: &str = r#"
format = 1
[camera]
position = [0.0, 0.0, 40.0]
look_at = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
fov = 14.0
[film]
width = 24
height = 16
[environment]
uniform = [0.5, 0.25, 0.125]
[[stone]]
shape = { name = "round-brilliant" }
width = 6.5
material = "diamond"
[render]
samples = 4
wavelengths = { count = 8, range = [380.0, 740.0] }
threshold = 1e-2
"#;

impl Workplace {
    pub fn new() -> Self {
        Self::with(SCENE)
    }

    pub fn with(scene: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("tiny.toml"), scene).unwrap();
        Workplace { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
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
        let scene = self.path("tiny.toml").display().to_string();
        let outputs: Vec<String> =
            outputs.iter().map(|name| format!("--output={}", self.path(name).display())).collect();
        let mut arguments = vec!["render", &scene];
        arguments.extend(outputs.iter().map(String::as_str));
        arguments.extend(options);
        command_with(&arguments, interrupt).0
    }
}

/// Runs `gemtrace ARGUMENTS…` through the library.
pub fn command(arguments: &[&str]) -> Result<Report, Error> {
    command_with(arguments, &Interrupt::default()).0
}

/// The same, with what went to the log.
pub fn command_with(arguments: &[&str], interrupt: &Interrupt) -> (Result<Report, Error>, String) {
    let cli = Cli::try_parse_from(std::iter::once("gemtrace").chain(arguments.iter().copied())).unwrap();
    let mut log = Vec::new();
    let result = run(&cli.command, &mut Console { log: &mut log, quiet: cli.quiet, interrupt });
    (result, String::from_utf8(log).unwrap())
}

/// A sample cut of the repository.
pub fn cut(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../spectral-core/data/cuts");
    folder.join(name).display().to_string()
}
