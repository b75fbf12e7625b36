//! Frames as one file that moves: animated PNG, and MP4 where ffmpeg is installed.
//!
//! Both are made of the frames' PNG files, so that they can be made anew at any time, and of frames that were rendered
//! in pieces.

use super::file;
use crate::Error;
use crate::import::{self, picture};
use image::RgbaImage;
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};
use spectral_core::color::{srgb_decode, srgb_encode};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Writes frames as an animated PNG that repeats without end: 8 bits, straight alpha.
///
/// # Errors
/// [`Error::File`] for a frame that cannot be read or has another size, [`Error::Output`] for the file.
pub fn apng(frames: &[PathBuf], fps: u16, path: &Path) -> Result<(), Error> {
    let first = read(frames, 0, None)?;
    let size = first.dimensions();
    let mut broken = None;
    let written = file::write(path, |file| {
        let mut buffer = BufWriter::new(file);
        encode(frames, fps, &first, &mut buffer, |i| {
            read(frames, i, Some(size)).inspect_err(|e| broken = Some(e.clone())).ok()
        })
        .map_err(|e| e.to_string())?;
        buffer.flush().map_err(|e| e.to_string())
    });
    broken.map_or(written.map(drop), Err)
}

fn encode(
    frames: &[PathBuf],
    fps: u16,
    first: &RgbaImage,
    output: &mut impl Write,
    mut frame: impl FnMut(usize) -> Option<RgbaImage>,
) -> Result<(), png::EncodingError> {
    let (width, height) = first.dimensions();
    let mut encoder = Encoder::new(output, width, height);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
    encoder.set_animated(frames.len() as u32, 0)?;
    encoder.set_frame_delay(1, fps)?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(first.as_raw())?;
    for i in 1..frames.len() {
        let Some(image) = frame(i) else {
            return Err(png::EncodingError::IoError(std::io::Error::other("a frame is missing")));
        };
        writer.write_image_data(image.as_raw())?;
    }
    writer.finish()
}

/// Encodes frames as MP4 (H.264, 4:2:0) by the program `ffmpeg`; what is transparent shows black, and an odd width or
/// height gains a row of black.
///
/// # Errors
/// [`Error::File`] for a frame, [`Error::Output`] where there is no ffmpeg or it fails.
pub fn mp4(frames: &[PathBuf], fps: u16, path: &Path, ffmpeg: &Path) -> Result<(), Error> {
    let first = read(frames, 0, None)?;
    let size = first.dimensions();
    let mut broken = None;
    let written = file::write(path, |file| {
        let (feed, place) = (tempfile::tempdir().map_err(|e| e.to_string())?, "film.mp4");
        let made = feed.path().join(place);
        let mut child = start(ffmpeg, size, fps, &made)?;
        let mut input = child.stdin.take().ok_or("ffmpeg takes no input")?;
        let mut fed = input.write_all(&over_black(&first));
        for i in 1..frames.len() {
            let Ok(image) = read(frames, i, Some(size)).inspect_err(|e| broken = Some(e.clone())) else {
                break;
            };
            fed = fed.and_then(|()| input.write_all(&over_black(&image)));
        }
        drop(input);
        let outcome = child.wait_with_output().map_err(|e| e.to_string())?;
        if !outcome.status.success() {
            let said = String::from_utf8_lossy(&outcome.stderr);
            let last = said.trim().lines().last().unwrap_or("without a word").to_owned();
            return Err(format!("ffmpeg fails: {last}"));
        }
        fed.map_err(|e| format!("ffmpeg does not take the frames: {e}"))?;
        let mut film = File::open(&made).map_err(|e| format!("ffmpeg left no film: {e}"))?;
        std::io::copy(&mut film, file).map(drop).map_err(|e| e.to_string())
    });
    broken.map_or(written.map(drop), Err)
}

/// ffmpeg, waiting for raw frames.
fn start(
    ffmpeg: &Path,
    (width, height): (u32, u32),
    fps: u16,
    made: &Path,
) -> Result<std::process::Child, String> {
    let mut command = Command::new(ffmpeg);
    command.args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
    command.args(["-s", &format!("{width}x{height}"), "-r", &fps.to_string(), "-i", "-"]);
    // 4:2:0 wants even sizes; sRGB is shown as BT.709 by players.
    command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709,format=yuv420p"]);
    command.args(["-c:v", "libx264", "-crf", "16", "-colorspace", "bt709", "-color_primaries", "bt709"]);
    command.args(["-color_trc", "iec61966-2-1", "-movflags", "+faststart", "-f", "mp4"]).arg(made);
    command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().map_err(|e| {
        let program = ffmpeg.display();
        format!("an MP4 needs {program}, which cannot be started: {e}; the frames are there for any encoder")
    })
}

/// Blended with black in linear light, as light itself would be.
fn over_black(image: &RgbaImage) -> Vec<u8> {
    let blend = |c: u8, alpha: u8| match alpha {
        255 => c,
        0 => 0,
        _ => {
            let light = srgb_decode(f64::from(c) / 255.0) * f64::from(alpha) / 255.0;
            (srgb_encode(light) * 255.0).round() as u8
        }
    };
    image.pixels().flat_map(|pixel| [0, 1, 2].map(|c| blend(pixel.0[c], pixel.0[3]))).collect()
}

fn read(frames: &[PathBuf], i: usize, size: Option<(u32, u32)>) -> Result<RgbaImage, Error> {
    let path = frames.get(i).ok_or_else(|| Error::Usage("a film needs at least one frame".to_owned()))?;
    let image = picture::png(&import::read_file(path)?).map_err(|e| Error::file(path, e))?.into_rgba8();
    match size {
        Some(size) if size != image.dimensions() => {
            let (width, height) = size;
            Err(Error::file(path, format!("this frame is not of the first one's size, {width} × {height}")))
        }
        _ => Ok(image),
    }
}
