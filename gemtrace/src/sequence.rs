//! Turntables and tilts: one scene document into the documents of its frames.
//!
//! A frame is the scene with another `[pose]`, and nothing else: camera, lights, ground and exposure stay. So frames
//! can be rendered in any order, on any machine, and each by itself.
//!
//! ```
//! use gemtrace::sequence::Motion;
//! let draft = gemtrace::scene_file::Draft::new("scene.toml".as_ref(), "format = 1\n[pose]\nturn = 10.0")?;
//! let frame = Motion::Turntable.frame(&draft, 9, 36);
//! assert_eq!(frame.table["pose"]["turn"].as_float(), Some(100.0));
//! let tilt = Motion::Tilt { from: -30.0, to: 30.0 };
//! assert_eq!([0, 6, 12].map(|i| tilt.angle(i, 13)), [-30.0, 0.0, 30.0]);
//! # Ok::<(), gemtrace::Error>(())
//! ```

use crate::Error;
use crate::batch::{Item, Pictures, Plan, plain};
use crate::scene_file::Draft;
use serde_json::{Map, json};
use std::path::Path;

/// How stones move from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Once about +z, counter-clockwise seen from above, in equal steps; the frame after the last would be the first.
    Turntable,
    /// About the camera's axis to the right, in equal steps from one angle to the other, degrees; both are shown. A
    /// positive angle brings what is upright in the picture towards the eye.
    Tilt {
        /// Of the first frame.
        from: f64,
        /// Of the last frame.
        to: f64,
    },
}

impl Motion {
    /// The word for it in names of files.
    pub fn name(self) -> &'static str {
        match self {
            Motion::Turntable => "turntable",
            Motion::Tilt { .. } => "tilt",
        }
    }

    /// The angle of frame `i` of `n`, counted from 0, degrees. A tilt of one frame shows the middle of its range.
    pub fn angle(self, i: u32, n: u32) -> f64 {
        match self {
            Motion::Turntable => 360.0 * f64::from(i) / f64::from(n),
            Motion::Tilt { from, to } if n < 2 => (from + to) / 2.0,
            Motion::Tilt { from, to } => from + (to - from) * (f64::from(i) / f64::from(n - 1)),
        }
    }

    /// The scene document of frame `i` of `n`: the angle is added to what `[pose]` says already.
    #[must_use]
    pub fn frame(self, scene: &Draft, i: u32, n: u32) -> Draft {
        let key = match self {
            Motion::Turntable => "turn",
            Motion::Tilt { .. } => "tilt",
        };
        scene.with("pose", key, scene.number("pose", key).unwrap_or(0.0) + self.angle(i, n))
    }

    /// All `n` frames of a scene as pictures of a batch.
    ///
    /// # Errors
    /// As [`Plan::new`].
    pub fn plan(self, scene: &Draft, n: u32, pictures: Pictures) -> Result<Plan, Error> {
        let stem = plain(&scene.stem());
        let item = |i| Item {
            name: self.frame_name(&stem, i, n),
            values: Map::from_iter([("angle".to_owned(), json!(self.angle(i, n)))]),
            scene: self.frame(scene, i, n).table,
        };
        let folder = scene.path.parent().unwrap_or(Path::new("")).to_owned();
        let title = format!("{} of {}", self.name(), scene.name());
        Plan::new(title, folder, (0..n).map(item).collect(), pictures)
    }

    /// The name of frame `i` of `n` without its extension, `brilliant-tilt-0001`: counted from 1, in as many digits
    /// for all, at least four.
    pub fn frame_name(self, stem: &str, i: u32, n: u32) -> String {
        let digits = n.to_string().len().max(4);
        format!("{stem}-{}-{:0digits$}", self.name(), i + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_ends_where_it_began() {
        let angles: Vec<f64> = (0..8).map(|i| Motion::Turntable.angle(i, 8)).collect();
        assert_eq!(angles, [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0]);
    }

    #[test]
    fn a_tilt_shows_both_ends() {
        let tilt = Motion::Tilt { from: -30.0, to: 30.0 };
        assert_eq!((tilt.angle(0, 7), tilt.angle(3, 7), tilt.angle(6, 7)), (-30.0, 0.0, 30.0));
        assert_eq!(tilt.angle(0, 1), 0.0);
    }

    #[test]
    fn frames_differ_in_their_pose_alone() {
        let draft = |text: &str| Draft::new("a.toml".as_ref(), text).unwrap();
        let scene = draft("format = 1\n[film]\nwidth = 8\n[pose]\nturn = 5\nsize = 4.0\n");
        let expected = draft("format = 1\n[film]\nwidth = 8\n[pose]\nturn = 95.0\nsize = 4.0\n");
        assert_eq!(Motion::Turntable.frame(&scene, 1, 4), expected);
        let tilted = Motion::Tilt { from: 10.0, to: 20.0 }.frame(&draft("format = 1"), 1, 2);
        assert_eq!(tilted, draft("format = 1\n[pose]\ntilt = 20.0\n"));
    }

    #[test]
    fn names_sort_as_the_frames_do() {
        assert_eq!(Motion::Turntable.frame_name("ring", 0, 36), "ring-turntable-0001");
        assert_eq!(Motion::Turntable.frame_name("ring", 9_999, 12_000), "ring-turntable-10000");
        assert_eq!(Motion::Turntable.frame_name("ring", 0, 12_000), "ring-turntable-00001");
    }
}
