//! Every state of the page: nothing for axe to report, no control that moves, no grey with a hue.

use super::browser::Page;
use super::place::Place;
use serde_json::Value;
use std::path::Path;

/// The states of the page: how each is reached from the settled one, what shows that it is there, and how it is left.
const STATES: [(&str, &str, &str, &str); 14] = [
    ("default", "0", "true", "0"),
    (
        "inspect",
        "(click('#inspect-button'), setTimeout(() => press('#view-a', 'Enter'), 100))",
        "$$('#events tr').length",
        "click('#inspect-button')",
    ),
    (
        "bench",
        "click('#bench-button')",
        "!$('#bench').hidden && $$('#curve path').length > 5",
        "click('#bench-button')",
    ),
    ("compare", "click('#compare-button')", "!$('#view-b').hidden && $('#view-b canvas').width > 1", "0"),
    (
        "wipe",
        "click('#modes input[value=wipe]')",
        "!$('#wipe').hidden",
        "(click('#modes input[value=sides]'), click('#compare-button'))",
    ),
    ("error", "drop('bad.gcs')", "!$('#toast').hidden", "click('#toast-close')"),
    (
        "refused",
        "type('[data-path=size] .num', '1000000')",
        "$('.why') || !$('#toast').hidden",
        "(click('#toast-close'), $('[data-path=size] .num').dispatchEvent(new Event('input', { bubbles: true })))",
    ),
    ("drop", "enter()", "!$('#drop').hidden", "leave()"),
    ("save", "click('[aria-controls=menu]')", "!$('#menu').hidden", "press('body', 'Escape')"),
    ("saved", "click('[data-save=png]')", "!$('#toast').hidden", "click('#toast-close')"),
    ("keys", "click('.bar [data-act=help]')", "$('#keys').open", "click('#keys-close')"),
    (
        "turning",
        "(press('#view-a', 'ArrowLeft'), press('#view-a', 'ArrowLeft'))",
        "$('#stage-word').textContent !== 'First picture'",
        "0",
    ),
    (
        "failed",
        "(hand({ type: 'status', side: 'A', stage: 'failed', samples: 0, of: null, device: 'cpu', answers: 9e15 }),
          hand({ type: 'notice', text: 'vulkan failed: the device was lost; cpu carries on' }))",
        "$('#stage-word').textContent === 'Device failed' && !$('#toast').hidden",
        "(click('#toast-close'), click('.backgrounds input:not(:checked)'))",
    ),
    (
        "lost",
        "dispatchEvent(new Event('offline'))",
        "$('#stage-word').textContent === 'Connection lost'",
        "dispatchEvent(new Event('online'))",
    ),
];

/// States of a page that is loaded anew: what of the server's messages is held back, what is added to the address, what is done
/// then, and what shows that the state is there.
const LOADED: [(&str, &str, &str, &str, &str); 3] = [
    (
        "start",
        "typeof m !== 'string' || m.includes('\"type\":\"status\"')",
        "",
        "0",
        "$('#stage-word').textContent === 'First picture' && $('#view-a .ov path')",
    ),
    (
        "refining",
        "(typeof m === 'string' ? m : new TextDecoder().decode(m.slice(4, 300))).includes('\"stage\":\"settled\"')",
        "",
        "click('[name=quality][value=normal]')",
        "$('#stage-word').textContent === 'Refining' && $('#view-a canvas').width > 1",
    ),
    ("embed", "false", "&embed=1", "0", "$('#view-a').ariaBusy === 'false' && $('#view-a canvas').width > 1"),
];

/// Holds messages back, and hands in others.
const HOLD: &str = "window.WebSocket = class extends WebSocket {
    set onmessage(f) { window.hand = m => f({ data: JSON.stringify(m) }); super.onmessage = e => {
      if (!(m => HELD)(e.data)) f(e); else if (typeof e.data !== 'string') this.send('{\"type\":\"shown\"}'); }; } };";

