//! Nobody else gets in, and nothing else is read or written.

use crate::support::{Page, Running, SCENE};
use serde_json::json;
use tungstenite::Message;

const SECRET: &[u8] = b"format = 1";

/// One of each kind, without a token.
const ROUTES: [&str; 8] = [
    "/",
    "/live",
    "/drop?name=a.asc&side=A",
    "/save?format=png&side=A",
    "/saved/scene.png",
    "/page/main.js",
    "/swatch/ruby.png",
    "/nothing",
];

#[test]
fn only_the_token_opens() {
    let view = Running::new(&[]);
    let token = view.token.clone();
    let wrong = token.replace(|c: char| c.is_ascii_digit(), "f");
    for path in ROUTES {
        let joint = if path.contains('?') { '&' } else { '?' };
        for bad in [
            path.to_owned(),
            format!("{path}{joint}token={wrong}"),
            format!("{path}{joint}token={}", &token[1..]),
        ] {
            assert_eq!(view.get(&bad).0, 403, "{bad}");
            let post =
                format!("POST {bad} HTTP/1.1\nHost: {}\nContent-Length: 1\nConnection: close\n\n", view.host);
            assert_eq!(view.request(&post, b"x").0, 403, "{bad}");
        }
    }
    assert_eq!(view.get(&format!("/page/{wrong}/main.js")).0, 403);
    assert_eq!(view.get(&format!("/page/{token}/main.js")).0, 200);
    assert_eq!(view.get(&format!("/page/{token}/no.js")).0, 404);
    assert!(Page::connect(&view.host, &wrong, None).is_err());
    assert!(view.drop_file("a.asc", "A", b"x").0 != 403);
}

#[test]
fn other_hosts_and_origins_are_refused() {
    let view = Running::new(&[]);
    let (host, token) = (view.host.clone(), view.token.clone());
    let ask_for = |path: &str, host: &str, origin: &str| {
        let origin = if origin.is_empty() { String::new() } else { format!("Origin: {origin}\n") };
        let joint = if path.contains('?') { '&' } else { '?' };
        let head =
            format!("GET {path}{joint}token={token} HTTP/1.1\nHost: {host}\n{origin}Connection: close\n\n");
        view.request(&head, &[]).0
    };
    let ask = |host: &str, origin: &str| ask_for("/", host, origin);
    for path in ROUTES {
        assert_eq!(ask_for(path, "evil.example", ""), 421, "{path}");
        assert_eq!(ask_for(path, &host, "http://evil.example"), 403, "{path}");
    }
    assert_eq!(ask(&host, ""), 200);
    assert_eq!(ask(&host, &format!("http://{host}")), 200);
    assert_eq!(ask("evil.example", ""), 421);
    assert_eq!(ask(&host.replace("127.0.0.1", "127.0.0.1.evil.example"), ""), 421);
    for origin in [
        "http://evil.example",
        "https://127.0.0.1",
        "null",
        "file://",
        &format!("http://{host}.evil.example"),
    ] {
        assert_eq!(ask(&host, origin), 403, "{origin}");
    }
    for two in [format!("{host}\nHost: evil.example"), format!("evil.example\nHost: {host}")] {
        assert!([400, 421].contains(&ask(&two, "")), "{two}");
    }
    assert!(Page::connect(&host, &token, Some("http://evil.example")).is_err());
    assert!(Page::connect(&host, &token, Some(&format!("http://{host}"))).is_ok());
}

#[test]
fn the_page_may_load_nothing_from_elsewhere() {
    let view = Running::new(&[]);
    let head = |path: &str| {
        let (status, answer) = view.get(path);
        assert_eq!(status, 200);
        String::from_utf8_lossy(&answer).split("\r\n\r\n").next().unwrap().to_ascii_lowercase()
    };
    let own = head(&format!("/?token={}", view.token));
    assert!(own.contains("default-src 'self'") && own.contains("frame-ancestors 'none'"), "{own}");
    assert!(own.contains("no-referrer") && own.contains("nosniff"), "{own}");
    let embedded = head(&format!("/?embed=1&token={}", view.token));
    assert!(!embedded.contains("frame-ancestors"), "{embedded}");
    let page = String::from_utf8(view.body("/")).unwrap();
    assert!(page.contains(&view.token) && !page.contains("{{token}}"));
}

