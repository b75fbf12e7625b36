//! The thread that owns the session: it takes orders, changes the documents, and renders what they say.

use super::description;
use super::document::{Document, History, Setup};
use super::hub::{Client, Hub};
use super::inbox::{Inbox, Order, Sessions};
use super::lists::{Kind, Lists, kind};
use super::message::{Change, Letter, Refusal};
use super::opening;
use super::setting;
use super::side::Side;
use super::sight::{Sight, Sights};
use super::store::Store;
use super::watch::Onlooker;
use crate::Error;
use crate::scene_file::Assets;
use glam::DQuat;
use serde_json::Value;
use spectral_core::shown;
use spectral_core::tracer::TraceReport;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// How long nothing must come before the ground is shaded as the picture has it.
const REST: Duration = Duration::from_millis(150);

/// What the thread owns.
pub struct Desk {
    pub history: History,
    pub lists: Lists,
    pub store: Arc<Store>,
    pub assets: Assets,
    pub inbox: Arc<Inbox>,
    pub hub: Arc<Hub>,
    pub sights: Arc<Sights>,
    pub sessions: Sessions,
    pub hello: Box<dyn Fn(&Lists) -> Value + Send>,
    pub sides: [Option<Side>; 2],
    pub size: [u32; 2],
    /// The newest change that was taken.
    pub answers: u64,
}

