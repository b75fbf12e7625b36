//! What headers of environments say: exposure, primaries, how the picture lies; and JPEG.

use exr::meta::attribute::Chromaticities;
use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage};
use gemtrace::import::environment::read;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use spectral_core::color::{RgbSpace, matrix::apply, srgb_decode};
use std::io::Cursor;
use std::path::Path;

/// A flat HDR of 2 × 3 texels, each row by row twice its number, with lines of the header.
fn hdr(signature: &str, lines: &str, size: &str) -> Vec<u8> {
    let mut file = format!("{signature}\n{lines}\n{size}\n").into_bytes();
    // Mantissa · 2^(exponent − 136): 128 is a half at 136.
    (1..=6).for_each(|k| file.extend([20 * k, 10 * k, 5 * k, 136]));
    file
}

const FORMAT: &str = "FORMAT=32-bit_rle_rgbe\n";

fn texels(bytes: &[u8]) -> Vec<[f32; 3]> {
    let (image, _) = read(Path::new("a.hdr"), bytes).unwrap_or_else(|e| panic!("{e}"));
    image.texels().to_vec()
}

/// The red components, as the numbers of the texels in the file.
fn order(bytes: &[u8]) -> Vec<u8> {
    texels(bytes).iter().map(|texel| (texel[0] / 20.0).round() as u8).collect()
}

#[test]
fn the_signature_of_an_hdr_is_any_programs() {
    let plain = texels(&hdr("#?RADIANCE", FORMAT, "-Y 3 +X 2"));
    assert_eq!(plain[0], [20.0, 10.0, 5.0]);
    for signature in ["#?RGBE", "#?AUTOPANO", "#?"] {
        assert_eq!(texels(&hdr(signature, FORMAT, "-Y 3 +X 2")), plain, "{signature}");
    }
    assert_eq!(texels(&hdr("#?RGBE", "", "-Y 3 +X 2")), plain);
    let windows = "#?RGBE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 3 +X 2\n".as_bytes();
    let mut file = windows.to_vec();
    (1..=6).for_each(|k| file.extend([20 * k, 10 * k, 5 * k, 136]));
    assert_eq!(texels(&file), plain);
}

#[test]
fn pixels_of_an_hdr_become_radiance() {
    let first = |lines: &str| texels(&hdr("#?RADIANCE", &format!("{lines}{FORMAT}"), "-Y 3 +X 2"))[0];
    for (lines, expected) in [
        ("EXPOSURE=2\n", [10.0, 5.0, 2.5]),
        ("EXPOSURE= 2.0\nEXPOSURE=0.5\nPIXASPECT=1.0\n", [20.0, 10.0, 5.0]),
        ("\tEXPOSURE=2\n# EXPOSURE=2\n", [20.0, 10.0, 5.0]),
        ("COLORCORR=2 1 0.5\n", [10.0, 10.0, 10.0]),
        ("GAMMA=2\n", [400.0, 100.0, 25.0]),
        ("PRIMARIES=.64 .33 .3 .6 .15 .06 .3127 .329\n", [20.0, 10.0, 5.0]),
    ] {
        let found = first(lines);
        assert!((0..3).all(|c| (found[c] / expected[c] - 1.0).abs() < 1e-6), "{lines}: {found:?}");
    }
    let (aces, white) = (RgbSpace::AcesCg.primaries(), RgbSpace::AcesCg.white());
    let eight: Vec<String> = aces.iter().chain([&white]).flatten().map(f64::to_string).collect();
    let wanted = apply(&RgbSpace::AcesCg.to_linear_srgb(), [20.0, 10.0, 5.0]);
    let found = first(&format!("PRIMARIES= {}\n", eight.join(" ")));
    assert!((0..3).all(|c| (f64::from(found[c]) / wanted[c] - 1.0).abs() < 1e-5), "{found:?} {wanted:?}");
    // Equal energy is white.
    let mut file = b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n".to_vec();
    file.extend([128, 128, 128, 129].repeat(2));
    assert!(texels(&file)[0].iter().all(|c| (c - 1.0).abs() < 1e-3), "{:?}", texels(&file));
    for (lines, message) in [
        ("EXPOSURE=0\n", "its EXPOSURE is '0', where 1 positive number is expected"),
        ("COLORCORR=1 1\n", "its COLORCORR is '1 1', where 3 positive numbers are expected"),
        ("PRIMARIES=1 2 3\n", "its PRIMARIES are '1 2 3', where eight numbers are expected"),
        ("PRIMARIES=0 0 0 0 0 0 0 0\n", "its primaries and white span no colours"),
        ("FORMAT=rgb\n", "its FORMAT is 'rgb': 32-bit_rle_rgbe and 32-bit_rle_xyze are read"),
    ] {
        let file = hdr("#?RADIANCE", lines, "-Y 3 +X 2");
        let error = read(Path::new("a.hdr"), file).unwrap_err().to_string();
        assert!(error.ends_with(message), "{error}");
    }
}

