//! What waits to be done: the newest of each gesture, in order.

use super::hub::{Client, locked};
use super::message::{Change, Letter, Refusal};
use crate::{Error, Session};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::oneshot;

/// The most that waits; then the page is told that it asks too fast.
const MOST: usize = 1000;
/// A time after which one may as well wait again.
const LONG: Duration = Duration::from_secs(3600);

/// Makes sessions with the devices that were asked for.
pub type Sessions = Arc<dyn Fn() -> Result<Session, Error> + Send + Sync>;

/// Something that changes what is shown.
pub enum Order {
    Change(Arc<Client>, Change),
    /// A page that comes, with the device pixels of one view.
    Hello(Arc<Client>, [u32; 2]),
    /// Device pixels of one view.
    Size([u32; 2]),
    /// A file that was dropped; without a side it is opened in place of what is there.
    Dropped {
        path: PathBuf,
        side: Option<Letter>,
        reply: oneshot::Sender<Result<(), Refusal>>,
    },
}

/// Something that waits, and may be overtaken by the next of its kind.
pub trait Overtaken {
    /// Whether `next` makes this needless.
    fn by(&self, next: &Self) -> bool;
}

/// What waits for one thread.
pub struct Queue<T> {
    waiting: Mutex<VecDeque<T>>,
    news: Condvar,
}

/// What waits for the desk.
pub type Inbox = Queue<Order>;

impl<T> Default for Queue<T> {
    fn default() -> Self {
        Queue { waiting: Mutex::default(), news: Condvar::new() }
    }
}

impl<T: Overtaken> Queue<T> {
    /// Adds something; returns whether there was room.
    pub fn put(&self, item: T) -> bool {
        let mut waiting = locked(&self.waiting);
        if waiting.back().is_some_and(|last| last.by(&item)) {
            waiting.pop_back();
        }
        if waiting.len() == MOST {
            return false;
        }
        waiting.push_back(item);
        self.news.notify_all();
        true
    }

    /// Whether something waits.
    pub fn is_waiting(&self) -> bool {
        !locked(&self.waiting).is_empty()
    }

    /// All that waits.
    pub fn take(&self) -> VecDeque<T> {
        std::mem::take(&mut locked(&self.waiting))
    }

    /// Waits until something waits, and takes the first.
    pub fn next(&self) -> T {
        let mut waiting = locked(&self.waiting);
        loop {
            if let Some(first) = waiting.pop_front() {
                return first;
            }
            waiting = self.news.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits until something waits.
    pub fn wait(&self) {
        while self.is_quiet(LONG) {}
    }

    /// Waits for a time; returns whether nothing has come.
    pub fn is_quiet(&self, time: Duration) -> bool {
        let waiting = locked(&self.waiting);
        let none = |waiting: &mut VecDeque<T>| waiting.is_empty();
        let waited = self.news.wait_timeout_while(waiting, time, none);
        waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }
}

impl Overtaken for Order {
    fn by(&self, next: &Self) -> bool {
        is_overtaken(self, next)
    }
}

/// Whether the next order of a gesture makes the last one needless.
fn is_overtaken(last: &Order, next: &Order) -> bool {
    match (last, next) {
        (Order::Size(_), Order::Size(_)) => true,
        (Order::Change(_, last), Order::Change(_, next)) => match (last, next) {
            (Change::Pose { done: false, .. }, Change::Pose { .. })
            | (Change::Lights { done: false, .. }, Change::Lights { .. })
            | (Change::Distance { done: false, .. }, Change::Distance { .. }) => true,
            (Change::Set { path: a, side: on, done: false, .. }, Change::Set { path: b, side, .. }) => {
                (a, on) == (b, side)
            }
            _ => false,
        },
        _ => false,
    }
}
