//! Who reaches the view, and what it reaches: tokens, hosts, bytes, and pages that embed it.

use super::place::Place;
use serde_json::json;
use std::io::{Read as _, Write as _};
use std::net::TcpListener;

const SIZE: [u32; 2] = [800, 480];

#[test]
fn nobody_gets_in_without_the_token_or_by_another_name() {
    let Some(place) = Place::new() else { return };
    let token = place.address.split("token=").nth(1).expect("a token");
    let page = place.browser.page(SIZE, false);
    let other = place.address.replace("127.0.0.1", "elsewhere.example");
    let wrong = place.address.replace(token, "0123456789abcdef");
    for address in [place.origin().to_owned(), wrong, other] {
        page.open(&address);
        page.wait("document.readyState === 'complete' && location.href !== 'about:blank'");
        let answers = page.events("Network.responseReceived");
        let statuses: Vec<_> =
            answers.iter().map(|a| &a["response"]["status"]).filter(|s| **s != 404).collect();
        assert!(
            !statuses.is_empty() && statuses.iter().all(|s| **s == 403 || **s == 421),
            "{address}: {statuses:?}"
        );
        assert_eq!(page.eval("document.querySelector('#stage')"), serde_json::Value::Null);
    }
    // A page from elsewhere that knows the token cannot connect, either.
    page.open("about:blank");
    let live = place.address.replace("http:", "ws:").replace("/?", "/live?");
    let answer = page.eval(&format!(
        "new Promise(r => {{ const s = new WebSocket('{live}'); s.onopen = () => r('open'); s.onerror = () => r('refused'); }})"
    ));
    assert_eq!(answer, "refused");
}

#[test]
fn the_page_is_small_and_asks_nobody_else() {
    let Some(place) = Place::new() else { return };
    let page = place.page(SIZE);
    // The rendered swatches come after the first picture.
    page.wait("document.querySelectorAll('#swatches img').length > 30");
    let loaded = page.loaded();
    let own = |address: &str| address.starts_with(place.origin()) || address.starts_with("data:");
    assert!(loaded.keys().all(|address| own(address)), "{loaded:#?}");
    let swatch = |address: &str| address.contains("/swatch/");
    let page_bytes: u64 = loaded.iter().filter(|(a, _)| !swatch(a)).map(|(_, bytes)| bytes).sum();
    let all: u64 = loaded.values().sum();
    println!("page {page_bytes} bytes, with swatches {all} bytes");
    assert!(page_bytes <= 150_000 && all <= 300_000, "{page_bytes} {all}: {loaded:#?}");
}

/// Serves one page that embeds the view, on a port of its own.
fn around(address: &str) -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let origin = format!("http://{}", listener.local_addr().expect("an address"));
    let html = format!(
        "<!doctype html><title>around</title><iframe id=view width=500 height=400 src='{address}&embed=1&origin={origin}'></iframe>
         <script>const said = []; addEventListener('message', e => said.push({{ from: e.origin, ...e.data }}));
         const ask = m => document.getElementById('view').contentWindow.postMessage({{ gemtrace: 1, ...m }}, '*');</script>"
    );
    let own = listener.try_clone().expect("a socket");
    std::thread::spawn(move || {
        for mut stream in own.incoming().map_while(Result::ok).take(4) {
            let _ = stream.read(&mut [0; 4096]);
            let _ = write!(
                stream,
                "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{html}",
                html.len()
            );
        }
    });
    (listener, origin)
}

#[test]
fn another_page_embeds_the_view_and_talks_with_it() {
    let Some(place) = Place::new() else { return };
    let (_listener, origin) = around(&place.address);
    let page = place.browser.page(SIZE, false);
    page.open(&origin);
    let said = |what: &str| format!("said.find(m => m.gemtrace === 1 && {what})");
    page.wait(&format!("typeof said !== 'undefined' && {}", said("m.type === 'ready' && m.protocol === 1")));
    page.wait(&said("m.type === 'state' && m.stage === 'settled'"));
    assert_eq!(page.eval("said[0].from"), place.origin());
    page.eval("ask({ type: 'set', id: 1, path: 'material', value: 'ruby' })");
    page.eval("ask({ type: 'pose', id: 2, quaternion: [0, 0, 0.6, 0.8] })");
    page.wait(&said("m.type === 'pose' && Math.abs(m.quaternion[2] - 0.6) < 1e-9"));
    page.eval("ask({ type: 'inspect', id: 3, x: 250, y: 200 })");
    page.wait(&said("m.type === 'pixel' && m.id === 3 && m.spectrum.radiance.length >= 8"));
    page.eval("ask({ type: 'save', id: 4, format: 'png' })");
    page.wait(&said("m.type === 'saved' && m.id === 4 && new Uint8Array(m.bytes)[1] === 0x50"));
    for (id, message) in
        [(5, json!({ "type": "delete" })), (6, json!({ "type": "pose", "quaternion": [1, 1, 1, 1] }))]
    {
        let mut message = message;
        message["id"] = id.into();
        page.eval(&format!("ask({message})"));
        page.wait(&said(&format!("m.type === 'error' && m.id === {id}")));
    }
}
