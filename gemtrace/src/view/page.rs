//! The page's files, which are part of the program.

use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write as _;

/// One file: its name, its type and what is in it.
pub struct File {
    pub name: &'static str,
    pub kind: &'static str,
    pub bytes: &'static [u8],
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(File { name: $name, kind: kind($name), bytes: include_bytes!(concat!("page/", $name)) }),*]
    };
}

/// Every file of the folder `page`.
const FILES: &[File] = files![
    "app.js",
    "bench.js",
    "camera.js",
    "compare.js",
    "control.css",
    "difference.js",
    "dom.js",
    "embed.js",
    "field.js",
    "gesture.js",
    "icon.svg",
    "index.html",
    "inspector.js",
    "keys.js",
    "link.js",
    "loupe.js",
    "main.js",
    "material.js",
    "narrow.css",
    "open.js",
    "overlay.js",
    "picture.js",
    "plot.js",
    "pose.js",
    "rotation.js",
    "settings.js",
    "status.js",
    "style.css",
    "toast.js",
];

/// The content type of a file.
const fn kind(name: &str) -> &'static str {
    match name.as_bytes() {
        [.., b'h', b't', b'm', b'l'] => "text/html; charset=utf-8",
        [.., b'c', b's', b's'] => "text/css; charset=utf-8",
        [.., b'j', b's'] => "text/javascript; charset=utf-8",
        [.., b's', b'v', b'g'] => "image/svg+xml",
        _ => "application/octet-stream",
    }
}

impl File {
    /// As gzip.
    pub fn packed(&self) -> Vec<u8> {
        let mut packer = GzEncoder::new(Vec::new(), Compression::best());
        // Writing to memory cannot fail.
        packer.write_all(self.bytes).and_then(|()| packer.finish()).unwrap_or_default()
    }
}

/// A file by its name.
pub fn file(name: &str) -> Option<&'static File> {
    FILES.iter().find(|file| file.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_folder_is_part_of_the_program() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/view/page");
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        assert_eq!(names, FILES.iter().map(|file| file.name).collect::<Vec<_>>());
        assert!(FILES.iter().all(|file| file.kind != "application/octet-stream"));
    }

    #[test]
    fn the_page_is_small() {
        let bytes: usize = FILES.iter().map(|file| file.packed().len()).sum();
        assert!(bytes < 150_000, "{bytes}");
    }
}
