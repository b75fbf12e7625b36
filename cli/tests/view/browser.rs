//! A Chromium without a window, driven by its own debugging protocol (Chrome DevTools Protocol) over a WebSocket.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::rc::Rc;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tungstenite::{Message, WebSocket};

/// What a test waits for comes within this time, on a machine that is busy with other tests.
const PATIENCE: Duration = Duration::from_secs(100);

/// The browser, or `None` where none is installed and `REQUIRE_BROWSER` does not demand one.
pub fn browser() -> Option<Browser> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success()));
    if found.is_none() {
        assert!(
            std::env::var_os("REQUIRE_BROWSER").is_none(),
            "REQUIRE_BROWSER: none of {names:?} is installed"
        );
        eprintln!("no Chromium is installed: nothing was tested");
    }
    found.map(Browser::start)
}

/// The connection to the browser, which ends when it is dropped.
struct Connection {
    process: Child,
    socket: WebSocket<TcpStream>,
    calls: u64,
    /// What the browser has told of itself since it was asked last.
    events: Vec<Value>,
    _profile: TempDir,
}

impl Drop for Connection {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Connection {
    fn call(&mut self, session: Option<&str>, method: &str, params: Value) -> Value {
        self.calls += 1;
        let id = self.calls;
        let mut request = json!({ "id": id, "method": method, "params": params });
        if let Some(session) = session {
            request["sessionId"] = session.into();
        }
        self.socket.send(Message::text(request.to_string())).expect("the browser listens");
        loop {
            let text = self.socket.read().expect("the browser answers");
            let Message::Text(text) = text else { continue };
            let answer: Value = serde_json::from_str(&text).expect("JSON");
            if answer["id"] == id {
                assert!(answer.get("error").is_none(), "{method}: {answer}");
                return answer["result"].clone();
            }
            if answer.get("method").is_some() {
                self.events.push(answer);
            }
        }
    }
}

pub struct Browser(Rc<RefCell<Connection>>);

impl Browser {
    fn start(program: &str) -> Self {
        let profile = tempfile::tempdir().expect("a folder");
        let mut process = Command::new(program)
            // A page of another name leads to the same machine: what an attacker's name server would do.
            .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run"])
            .args(["--disable-dev-shm-usage", "--host-resolver-rules=MAP elsewhere.example 127.0.0.1"])
            .args(["--remote-debugging-port=0", "about:blank"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .expect("the browser starts");
        let mut lines = BufReader::new(process.stderr.take().expect("a pipe")).lines();
        let address = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| line.strip_prefix("DevTools listening on ").map(str::to_owned))
            .expect("an address");
        std::thread::spawn(move || lines.map_while(Result::ok).for_each(drop));
        let host = address.trim_start_matches("ws://").split('/').next().expect("a host");
        let stream = TcpStream::connect(host).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        let (socket, _) = tungstenite::client(&address, stream).expect("a WebSocket");
        let connection = Connection { process, socket, calls: 0, events: Vec::new(), _profile: profile };
        Browser(Rc::new(RefCell::new(connection)))
    }

    /// A page with an inner size in CSS pixels; `touch` is a phone.
    pub fn page(&self, [width, height]: [u32; 2], touch: bool) -> Page {
        let call =
            |session: Option<&str>, method: &str, params| self.0.borrow_mut().call(session, method, params);
        let target = call(None, "Target.createTarget", json!({ "url": "about:blank" }))["targetId"].clone();
        let attached = call(None, "Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        let page = Page {
            connection: Rc::clone(&self.0),
            session: attached["sessionId"].as_str().expect("a session").to_owned(),
        };
        for domain in ["Page", "Runtime", "Network", "Log"] {
            page.call(&format!("{domain}.enable"), json!({}));
        }
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": touch });
        page.call("Emulation.setDeviceMetricsOverride", metrics);
        // As if each page's window were in front: focus and keys are tested.
        page.call("Emulation.setFocusEmulationEnabled", json!({ "enabled": true }));
        page.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": touch }));
        page
    }
}

/// A page of the browser.
pub struct Page {
    connection: Rc<RefCell<Connection>>,
    session: String,
}

impl Page {
    pub fn call(&self, method: &str, params: Value) -> Value {
        self.connection.borrow_mut().call(Some(&self.session), method, params)
    }

    pub fn open(&self, address: &str) {
        self.call("Page.navigate", json!({ "url": address }));
    }

    /// The value of an expression, promises awaited.
    pub fn eval(&self, expression: &str) -> Value {
        let asked = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true, "userGesture": true });
        let answer = self.call("Runtime.evaluate", asked);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}\n{:#}", answer["exceptionDetails"]);
        answer["result"]["value"].clone()
    }

