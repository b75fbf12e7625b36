//! The server: whom it lets in, the page's files, dropped files, and a connection for each page.

use super::export::{self, Export};
use super::guard::Guard;
use super::hub::{Client, Hub, Next};
use super::inbox::{Inbox, Order};
use super::inquiry::Inquiry;
use super::message::{Ask, Format, Letter, PROTOCOL, Page, Refusal};
use super::page;
use super::store::{LARGEST, Store};
use super::swatch::Swatches;
use crate::Error;
use axum::body::Body;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{Path, Query, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next as Inner};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Router, serve as axum_serve};
use serde::Deserialize;
use serde_json::json;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{Semaphore, oneshot};

/// What the server has at hand.
pub struct Server {
    pub listener: std::net::TcpListener,
    pub guard: Guard,
    pub hub: Arc<Hub>,
    pub inbox: Arc<Inbox>,
    pub store: Arc<Store>,
    pub inquiry: Inquiry,
    pub export: Arc<Export>,
    pub swatches: Swatches,
    /// How many files may be on their way at a time: each is in memory as a whole.
    pub uploads: Semaphore,
}

/// Files that may be on their way at a time.
pub const UPLOADS: usize = 2;

/// How often it is asked whether to stop.
const TICK: Duration = Duration::from_millis(50);
/// A page that takes nothing for so long is gone.
const PATIENCE: Duration = Duration::from_secs(30);
/// A file that takes longer to come is not waited for.
const UPLOAD: Duration = Duration::from_secs(300);
/// The largest message of a page, bytes.
const MESSAGE: usize = 64 << 10;
/// Edges of a view, device pixels.
const EDGES: std::ops::RangeInclusive<u32> = 16..=4096;

/// Serves until `stop` says so.
pub fn serve(server: Server, stop: &dyn Fn() -> bool) -> Result<(), Error> {
    let failed = |e: std::io::Error| Error::output("the server", format!("cannot be run ({e})"));
    server.listener.set_nonblocking(true).map_err(failed)?;
    let store = Arc::clone(&server.store);
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build().map_err(failed)?;
    let served = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(server.listener.try_clone().map_err(failed)?);
        let routes = routes(Arc::new(server));
        let listener = listener.map_err(failed)?;
        let stopped = async {
            while !stop() {
                tokio::time::sleep(TICK).await;
            }
        };
        tokio::select! {
            served = async { axum_serve(listener, routes).await } => served.map_err(failed),
            () = stopped => Ok(()),
        }
    });
    // Other threads hold it until the process ends.
    store.clear();
    served
}

fn routes(server: Arc<Server>) -> Router {
    Router::new()
        .route("/", get(index))
        .route("/page/{token}/{name}", get(file))
        .route("/live", get(live))
        .route("/drop", post(dropped))
        .route("/save", get(saved))
        .route("/saved/{name}", get(written))
        .route("/swatch/{name}", get(swatch))
        .layer(middleware::from_fn_with_state(Arc::clone(&server), guarded))
        .with_state(server)
}

/// What every request must have.
#[derive(Deserialize)]
struct Token {
    #[serde(default)]
    token: String,
    #[serde(default)]
    embed: Option<String>,
}

/// Lets in only what knows the token and comes from here, and says how the page may be used.
async fn guarded(State(server): State<Arc<Server>>, request: Request, inner: Inner) -> Response {
    if let Err((status, why)) = server.guard.check(request.headers()) {
        return (status, why).into_response();
    }
    let path = request.uri().path().to_owned();
    let query = Query::<Token>::try_from_uri(request.uri()).map(|query| query.0).ok();
    let in_path = path.strip_prefix("/page/").and_then(|rest| rest.split('/').next());
    let token = in_path.or(query.as_ref().map(|query| query.token.as_str())).unwrap_or_default();
    if !server.guard.knows(token) {
        let why = "this address lacks the token; open the address that gemtrace view printed";
        return (StatusCode::FORBIDDEN, why).into_response();
    }
    let embedded = query.is_some_and(|query| query.embed.is_some());
    let mut response = inner.run(request).await;
    protect(response.headers_mut(), embedded);
    response
}

/// Nothing from elsewhere, no other page around it unless it is embedded, and no address of it in what it asks for.
fn protect(headers: &mut HeaderMap, embedded: bool) {
    let policy = if embedded {
        "default-src 'self'; img-src 'self' blob: data:; connect-src 'self'"
    } else {
        "default-src 'self'; img-src 'self' blob: data:; connect-src 'self'; frame-ancestors 'none'"
    };
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, policy),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if !embedded {
        headers.insert("cross-origin-resource-policy", HeaderValue::from_static("same-origin"));
    }
}

