//! A view, and a page that speaks its protocol without a browser.

use gemtrace::view::{Options, View};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// What no message may take longer than.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// A small scene: nine samples, so that it settles at once.
pub const SCENE: &str = "format = 1\n[camera]\nposition = [0, -12, 26]\nlook_at = [0, 0, -0.4]\n\
    [render]\nsamples = 9\n[[stone]]\nshape = \"round-brilliant\"\nwidth = 6.5\nmaterial = \"diamond\"\n";

/// A running view with a folder of its own.
pub struct Running {
    pub folder: tempfile::TempDir,
    pub host: String,
    pub token: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    /// A view of [`SCENE`], in a folder with these files.
    pub fn new(files: &[(&str, &[u8])]) -> Self {
        Running::of("scene.toml", files)
    }

    /// A view of one of the files.
    pub fn of(opened: &str, files: &[(&str, &[u8])]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        std::fs::write(place("scene.toml"), SCENE).unwrap();
        for (name, bytes) in files {
            std::fs::create_dir_all(place(name).parent().unwrap()).unwrap();
            std::fs::write(place(name), bytes).unwrap();
        }
        let options = Options {
            backend: "cpu".to_owned(),
            start: folder.path().to_owned(),
            output: place("views"),
            ..Options::default()
        };
        let view = View::open(&[place(opened)], &options).unwrap();
        let address = view.address();
        let (host, token) = address.strip_prefix("http://").unwrap().split_once("/?token=").unwrap();
        let (host, token) = (host.to_owned(), token.to_owned());
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || view.serve(&|| stopped.load(Ordering::Relaxed)).unwrap());
        Running { folder, host, token, stop, thread: Some(thread) }
    }

    pub fn place(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A request as it stands on the line; the answer's status and all of it.
    pub fn request(&self, head: &str, body: &[u8]) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(head.replace('\n', "\r\n").as_bytes()).unwrap();
        // A server that refuses does not read all of it.
        let _ = stream.write_all(body);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let text = String::from_utf8_lossy(&answer);
        let status = text.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        (status, answer)
    }

    pub fn get(&self, path: &str) -> (u16, Vec<u8>) {
        self.request(&format!("GET {path} HTTP/1.1\nHost: {}\nConnection: close\n\n", self.host), &[])
    }

    /// The body of what is there under a path, with the token.
    pub fn body(&self, path: &str) -> Vec<u8> {
        let joint = if path.contains('?') { '&' } else { '?' };
        let (status, answer) = self.get(&format!("{path}{joint}token={}", self.token));
        assert_eq!(status, 200, "{path}: {}", String::from_utf8_lossy(&answer));
        let end = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n").unwrap();
        answer[end + 4..].to_vec()
    }

    /// Drops a file; the answer's status and text.
    pub fn drop_file(&self, name: &str, side: &str, bytes: &[u8]) -> (u16, String) {
        let (host, token, length) = (&self.host, &self.token, bytes.len());
        let head = format!(
            "POST /drop?name={name}&side={side}&token={token} HTTP/1.1\nHost: {host}\nContent-Length: {length}\n\
             Connection: close\n\n"
        );
        let (status, answer) = self.request(&head, bytes);
        (status, String::from_utf8_lossy(&answer).into_owned())
    }

    /// A page of 64 × 48 pixels.
    pub fn page(&self) -> Page {
        let mut page = Page::connect(&self.host, &self.token, None).unwrap();
        page.hello([64, 48]);
        page
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

/// A picture that came.
pub struct Picture {
    pub header: Value,
    pub bytes: Vec<u8>,
}

/// One connection.
pub struct Page {
    socket: WebSocket<TcpStream>,
    id: u64,
    /// Of a view, pixels.
    size: [f64; 2],
}

/// What comes from the server.
pub enum News {
    Text(Value),
    Picture(Picture),
}

impl Page {
    pub fn connect(host: &str, token: &str, origin: Option<&str>) -> Result<Self, String> {
        let mut request = format!("ws://{host}/live?token={token}").into_client_request().unwrap();
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().unwrap());
        }
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_nodelay(true).unwrap();
        let (socket, _) = tungstenite::client(request, stream).map_err(|e| e.to_string())?;
        Ok(Page { socket, id: 0, size: [1.0; 2] })
    }

    pub fn hello(&mut self, [width, height]: [u32; 2]) {
        self.size = [width, height].map(f64::from);
        self.say(json!({ "type": "hello", "protocol": 1, "width": width, "height": height }));
    }

    pub fn say(&mut self, message: Value) {
        self.socket.send(Message::text(message.to_string())).unwrap();
    }

    /// What is no message of the protocol.
    pub fn send(&mut self, message: Message) {
        // The server may have ended the connection.
        drop(self.socket.send(message));
    }

    /// The same with a new id.
    pub fn ask(&mut self, mut message: Value) -> u64 {
        self.id += 1;
        message["id"] = self.id.into();
        self.say(message);
        self.id
    }

    pub fn set(&mut self, path: &str, value: Value) -> u64 {
        self.ask(json!({ "type": "set", "path": path, "value": value, "side": "A", "done": true }))
    }

    /// The next message; pictures are acknowledged.
    pub fn next(&mut self) -> News {
        self.read().expect("a message comes")
    }

    /// Whether a picture is of this page's size, or smaller: the first may have been rendered before the page came.
    fn is_own(&self, header: &Value) -> bool {
        let [width, height] = [&header["width"], &header["height"]].map(|v| v.as_f64().unwrap());
        (width / height / (self.size[0] / self.size[1]) - 1.0).abs() < 0.1
    }

    /// The same; `None` where the connection ends.
    pub fn read(&mut self) -> Option<News> {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => return Some(News::Text(serde_json::from_str(&text).unwrap())),
                Ok(Message::Binary(bytes)) => {
                    let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
                    let header: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
                    self.send(Message::text(json!({ "type": "shown" }).to_string()));
                    return Some(News::Picture(Picture { header, bytes: bytes[4 + length..].to_vec() }));
                }
                Ok(_) => {}
                Err(_) => return None,
            }
        }
    }

    /// The next message of a type.
    pub fn wait(&mut self, kind: &str) -> Value {
        self.wait_for(|message| message["type"] == kind)
    }

    pub fn wait_for(&mut self, mut wanted: impl FnMut(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            assert!(start.elapsed() < PATIENCE, "it does not come");
            match self.next() {
                News::Text(message) if wanted(&message) => return message,
                _ => {}
            }
        }
    }

    /// The next picture that shows change `answers` or a newer one, at a stage.
    pub fn picture(&mut self, stage: &str, answers: u64) -> Picture {
        let start = Instant::now();
        loop {
            assert!(start.elapsed() < PATIENCE, "no picture comes");
            if let News::Picture(picture) = self.next()
                && picture.header["stage"] == stage
                && picture.header["answers"].as_u64().unwrap() >= answers
                && self.is_own(&picture.header)
            {
                return picture;
            }
        }
    }
}

/// The size and the RGBA bytes of a PNG.
pub fn decoded(png: &[u8]) -> ([u32; 2], Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    ([info.width, info.height], pixels)
}

/// The PNG that `gemtrace render` would write for a scene file.
pub fn rendered(scene: &Path) -> Vec<u8> {
    let mut session = gemtrace::Session::open("cpu").unwrap();
    let loaded = session.load(scene).unwrap();
    session.render(loaded).unwrap().png().unwrap()
}
