//! What page and server say to each other. `docs/view-protocol.md` is the same for people.

use serde::Deserialize;
use serde_json::{Value, json};

/// The version of the protocol.
pub const PROTOCOL: u32 = 1;

/// One of the two stones that are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum Letter {
    A,
    B,
}

impl Letter {
    pub const ALL: [Letter; 2] = [Letter::A, Letter::B];

    pub fn name(self) -> &'static str {
        ["A", "B"][self as usize]
    }
}

/// What a page says.
#[derive(Debug, Clone)]
pub enum Ask {
    Page(Page),
    Change(Change),
    Question(Question),
}

impl Ask {
    /// Reads a message; what is wrong with one is for whoever wrote the page.
    pub fn parse(text: &str) -> Result<Self, String> {
        #[derive(Deserialize)]
        struct Kind {
            r#type: String,
        }
        let Kind { r#type: kind } = serde_json::from_str(text).map_err(|e| e.to_string())?;
        let read = match kind.as_str() {
            "hello" | "size" | "shown" => serde_json::from_str(text).map(Ask::Page),
            "inspect" | "hover" | "curve" | "save" | "command" => {
                serde_json::from_str(text).map(Ask::Question)
            }
            _ => serde_json::from_str(text).map(Ask::Change),
        };
        read.map_err(|e| e.to_string())
    }
}

/// What a page says of itself.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Page {
    /// The first message.
    Hello { protocol: u32, width: u32, height: u32 },
    /// Device pixels of one view.
    Size { width: u32, height: u32 },
    /// A picture has been drawn; the next one may come.
    Shown {},
}

/// What changes the state.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Change {
    Pose {
        #[serde(default)]
        id: u64,
        /// x, y, z, w.
        rotation: [f64; 4],
        done: bool,
    },
    Lights {
        #[serde(default)]
        id: u64,
        rotation: f64,
        done: bool,
    },
    Distance {
        #[serde(default)]
        id: u64,
        factor: f64,
        done: bool,
    },
    FaceUp {
        #[serde(default)]
        id: u64,
    },
    Set {
        #[serde(default)]
        id: u64,
        path: String,
        value: Value,
        side: Letter,
        done: bool,
    },
    Undo {
        #[serde(default)]
        id: u64,
    },
    Redo {
        #[serde(default)]
        id: u64,
    },
    Compare {
        #[serde(default)]
        on: Option<bool>,
        #[serde(default)]
        swap: bool,
    },
}

impl Change {
    /// The number of the message.
    pub fn id(&self) -> u64 {
        match *self {
            Change::Pose { id, .. }
            | Change::Lights { id, .. }
            | Change::Distance { id, .. }
            | Change::FaceUp { id }
            | Change::Set { id, .. }
            | Change::Undo { id }
            | Change::Redo { id } => id,
            Change::Compare { .. } => 0,
        }
    }
}

/// A pixel of a view of this size; without a size, of the picture.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Spot {
    pub x: f64,
    pub y: f64,
    #[serde(default)]
    pub width: f64,
    #[serde(default)]
    pub height: f64,
}

/// What is answered without changing anything.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Question {
    Inspect {
        side: Letter,
        #[serde(flatten)]
        at: Spot,
        #[serde(default)]
        id: u64,
    },
    Hover {
        side: Letter,
        #[serde(flatten)]
        at: Spot,
        #[serde(default)]
        id: u64,
    },
    Curve {
        side: Letter,
        #[serde(default)]
        id: u64,
    },
    Save {
        format: Format,
        side: Letter,
        #[serde(default)]
        id: u64,
    },
    Command {
        side: Letter,
        #[serde(default)]
        id: u64,
    },
}

/// What can be taken away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    Png,
    Exr,
    SpectralExr,
    Scene,
    Turn,
}

impl Format {
    /// The format of a name.
    pub fn by_name(name: &str) -> Option<Self> {
        let all = [Format::Png, Format::Exr, Format::SpectralExr, Format::Scene, Format::Turn];
        all.into_iter().find(|format| format.name() == name)
    }

    pub fn name(self) -> &'static str {
        match self {
            Format::Png => "png",
            Format::Exr => "exr",
            Format::SpectralExr => "spectral-exr",
            Format::Scene => "scene",
            Format::Turn => "turn",
        }
    }

    /// The end of its files' names.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Png | Format::Turn => "png",
            Format::Exr | Format::SpectralExr => "exr",
            Format::Scene => "toml",
        }
    }
}

/// Something that was not done, for people.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Refusal {
    /// What was not done: "portuguese.gcs was not opened".
    pub what: String,
    /// File, line, tier.
    pub place: Option<Box<str>>,
    pub why: String,
    /// What is as before.
    pub unchanged: String,
    /// The setting that returns to its old value.
    pub path: Option<Box<str>>,
    pub code: &'static str,
}

impl Refusal {
    pub fn to_json(&self) -> Value {
        let Refusal { what, place, why, unchanged, path, code } = self;
        json!({ "type": "error", "what": what, "where": place, "why": why, "unchanged": unchanged, "path": path,
                "code": code })
    }
}