impl Desk {
    /// Shows what was opened.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn begin(&mut self) -> Result<(), Error> {
        Letter::ALL.into_iter().try_for_each(|letter| self.show_side(letter))?;
        self.tell_lists();
        self.tell_state();
        Ok(())
    }

    /// Works until the process ends.
    pub fn run(mut self) {
        loop {
            for order in self.inbox.take() {
                self.obey(order);
            }
            if !self.step() {
                self.inbox.wait();
            }
        }
    }

    /// Renders one frame, or goes on with one picture; returns whether there was anything to do.
    fn step(&mut self) -> bool {
        let moving = self.sides.iter().flatten().filter(|side| side.fresh).count();
        let letter = |wanted: fn(&Side) -> bool, sides: &[Option<Side>; 2]| {
            Letter::ALL.into_iter().find(|letter| sides[*letter as usize].as_ref().is_some_and(wanted))
        };
        if let Some(letter) = letter(|side| side.fresh, &self.sides) {
            self.frame(letter, 1.0 / moving as f64);
            return true;
        }
        match letter(|side| !side.rests, &self.sides) {
            Some(letter) => {
                self.refine(letter);
                true
            }
            None => false,
        }
    }

    fn frame(&mut self, letter: Letter, share: f64) {
        let (inbox, hub) = (&self.inbox, &self.hub);
        let Some(side) = self.sides[letter as usize].as_mut() else { return };
        let mut watch = Onlooker::new(hub, inbox, letter, self.answers, side);
        let Some(film) = side.frame(share, &|| inbox.is_waiting(), &mut watch) else { return };
        self.sights.set(letter, Sight::new(side, self.answers));
        watch.show(&film, "moving", film.samples(0, 0), side.prepared().wavelength_count());
        watch.status("moving", film.samples(0, 0), None, &TraceReport::default());
    }

    fn refine(&mut self, letter: Letter) {
        let Some(side) = self.sides[letter as usize].as_mut() else { return };
        // A hand that turns on does not wait for fine shadows.
        if side.coarse && !self.inbox.is_quiet(REST) {
            return;
        }
        let shaded = if side.coarse { side.shade(&mut self.assets) } else { Ok(()) };
        let mut watch = Onlooker::new(&self.hub, &self.inbox, letter, self.answers, side);
        match shaded.and_then(|()| side.refine(&mut watch)) {
            Ok(Some(picture)) => {
                let change = picture.film.change();
                let sight = Sight { picture: Some(Arc::new(picture)), ..Sight::new(side, self.answers) };
                let sight = self.sights.set(letter, sight);
                self.sights.settle(letter, &sight, &self.hub);
                let samples = side.settings.as_ref().map_or(0, |settings| settings.samples);
                watch.status("settled", samples, change, &side.rendered.traced);
            }
            Ok(None) => {}
            Err(error) => {
                side.rests = true;
                let sight = Sight { failed: true, ..Sight::new(side, self.answers) };
                self.sights.set(letter, sight);
                watch.status("failed", 0, None, &TraceReport::default());
                let what = "the picture was not finished".to_owned();
                let unchanged = "the last picture stays".to_owned();
                self.hub.tell(&refusal(what, &error, unchanged, None).to_json());
            }
        }
    }

    fn obey(&mut self, order: Order) {
        match order {
            Order::Hello(client, size) => {
                // First the size, so that the first state that the page gets is right.
                self.resize(size);
                self.hub.join(&client);
            }
            Order::Size(size) => self.resize(size),
            Order::Change(client, change) => self.change(&client, change),
            Order::Dropped { path, side, reply } => {
                // Whoever dropped it may be gone.
                drop(reply.send(self.open(&path, side)));
            }
        }
    }

    fn resize(&mut self, size: [u32; 2]) {
        if size != self.size {
            self.size = size;
            let before = self.history.now.clone();
            self.show(&before, None, None);
            self.tell_state();
        }
    }

    fn change(&mut self, client: &Arc<Client>, change: Change) {
        let before = self.history.now.clone();
        let (label, done, path) = match self.apply(change) {
            Ok(Some(applied)) => applied,
            Ok(None) => {
                // A step to and fro is what it was, but for what can no longer be read.
                if self.show(&before, Some(client), None) {
                    self.tell_state();
                }
                return;
            }
            Err(refusal) => {
                client.answer(&refusal.to_json());
                return self.tell_state();
            }
        };
        if !self.show(&before, Some(client), path.as_deref()) {
            return self.tell_state();
        }
        self.history.note(label, before, done);
        if done {
            self.tell_state();
        }
    }

    /// Changes the documents; says what the change is called, whether it is done, and which setting it is.
    fn apply(&mut self, change: Change) -> Result<Option<(String, bool, Option<String>)>, Refusal> {
        self.answers = self.answers.max(change.id());
        let (label, done) = match change {
            Change::Pose { rotation, done, .. } => {
                let pose = unit(rotation)?;
                self.setups().for_each(|setup| setup.set_pose(pose));
                ("turn", done)
            }
            Change::FaceUp { .. } => {
                self.setups().for_each(Setup::face_up);
                ("face up", true)
            }
            Change::Distance { factor, done, .. } => {
                let factor = if factor.is_finite() { factor.clamp(0.2, 10.0) } else { 1.0 };
                self.setups().for_each(|setup| setup.set_distance(factor));
                ("distance", done)
            }
            Change::Lights { rotation, done, .. } => {
                let (lists, sides) = (&self.lists, &mut self.history.now.sides);
                for setup in sides.iter_mut().flatten() {
                    setting::set(setup, lists, "rotation", &Value::from(rotation))
                        .map_err(|why| unfit("the lights were not turned", &why))?;
                }
                ("lights", done)
            }
            Change::Set { path, value, side, done, .. } => {
                return Ok(Some((self.set(&path, &value, side)?, done, Some(path))));
            }
            Change::Undo { .. } | Change::Redo { .. } => {
                self.history.step(matches!(change, Change::Undo { .. }));
                return Ok(None);
            }
            Change::Compare { on, swap } => return Ok(Some(self.compare(on, swap))),
        };
        Ok(Some((label.to_owned(), done, None)))
    }

    /// The scenes of both sides.
    fn setups(&mut self) -> impl Iterator<Item = &mut Setup> {
        self.history.now.sides.iter_mut().flatten()
    }

    /// Changes a setting; exposure and tone are one for both sides.
    fn set(&mut self, path: &str, value: &Value, side: Letter) -> Result<String, Refusal> {
        let refuse = |why: String| Refusal {
            path: Some(path.into()),
            ..unfit(&format!("{path} was not changed"), &why)
        };
        let document = &mut self.history.now;
        let mut value = value.clone();
        if path == "exposure" {
            document.auto = value.as_str() == Some("auto");
            if document.auto {
                value = self.sights.exposure(side).into();
            }
        }
        let (document, lists) = (&mut self.history.now, &self.lists);
        let both = matches!(path, "exposure" | "tone");
        let sides = Letter::ALL.into_iter().filter(|letter| *letter == side || both);
        let mut label = None;
        for letter in sides {
            if let Some(setup) = document.sides[letter as usize].as_mut() {
                label = Some(setting::set(setup, lists, path, &value).map_err(refuse)?);
            }
        }
        label.ok_or_else(|| refuse(format!("there is no side {}", side.name())))
    }

    fn compare(&mut self, on: Option<bool>, swap: bool) -> (String, bool, Option<String>) {
        let sides = &mut self.history.now.sides;
        match on {
            Some(true) if sides[1].is_none() => sides[1] = sides[0].clone(),
            Some(false) => sides[1] = None,
            _ => {}
        }
        if swap && sides[1].is_some() {
            sides.swap(0, 1);
        }
        ("compare".to_owned(), true, None)
    }

    /// Brings the sides to what the document says. If one of them cannot be shown, all return to what they were, and who
    /// asked is told.
    fn show(&mut self, before: &Document, client: Option<&Arc<Client>>, path: Option<&str>) -> bool {
        for letter in Letter::ALL {
            if let Err(error) = self.show_side(letter) {
                let what = path
                    .map_or("the scene was not changed".to_owned(), |path| format!("{path} was not changed"));
                let refusal = refusal(what, &error, "the stone is as before".to_owned(), path);
                match client {
                    Some(client) => client.answer(&refusal.to_json()),
                    None => self.hub.tell(&refusal.to_json()),
                }
                if self.history.now != *before {
                    self.history.now = before.clone();
                    self.show(before, client, path);
                }
                return false;
            }
        }
        true
    }

    fn show_side(&mut self, letter: Letter) -> Result<(), Error> {
        let place = letter as usize;
        let Some(setup) = &self.history.now.sides[place] else {
            if self.sides[place].take().is_some() {
                self.sights.forget(letter);
                self.hub.forget(letter);
            }
            return Ok(());
        };
        match &mut self.sides[place] {
            Some(side) if side.setup == *setup && side.size == self.size => Ok(()),
            Some(side) => {
                side.change(setup, self.size, &mut self.assets)?;
                self.sights.set(letter, Sight::new(side, self.answers));
                Ok(())
            }
            None => {
                let session = (self.sessions)()?;
                let side = Side::new(session, setup, self.size, &mut self.assets)?;
                self.sights.set(letter, Sight::new(&side, self.answers));
                self.sides[place] = Some(side);
                Ok(())
            }
        }
    }

    /// Opens a dropped file: a light or a scene in place of what is there, a stone on the side that is meant.
    fn open(&mut self, path: &Path, side: Option<Letter>) -> Result<(), Refusal> {
        let name = self.store.label(path);
        let what = || format!("{} was not opened", shown(&name));
        let before = self.history.now.clone();
        let letter = side.unwrap_or(Letter::A);
        match kind(path) {
            Some(Kind::Scene) => {
                let setup = opening::open(path, false, &self.store, &mut self.lists, &mut self.assets);
                let setup =
                    setup.map_err(|e| refusal(what(), &e, "the scene is as before".to_owned(), None))?;
                self.history.now.sides[if side == Some(Letter::B) { 1 } else { 0 }] = Some(setup);
            }
            Some(_) => {
                let added = self.lists.add_file(path, &self.store, "Opened");
                if letter == Letter::B && self.history.now.sides[1].is_none() {
                    self.history.now.sides[1] = self.history.now.sides[0].clone();
                }
                let (path, id) = added.ok_or_else(|| unfit(&what(), "it is of no kind that is read here"))?;
                self.set(path, &Value::from(id), letter)?;
            }
            None => {
                let why = "cuts (.asc, .gem, .gcs), meshes (.obj, .stl, .ply), lights (.hdr, .exr) and scenes (.toml) are opened";
                return Err(unfit(&what(), why));
            }
        }
        for letter in Letter::ALL {
            if let Err(error) = self.show_side(letter) {
                self.history.now = before.clone();
                self.show(&before, None, None);
                return Err(refusal(what(), &error, "the stone is unchanged".to_owned(), None));
            }
        }
        self.history.note(format!("open {name}"), before, true);
        self.tell_lists();
        self.tell_state();
        Ok(())
    }

    fn tell_state(&self) {
        self.hub.state(&description::state(&self.history, &self.sides, &self.lists, &self.store));
    }

    fn tell_lists(&self) {
        self.hub.set_hello(&(self.hello)(&self.lists));
    }
}

