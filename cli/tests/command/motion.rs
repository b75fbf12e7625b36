//! `turntable` and `tilt`.

use super::read::Png;
use super::support::{Report, SCENE, Workplace, assert_matches, command};
use gemtrace::Error;
use std::path::Path;

const QUICK: [&str; 4] = ["--backend=cpu", "--samples=1", "--size=12x8", "--frames=3"];

fn run(place: &Workplace, motion: &str, options: &[String]) -> Result<Report, Error> {
    let scene = place.name("tiny.toml");
    let mut arguments = vec![motion, scene.as_str()];
    arguments.extend(QUICK);
    arguments.extend(options.iter().map(String::as_str));
    command(&arguments)
}

fn option(name: &str, path: &Path) -> String {
    format!("--{name}={}", path.display())
}

#[test]
fn frames_are_the_scene_turned_and_the_same_every_time() {
    let scene = SCENE.replace("uniform = [0.5, 0.25, 0.125]", "preset = \"studio\"");
    let place = Workplace::with(&scene);
    for name in ["one", "two"] {
        let options = [option("output", &place.path(name)), "--exr".into()];
        let report = run(&place, "turntable", &options).unwrap();
        assert_eq!(report.json["angles"], serde_json::json!([0.0, 120.0, 240.0]));
    }
    let expected: Vec<String> =
        (1..=3).flat_map(|i| ["exr", "png"].map(|kind| format!("tiny-turntable-000{i}.{kind}"))).collect();
    let frames = place.pictures("one");
    assert!(frames.keys().eq(&expected) && frames == place.pictures("two"), "{:?}", frames.keys());
    // A frame is what `render` makes of the scene with that pose.
    let posed = Workplace::with(&format!("{scene}[pose]\nturn = 120.0\n"));
    posed.render(&["a.png"], &QUICK[..3]).unwrap();
    let frame = Png::open(&place.path("one/tiny-turntable-0002.png"));
    assert_eq!(frame.samples, Png::open(&posed.path("a.png")).samples);
    assert_ne!(frame.samples, Png::open(&place.path("one/tiny-turntable-0001.png")).samples);
}

#[test]
fn a_tilt_passes_the_scene_as_it_stands() {
    let place = Workplace::new();
    let folder = place.path("frames");
    let range = "--range=-10..10".to_owned();
    let report = run(&place, "tilt", &[option("output", &folder), range]).unwrap();
    assert_eq!(report.json["angles"], serde_json::json!([-10.0, 0.0, 10.0]));
    place.render(&["still.png"], &QUICK[..3]).unwrap();
    let middle = Png::open(&folder.join("tiny-tilt-0002.png"));
    assert_eq!(middle.samples, Png::open(&place.path("still.png")).samples);
}

#[test]
fn an_animated_png_holds_every_frame() {
    let place = Workplace::with(&SCENE.replace("height = 16", "height = 16\nbackground = \"transparent\""));
    let (folder, film) = (place.path("frames"), place.path("film.png"));
    run(&place, "turntable", &[option("output", &folder), option("apng", &film), "--fps=12".into()]).unwrap();
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&film).unwrap())).read_info().unwrap();
    let animation = *reader.info().animation_control().unwrap();
    assert_eq!((animation.num_frames, animation.num_plays), (3, 0));
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    for i in 1..=3 {
        reader.next_frame(&mut pixels).unwrap();
        let frame = reader.info().frame_control().unwrap();
        assert_eq!((frame.delay_num, frame.delay_den), (1, 12));
        let single = image::open(folder.join(format!("tiny-turntable-000{i}.png"))).unwrap().into_rgba8();
        assert!(pixels == *single.as_raw(), "frame {i}");
    }
    assert!(pixels.chunks(4).any(|pixel| pixel[3] == 0));
}

#[cfg(unix)]
fn encoder(place: &Workplace, script: &str) -> String {
    use std::os::unix::fs::PermissionsExt as _;
    let path = place.path("encoder");
    place.write("encoder", format!("#!/bin/sh\nfor last; do :; done\n{script}\n"));
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    option("ffmpeg", &path)
}

#[test]
#[cfg(unix)]
fn an_encoder_gets_every_frame_over_black() {
    let place = Workplace::with(&SCENE.replace("height = 16", "height = 16\nbackground = \"transparent\""));
    let (folder, film) = (place.path("frames"), place.path("film.mp4"));
    let encoded = |script: &str| {
        let options = [option("output", &folder), option("mp4", &film), encoder(&place, script)];
        run(&place, "tilt", &options).unwrap()
    };
    encoded("cat > \"$last\"");
    let raw = std::fs::read(&film).unwrap();
    assert_eq!(raw.len(), 3 * 12 * 8 * 3);
    assert_eq!(raw[..3], [0, 0, 0], "the corner is transparent");
    let frame = image::open(folder.join("tiny-tilt-0001.png")).unwrap().into_rgba8();
    let middle = 4 * 12 + 6;
    assert_eq!(raw[3 * middle..][..3], frame.as_raw()[4 * middle..][..3]);
    // What an encoder complains of is told, and the film before stays.
    let failure = encoded("cat > /dev/null; echo no such codec >&2; exit 1").failure.unwrap();
    assert_matches(&failure.to_string(), "*(ffmpeg fails: no such codec)");
    assert_eq!(std::fs::read(&film).unwrap().len(), raw.len());
}

#[test]
fn without_an_encoder_the_frames_are_there() {
    let place = Workplace::new();
    let (folder, film) = (place.path("frames"), place.path("film.mp4"));
    let none = option("ffmpeg", &place.path("no-such-program"));
    let report = run(&place, "turntable", &[option("output", &folder), option("mp4", &film), none]).unwrap();
    let failure = report.failure.unwrap();
    assert!(failure.to_string().contains("an MP4 needs") && failure.exit_code() == 4, "{failure}");
    assert!(!film.exists() && place.pictures("frames").len() == 3);
}

#[test]
fn a_scene_that_is_wrong_is_told_with_its_own_lines() {
    let place = Workplace::with(&SCENE.replace("width = 6.5", "widht = 6.5"));
    let error = run(&place, "turntable", &[option("output", &place.path("frames"))]).unwrap_err();
    assert_matches(&error.to_string(), "*line 14: unknown key 'widht'*");
    assert!(!place.path("frames").exists());
}

#[test]
fn a_sequence_can_be_shared_out_and_gone_on_with() {
    let place = Workplace::new();
    let [one, many] = ["one", "many"].map(|name| place.path(name));
    let film = place.path("film.png");
    run(&place, "turntable", &[option("output", &one)]).unwrap();
    for shard in ["2/2", "1/2"] {
        let options = [option("output", &many), format!("--shard={shard}"), option("apng", &film)];
        assert_eq!(run(&place, "turntable", &options).unwrap().failure, None);
        assert!(!film.exists());
    }
    command(&["merge", many.to_str().unwrap()]).unwrap();
    let frames = place.pictures("one");
    assert!(frames.len() == 3 && frames == place.pictures("many"));
    // All frames are there: what is left is to join them.
    let report = run(&place, "turntable", &[option("output", &many), option("apng", &film)]).unwrap();
    assert_eq!((&report.json["rendered"], &report.json["kept"]), (&0.into(), &3.into()));
    assert!(film.exists());
}