/// The page, in whose links the token stands.
async fn index(State(server): State<Arc<Server>>) -> Response {
    let file = page::file("index.html").map_or(&b""[..], |file| file.bytes);
    let text = String::from_utf8_lossy(file).replace("{{token}}", server.guard.token());
    ([(header::CONTENT_TYPE, "text/html; charset=utf-8")], text).into_response()
}

async fn file(Path((_, name)): Path<(String, String)>, headers: HeaderMap) -> Response {
    let Some(file) = page::file(&name) else {
        return (StatusCode::NOT_FOUND, "no such file").into_response();
    };
    let accepted = headers.get(header::ACCEPT_ENCODING).and_then(|accepted| accepted.to_str().ok());
    let kind = (header::CONTENT_TYPE, file.kind);
    if accepted.is_some_and(|accepted| accepted.contains("gzip")) {
        return ([kind, (header::CONTENT_ENCODING, "gzip")], file.packed()).into_response();
    }
    ([kind], file.bytes).into_response()
}

/// Where a dropped file goes.
#[derive(Deserialize)]
struct Drop {
    name: String,
    #[serde(default)]
    side: String,
}

/// Takes a dropped file; one that is too large is refused before any of it is read.
async fn dropped(
    State(server): State<Arc<Server>>,
    Query(dropped): Query<Drop>,
    headers: HeaderMap,
    body: Body,
) -> Response {
    let refuse = |why: String| Refusal {
        what: format!("{} was not opened", spectral_core::shown(&dropped.name)),
        why,
        unchanged: "the stone is unchanged".to_owned(),
        code: "size",
        ..Refusal::default()
    };
    let bytes = match received(&server.uploads, &headers, body).await {
        Ok(bytes) => bytes,
        Err((status, why)) => return refused(status, &refuse(why)),
    };
    let path = match server.store.keep(&dropped.name, &bytes) {
        Ok(path) => path,
        Err(refusal) => return refused(StatusCode::UNPROCESSABLE_ENTITY, &refusal),
    };
    let side = Letter::ALL.into_iter().find(|letter| letter.name() == dropped.side);
    let (reply, answer) = oneshot::channel();
    if !server.inbox.put(Order::Dropped { path, side, reply }) {
        return refused(StatusCode::SERVICE_UNAVAILABLE, &refuse("too much is asked for at once".to_owned()));
    }
    match answer.await {
        Ok(Ok(())) => (StatusCode::OK, json_type(), "{}").into_response(),
        Ok(Err(refusal)) => refused(StatusCode::UNPROCESSABLE_ENTITY, &refusal),
        Err(_) => refused(StatusCode::INTERNAL_SERVER_ERROR, &refuse("the view has ended".to_owned())),
    }
}

/// The bytes of a dropped file, or why they are not taken.
async fn received(
    uploads: &Semaphore,
    headers: &HeaderMap,
    body: Body,
) -> Result<axum::body::Bytes, (StatusCode, String)> {
    let length =
        headers.get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    let large = || (StatusCode::PAYLOAD_TOO_LARGE, format!("files of up to {} MB are taken", LARGEST >> 20));
    if length.is_some_and(|length| length > LARGEST) {
        return Err(large());
    }
    // It is never closed.
    let _turn = uploads.acquire().await;
    let bytes = tokio::time::timeout(UPLOAD, axum::body::to_bytes(body, LARGEST as usize)).await;
    let bytes = bytes.map_err(|_| (StatusCode::REQUEST_TIMEOUT, "it came too slowly".to_owned()))?;
    bytes.map_err(|_| large())
}

/// What is downloaded.
#[derive(Deserialize)]
struct Save {
    format: String,
    side: String,
}