#[test]
fn files_that_are_too_large_are_refused_before_they_are_read() {
    let view = Running::new(&[]);
    let (host, token) = (&view.host, &view.token);
    // A hundred megabytes are announced and none is sent: an answer comes all the same.
    let head = format!(
        "POST /drop?name=big.obj&side=A&token={token} HTTP/1.1\nHost: {host}\nContent-Length: 104857600\n\
         Connection: close\n\n"
    );
    let (status, answer) = view.request(&head, &[]);
    let text = String::from_utf8_lossy(&answer);
    assert!(status == 413 && text.contains("up to 64 MB"), "{text}");
    // Without a length it is read up to the limit.
    let head = format!(
        "POST /drop?name=big.obj&side=A&token={token} HTTP/1.1\nHost: {host}\nTransfer-Encoding: chunked\n\
         Connection: close\n\n"
    );
    let mut body = b"4400000\r\n".to_vec();
    body.resize(body.len() + 0x440_0000, b'#');
    body.extend(b"\r\n0\r\n\r\n");
    assert!([413, 0].contains(&view.request(&head, &body).0));
}

#[test]
fn no_path_leads_out() {
    let view = Running::new(&[]);
    let token = &view.token;
    for path in ["..%2Fview.rs", "../main.js", "%2Fetc%2Fpasswd", "..%5C..%5Cwin.ini", "main.js%00", "."] {
        for folder in [format!("/page/{token}/"), "/swatch/".to_owned(), "/saved/".to_owned()] {
            let status = view.get(&format!("{folder}{path}?token={token}")).0;
            assert!([400, 403, 404].contains(&status), "{folder}{path}: {status}");
        }
    }
    // Only what was saved is there, although the folder has more.
    std::fs::create_dir_all(view.place("views")).unwrap();
    std::fs::write(view.place("views/own.png"), "x").unwrap();
    assert_eq!(view.get(&format!("/saved/own.png?token={token}")).0, 404);
    for bad in
        ["/save?side=A", "/save?format=exe&side=A", "/save?format=png&side=C", "/save?format=../x&side=A"]
    {
        assert_eq!(view.get(&format!("{bad}&token={token}")).0, 400, "{bad}");
    }
}

#[test]
fn files_come_two_at_a_time_and_none_stops_the_others() {
    let view = Running::new(&[]);
    let cut: &[u8] = include_bytes!("../../../spectral-core/data/cuts/srb_quartz_57.asc");
    std::thread::scope(|scope| {
        let drops: Vec<_> = (0..8)
            .map(|k| {
                scope.spawn({
                    let view = &view;
                    move || view.drop_file(&format!("{k}.asc"), "A", cut)
                })
            })
            .collect();
        for drop in drops {
            let (status, text) = drop.join().unwrap();
            assert_eq!(status, 200, "{text}");
        }
    });
    let mut page = view.page();
    assert!(page.wait("state")["sides"]["A"]["name"].as_str().unwrap().ends_with(".asc"));
}

#[test]
fn dropped_scenes_read_no_files_beyond() {
    let view = Running::new(&[("inside.csv", b"400, 0.1\n700, 0.1\n")]);
    let outside = tempfile::tempdir().unwrap();
    std::fs::write(outside.path().join("secret.csv"), SECRET).unwrap();
    let named = |file: &str| format!("{SCENE}\n[material.ink]\nlike = \"quartz\"\nabsorption = \"{file}\"\n");
    let secret = outside.path().join("secret.csv");
    #[cfg(unix)]
    std::os::unix::fs::symlink(&secret, view.place("link.csv")).unwrap();
    for bad in
        ["../secret.csv", "/etc/passwd", "link.csv", secret.to_str().unwrap(), "../../../../../../etc/passwd"]
    {
        let (status, text) = view.drop_file("scene.toml", "open", named(bad).as_bytes());
        assert!(status == 422 && text.contains("dropped") && text.contains("line"), "{bad}: {text}");
        assert!(!text.contains("root:"), "{text}");
    }
    let (status, text) = view.drop_file("scene.toml", "open", named("inside.csv").as_bytes());
    assert_eq!(status, 200, "{text}");
    // What was dropped before may be named.
    assert_eq!(
        view.drop_file("cut.asc", "B", include_bytes!("../../../spectral-core/data/cuts/srb_quartz_57.asc"))
            .0,
        200
    );
    let scene = SCENE.replace("shape = \"round-brilliant\"", "cut = \"cuts/cut.asc\"");
    let (status, text) = view.drop_file("other.toml", "open", scene.as_bytes());
    assert_eq!(status, 200, "{text}");
    for name in ["..%2Fa.asc", "%2Fetc%2Fa.asc", "", "a%00.asc"] {
        assert_eq!(view.drop_file(name, "A", b"x").0, 422, "{name}");
    }
}

