//! What a person does: turns, chooses, drops, clicks, compares, saves, and comes back.

use super::browser::Page;
use super::place::{Place, pixels};
use serde_json::Value;
use std::process::Command;

const SIZE: [u32; 2] = [800, 480];

fn pose(page: &Page) -> Vec<String> {
    ["tilt", "turn", "lights"]
        .map(|id| page.eval(&format!("document.querySelector('#{id}').value")).to_string())
        .to_vec()
}

/// A file dropped onto a zone, as a browser tells it.
fn drop_file(page: &Page, zone: &str, name: &str, bytes: &str) {
    page.eval(&format!(
        "(() => {{ const data = new DataTransfer(); data.items.add(new File([{bytes}], '{name}'));
           for (const type of ['dragenter', 'dragover', 'drop'])
             document.querySelector('{zone}').dispatchEvent(new DragEvent(type, {{ bubbles: true, dataTransfer: data }})); }})()"
    ));
}

/// The next settled picture that differs from this one.
fn anew(page: &Page, old: &(u32, Vec<u8>)) -> (u32, Vec<u8>) {
    for _ in 0..200 {
        page.settle();
        let now = pixels(page, "#view-a");
        if now != *old {
            return now;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    panic!("the picture stays the same")
}

#[test]
fn a_drag_turns_the_stone_as_one_step_of_undo() {
    let Some(place) = Place::new() else { return };
    let page = place.page(SIZE);
    let (before, [x, y]) = (pose(&page), page.middle("#view-a"));
    let picture = pixels(&page, "#view-a");
    page.drag([x, y], [x + 60.0, y - 40.0], 0);
    page.wait("!document.querySelector('[data-act=undo]').disabled");
    let turned = pose(&page);
    assert_ne!(turned[..2], before[..2]);
    let seen = anew(&page, &picture);
    // Shift turns the lights, not the stone.
    page.drag([x, y], [x + 60.0, y], 8);
    page.wait(&format!("document.querySelector('#lights').value !== {}", before[2]));
    assert_eq!(pose(&page)[..2], turned[..2]);
    page.key("z", 2);
    page.wait(&format!("document.querySelector('#lights').value === {}", before[2]));
    page.key("z", 2);
    page.wait(&format!("document.querySelector('#tilt').value === {}", before[0]));
    assert_eq!(anew(&page, &seen), picture, "the same state is the same picture");
    assert_eq!(page.complaints(), [] as [String; 0]);
}

#[test]
fn keys_do_what_the_pointer_does() {
    let Some(place) = Place::new() else { return };
    let page = place.page(SIZE);
    let before = pose(&page);
    page.eval("document.querySelector('#view-a').focus()");
    page.key("ArrowRight", 0);
    page.wait(&format!("document.querySelector('#turn').value !== {}", before[1]));
    page.wait("!document.querySelector('[data-act=undo]').disabled");
    page.key("f", 0);
    page.wait("document.querySelector('#tilt').value === '0.0°'");
    page.key("i", 0);
    page.wait("!document.querySelector('#inspect').hidden");
    page.key("Escape", 0);
    page.wait("document.querySelector('#inspect').hidden");
    // A number in the pose plate, with a comma.
    page.eval(
        "(n => { n.value = '12,5'; n.dispatchEvent(new Event('change', { bubbles: true })); })(document.querySelector('#tilt'))",
    );
    page.wait("document.querySelector('#tilt').value === '12.5°'");
    page.settle();
    assert_eq!(page.complaints(), [] as [String; 0]);
}

#[test]
fn materials_are_chosen_and_a_cut_is_dropped() {
    let Some(place) = Place::new() else { return };
    let page = place.page(SIZE);
    let diamond = pixels(&page, "#view-a");
    page.click("#swatches input[value=ruby]");
    page.wait("document.querySelector('#caption b').textContent.startsWith('Ruby')");
    let ruby = anew(&page, &diamond);
    // A search dims what does not match; Enter takes the first.
    page.eval(
        "(n => { n.focus(); n.value = 'emer'; n.dispatchEvent(new Event('input', { bubbles: true })); })(document.querySelector('#find'))",
    );
    page.key("Enter", 0);
    page.wait("document.querySelector('#swatches input[value=emerald]').checked");
    let emerald = anew(&page, &ruby);
    let cut = std::fs::read(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../spectral-core/data/cuts/emerald_step_49.gem"),
    );
    let bytes = cut.expect("a cut").iter().map(u8::to_string).collect::<Vec<_>>().join(",");
    drop_file(&page, "#zone-open", "mine.gem", &format!("new Uint8Array([{bytes}])"));
    page.wait("document.querySelector('#file span').textContent === 'mine.gem'");
    let step = anew(&page, &emerald);
    assert_eq!(page.complaints(), [] as [String; 0]);
    // What cannot be read changes nothing, and says so.
    drop_file(&page, "#zone-open", "bad.gcs", "'<GemCutStudio'");
    page.wait("/was not opened/.test(document.querySelector('#toast:not([hidden])')?.textContent)");
    let said = page.text("#toast");
    assert!(said.contains("bad.gcs was not opened") && said.contains("unchanged"), "{said}");
    assert!(pixels(&page, "#view-a") == step, "the stone is not the same");
}

#[test]
fn a_file_of_100_megabytes_is_refused() {
    let Some(place) = Place::new() else { return };
    let page = place.page(SIZE);
    drop_file(&page, "#zone-open", "large.stl", "new Uint8Array(100 << 20)");
    page.wait("/was not opened/.test(document.querySelector('#toast:not([hidden])')?.textContent)");
    let said = page.text("#toast");
    assert!(said.contains("large.stl was not opened") && said.contains("64 MB"), "{said}");
    // A program that does not look at the size is refused by the server, before it has read the file.
    let status = page.eval(
        "fetch('drop?name=large.stl&side=open&' + location.search.slice(1), { method: 'POST', body: new Uint8Array(100 << 20) })
           .then(r => r.status, () => 'closed')",
    );
    assert!(status == 413 || status == "closed", "{status}");
    assert_eq!(page.text("#stage-word"), "Settled");
}

#[test]
fn a_click_shows_spectrum_and_path() {
    let Some(place) = Place::new() else { return };
    let page = place.page([1200, 700]);
    let [x, y] = page.middle("#view-a");
    page.mouse("mouseMoved", [x, y - 40.0], 0);
    page.wait("document.querySelector('#hover').textContent !== '–'");
    page.mouse("mousePressed", [x, y - 40.0], 0);
    page.mouse("mouseReleased", [x, y - 40.0], 0);
    page.wait("document.querySelectorAll('#events tr').length > 1");
    assert!(page.eval("document.querySelectorAll('#spectrum rect').length").as_u64() >= Some(8));
    assert_eq!(
        page.eval("document.querySelectorAll('#section [data-e]').length"),
        page.eval("document.querySelectorAll('#events tr').length")
    );
    page.wait("document.querySelectorAll('#view-a .ov polyline').length === 2");
    let shown = page.eval("getComputedStyle(document.querySelector('.chip')).backgroundColor");
    assert!(shown.as_str().is_some_and(|c| c.starts_with("rgb")), "{shown}");
    // The same number is marked in the table, the section and on the stone.
    page.eval("document.querySelector('#events button[data-e=\"1\"]').focus()");
    assert_eq!(
        page.eval("[...document.querySelectorAll('[data-e=\"1\"]')].every(n => n.classList.contains('on'))"),
        true
    );
    // Turning drops the path.
    page.drag([x + 150.0, y], [x + 180.0, y], 0);
    page.wait("document.querySelectorAll('#events tr').length === 0");
    assert_eq!(page.complaints(), [] as [String; 0]);
}

#[test]
fn two_stones_are_compared_under_one_drag() {
    let Some(place) = Place::new() else { return };
    let page = place.page(SIZE);
    page.key("c", 0);
    page.wait(
        "document.body.hasAttribute('data-compare') && document.querySelector('#view-b canvas').width > 1",
    );
    page.key("2", 0);
    page.click("#swatches input[value=sapphire]");
    page.wait("document.querySelector('#tag-b').textContent.includes('Sapphire')");
    assert!(page.text("#tag-a").contains("Diamond"));
    page.wait("/^[0-9]/.test(document.querySelector('#difference').textContent)");
    let before = [pixels(&page, "#view-a"), pixels(&page, "#view-b")];
    assert_ne!(before[0], before[1]);
    let [x, y] = page.middle("#view-b");
    page.drag([x, y], [x + 40.0, y - 20.0], 0);
    page.wait("document.querySelector('#difference').textContent === '–'");
    page.wait("/^[0-9]/.test(document.querySelector('#difference').textContent)");
    let after = [pixels(&page, "#view-a"), pixels(&page, "#view-b")];
    assert!(after[0] != before[0] && after[1] != before[1], "one drag turns both");
    page.key("x", 0);
    page.wait("document.querySelector('#tag-a').textContent.includes('Sapphire')");
    page.key("c", 0);
    page.wait("!document.body.hasAttribute('data-compare')");
    assert_eq!(page.complaints(), [] as [String; 0]);
}

#[test]
fn the_settled_picture_is_the_one_that_render_writes() {
    let Some(place) = Place::new() else { return };
    let page = place.page(SIZE);
    let [x, y] = page.middle("#view-a");
    page.drag([x, y], [x + 50.0, y + 30.0], 0);
    page.click("#swatches input[value=peridot]");
    page.wait("document.querySelector('#caption b').textContent.startsWith('Peridot')");
    page.wait("document.querySelector('#view-a').getAttribute('aria-busy') === 'true'");
    page.settle();
    for (format, extension) in [("png", "png"), ("scene", "toml")] {
        page.click(&format!("[data-save={format}]"));
        page.wait(&format!("document.querySelector('#toast').textContent.includes('.{extension}')"));
        page.click("#toast-close");
    }
    let saved = place.views();
    let find = |extension: &str| {
        saved.iter().find(|path| path.extension().is_some_and(|e| e == extension)).expect("a file")
    };
    // The command that is shown, as a shell takes it.
    page.eval(
        "import(document.querySelector('script[type=module]').src.replace('main.js', 'app.js'))
           .then(({ listen }) => listen('command', ({ text }) => { window.command = text; }))",
    );
    page.key("k", 0);
    page.wait("window.command");
    let command = page.eval("command").as_str().expect("text").to_owned();
    let shell =
        command.replacen("gemtrace render", &format!("'{}' render -q", env!("CARGO_BIN_EXE_gemtrace")), 1);
    let status = Command::new("sh").arg("-c").arg(shell).current_dir(place.folder.path()).status();
    assert!(status.expect("it runs").success(), "{command}");
    let rendered = place.folder.path().join(command.rsplit(' ').next().unwrap_or_default());
    let [written, rendered] =
        [find("png"), &rendered].map(|path| image::open(path).expect("a picture").into_rgba8());
    let (width, canvas) = pixels(&page, "#view-a");
    assert_eq!(width, rendered.width());
    assert!(canvas == rendered.as_raw()[..], "the canvas differs from what render writes");
    assert!(written == rendered, "the saved picture differs from what render writes");
    assert_eq!(page.complaints(), [] as [String; 0]);
}

#[test]
fn a_reload_and_a_second_window_show_the_same_state() {
    let Some(place) = Place::new() else { return };
    let page = place.page(SIZE);
    page.click("#swatches input[value=amethyst]");
    page.wait("document.querySelector('#caption b').textContent.startsWith('Amethyst')");
    let [x, y] = page.middle("#view-a");
    page.drag([x, y], [x + 50.0, y], 0);
    page.wait("document.querySelector('[data-act=undo]').dataset.tip?.startsWith('Undo: ')");
    page.settle();
    let (state, picture) = (pose(&page), pixels(&page, "#view-a"));
    page.call("Page.reload", serde_json::json!({}));
    page.wait("document.querySelector('#swatches input[value=amethyst]')?.checked");
    page.settle();
    assert_eq!((pose(&page), pixels(&page, "#view-a")), (state.clone(), picture.clone()));
    let second = place.page(SIZE);
    second.wait("document.querySelector('#swatches input[value=amethyst]')?.checked");
    assert_eq!((pose(&second), pixels(&second, "#view-a")), (state, picture));
    second.click("#swatches input[value=citrine]");
    page.wait("document.querySelector('#swatches input[value=citrine]').checked");
    let title: Value = page.eval("document.title");
    assert!(title.as_str().is_some_and(|t| t.contains("brilliant.asc")), "{title}");
}

#[test]
fn a_lost_connection_comes_back_with_what_was_turned_meanwhile() {
    let Some(place) = Place::new() else { return };
    let page = place.page(SIZE);
    let (before, picture) = (pose(&page), pixels(&page, "#view-a"));
    let offline = |on: bool| {
        page.call(
            "Network.emulateNetworkConditions",
            serde_json::json!({
            "offline": on, "latency": 0, "downloadThroughput": -1, "uploadThroughput": -1 }),
        );
    };
    offline(true);
    page.wait("document.querySelector('#stage-word').textContent === 'Connection lost'");
    assert_eq!(pixels(&page, "#view-a"), picture, "the last picture stays");
    let [x, y] = page.middle("#view-a");
    page.drag([x, y], [x + 60.0, y], 0);
    let turned = pose(&page);
    assert_ne!(turned, before);
    page.wait("document.querySelectorAll('#view-a .ov path').length > 0");
    page.eval("document.querySelector('[data-save=png]').click()");
    offline(false);
    page.settle();
    page.wait("!document.querySelector('[data-act=undo]').disabled");
    anew(&page, &picture);
    assert_eq!(pose(&page), turned);
}