#[test]
fn an_hdr_may_lie_in_any_way() {
    for (size, expected) in [
        ("-Y 3 +X 2", [1, 2, 3, 4, 5, 6]),
        ("-Y 3 -X 2", [2, 1, 4, 3, 6, 5]),
        ("+Y 3 +X 2", [5, 6, 3, 4, 1, 2]),
        ("+Y 3 -X 2", [6, 5, 4, 3, 2, 1]),
        // Two columns of three, the first from the top down.
        ("+X 2 -Y 3", [1, 4, 2, 5, 3, 6]),
        ("+X 2 +Y 3", [3, 6, 2, 5, 1, 4]),
        ("-X 2 -Y 3", [4, 1, 5, 2, 6, 3]),
        ("-X 2 +Y 3", [6, 3, 5, 2, 4, 1]),
    ] {
        assert_eq!(order(&hdr("#?RADIANCE", FORMAT, size)), expected, "{size}");
    }
    for size in ["3 2", "-Y 3 -Y 2", "-Y x +X 2", "-Y -3 +X 2", ""] {
        let error = read(Path::new("a.hdr"), hdr("#?RADIANCE", FORMAT, size)).unwrap_err().to_string();
        assert!(error.contains("where '-Y height +X width' is expected"), "{size}: {error}");
    }
}

/// An EXR of 2 × 1 equal texels with these primaries and white.
fn exr(texel: [f64; 3], declared: Option<[[f64; 2]; 4]>) -> Vec<u8> {
    let [r, g, b] = texel.map(|c| c as f32);
    let channels = SpecificChannels::rgb(move |_| (r, g, b));
    let layer = Layer::new((2, 1), LayerAttributes::named("light"), Encoding::FAST_LOSSLESS, channels);
    let mut image = Image::from_layer(layer);
    let pair = |[x, y]: [f64; 2]| Vec2(x as f32, y as f32);
    image.attributes.chromaticities = declared.map(|given| {
        let [red, green, blue, white] = given.map(pair);
        Chromaticities { red, green, blue, white }
    });
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn the_primaries_of_an_exr_are_converted() {
    let declared = |space: RgbSpace| {
        let [red, green, blue] = space.primaries();
        let white = if space == RgbSpace::Xyz { [1.0 / 3.0; 2] } else { space.white() };
        [red, green, blue, white]
    };
    for space in RgbSpace::ALL {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3], [0.2, 3.0, 0.7]] {
            let file = exr(apply(&space.from_linear_srgb(), rgb), Some(declared(space)));
            let (image, warnings) = read(Path::new("a.exr"), file).unwrap();
            let found = image.texels()[0].map(f64::from);
            assert!((0..3).all(|c| (found[c] - rgb[c]).abs() < 2e-6), "{}: {found:?}", space.name());
            assert!(warnings.is_empty(), "{warnings:?}");
        }
    }
    // ACES 2065-1, which is none of ours: its white is white.
    let ap0 = [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]];
    let (image, _) = read(Path::new("a.exr"), exr([0.5; 3], Some(ap0))).unwrap();
    assert!(image.texels()[0].iter().all(|c| (c - 0.5).abs() < 1e-5), "{:?}", image.texels()[0]);
    let (image, warnings) = read(Path::new("a.exr"), exr([0.5, 0.25, 0.1], Some([[0.0; 2]; 4]))).unwrap();
    assert_eq!(image.texels()[0], [0.5, 0.25, 0.1]);
    assert!(
        warnings[0].message.contains("span no colours; its values are taken for linear sRGB"),
        "{warnings:?}"
    );
    assert_eq!(read(Path::new("a.exr"), exr([0.5; 3], None)).unwrap().0.texels()[0], [0.5; 3]);
}

#[test]
fn a_jpeg_is_srgb_and_says_what_it_lacks() {
    let pixels = [200_u8, 100, 50].repeat(16 * 8);
    let encode = |profile: Option<Vec<u8>>| {
        let mut bytes = Vec::new();
        let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 100);
        if let Some(profile) = profile {
            encoder.set_icc_profile(profile).unwrap();
        }
        encoder.write_image(&pixels, 16, 8, ExtendedColorType::Rgb8).unwrap();
        read(Path::new("a.jpg"), bytes).unwrap()
    };
    let (plain, warnings) = encode(None);
    let found = plain.texels()[0];
    let wanted = [200.0, 100.0, 50.0].map(|v| srgb_decode(v / 255.0));
    assert!((0..3).all(|c| (f64::from(found[c]) - wanted[c]).abs() < 0.01), "{found:?}");
    assert!(
        warnings.len() == 1 && warnings[0].message.contains("no light brighter than white"),
        "{warnings:?}"
    );
    // The same numbers in a wider space are a stronger orange.
    let (wide, warnings) = encode(Some(moxcms::ColorProfile::new_display_p3().encode().unwrap()));
    let [r, g, b] = wide.texels()[0];
    assert!(
        r > found[0] + 0.02 && g < found[1] && b < found[2] && warnings.len() == 1,
        "{:?}",
        wide.texels()[0]
    );
    let (odd, warnings) = encode(Some(vec![0; 200]));
    assert!(
        odd.texels()[0] == found && warnings[1].message.contains("colour profile cannot be used"),
        "{warnings:?}"
    );
    assert!(read(Path::new("a.jpg"), [0xff, 0xd8, 0xff, 0xe0, 0, 0]).is_err());
}
