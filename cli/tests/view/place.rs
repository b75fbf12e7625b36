//! A running `gemtrace view` in a folder of its own, and a browser that looks at it.

use super::browser::{Browser, Page, browser};
use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Instant;
use tempfile::TempDir;

/// A brilliant in the built-in studio, quick to settle.
pub const SCENE: &str = r##"format = 1

[camera]
position = [0.0, -11.12, 30.05]
look_at = [0.0, 0.0, -0.49]

[film]
background = "#333333"

[[stone]]
cut = "brilliant.asc"
width = 6.5
material = "diamond"

[render]
quality = "draft"
"##;

pub struct Place {
    server: Child,
    /// When the program was started.
    pub started: Instant,
    /// With the token.
    pub address: String,
    pub folder: TempDir,
    pub browser: Browser,
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Place {
    /// `None` where there is no browser and none is demanded.
    pub fn new() -> Option<Self> {
        Place::of(SCENE, &[])
    }

    /// With another scene, and with files beside it.
    pub fn of(scene: &str, files: &[(&str, Vec<u8>)]) -> Option<Self> {
        let browser = browser()?;
        let folder = tempfile::tempdir().expect("a folder");
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
        let cut = root.join("spectral-core/data/cuts/srb_diamond_57.asc");
        std::fs::copy(cut, folder.path().join("brilliant.asc")).expect("a cut");
        std::fs::write(folder.path().join("scene.toml"), scene).expect("a scene");
        for (name, bytes) in files {
            std::fs::write(folder.path().join(name), bytes).expect("a file");
        }
        let started = Instant::now();
        let mut server = Command::new(env!("CARGO_BIN_EXE_gemtrace"))
            .args(["view", "--no-open", "--port", "0", "--backend", "cpu", "scene.toml"])
            .current_dir(folder.path())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the server starts");
        let mut lines = BufReader::new(server.stderr.take().expect("a pipe")).lines();
        let address = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| Some(line[line.find("http://")?..].split_whitespace().next()?.to_owned()))
            .expect("an address");
        std::thread::spawn(move || lines.map_while(Result::ok).for_each(drop));
        Some(Place { server, started, address, folder, browser })
    }

    /// A settled page.
    pub fn page(&self, size: [u32; 2]) -> Page {
        let page = self.browser.page(size, size[0] < 640);
        page.open(&self.address);
        page.settle();
        page
    }

    /// The number of the server's process.
    pub fn process(&self) -> u32 {
        self.server.id()
    }

    pub fn origin(&self) -> &str {
        self.address.split("/?").next().expect("an origin")
    }

    /// Files of the output folder, sorted.
    pub fn views(&self) -> Vec<PathBuf> {
        let folder = self.folder.path().join("views");
        let mut found: Vec<_> = std::fs::read_dir(folder)
            .into_iter()
            .flatten()
            .map(|entry| entry.expect("an entry").path())
            .collect();
        found.sort();
        found
    }
}

/// Of a page: the pixels of the canvas of a side, RGBA.
pub fn pixels(page: &Page, view: &str) -> (u32, Vec<u8>) {
    use base64::Engine as _;
    let text = page.eval(&format!(
        "(c => {{ const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let s = c.width + ':';
           let b = ''; for (const v of d) b += String.fromCharCode(v); return s + btoa(b); }})
         (document.querySelector('{view} canvas'))"
    ));
    let (width, bytes) = text.as_str().expect("text").split_once(':').expect("a width");
    (
        width.parse().expect("a number"),
        base64::engine::general_purpose::STANDARD.decode(bytes).expect("base64"),
    )
}
