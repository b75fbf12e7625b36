//! The state of a view: two scene documents, and those before them.
//!
//! Everything that is seen is in the documents, so that what is saved renders it.

use crate::scene_file::Draft;
use glam::{DMat3, DQuat, DVec3, EulerRot};
use toml::{Table, Value};

/// The most steps that can be undone.
const STEPS: usize = 200;

/// One side: a scene, and how far its eye was when it was opened.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    pub draft: Draft,
    /// Distance of the eye, or height of a parallel view, mm.
    opening: f64,
}

impl Setup {
    pub fn new(draft: Draft) -> Self {
        let mut setup = Setup { draft, opening: 1.0 };
        setup.opening = setup.reach().unwrap_or(1.0);
        setup
    }

    /// A table of the document.
    pub fn section(&self, name: &str) -> Option<&Table> {
        self.draft.table.get(name)?.as_table()
    }

    /// The same, made if it is not there.
    pub fn section_mut(&mut self, name: &str) -> Option<&mut Table> {
        let value = self.draft.table.entry(name).or_insert_with(|| Value::Table(Table::new()));
        value.as_table_mut()
    }

    /// The first stone's table.
    pub fn stone(&self) -> Option<&Table> {
        self.draft.table.get("stone")?.as_array()?.first()?.as_table()
    }

    /// The same, made if it is not there.
    pub fn stone_mut(&mut self) -> Option<&mut Table> {
        let stones =
            self.draft.table.entry("stone").or_insert_with(|| Value::Array(vec![Value::Table(Table::new())]));
        stones.as_array_mut()?.first_mut()?.as_table_mut()
    }

    fn camera_point(&self, key: &str) -> Option<DVec3> {
        let list = self.section("camera")?.get(key)?.as_array()?;
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|v| v as f64));
        let numbers: Vec<f64> = list.iter().filter_map(number).collect();
        Some(DVec3::from(<[f64; 3]>::try_from(numbers).ok()?))
    }

    fn eye(&self) -> Option<[DVec3; 2]> {
        Some([self.camera_point("position")?, self.camera_point("look_at")?])
    }

    fn reach(&self) -> Option<f64> {
        self.draft.number("camera", "orthographic").or_else(|| self.eye().map(|[eye, at]| eye.distance(at)))
    }

    /// How far the eye is, in units of how far it was at first.
    pub fn distance(&self) -> f64 {
        self.reach().map_or(1.0, |reach| reach / self.opening)
    }

    pub fn set_distance(&mut self, factor: f64) {
        let reach = self.opening * factor;
        if self.draft.number("camera", "orthographic").is_some() {
            self.draft = self.draft.with("camera", "orthographic", reach);
        } else if let Some([eye, at]) = self.eye() {
            let place = at + (eye - at).normalize_or(DVec3::Z) * reach;
            self.draft = self.draft.with("camera", "position", list(&place.to_array()));
        }
    }

    /// How the stones are turned: rotation, turn and tilt together.
    pub fn pose(&self) -> DQuat {
        let angles = self.section("pose").and_then(|pose| pose.get("rotation")?.as_array());
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|v| v as f64)).unwrap_or(0.0);
        let angles: Vec<f64> = angles.map_or_else(Vec::new, |list| list.iter().map(number).collect());
        let [x, y, z] = <[f64; 3]>::try_from(angles).unwrap_or_default().map(f64::to_radians);
        let angle = |key| self.draft.number("pose", key).unwrap_or(0.0).to_radians();
        let up = self.camera_point("up").unwrap_or(DVec3::Z);
        let right = self.eye().map(|[eye, at]| (at - eye).cross(up)).and_then(DVec3::try_normalize);
        DQuat::from_axis_angle(right.unwrap_or(DVec3::X), angle("tilt"))
            * DQuat::from_rotation_z(angle("turn"))
            * DQuat::from_euler(EulerRot::ZYX, z, y, x)
    }

    /// Turns the stones; one rotation takes the place of turn and tilt.
    pub fn set_pose(&mut self, pose: DQuat) {
        let (z, y, x) = DMat3::from_quat(pose.normalize()).to_euler(EulerRot::ZYX);
        // A millionth of a degree is far below a pixel, and is readable. The sum has no negative zero.
        let angles = [x, y, z].map(|angle| (angle.to_degrees() * 1e6).round() / 1e6 + 0.0);
        if let Some(pose) = self.section_mut("pose") {
            ["turn", "tilt"].iter().for_each(|key| drop(pose.remove(*key)));
            pose.insert("rotation".to_owned(), list(&angles));
        }
    }

    /// Turns +z, a table's normal, towards the eye.
    pub fn face_up(&mut self) {
        let towards = self.eye().map_or(DVec3::Z, |[eye, at]| (eye - at).normalize_or(DVec3::Z));
        self.set_pose(DQuat::from_rotation_arc(DVec3::Z, towards));
    }

    /// The scene for a picture of this size. A picture that is narrower than high shows as much across as a square one.
    pub fn sized(&self, [width, height]: [u32; 2]) -> Draft {
        let mut draft =
            self.draft.with("film", "width", i64::from(width)).with("film", "height", i64::from(height));
        if width < height {
            let ratio = f64::from(height) / f64::from(width);
            if let Some(across) = self.draft.number("camera", "orthographic") {
                draft = draft.with("camera", "orthographic", across * ratio);
            } else {
                let fov = self.draft.number("camera", "fov").unwrap_or(crate::scene_file::DEFAULT_FOV);
                let half = (fov.to_radians() / 2.0).tan() * ratio;
                draft = draft.with("camera", "fov", 2.0 * half.atan().to_degrees());
            }
        }
        draft
    }
}

/// Numbers as a TOML list.
pub fn list(numbers: &[f64]) -> Value {
    Value::Array(numbers.iter().map(|number| Value::Float(*number)).collect())
}

/// All that can be undone.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    pub sides: [Option<Setup>; 2],
    /// Whether the exposure was last chosen by the picture itself.
    pub auto: bool,
}

/// The document now, before and after.
pub struct History {
    pub now: Document,
    past: Vec<(String, Document)>,
    future: Vec<(String, Document)>,
    /// The document before a gesture that goes on.
    gesture: Option<Document>,
}

impl History {
    pub fn new(now: Document) -> Self {
        History { now, past: Vec::new(), future: Vec::new(), gesture: None }
    }

    /// A change has been made to `now`, which was `before`; a gesture that goes on makes one step when it is done.
    pub fn note(&mut self, label: String, before: Document, done: bool) {
        let before = self.gesture.take().unwrap_or(before);
        if !done {
            self.gesture = Some(before);
        } else if before != self.now {
            self.past.push((label, before));
            self.future.clear();
            let most = self.past.len().saturating_sub(STEPS);
            self.past.drain(..most);
        }
    }

    /// Goes a step back, or forth again; a gesture that goes on has ended.
    pub fn step(&mut self, back: bool) {
        if let Some(before) = self.gesture.take() {
            self.note("the last change".to_owned(), before, true);
        }
        let History { now, past, future, .. } = self;
        let (from, to) = if back { (past, future) } else { (future, past) };
        if let Some((label, other)) = from.pop() {
            to.push((label, std::mem::replace(now, other)));
        }
    }

    /// What undo and redo would undo and redo.
    pub fn labels(&self) -> [Option<&str>; 2] {
        [&self.past, &self.future].map(|steps| steps.last().map(|(label, _)| label.as_str()))
    }
}
