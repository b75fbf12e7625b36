//! Questions about what is seen: the facet under the cursor, a pixel, light return over tilt, the command line.
//!
//! They are answered from the latest sight, on threads of their own, so that no picture waits for them.

use super::export::Export;
use super::hub::{Client, locked};
use super::inbox::{Overtaken, Queue};
use super::message::{Question, Refusal, Spot};
use super::pixel;
use super::sight::{Sight, Sights};
use super::solid::Solid;
use super::watch::Patience;
use super::{curve, desk};
use crate::{Error, Session, import};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// Who asks what.
pub struct Asked {
    pub client: Arc<Client>,
    pub question: Question,
}

impl Overtaken for Asked {
    fn by(&self, next: &Self) -> bool {
        let same = Arc::ptr_eq(&self.client, &next.client);
        let kind = std::mem::discriminant(&self.question) == std::mem::discriminant(&next.question);
        same && kind && !matches!(next.question, Question::Save { .. } | Question::Command { .. })
    }
}

/// The threads that answer.
pub struct Inquiry {
    /// Quick questions, curves, and files.
    queues: [Arc<Queue<Asked>>; 3],
}

impl Inquiry {
    /// Starts the threads.
    ///
    /// # Errors
    /// [`Error::Output`] where they cannot be started.
    pub fn start(
        sights: &Arc<Sights>,
        export: &Arc<Export>,
        busy: impl Fn() -> bool + Send + 'static,
    ) -> Result<Self, Error> {
        let queues: [Arc<Queue<Asked>>; 3] = Default::default();
        let [quick, curves, files] = queues.clone();
        let (seen, exported) = (Arc::clone(sights), Arc::clone(export));
        spawn(move || {
            let mut eye = Eye::default();
            loop {
                answer(&quick.next(), &seen, |sight, question| eye.answer(sight, question, &exported));
            }
        })?;
        let seen = Arc::clone(sights);
        spawn(move || {
            let mut session = None;
            loop {
                let asked = curves.next();
                let mut watch = Patience { busy: &busy, over: &|| curves.is_waiting() };
                answer(&asked, &seen, |sight, question| {
                    let session = match &mut session {
                        Some(session) => session,
                        none => none.insert(curve::session()?),
                    };
                    curve::answer(sight, question, session, &mut watch)
                });
            }
        })?;
        let exported = Arc::clone(export);
        spawn(move || {
            loop {
                let asked = files.next();
                if let Question::Save { format, side, id } = asked.question {
                    asked.client.answer(&exported.save(&asked.client, side, format, id));
                }
            }
        })?;
        Ok(Inquiry { queues })
    }

    /// Takes a question; returns whether there was room for it.
    pub fn ask(&self, client: &Arc<Client>, question: Question) -> bool {
        let queue = match question {
            Question::Curve { .. } => 1,
            Question::Save { .. } => 2,
            _ => 0,
        };
        self.queues[queue].put(Asked { client: Arc::clone(client), question })
    }
}

fn spawn(work: impl FnOnce() + Send + 'static) -> Result<(), Error> {
    let thread = std::thread::Builder::new().name("view answers".to_owned()).spawn(work);
    thread.map(drop).map_err(|e| Error::output("a thread", format!("cannot be started ({e})")))
}

/// Answers a question, or says why not.
fn answer(
    asked: &Asked,
    sights: &Sights,
    find: impl FnOnce(&Sight, &Question) -> Result<Option<Value>, Error>,
) {
    let (side, id, what) = match asked.question {
        Question::Inspect { side, id, .. } => (side, id, "the pixel was not inspected"),
        Question::Hover { side, id, .. } => (side, id, "the facet was not found"),
        Question::Curve { side, id } => (side, id, "the curve was not measured"),
        Question::Command { side, id } => (side, id, "there is no command"),
        Question::Save { side, id, .. } => (side, id, "nothing was saved"),
    };
    match sights.get(side).and_then(|sight| find(&sight, &asked.question)) {
        Ok(Some(message)) => asked.client.answer(&message),
        Ok(None) => {}
        Err(error) => {
            let refusal: Refusal =
                desk::refusal(what.to_owned(), &error, "the picture is as before".to_owned(), None);
            let mut message = refusal.to_json();
            message["id"] = id.into();
            asked.client.answer(&message);
        }
    }
}

/// A place in the picture, or so near to it that a ray can be made of it. In a view of another size the picture's middle is in the
/// middle, and its smaller edge is as long as that of the view.
fn place(sight: &Sight, at: Spot) -> [f64; 2] {
    let own = [sight.loaded.scene.width, sight.loaded.scene.height].map(f64::from);
    let view = if at.width > 0.0 && at.height > 0.0 { [at.width, at.height] } else { own };
    let scale = own[0].min(own[1]) / view[0].min(view[1]);
    let scaled =
        |at: f64, k: usize| if view == own { at } else { (at + 0.5 - view[k] / 2.0) * scale + own[k] / 2.0 };
    [scaled(at.x, 0).clamp(-own[0], 2.0 * own[0]), scaled(at.y, 1).clamp(-own[1], 2.0 * own[1])]
}

/// What quick questions need again and again.
#[derive(Default)]
struct Eye {
    session: Option<Session>,
    gears: Mutex<HashMap<PathBuf, Option<i32>>>,
}

impl Eye {
    fn answer(
        &mut self,
        sight: &Sight,
        question: &Question,
        export: &Export,
    ) -> Result<Option<Value>, Error> {
        let solid = Solid::new(&sight.loaded, sight.setup.pose());
        let gear = self.gear(sight);
        match *question {
            Question::Hover { at, id, .. } => {
                let ray = pixel::ray(sight, place(sight, at));
                let facet = backend_cpu::first_facet(&sight.prepared, &ray);
                let place = facet.and_then(|facet| solid.place(facet));
                let outline = place.map(|place| pixel::points(&solid.outline(place)));
                let facet = place.and_then(|place| solid.facet(place, gear));
                Ok(Some(json!({ "type": "facet", "id": id, "facet": facet, "outline": outline })))
            }
            Question::Inspect { at, id, .. } => {
                let session = match &mut self.session {
                    Some(session) => session,
                    none => none.insert(Session::open("cpu")?),
                };
                let mut found = pixel::inspect(sight, &solid, gear, place(sight, at), session)?;
                found["id"] = id.into();
                Ok(Some(found))
            }
            Question::Command { id, .. } => {
                Ok(Some(json!({ "type": "command", "id": id, "text": export.command(sight)? })))
            }
            Question::Curve { .. } | Question::Save { .. } => Ok(None),
        }
    }

    /// The teeth of the gear of the design that is shown.
    fn gear(&self, sight: &Sight) -> Option<i32> {
        let path = PathBuf::from(sight.setup.stone()?.get("cut")?.as_str()?);
        let read = |path: &PathBuf| {
            let bytes = import::read_file(path).ok()?;
            import::cut::read(path, &bytes).ok()?.0.gear
        };
        *locked(&self.gears).entry(path.clone()).or_insert_with(|| read(&path))
    }
}