async fn saved(State(server): State<Arc<Server>>, Query(save): Query<Save>) -> Response {
    let side = Letter::ALL.into_iter().find(|letter| letter.name() == save.side);
    let (Some(side), Some(format)) = (side, Format::by_name(&save.format)) else {
        return (StatusCode::BAD_REQUEST, "a format is png, exr, spectral-exr, scene or turn, a side A or B")
            .into_response();
    };
    let export = Arc::clone(&server.export);
    match beside(move || export.download(side, format)).await {
        Ok(Ok((name, bytes))) => attached(&name, bytes),
        Ok(Err(error)) => refused(StatusCode::UNPROCESSABLE_ENTITY, &export::refused(&error)),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

/// A file that was saved before.
async fn written(State(server): State<Arc<Server>>, Path(name): Path<String>) -> Response {
    let (export, asked) = (Arc::clone(&server.export), name.clone());
    match beside(move || export.saved(&asked)).await {
        Ok(Some(Ok(bytes))) => attached(&name, bytes),
        Ok(Some(Err(error))) => refused(StatusCode::UNPROCESSABLE_ENTITY, &export::refused(&error)),
        _ => (StatusCode::NOT_FOUND, "nothing was saved under this name").into_response(),
    }
}

/// A download.
fn attached(name: &str, bytes: Vec<u8>) -> Response {
    let kind = match name.rsplit('.').next() {
        Some("png") => "image/png",
        Some("exr") => "image/x-exr",
        _ => "application/toml",
    };
    let place = format!("attachment; filename=\"{name}\"");
    ([(header::CONTENT_TYPE, kind.to_owned()), (header::CONTENT_DISPOSITION, place)], bytes).into_response()
}

/// Does what takes long on a thread of its own, so that others are answered meanwhile.
async fn beside<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, oneshot::error::RecvError> {
    let (reply, answer) = oneshot::channel();
    std::thread::spawn(move || drop(reply.send(work())));
    answer.await
}

/// A small picture of a material.
async fn swatch(State(server): State<Arc<Server>>, Path(name): Path<String>) -> Response {
    let made = beside(move || server.swatches.get(name.trim_end_matches(".png"))).await;
    match made {
        Ok(Ok(png)) => ([(header::CONTENT_TYPE, "image/png")], png.to_vec()).into_response(),
        _ => (StatusCode::NOT_FOUND, "no such material").into_response(),
    }
}

fn json_type() -> [(header::HeaderName, &'static str); 1] {
    [(header::CONTENT_TYPE, "application/json")]
}

fn refused(status: StatusCode, refusal: &Refusal) -> Response {
    (status, json_type(), json!({ "error": refusal.to_json() }).to_string()).into_response()
}

/// A page's connection.
async fn live(State(server): State<Arc<Server>>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .max_message_size(MESSAGE)
        .max_frame_size(MESSAGE)
        .on_upgrade(move |socket| connected(server, socket))
}

async fn connected(server: Arc<Server>, mut socket: WebSocket) {
    let client = Arc::new(Client::default());
    while tokio::select! {
        message = socket.recv() => match message {
            Some(Ok(message)) => hear(&server, &client, &message),
            Some(Err(error)) => {
                complain(&client, &format!("{error}; messages have up to {} kB", MESSAGE >> 10));
                false
            }
            None => false,
        },
        next = client.next() => send(&mut socket, next).await,
    } {}
    server.hub.leave(&client);
    for text in client.last_words() {
        if !send(&mut socket, Next::Text(text)).await {
            return;
        }
    }
    // It may have gone already.
    drop(tokio::time::timeout(PATIENCE, socket.send(Message::Close(None))).await);
}

/// Sends what is next; returns whether the page takes it.
async fn send(socket: &mut WebSocket, next: Next) -> bool {
    let message = match next {
        Next::Text(text) => Message::Text((&*text).into()),
        Next::Picture(bytes) => Message::Binary(axum::body::Bytes::from_owner(bytes)),
    };
    matches!(tokio::time::timeout(PATIENCE, socket.send(message)).await, Ok(Ok(())))
}

/// Takes a message of a page; returns whether the connection goes on.
fn hear(server: &Server, client: &Arc<Client>, message: &Message) -> bool {
    let text = match message {
        Message::Text(text) => text.as_str(),
        Message::Close(_) => return false,
        Message::Binary(_) => return complain(client, "messages are JSON text"),
        _ => return true,
    };
    match Ask::parse(text) {
        Ok(Ask::Page(Page::Hello { protocol: PROTOCOL, width, height })) => {
            server.inbox.put(Order::Hello(Arc::clone(client), [width, height].map(within)))
        }
        Ok(Ask::Page(Page::Hello { .. })) => {
            complain(
                client,
                &format!("this server speaks version {PROTOCOL} of the protocol; load the page again"),
            );
            false
        }
        Ok(Ask::Page(Page::Size { width, height })) => {
            server.inbox.put(Order::Size([width, height].map(within)))
        }
        Ok(Ask::Page(Page::Shown {})) => {
            client.shown();
            true
        }
        Ok(Ask::Change(change)) => {
            server.inbox.put(Order::Change(Arc::clone(client), change))
                || complain(client, "too much is asked for at once")
        }
        Ok(Ask::Question(question)) => {
            server.inquiry.ask(client, question) || complain(client, "too much is asked for at once")
        }
        Err(error) => complain(client, &format!("not a message of this protocol: {error}")),
    }
}

fn within(edge: u32) -> u32 {
    edge.clamp(*EDGES.start(), *EDGES.end())
}

/// Says what is wrong with a message.
fn complain(client: &Client, why: &str) -> bool {
    let refusal = Refusal {
        what: "a message was not understood".to_owned(),
        why: why.to_owned(),
        unchanged: "nothing is changed".to_owned(),
        code: "protocol",
        ..Refusal::default()
    };
    client.answer(&refusal.to_json());
    true
}
