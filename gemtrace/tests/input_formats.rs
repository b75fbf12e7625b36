//! What is read: the three formats of a cut, the formats and channels of environments, and whole scenes.

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    SmallVec, SpecificChannels, Vec2, WritableImage, f16,
};
use gemtrace::{import, scene_file};
use glam::DVec3;
use spectral_core::camera::Projection;
use spectral_core::cut::Cut;
use spectral_core::environment::{LatLong, Source};
use spectral_core::mesh::Plane;
use spectral_core::scene::Background;
use spectral_core::settings::{Coverage, Leftover, Quality, RenderSettings};
use spectral_core::wavelength::WavelengthGrid;
use std::io::Cursor;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn cut(name: &str) -> Cut {
    let path = root().join("spectral-core/data/cuts").join(name);
    let (cut, warnings) = import::cut::read(&path, &import::read_file(&path).unwrap()).unwrap();
    assert!(warnings.is_empty(), "{name}: {warnings:?}");
    cut
}

/// The planes in the frame of Gem Cut Studio: the larger of the x and y reach is 1, and z is centred.
fn normalised(cut: &Cut) -> Vec<Plane> {
    let (low, high) = cut.solid().unwrap().0.bounds();
    let scale = 1.0 / low.abs().max(high.abs()).truncate().max_element();
    let centre = DVec3::new(0.0, 0.0, (low.z + high.z) / 2.0);
    let moved = |p: Plane| Plane { normal: p.normal, offset: scale * (p.offset - p.normal.dot(centre)) };
    cut.facets.iter().map(|f| moved(f.plane)).collect()
}

/// How far the planes of `a` are from their nearest of `b`, normal and offset, at most.
fn distance(a: &[Plane], b: &[Plane]) -> f64 {
    assert_eq!(a.len(), b.len());
    let apart = |p: &Plane, q: &Plane| (p.normal - q.normal).length().max((p.offset - q.offset).abs());
    let nearest = |p: &Plane| b.iter().map(|q| apart(p, q)).fold(f64::INFINITY, f64::min);
    a.iter().map(nearest).fold(0.0, f64::max)
}

#[test]
fn three_formats_of_a_cut_give_the_same_planes() {
    for name in ["srb_diamond_57", "emerald_step_49", "portuguese_161"] {
        let [asc, gem, gcs] = ["asc", "gem", "gcs"].map(|format| cut(&format!("{name}.{format}")));
        let planes = |cut: &Cut| cut.facets.iter().map(|f| f.plane).collect::<Vec<_>>();
        let binary = distance(&planes(&asc), &planes(&gem));
        assert!(binary < 1e-6, "{name}: .gem differs by {binary:e}");
        let studio = distance(&normalised(&asc), &normalised(&gcs));
        assert!(studio < 1e-5, "{name}: .gcs differs by {studio:e}");
        assert_eq!((asc.gear, gem.gear, gcs.gear), (Some(96), Some(96), Some(96)));
        assert_eq!(asc.index_of_refraction, gem.index_of_refraction);
        assert!(
            asc.facets.iter().zip(&gem.facets).all(|(a, g)| g.name.is_none() || a.name == g.name),
            "{name}"
        );
    }
}

fn environment(name: &str, bytes: &[u8]) -> (LatLong, Vec<String>) {
    let (image, warnings) = import::environment::read(Path::new(name), bytes).unwrap();
    (image, warnings.into_iter().map(|w| w.message).collect())
}

