//! The page's files, which are part of the program.

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
const FILES: &[File] = files!["index.html"];

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

pub fn file(name: &str) -> Option<&'static File> {
    FILES.iter().find(|file| file.name == name)
}
