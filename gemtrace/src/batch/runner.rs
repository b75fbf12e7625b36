//! A plan carried out: what is missing or has changed, item by item.

use super::manifest::{self, Done, Event, FileRecord, Manifest, Seconds};
use super::{Item, Plan, merge};
use crate::output::{self, Picture, Target};
use crate::session::{Session, Watch};
use crate::shard::Shard;
use crate::{Error, import};
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Where a plan is carried out, and how much of it.
#[derive(Debug, Clone)]
pub struct Place {
    /// The folder for pictures and manifests; made if it is not there.
    pub output: PathBuf,
    /// The share of the items to render.
    pub shard: Shard,
}

/// The outcome of a run.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Summary {
    /// Items in the shard.
    pub items: usize,
    /// Of those, the ones that were there already.
    pub kept: usize,
    /// The ones rendered now.
    pub rendered: usize,
    /// The ones that failed, each with the reason.
    pub failed: Vec<(String, Error)>,
    /// Whether the observer stopped it; the item at hand then counts neither as rendered nor as failed.
    pub interrupted: bool,
    /// Why not all of this is in the manifest.
    pub unrecorded: Option<Error>,
    /// How long it took.
    pub elapsed: Duration,
}

impl Summary {
    /// The outcome as one error: an interruption, or the items that failed.
    pub fn failure(&self) -> Option<Error> {
        if self.interrupted {
            return Some(Error::Interrupted);
        }
        let Some((first, error)) = self.failed.first() else { return self.unrecorded.clone() };
        let mut message = match self.failed.len() {
            1 => format!("item '{first}' failed: {error}"),
            n => format!("{n} of {} items failed, the first of them '{first}': {error}", self.items),
        };
        if let Some(error) = &self.unrecorded {
            message += &format!("; and not all of this is recorded: {error}");
        }
        Some(Error::Items(message))
    }
}

/// Someone who follows a batch: its pictures as a [`Watch`], and the order in which they are made. Every method may
/// be left out, and `()` leaves out all.
#[allow(unused_variables, reason = "names of arguments are documentation")]
pub trait Observer: Watch {
    /// What is to be rendered is known: of `items` in the shard, `kept` are there already.
    fn planned(&mut self, items: usize, kept: usize) {}

    /// An item is about to be rendered. A break ends the batch before it.
    fn begin(&mut self, item: &str) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// An item is done, or has failed.
    fn end(&mut self, item: &str, outcome: Result<&Done, &Error>) {}
}

impl Observer for () {}

/// Renders the items of a shard that are not there yet, and records each in the manifest. An item is there if a manifest
/// of the folder says that it was made from the same scene and the same files, and its pictures are what they were.
///
/// An item that fails is recorded, and the next one begun.
///
/// # Errors
/// [`Error::Output`] where the folder or the manifest cannot be written to at all. Everything else is in the summary.
pub fn run(
    plan: &Plan,
    place: &Place,
    session: &mut Session,
    observer: &mut dyn Observer,
) -> Result<Summary, Error> {
    let start = Instant::now();
    let folder = &place.output;
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::output(folder, format!("this folder cannot be made ({e})")))?;
    write_plan(plan, folder)?;
    let manifest = Manifest::open(folder, place.shard)?;
    if place.shard.is_whole() {
        merge::remove_leftovers(folder);
    }
    let (todo, items) = remaining(plan, place)?;
    output::remove_leftovers(&todo.iter().flat_map(|task| task.files(plan, folder)).collect::<Vec<_>>());

    let kept = items - todo.len();
    observer.planned(items, kept);
    session.output = plan.pictures().options;
    let mut worker = Worker { plan, place, manifest, session, observer };
    let mut summary = Summary { items, kept, ..Summary::default() };
    for task in &todo {
        if worker.observer.begin(&task.item.name).is_break() {
            summary.interrupted = true;
            break;
        }
        match worker.work(task) {
            Ok(()) => summary.rendered += 1,
            Err(Error::Interrupted) => {
                summary.interrupted = true;
                break;
            }
            Err(error) => summary.failed.push((task.item.name.clone(), error)),
        }
    }
    summary.unrecorded = worker.manifest.flush().err();
    summary.elapsed = start.elapsed();
    Ok(summary)
}

/// Says what belongs into the folder; a file that says so already stays, since other shards write the same.
fn write_plan(plan: &Plan, folder: &Path) -> Result<(), Error> {
    let (path, text) = (folder.join(Plan::FILE), plan.to_json()?.to_string() + "\n");
    match import::read_file(&path) {
        Ok(there) if there == text.as_bytes() => output::check(&path),
        _ => output::write_text(&path, &text).map(drop),
    }
}

/// An item to be rendered.
struct Task<'a> {
    item: &'a Item,
    identity: String,
}

impl Task<'_> {
    fn files(&self, plan: &Plan, folder: &Path) -> Vec<PathBuf> {
        plan.files(self.item).map(|(name, _)| folder.join(name)).collect()
    }
}