#[test]
fn what_is_no_message_harms_nobody() {
    let view = Running::new(&[]);
    let mut page = view.page();
    for bad in [
        json!(7),
        json!({}),
        json!({ "type": "nonsense" }),
        json!({ "type": "pose", "rotation": [0, 0, 0], "done": true }),
        json!({ "type": "pose", "rotation": [0, 0, 0, 9], "done": true }),
        json!({ "type": "set", "path": "film.width", "value": 9, "side": "A", "done": true }),
        json!({ "type": "set", "path": "cut", "value": "file:../../secret.asc", "side": "A", "done": true }),
        json!({ "type": "set", "path": "size", "value": -4, "side": "A", "done": true }),
        json!({ "type": "set", "path": "size", "value": "4", "side": "A", "done": true }),
        json!({ "type": "set", "path": "material", "value": "ruby", "side": "B", "done": true }),
    ] {
        page.say(bad.clone());
        let error = page.wait("error");
        assert!(
            error["what"].is_string() && error["why"].is_string() && error["unchanged"].is_string(),
            "{bad}: {error}"
        );
    }
    let answers = page.set("material", json!("ruby"));
    page.picture("settled", answers);
}

#[test]
fn what_is_no_text_of_this_protocol_is_told_so() {
    let view = Running::new(&[]);
    let mut page = view.page();
    page.wait("state");
    let deep = "[".repeat(30_000);
    for bad in [
        "",
        "{",
        "null",
        "[]",
        "{\"type\":5}",
        &deep,
        &format!("{{\"type\":\"set\",\"path\":{deep}}}"),
        "{\"type\":\"pose\",\"rotation\":[1e999,0,0,0],\"done\":true}",
        "{\"type\":\"size\",\"width\":-1,\"height\":1e12}",
        "{\"type\":\"inspect\",\"side\":\"C\",\"x\":0,\"y\":0}",
        "{\"type\":\"save\",\"side\":\"A\",\"format\":\"../x\"}",
    ] {
        page.send(Message::text(bad));
        let error = page.wait("error");
        assert_eq!(error["code"], "protocol", "{}", &bad[..bad.len().min(60)]);
    }
    page.send(Message::binary(vec![0xff; 100]));
    assert_eq!(page.wait("error")["why"], "messages are JSON text");
    // Numbers beyond all reason are numbers.
    for (question, answer) in [("inspect", "pixel"), ("hover", "facet")] {
        for [x, y] in [[1e300, 0.0], [-1e300, 1e300], [0.0, -5.0], [1e9, 1e9]] {
            page.ask(json!({ "type": question, "side": "A", "x": x, "y": y }));
            assert!(page.wait(answer)["facet"].is_null(), "{x} {y}");
        }
    }
    page.ask(json!({ "type": "distance", "factor": 1e308, "done": true }));
    page.ask(json!({ "type": "lights", "rotation": -1e308, "done": true }));
    page.say(json!({ "type": "size", "width": 0, "height": 4_294_967_295_u32 }));
    page.say(json!({ "type": "size", "width": 64, "height": 48 }));
    let answers = page.set("material", json!("ruby"));
    page.picture("settled", answers);
}

#[test]
fn a_message_that_is_too_large_ends_its_connection_alone() {
    let view = Running::new(&[]);
    let [mut page, mut other] = [view.page(), view.page()];
    for size in [65 << 10, 10 << 20] {
        page.wait("state");
        page.send(Message::text(" ".repeat(size)));
        let mut said = Vec::new();
        while let Some(news) = page.read() {
            said.extend(if let crate::support::News::Text(text) = news { Some(text) } else { None });
        }
        assert!(
            size > 1 << 20
                || said.iter().any(|text| text["why"].as_str().is_some_and(|why| why.contains("64 kB"))),
            "{said:?}"
        );
        page = view.page();
    }
    let answers = other.set("material", json!("ruby"));
    other.picture("settled", answers);
}

#[test]
fn a_page_that_takes_nothing_stops_nobody() {
    let view = Running::new(&[]);
    let mut silent = view.page();
    silent.say(json!({ "type": "size", "width": 64, "height": 48 }));
    let mut page = view.page();
    for k in 0..300 {
        let a = 0.01 * f64::from(k);
        let id = page.ask(json!({ "type": "pose", "rotation": [a.sin(), 0, 0, a.cos()], "done": true }));
        silent.ask(json!({ "type": "hover", "side": "A", "x": k, "y": 20 }));
        if k % 50 == 0 {
            page.picture("moving", id);
        }
    }
    let answers = page.set("material", json!("ruby"));
    page.picture("settled", answers);
}

#[test]
fn another_version_is_told_so() {
    let view = Running::new(&[]);
    let mut page = Page::connect(&view.host, &view.token, None).unwrap();
    page.say(json!({ "type": "hello", "protocol": 2, "width": 64, "height": 48 }));
    assert!(page.wait("error")["why"].as_str().unwrap().contains("version 1"));
}