/// Short names for the table above.
const HELPERS: &str = "
    window.$ = s => document.querySelector(s); window.$$ = s => document.querySelectorAll(s);
    window.click = s => ([...$$(s)].find(n => n.checkVisibility() || n.matches('input')) ?? $(s)).click();
    window.press = (s, key) => $(s).dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, cancelable: true }));
    window.type = (s, v) => { const n = $(s); n.value = v; n.dispatchEvent(new Event('change', { bubbles: true })); };
    window.files = name => { const d = new DataTransfer(); d.items.add(new File(['x'], name)); return d; };
    window.tell = (type, data) => $('#zone-open').dispatchEvent(new DragEvent(type, { bubbles: true, dataTransfer: data }));
    window.drop = name => { const d = files(name); for (const t of ['dragenter', 'dragover', 'drop']) tell(t, d); };
    window.enter = () => { const d = files('a.asc'); tell('dragenter', d); tell('dragover', d); };
    window.leave = () => tell('dragleave', files('a.asc')); 0";

/// Goes through all states of a page.
fn visit(place: &Place, size: [u32; 2], mut look: impl FnMut(&str, &Page)) {
    let opened = |hold: &str, besides: &str| {
        let page = place.browser.page(size, size[0] < 640);
        let script = format!("{}{HELPERS}", HOLD.replace("HELD", hold));
        page.call("Page.addScriptToEvaluateOnNewDocument", serde_json::json!({ "source": script }));
        // What is halfway between two colours is no state.
        let still = serde_json::json!([{ "name": "prefers-reduced-motion", "value": "reduce" }]);
        page.call("Emulation.setEmulatedMedia", serde_json::json!({ "features": still }));
        page.open(&format!("{}{besides}", place.address));
        page
    };
    for (name, hold, besides, enter, there) in LOADED {
        let page = opened(hold, besides);
        page.wait("window.$ && $('#swatches input') && $('#view-a').ariaLabel !== 'Stone'");
        page.eval(&format!("void ({enter})"));
        page.wait(there);
        look(name, &page);
        page.eval("click('[name=quality][value=draft]')");
        page.wait("$('[name=quality][value=draft]').checked");
        page.call("Page.close", serde_json::json!({}));
    }
    let page = opened("false", "");
    page.settle();
    for (name, enter, there, leave) in STATES {
        page.eval(&format!("void ({enter})"));
        page.wait(there);
        look(name, &page);
        page.eval(&format!("void ({leave})"));
    }
    page.settle();
}

/// axe-core's program, where `test.sh` puts it; `None` where it is missing and not demanded.
fn axe() -> Option<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/axe/node_modules/axe-core/axe.min.js");
    let program = std::fs::read_to_string(&path).ok();
    if program.is_none() {
        assert!(
            std::env::var_os("REQUIRE_BROWSER").is_none(),
            "REQUIRE_BROWSER: {} is missing",
            path.display()
        );
        eprintln!("axe-core is not installed: accessibility was not tested");
    }
    program
}

/// Greys with a hue, outside of what shows stones and spectra.
const HUES: &str = "[...document.querySelectorAll('body, body *')].filter(n => !n.closest('.swatches, .chip, #spectrum, canvas')).flatMap(n => {
    const style = getComputedStyle(n);
    return ['color', 'backgroundColor', 'borderTopColor', 'outlineColor', 'fill', 'stroke', 'boxShadow', 'backgroundImage']
      .flatMap(p => [...style[p].matchAll(/rgba?\\((\\d+), (\\d+), (\\d+)/g)].filter(([, r, g, b]) => r !== g || g !== b)
        .map(m => `${n.id || n.className || n.tagName} ${p} ${m[0]}`)); })";

/// Places and sizes of the controls and figures that are there in every state.
const BOXES: &str = "[...document.querySelectorAll('.bar .btn, .status .cell:not(.retry), .panel .row > *, .panel summary, #find, #caption')]
    .filter(n => n.checkVisibility() && !n.matches('.why'))
    .map(n => `${n.id || n.className || n.tagName} ${(b => [b.x, b.y, b.width, b.height].map(Math.round).join())(n.getBoundingClientRect())}`)";

