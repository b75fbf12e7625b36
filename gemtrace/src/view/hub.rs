//! What goes out to the pages: to each the newest of everything, and never a queue of pictures.

use super::message::Letter;
use serde_json::Value;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// A message with a picture, ready to be sent.
pub type Bytes = Arc<[u8]>;

/// The most answers that wait for a page; older ones are dropped, since a page that takes none is not there any more.
const WAITING: usize = 64;

/// What waits for one page.
#[derive(Default)]
struct Waiting {
    state: Option<Arc<str>>,
    status: [Option<Arc<str>>; 2],
    pictures: [Option<Bytes>; 2],
    answers: VecDeque<Arc<str>>,
    /// Whether the page has yet to draw the last picture.
    busy: bool,
    /// Whether the connection has ended.
    gone: bool,
}

/// One page.
#[derive(Default)]
pub struct Client {
    waiting: Mutex<Waiting>,
    news: Notify,
}

/// What is sent next.
pub enum Next {
    Text(Arc<str>),
    Picture(Bytes),
}

impl Client {
    /// Sends an answer to this page alone.
    pub fn answer(&self, message: &Value) {
        self.put(message.to_string().into());
    }

    fn put(&self, text: Arc<str>) {
        let mut waiting = locked(&self.waiting);
        if waiting.answers.len() == WAITING {
            waiting.answers.pop_front();
        }
        waiting.answers.push_back(text);
        self.news.notify_one();
    }

    /// Whether the connection has ended.
    pub fn is_gone(&self) -> bool {
        locked(&self.waiting).gone
    }

    /// What has not been sent yet, where the connection is about to end.
    pub fn last_words(&self) -> Vec<Arc<str>> {
        locked(&self.waiting).answers.drain(..).collect()
    }

    /// The page has drawn a picture.
    pub fn shown(&self) {
        locked(&self.waiting).busy = false;
        self.news.notify_one();
    }

    /// Waits for something to send.
    pub async fn next(&self) -> Next {
        loop {
            if let Some(next) = self.take() {
                return next;
            }
            self.news.notified().await;
        }
    }

    fn take(&self) -> Option<Next> {
        let mut waiting = locked(&self.waiting);
        // An answer first: an error stands before the state that it left.
        let text = waiting.answers.pop_front().or_else(|| waiting.state.take());
        let text = text.or_else(|| waiting.status.iter_mut().find_map(Option::take));
        if let Some(text) = text {
            return Some(Next::Text(text));
        }
        let picture = (!waiting.busy).then(|| waiting.pictures.iter_mut().find_map(Option::take))??;
        waiting.busy = true;
        Some(Next::Picture(picture))
    }

    fn tell(&self, change: impl FnOnce(&mut Waiting)) {
        change(&mut locked(&self.waiting));
        self.news.notify_one();
    }
}

/// All pages, and what one that comes later must know.
#[derive(Default)]
pub struct Hub(Mutex<Latest>);

#[derive(Default)]
struct Latest {
    clients: Vec<Arc<Client>>,
    hello: Option<Arc<str>>,
    state: Option<Arc<str>>,
    status: [Option<Arc<str>>; 2],
    pictures: [Option<Bytes>; 2],
}

impl Hub {
    /// A page that has said hello: it gets all there is.
    pub fn join(&self, client: &Arc<Client>) {
        let mut latest = locked(&self.0);
        if client.is_gone() || latest.clients.iter().any(|other| Arc::ptr_eq(other, client)) {
            return;
        }
        client.tell(|waiting| {
            waiting.answers.extend(latest.hello.clone());
            waiting.answers.extend(latest.state.clone());
            (waiting.status, waiting.pictures) = (latest.status.clone(), latest.pictures.clone());
        });
        latest.clients.push(Arc::clone(client));
    }

    pub fn leave(&self, client: &Arc<Client>) {
        client.tell(|waiting| waiting.gone = true);
        locked(&self.0).clients.retain(|other| !Arc::ptr_eq(other, client));
    }

    /// The first message to every page.
    pub fn set_hello(&self, message: &Value) {
        locked(&self.0).hello = Some(message.to_string().into());
    }

    pub fn state(&self, message: &Value) {
        let (mut latest, text) = (locked(&self.0), Arc::<str>::from(message.to_string()));
        latest.clients.iter().for_each(|client| client.tell(|waiting| waiting.state = Some(text.clone())));
        latest.state = Some(text);
    }

    pub fn status(&self, side: Letter, message: &Value) {
        let (mut latest, text) = (locked(&self.0), Arc::<str>::from(message.to_string()));
        let side = side as usize;
        latest.clients.iter().for_each(|client| client.tell(|w| w.status[side] = Some(text.clone())));
        latest.status[side] = Some(text);
    }

    pub fn picture(&self, side: Letter, picture: Bytes) {
        let (mut latest, side) = (locked(&self.0), side as usize);
        latest.clients.iter().for_each(|client| client.tell(|w| w.pictures[side] = Some(picture.clone())));
        latest.pictures[side] = Some(picture);
    }

    /// There is no such side any more.
    pub fn forget(&self, side: Letter) {
        let (mut latest, side) = (locked(&self.0), side as usize);
        (latest.status[side], latest.pictures[side]) = (None, None);
        let forget = |waiting: &mut Waiting| (waiting.status[side], waiting.pictures[side]) = (None, None);
        latest.clients.iter().for_each(|client| client.tell(forget));
    }

    /// To every page.
    pub fn tell(&self, message: &Value) {
        let text = Arc::<str>::from(message.to_string());
        locked(&self.0).clients.iter().for_each(|client| client.put(text.clone()));
    }
}

/// A lock that outlives a panic of whoever held it: what it guards is replaced as a whole.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