    pub fn text(&self, selector: &str) -> String {
        self.eval(&format!("document.querySelector({selector:?}).textContent"))
            .as_str()
            .unwrap_or_default()
            .to_owned()
    }

    pub fn click(&self, selector: &str) {
        self.eval(&format!("document.querySelector({selector:?}).click()"));
    }

    /// Waits until an expression is true.
    pub fn wait(&self, expression: &str) {
        let start = Instant::now();
        while self.eval(&format!("Boolean({expression})")) != true {
            if start.elapsed() > PATIENCE {
                let seen = self.eval("document.body.innerText");
                panic!(
                    "in vain: {expression}\n{}\n{:?}",
                    seen.as_str().unwrap_or_default(),
                    self.complaints()
                );
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits for the settled picture of every side.
    pub fn settle(&self) {
        self.wait(
            "document.querySelector('#stage-word')?.textContent === 'Settled'
             && [...document.querySelectorAll('.view:not([hidden])')].every(v => v.ariaBusy === 'false')",
        );
    }

    pub fn mouse(&self, kind: &str, [x, y]: [f64; 2], modifiers: u32) {
        let button = if kind == "mouseMoved" { "none" } else { "left" };
        let buttons = u32::from(kind == "mousePressed");
        let event = json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": buttons,
                            "clickCount": 1, "modifiers": modifiers });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Presses, moves in steps and releases.
    pub fn drag(&self, from: [f64; 2], to: [f64; 2], modifiers: u32) {
        self.mouse("mouseMoved", from, modifiers);
        self.mouse("mousePressed", from, modifiers);
        for k in 1..=8 {
            let at = [0, 1].map(|i| from[i] + (to[i] - from[i]) * f64::from(k) / 8.0);
            self.call(
                "Input.dispatchMouseEvent",
                json!({ "type": "mouseMoved", "x": at[0], "y": at[1], "button": "left", "buttons": 1,
                        "modifiers": modifiers }),
            );
            std::thread::sleep(Duration::from_millis(16));
        }
        self.mouse("mouseReleased", to, modifiers);
    }

    /// A key with what it writes; modifiers: 1 Alt, 2 Ctrl, 8 Shift.
    pub fn key(&self, key: &str, modifiers: u32) {
        for kind in ["keyDown", "keyUp"] {
            let event = json!({ "type": kind, "key": key, "modifiers": modifiers });
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    /// The middle of an element, CSS pixels of the page.
    pub fn middle(&self, selector: &str) -> [f64; 2] {
        let found = self.eval(&format!(
            "(b => [b.x + b.width / 2, b.y + b.height / 2])(document.querySelector({selector:?}).getBoundingClientRect())"
        ));
        [0, 1].map(|i| found[i].as_f64().expect("a place"))
    }

    /// Writes what is seen as a PNG, for people to look at.
    pub fn shoot(&self, path: &Path) {
        let answer = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let bytes = STANDARD.decode(answer["data"].as_str().expect("text")).expect("base64");
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, bytes).expect("a picture");
    }

    /// What has happened since it was asked last, of this page.
    pub fn events(&self, method: &str) -> Vec<Value> {
        self.eval("0");
        let mut connection = self.connection.borrow_mut();
        let (own, others) = std::mem::take(&mut connection.events)
            .into_iter()
            .partition(|event| event["sessionId"] == self.session.as_str() && event["method"] == method);
        connection.events = others;
        own.into_iter().map(|event: Value| event["params"].clone()).collect()
    }

    /// Exceptions, and errors of the console.
    pub fn complaints(&self) -> Vec<String> {
        let thrown = self.events("Runtime.exceptionThrown");
        let logged =
            self.events("Log.entryAdded").into_iter().filter(|entry| entry["entry"]["level"] == "error");
        thrown.into_iter().chain(logged).map(|event| event.to_string()).collect()
    }

    /// Bytes that came over the network for each address.
    pub fn loaded(&self) -> BTreeMap<String, u64> {
        let requests = self.events("Network.requestWillBeSent");
        let finished = self.events("Network.loadingFinished");
        let size = |id: &Value| {
            finished
                .iter()
                .find(|done| done["requestId"] == *id)
                .and_then(|done| done["encodedDataLength"].as_f64())
        };
        let address = |request: &Value| request["request"]["url"].as_str().unwrap_or_default().to_owned();
        requests.iter().map(|r| (address(r), size(&r["requestId"]).unwrap_or_default() as u64)).collect()
    }
}