/// What the manifests do not have, and the number of items of the shard.
fn remaining<'a>(plan: &'a Plan, place: &Place) -> Result<(Vec<Task<'a>>, usize), Error> {
    let known = manifest::read_all(&place.output)?;
    let mut inputs = HashMap::new();
    let (mut todo, mut items) = (Vec::new(), 0);
    for (number, item) in plan.items().iter().enumerate() {
        if !place.shard.has(number) {
            continue;
        }
        items += 1;
        let identity = plan.identity(item)?;
        let lines = known.get(&item.name).map_or(&[][..], Vec::as_slice);
        let there = lines.iter().any(|line| match line {
            Event::Done(done) => done.identity == identity && is_there(done, plan, place, &mut inputs),
            _ => false,
        });
        if !there {
            todo.push(Task { item, identity });
        }
    }
    Ok((todo, items))
}

/// Whether an item's inputs and pictures are still as its line says. Each input is checked once: many items share them.
fn is_there(done: &Done, plan: &Plan, place: &Place, inputs: &mut HashMap<FileKey, bool>) -> bool {
    let unchanged = |record: &FileRecord, inputs: &mut HashMap<FileKey, bool>| {
        let key = (record.path.clone(), record.sha256.clone());
        *inputs.entry(key).or_insert_with(|| record.holds(&plan.folder().join(&record.path)))
    };
    done.inputs.iter().all(|record| unchanged(record, inputs))
        && done.outputs.iter().all(|record| record.holds(&place.output.join(&record.path)))
}

/// A file's name and the contents that it should have.
type FileKey = (String, String);

/// Does one item after the other.
struct Worker<'a> {
    plan: &'a Plan,
    place: &'a Place,
    manifest: Manifest,
    session: &'a mut Session,
    observer: &'a mut dyn Observer,
}

impl Worker<'_> {
    /// Renders an item and records the outcome.
    fn work(&mut self, task: &Task) -> Result<(), Error> {
        let (item, identity) = (task.item.name.clone(), task.identity.clone());
        self.record(&Event::Started { item: item.clone(), identity: identity.clone() });
        let outcome = self.make(task);
        let line = match &outcome {
            Ok(done) => Event::Done(Box::new(done.clone())),
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(error) => {
                let (message, exit_code, values) =
                    (error.to_string(), error.exit_code(), task.item.values.clone());
                Event::Failed { item, identity, values, message, exit_code }
            }
        };
        self.record(&line);
        self.observer.end(&task.item.name, outcome.as_ref());
        outcome.map(|_| ())
    }

    /// A line that cannot be written waits while the run goes on; if it is never written, the summary says so.
    fn record(&mut self, line: &Event) {
        if let Err(error) = self.manifest.append(line) {
            self.observer.warning(&error.to_string());
        }
    }

    fn make(&mut self, task: &Task) -> Result<Done, Error> {
        let start = Instant::now();
        let item = task.item;
        let targets = self.targets(item)?;
        let text = self.plan.scene_text(item)?;
        let loaded = self.session.assets.parse(&text, Path::new(&item.name), self.plan.folder());
        let mut loaded = loaded.map_err(without_line)?;
        loaded.name.clone_from(&item.name);
        let inputs = loaded.files.iter().map(|file| file.path.as_path());
        output::refuse_overlap(targets.iter().map(Target::path), inputs)?;
        self.plan.overrides().apply(&mut loaded);
        let scene = self.session.prepare(&loaded.scene, &loaded.settings)?;
        loaded.scene.stones = Vec::new();
        let inputs =
            loaded.files.iter().map(|file| FileRecord::of_source(file, self.plan.folder())).collect();
        let warnings = loaded.warnings.iter().chain(&scene.warnings).map(ToString::to_string).collect();
        let (film, rendered) = self.session.film(&scene, &mut *self.observer)?;
        let picture = rendered.picture(film, &scene, &loaded, self.plan.pictures().options);
        let outputs = self.write(item, &targets, &picture)?;
        let report = &rendered.traced;
        Ok(Done {
            item: item.name.clone(),
            identity: task.identity.clone(),
            values: item.values.clone(),
            inputs,
            outputs,
            scene_hash: loaded.hash,
            settings: output::settings(rendered.shown(&scene)),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            devices: rendered.devices.iter().map(output::device).collect(),
            choice: rendered.reason,
            rays: report.rays,
            energy: output::energy(&report.energy),
            seconds: Seconds {
                total: start.elapsed().as_secs_f64(),
                build: report.build.as_secs_f64(),
                trace: report.trace.as_secs_f64(),
            },
            warnings,
        })
    }

    /// The item's files, which can be written as far as can be known before.
    fn targets(&self, item: &Item) -> Result<Vec<Target>, Error> {
        let target = |(name, _)| {
            let path = self.place.output.join(name);
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)
                    .map_err(|e| Error::output(folder, format!("this folder cannot be made ({e})")))?;
            }
            let target = Target::new(path)?;
            target.check()?;
            Ok(target)
        };
        self.plan.files(item).map(target).collect()
    }

    fn write(&self, item: &Item, targets: &[Target], picture: &Picture) -> Result<Vec<FileRecord>, Error> {
        let names = self.plan.files(item).map(|(name, _)| name);
        let write = |(target, name): (&Target, String)| {
            picture.write(target)?;
            FileRecord::of(&name, target.path())
        };
        targets.iter().zip(names).map(write).collect()
    }
}

/// The scene of an item is in no file: what is wrong with it has no line to look at.
fn without_line(error: Error) -> Error {
    match error {
        Error::Scene { message, .. } => Error::Item(message),
        other => other,
    }
}