/// A rotation as a page sends it.
fn unit(rotation: [f64; 4]) -> Result<DQuat, Refusal> {
    let pose = DQuat::from_array(rotation);
    let unit = pose.is_finite() && (pose.length() - 1.0).abs() < 0.01;
    unit.then_some(pose)
        .ok_or_else(|| unfit("the stone was not turned", "a pose is a unit quaternion [x, y, z, w]"))
}

/// Something that the page should not have asked for.
fn unfit(what: &str, why: &str) -> Refusal {
    Refusal {
        what: what.to_owned(),
        why: why.to_owned(),
        unchanged: "nothing is changed".to_owned(),
        code: "value",
        ..Refusal::default()
    }
}

/// An error as the page shows it.
pub fn refusal(what: String, error: &Error, unchanged: String, path: Option<&str>) -> Refusal {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (place, why, code) = match error {
        Error::Scene { path, line, message } => {
            (Some(format!("{}, line {line}", name(path))), message.clone(), "scene")
        }
        Error::File { path, message } => (Some(name(path)), message.clone(), "file"),
        Error::Output { path, message } => (Some(path.display().to_string()), message.clone(), "output"),
        Error::Render { device, message } => (Some(device.clone()), message.clone(), "device"),
        other => (None, other.to_string(), "value"),
    };
    Refusal { what, place: place.map(Into::into), why, unchanged, path: path.map(Into::into), code }
}
