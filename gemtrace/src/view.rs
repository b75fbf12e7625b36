//! A live view of a scene, in any browser: a server that this machine alone can ask, and its page.
//!
//! ```text
//! browser ◄──► server (axum) ──► inbox ──► desk: documents ──► session ──► film
//!    ▲            │ questions                   │ pictures, states
//!    └──── hub ◄──┴──────── inquiry ◄── sights ─┘
//! ```
//!
//! * The state is two scene [documents](crate::scene_file::Draft), so that what is saved renders what was seen.
//! * One thread owns the session and renders: while something moves, as much as fits in the time of a frame; at rest the
//!   picture that `gemtrace render` writes. What is newer breaks it off.
//! * Questions (a pixel, a curve, a file) are answered on another thread, from what was seen last.
//! * Nothing is queued: a page that is slow gets the newest of everything.
//!
//! `docs/view-protocol.md` describes what page and server say to each other.

mod curve;
mod description;
mod desk;
mod display;
mod document;
mod export;
mod guard;
mod hub;
mod inbox;
mod inquiry;
mod lists;
mod message;
mod opening;
mod pace;
mod page;
mod pixel;
mod server;
mod setting;
mod side;
mod sight;
mod solid;
mod store;
mod swatch;
mod watch;

use crate::scene_file::Assets;
use crate::{Error, Session, registry};
use desk::Desk;
use document::{Document, History};
use export::Export;
use guard::Guard;
use hub::Hub;
use inbox::{Inbox, Sessions};
use inquiry::Inquiry;
use lists::Lists;
use serde_json::{Value, json};
use sight::Sights;
use spectral_core::tracer::OpenOptions;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use store::Store;

/// Decoded files that are kept although the scene no longer names them: what was chosen a moment ago.
const RESTING: usize = 8;
/// Device pixels of a view before a page says its own.
const SIZE: [u32; 2] = [512, 512];

/// How a view is opened.
#[derive(Debug, Clone)]
pub struct Options {
    /// What renders, as [`registry::choose`] has it.
    pub backend: String,
    /// Which of its devices.
    pub device: Option<usize>,
    /// How devices are opened.
    pub open: OpenOptions,
    /// The address to listen at; anything but loopback lets other machines in that know the token.
    pub listen: IpAddr,
    /// The port; 0 takes a free one.
    pub port: u16,
    /// The folder whose files may be read.
    pub start: PathBuf,
    /// The folder that pictures and scenes are saved to.
    pub output: PathBuf,
}

impl Default for Options {
    /// Any device, this machine alone, the current folder.
    fn default() -> Self {
        Options {
            backend: registry::AUTO.to_owned(),
            device: None,
            open: OpenOptions::default(),
            listen: Ipv4Addr::LOCALHOST.into(),
            port: 0,
            start: PathBuf::from("."),
            output: PathBuf::from("views"),
        }
    }
}

/// A view whose server is ready to be asked.
pub struct View {
    server: server::Server,
    address: SocketAddr,
}

impl View {
    /// Opens scenes, cuts and meshes: the first as A, a second as B beside it; what follows is listed. Rendering begins at
    /// once.
    ///
    /// # Errors
    /// [`Error::Usage`] for a device that is not there, [`Error::Output`] for an address that cannot be listened at, and what
    /// is wrong with the files.
    pub fn open(files: &[PathBuf], options: &Options) -> Result<Self, Error> {
        let (listener, address) = listen(SocketAddr::new(options.listen, options.port))?;
        let guard = Guard::new(!options.listen.is_loopback()).map_err(|e| Error::output("the token", e))?;
        let store = Arc::new(Store::new(&options.start, &std::env::temp_dir())?);
        let (hub, inbox, sights) = (Arc::<Hub>::default(), Arc::<Inbox>::default(), Arc::<Sights>::default());
        let (backend, device, open) = (options.backend.clone(), options.device, options.open);
        // A device that is not there is said before anything is shown.
        registry::choose(&backend, device)?;
        let sessions: Sessions =
            Arc::new(move || Ok(Session::new(registry::choose(&backend, device)?, open)));
        let export = Arc::new(Export {
            store: Arc::clone(&store),
            sights: Arc::clone(&sights),
            sessions: Arc::clone(&sessions),
            folder: options.output.clone(),
            written: Mutex::default(),
            last: Mutex::default(),
        });
        let busy = Arc::clone(&sights);
        let inquiry = Inquiry::start(&sights, &export, move || busy.is_busy())?;
        let desk = desk(files, options, sessions, (&store, &hub, &inbox, &sights))?;
        std::thread::Builder::new()
            .name("view".to_owned())
            .spawn(move || desk.run())
            .map_err(|e| Error::output("a thread", format!("cannot be started ({e})")))?;
        let server = server::Server {
            listener,
            guard,
            hub,
            inbox,
            store,
            inquiry,
            export,
            swatches: swatch::Swatches::default(),
            uploads: tokio::sync::Semaphore::new(server::UPLOADS),
        };
        Ok(View { server, address })
    }

    /// The address of the page, with the token.
    pub fn address(&self) -> String {
        format!("http://{}/?token={}", self.address, self.server.guard.token())
    }

    /// Serves pages until `stop` says so, which is asked several times a second.
    ///
    /// # Errors
    /// [`Error::Output`] where the system has no more connections.
    pub fn serve(self, stop: &dyn Fn() -> bool) -> Result<(), Error> {
        server::serve(self.server, stop)
    }
}

/// Listens at an address; which one it is, where any port was asked for.
fn listen(address: SocketAddr) -> Result<(TcpListener, SocketAddr), Error> {
    let bind =
        |e| Error::output(address.to_string(), format!("cannot be listened at ({e}); choose another port"));
    let listener = TcpListener::bind(address).map_err(bind)?;
    let address = listener.local_addr().map_err(bind)?;
    Ok((listener, address))
}

/// The desk with the files on it.
fn desk(
    files: &[PathBuf],
    options: &Options,
    sessions: Sessions,
    (store, hub, inbox, sights): (&Arc<Store>, &Arc<Hub>, &Arc<Inbox>, &Arc<Sights>),
) -> Result<Desk, Error> {
    let mut assets = Assets::keeping(RESTING, store.gate());
    let mut lists = Lists::new(store);
    let mut opened = Vec::new();
    for file in files {
        let path = file.canonicalize();
        let path = path.as_deref().unwrap_or(file);
        opened.push(opening::open(path, true, store, &mut lists, &mut assets)?);
    }
    let mut opened = opened.into_iter();
    let first = opened.next().unwrap_or_else(opening::nothing);
    let document = Document { sides: [Some(first), opened.next()], auto: false };
    let output = options.output.display().to_string();
    let hello = Box::new(move |lists: &Lists| hello(lists, &output));
    let mut desk = Desk {
        history: History::new(document),
        lists,
        store: Arc::clone(store),
        assets,
        inbox: Arc::clone(inbox),
        hub: Arc::clone(hub),
        sights: Arc::clone(sights),
        sessions,
        hello,
        sides: [None, None],
        size: SIZE,
        answers: 0,
    };
    desk.begin()?;
    Ok(desk)
}

/// The message `hello`.
fn hello(lists: &Lists, output: &str) -> Value {
    json!({
        "type": "hello", "protocol": message::PROTOCOL, "program": concat!("gemtrace ", env!("CARGO_PKG_VERSION")),
        "lists": lists.json(), "limits": { "upload": store::LARGEST }, "output": output,
    })
}