/// An EXR of 4 × 2 texels with these channels; each channel's value is its number from 1, texel by texel ten more.
fn exr(channels: &[&str], compression: Compression) -> Vec<u8> {
    let list: SmallVec<[_; 4]> = channels
        .iter()
        .enumerate()
        .map(|(c, name)| {
            let values = (0..8).map(|texel| (c + 1 + 10 * texel) as f32).collect();
            AnyChannel::new(*name, FlatSamples::F32(values))
        })
        .collect();
    let encoding = Encoding { compression, ..Encoding::UNCOMPRESSED };
    let layer = Layer::new((4, 2), LayerAttributes::default(), encoding, AnyChannels::sort(list));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// An EXR of 40 × 33 texels of half floats, (x, xy, ½).
fn gradient(compression: Compression, blocks: Blocks) -> Vec<u8> {
    let half = |v: usize| f16::from_f32(v as f32);
    let channels =
        SpecificChannels::rgb(|at: Vec2<usize>| (half(at.0), half(at.0 * at.1), f16::from_f32(0.5)));
    let encoding = Encoding { compression, blocks, ..Encoding::UNCOMPRESSED };
    let mut bytes = Cursor::new(Vec::new());
    let layer = Layer::new((40, 33), LayerAttributes::default(), encoding, channels);
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn every_compression_is_read() {
    use Compression::{B44, B44A, DWAA, DWAB, PIZ, PXR24, RLE, Uncompressed, ZIP1, ZIP16};
    for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ, PXR24, B44, B44A, DWAA(None), DWAB(None)] {
        // Tiny tiles are stored as they are where compression does not pay.
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 16)), Blocks::Tiles(Vec2(2, 1))] {
            let (image, _) = environment("a.exr", &gradient(compression, blocks));
            let texel = image.texels()[20 * 40 + 30];
            let wanted = [30.0, 600.0, 0.5];
            // The lossy methods promise no bound; a gradient comes back within a few per cent of its range.
            let near = texel.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= 0.02 * b + 0.5);
            assert!(near, "{compression} {blocks:?}: {texel:?}");
        }
    }
}

#[test]
fn dwa_chunks_that_ask_for_terabytes_are_refused() {
    let mut bytes = include_bytes!("../../scenes/environments/apartment.exr").to_vec();
    // The first chunk: the offset table follows the header's closing zero; its first entry points at (y, size, data).
    let first = first_chunk(&bytes);
    let counter = first + 8 + 7 * 8;
    bytes[counter..counter + 8].copy_from_slice(&(1u64 << 40).to_le_bytes());
    let error = import::environment::read(Path::new("a.exr"), &bytes).unwrap_err().to_string();
    assert!(
        error.starts_with("a.exr: not a complete OpenEXR file: ") && error.contains("DWA section size"),
        "{error}"
    );
}

/// Where the first chunk of a single-part EXR with one scan-line block stands.
fn first_chunk(bytes: &[u8]) -> usize {
    let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    // The one place in the head that points right behind itself.
    (8..4096).find(|&at| number(at) == at + 8).expect("an offset table of one entry")
}

#[test]
fn channels_are_found_by_name() {
    let texel = |channels: &[&str]| environment("a.exr", &exr(channels, Compression::ZIP16)).0.texels()[0];
    assert_eq!(texel(&["A", "B", "G", "R"]), [4.0, 3.0, 2.0]);
    assert_eq!(texel(&["Y"]), [1.0; 3]);
    assert_eq!(texel(&["Combined.B", "Combined.G", "Combined.R", "Depth.Z"]), [3.0, 2.0, 1.0]);
}

#[test]
fn odd_channels_are_named() {
    let refused = |channels: &[&str]| {
        let bytes = exr(channels, Compression::ZIP16);
        import::environment::read(Path::new("a.exr"), &bytes).unwrap_err().to_string()
    };
    let expected = "a.exr: an environment needs the channels R, G and B, or Y alone; found: ";
    assert_eq!(refused(&["Z", "normal.X"]), format!("{expected}Z, normal.X"));
    assert_eq!(refused(&["G", "R"]), format!("{expected}G, R"));
    assert_eq!(refused(&["BY", "RY", "Y"]), format!("{expected}BY, RY, Y"));
    assert_eq!(refused(&["S0.500nm"]), format!("{expected}S0.500nm"));
}