#[test]
fn in_every_state_controls_stay_in_place_greys_are_neutral_and_axe_is_silent() {
    let (Some(axe), Some(place)) = (axe(), Place::new()) else { return };
    let none = Value::Array(Vec::new());
    for size in [[1440, 900], [390, 844]] {
        let mut boxes = Value::Null;
        visit(&place, size, |state, page| {
            page.shoot(&Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("view/{state}-{}.png", size[0])));
            assert_eq!(page.eval(HUES), none, "{state}");
            if page.eval("typeof axe") == "undefined" {
                page.eval(&format!("{axe}; 0"));
            }
            let found = page.eval(
                "axe.run(document, { resultTypes: ['violations'] }).then(r => r.violations.map(v =>
                   `${v.id}: ${v.nodes.slice(0, 3).map(n => n.html.slice(0, 200) + ' ' + n.failureSummary).join('\\n')}`))",
            );
            assert_eq!(found, none, "{state} at {size:?}");
            // On a phone docks take the panel's place; the reason beneath a refused value makes place for itself.
            if size[0] > 1000 && state != "refused" && state != "embed" {
                let now = page.eval(BOXES);
                boxes = if boxes.is_null() { now.clone() } else { boxes.take() };
                assert_eq!(now, boxes, "{state}");
                assert!(now.as_array().is_some_and(|list| list.len() > 30), "{now}");
            }
        });
    }
}

#[test]
fn every_focus_is_seen() {
    let Some(place) = Place::new() else { return };
    let page = place.page([1440, 900]);
    let mut seen = Vec::new();
    for _ in 0..40 {
        page.call(
            "Input.dispatchKeyEvent",
            serde_json::json!({ "type": "keyDown", "key": "Tab", "code": "Tab", "windowsVirtualKeyCode": 9 }),
        );
        page.call(
            "Input.dispatchKeyEvent",
            serde_json::json!({ "type": "keyUp", "key": "Tab", "code": "Tab", "windowsVirtualKeyCode": 9 }),
        );
        let focus = page.eval(
            "(n => { if (n === document.body) return null; const shown = n.matches('.segments input, .swatches input, .backgrounds input') ? n.nextElementSibling : n;
               const s = getComputedStyle(shown); return [n.id || n.textContent.trim().slice(0, 20) || n.value || n.tagName, s.outlineStyle, s.outlineWidth]; })(document.activeElement)",
        );
        if focus.is_null() {
            break; // The end of the page.
        }
        assert!(focus[1] == "solid" && focus[2] == "2px", "{focus}");
        seen.push(focus[0].as_str().unwrap_or_default().to_owned());
    }
    assert_eq!(seen[0], "Skip to the stone");
    for id in [
        "file",
        "compare-button",
        "inspect-button",
        "bench-button",
        "save-button",
        "view-a",
        "tilt",
        "turn",
        "lights",
        "cut",
        "find",
    ] {
        assert!(seen.iter().any(|s| s == id), "{id} is not reached by Tab: {seen:?}");
    }
}

#[test]
fn narrow_windows_large_text_and_right_to_left_cut_nothing_off() {
    let Some(place) = Place::new() else { return };
    let outside = "[...document.querySelectorAll('.bar *, .panel .tabs *, .status .cell, .pose *, #toast *')]
        .filter(n => n.checkVisibility() && !n.closest('.menu, svg, .vh, [hidden]') && getComputedStyle(n).clipPath === 'none')
        .filter(n => (b => b.width && (b.left < -1 || b.right > innerWidth + 1))(n.getBoundingClientRect()))
        .map(n => n.id || n.className || n.tagName)";
    for (size, font, direction) in [
        ([1024, 700], 16, "ltr"),
        ([390, 844], 16, "ltr"),
        ([320, 640], 16, "ltr"),
        ([1440, 900], 32, "ltr"),
        ([390, 844], 32, "ltr"),
        ([1440, 900], 16, "rtl"),
        ([390, 844], 16, "rtl"),
    ] {
        let page = place.browser.page(size, size[0] < 640);
        page.call("Page.setFontSizes", serde_json::json!({ "fontSizes": { "standard": font } }));
        page.open(&format!("{}&dir={direction}", place.address));
        page.settle();
        assert_eq!(page.eval("document.documentElement.dir"), direction);
        assert_eq!(page.eval(outside), Value::Array(Vec::new()), "{size:?} {font} {direction}");
        assert!(
            page.eval("document.querySelector('#view-a').clientHeight").as_f64() >= Some(120.0),
            "{size:?} {font}"
        );
    }
}