#[test]
fn broken_texels_are_counted_and_replaced() {
    let values = |low| [1.0, f32::NAN, f32::INFINITY, 4.0, low, 6.0, 7.0, 8.0];
    let read = |low| environment("a.exr", &grey(&values(low)));
    let (image, warnings) = read(-5.0);
    assert_eq!(image.texels()[..5], [[1.0; 3], [0.0; 3], [0.0; 3], [4.0; 3], [0.0; 3]]);
    assert!(warnings[0].starts_with("a.exr: 2 of the environment's 8 texels are not finite"), "{warnings:?}");
    assert!(warnings[1].starts_with("a.exr: 1 of the environment's 8 texels"), "{warnings:?}");
    // 1/40 of a light of 26: beyond it there is something to see.
    assert_eq!([-0.66, -0.64, -0.0].map(|low| read(low).1.len()), [2, 1, 1]);
}

/// Grey texels, 4 × 2.
fn grey(values: &[f32; 8]) -> Vec<u8> {
    let channel = |name| AnyChannel::new(name, FlatSamples::F32(values.to_vec()));
    let channels = AnyChannels::sort(["R", "G", "B"].into_iter().map(channel).collect::<SmallVec<[_; 4]>>());
    let layer = Layer::new((4, 2), LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn png_is_decoded_and_hdr_is_linear() {
    let picture = image::RgbaImage::from_fn(4, 2, |x, _| image::Rgba([0, 128, (x * 85) as u8, 9]));
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let (png, warnings) = environment("a.png", bytes.get_ref());
    let [r, g, b] = png.texels()[3];
    assert!(r == 0.0 && (g - 0.215_860_5).abs() < 1e-6 && (b - 1.0).abs() < 1e-6, "{:?}", png.texels()[3]);
    assert_eq!(warnings, ["a.png: its alpha channel is ignored"]);
    // RGBE: mantissas over 256, times two to the fourth byte less 128.
    let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    (0..8).for_each(|_| hdr.extend([128, 64, 32, 132]));
    let (hdr, warnings) = environment("a.hdr", &hdr);
    assert_eq!(hdr.texels()[7], [8.0, 4.0, 2.0]);
    assert!(warnings.is_empty(), "{warnings:?}");
    let square = image::RgbImage::new(2, 2);
    let mut bytes = Cursor::new(Vec::new());
    square.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let (_, warnings) = environment("a.png", bytes.get_ref());
    assert!(warnings[0].contains("not twice as wide as high"), "{warnings:?}");
}

#[test]
fn every_scene_that_comes_with_the_program_loads() {
    let mut count = 0;
    for entry in std::fs::read_dir(root().join("scenes")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            let loaded = scene_file::load(&path).unwrap_or_else(|e| panic!("{e}"));
            spectral_core::prepare::PreparedScene::new(&loaded.scene, &loaded.settings).unwrap();
            let Source::Image(image) = &loaded.scene.environment.source else { panic!("{}", path.display()) };
            assert!(image.texels().iter().flatten().all(|v| v.is_finite()));
            count += 1;
        }
    }
    assert!(count >= 7, "{count} scenes");
}

/// The format as it was first written down, whole.
const REFERENCE: &str = include_str!("data/reference.toml");

#[test]
fn every_key_arrives() {
    let loaded = scene_file::parse(REFERENCE, Path::new("a.toml"), &root().join("scenes")).unwrap();
    let (scene, settings) = (&loaded.scene, &loaded.settings);
    assert_eq!(scene.camera.position, DVec3::new(0.0, -11.12, 30.05));
    assert_eq!(scene.camera.projection, Projection::Perspective { fov: 14.0 });
    assert_eq!((scene.width, scene.height, scene.background), (512, 256, Background::Environment));
    assert_eq!((scene.environment.rotation, scene.environment.scale), (30.0, 2.0));
    let [cut, shape] = &scene.stones[..] else { panic!("two stones") };
    assert_eq!((cut.width, cut.position, cut.rotation), (Some(6.5), DVec3::Y, DVec3::new(10.0, 20.0, 30.0)));
    assert_eq!((cut.mesh.facets().len(), shape.mesh.facets().len()), (73, 121));
    assert!((cut.material.absorption(553.0) - 0.915).abs() < 1e-12);
    assert_eq!((settings.samples, settings.wavelengths.len(), settings.jitter), (16, 32, false));
    assert_eq!((settings.max_depth, settings.leftover, settings.threshold), (63, Leftover::Drop, 1e-4));
    assert_eq!((settings.polarized, settings.spectral), (false, true));
    assert_eq!(loaded.files.len(), 2);
}

#[test]
fn the_other_ways_to_say_it_arrive_too() {
    let text = "format = 1\n[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\northographic = 8\n\
        [film]\nbackground = \"transparent\"\n[environment]\nuniform = [1, 2, 3]\nilluminant = \"light.csv\"\n\
        [[stone]]\nshape = \"step\"\nmaterial = \"diamond\"\nname = \"mine\"\npriority = -3\n\
        [material.diamond]\nlike = \"ruby\"\n[render]\nwavelengths = [420, 460, 490]\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("light.csv"), "380,1\n780,2\n").unwrap();
    let loaded = scene_file::parse(text, Path::new("a.toml"), folder.path()).unwrap();
    assert_eq!(loaded.scene.camera.projection, Projection::Orthographic { height: 8.0 });
    assert_eq!(loaded.scene.background, Background::Transparent);
    assert_eq!(loaded.scene.environment.source, Source::Uniform([1.0, 2.0, 3.0]));
    let stone = &loaded.scene.stones[0];
    assert_eq!((stone.name.as_str(), stone.priority), ("mine", -3));
    assert!(stone.material.index(589.3) < 1.8, "the scene's own diamond comes before the catalogue's");
    assert!(!loaded.settings.jitter && loaded.settings.wavelengths.nm() == [420.0, 460.0, 490.0]);
    assert!(loaded.warnings.iter().any(|w| w.message.contains("mine has no width")), "{:?}", loaded.warnings);
    let rest =
        scene_file::parse(&text[..text.find("[film]").unwrap()], Path::new("a.toml"), folder.path()).unwrap();
    let settings = |render: &str| {
        let text = format!("{}[render]\n{render}\n", &text[..text.find("[film]").unwrap()]);
        scene_file::parse(&text, Path::new("a.toml"), folder.path()).unwrap().settings
    };
    let plain = RenderSettings::default();
    assert_eq!(rest.settings, plain.at(Quality::Normal));
    assert_eq!(settings("quality = 'draft'"), plain.at(Quality::Draft));
    // Numbers are for what the quality leaves open, wherever they stand.
    assert_eq!(settings("samples = 4\nquality = 'final'"), plain.at(Quality::Final).with_samples(4));
    let most = plain.at(Quality::Normal).with_samples(27).with_tolerance(2.0);
    assert_eq!(settings("samples = 27\ntolerance = 2"), most);
    assert_eq!(settings("tolerance = 2"), plain.at(Quality::Normal).with_tolerance(2.0));
    let coverage = |text: &str| settings(text).coverage;
    assert_eq!(coverage("quality = 'final'"), Coverage::Auto);
    assert_eq!(coverage("quality = 'final'\nsamples = 4"), Coverage::Points);
    assert_eq!(coverage("coverage = 'points'"), Coverage::Points);
    assert_eq!(settings("coverage = 'area'\nsamples = 9").area.offsets, 9);
    assert_eq!(settings("spectral = true").wavelengths, WavelengthGrid::default());
    assert!(rest.scene.stones.is_empty() && rest.files.is_empty());
}

#[test]
fn the_hash_follows_the_text_and_the_files() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("light.csv");
    let text = "format = 1\n[camera]\nposition = [0, 0, 9]\nlook_at = [1, 0, 0]\n[environment]\nilluminant = \"light.csv\"\n";
    let hash = |text: &str| scene_file::parse(text, Path::new("a.toml"), folder.path()).unwrap().hash;
    std::fs::write(&table, "380,1\n780,2\n").unwrap();
    let first = hash(text);
    assert_eq!((first.len(), &first), (64, &hash(text)));
    assert_ne!(first, hash(&text.replace("0, 9", "0, 8")));
    std::fs::write(&table, "380,1\n780,3\n").unwrap();
    assert_ne!(first, hash(text));
}
