//! Radiance HDR: its header here, its pixels through the crate `image`.
//!
//! The header says how pixels become radiance: they are divided by every EXPOSURE and COLORCORR (G. Ward, "The Radiance
//! picture file format"), and raised to GAMMA where a program wrote corrected ones (B. Walter's rgbe.c). It also names the
//! PRIMARIES and how the picture lies. The signature after `#?` is the name of a program and says nothing.

use super::chromaticity::{self, Chromaticities};
use super::{Decoded, check_size};
use crate::import::picture::incomplete;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;
use spectral_core::{memory, shown};
use std::io::Read;

/// Longer headers are no headers, bytes.
const LONGEST: usize = 1 << 20;
/// XYZ as primaries: that of FORMAT=32-bit_rle_xyze.
const XYZ: Chromaticities = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]];

/// What a header says of the pixels.
struct Header {
    /// What each component was multiplied by.
    gain: [f64; 3],
    gamma: f64,
    primaries: Option<Chromaticities>,
    /// Width and height, as the picture is seen.
    size: [usize; 2],
    /// Whether scan lines are columns.
    upright: bool,
    /// Whether scan lines begin at the right or the bottom, and whether the first of them is there.
    reversed: [bool; 2],
    /// Where pixels begin, bytes.
    end: usize,
}

/// Decoded into the texels themselves.
pub(super) fn read(bytes: &[u8]) -> Result<Decoded, String> {
    let header = Header::read(bytes)?;
    let [width, height] = header.size;
    let size = check_size(width, height, bytes.len())?;
    memory::check(width as u64 * height as u64 * 12, || "the image".into()).map_err(|e| e.to_string())?;
    let [length, lines] = if header.upright { [height, width] } else { [width, height] };
    let plain = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {lines} +X {length}\n");
    let pixels = bytes.get(header.end..).unwrap_or_default();
    let decoder = HdrDecoder::new(plain.as_bytes().chain(pixels)).map_err(incomplete)?;
    let mut texels = vec![[0.0_f32; 3]; width * height];
    decoder.read_image(bytemuck::cast_slice_mut(&mut texels)).map_err(incomplete)?;
    header.correct(&mut texels)?;
    Ok(Decoded { size, texels: header.laid(texels), warnings: Vec::new() })
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut header = Header {
            gain: [1.0; 3],
            gamma: 1.0,
            primaries: None,
            size: [0; 2],
            upright: false,
            reversed: [false; 2],
            end: 0,
        };
        let mut format = None;
        loop {
            let line = header.line(bytes)?;
            if line.is_empty() {
                break;
            }
            // What is indented was the header of a picture that this one was made of.
            let Some((key, value)) = line.split_once('=') else { continue };
            match key {
                "EXPOSURE" => header.divide(numbers::<1>(key, value)?.map(|v| [v; 3])[0]),
                "COLORCORR" => header.divide(numbers(key, value)?),
                "GAMMA" => [header.gamma] = numbers(key, value)?,
                "PRIMARIES" => header.primaries = Some(primaries(value)?),
                "FORMAT" => format = Some(value.trim().to_owned()),
                _ => {}
            }
        }
        match format.as_deref() {
            None | Some("32-bit_rle_rgbe") => {}
            Some("32-bit_rle_xyze") => header.primaries = Some(XYZ),
            Some(other) => {
                let other = shown(other);
                return Err(format!("its FORMAT is '{other}': 32-bit_rle_rgbe and 32-bit_rle_xyze are read"));
            }
        }
        let line = header.line(bytes)?;
        header.lie(&line)?;
        Ok(header)
    }

    /// The next line.
    fn line(&mut self, bytes: &[u8]) -> Result<String, String> {
        let rest = bytes.get(self.end..bytes.len().min(LONGEST)).unwrap_or_default();
        let end =
            rest.iter().position(|b| *b == b'\n').ok_or("not a complete image: its header has no end")?;
        self.end += end + 1;
        Ok(String::from_utf8_lossy(&rest[..end]).trim_end_matches('\r').to_owned())
    }

    fn divide(&mut self, by: [f64; 3]) {
        (0..3).for_each(|c| self.gain[c] *= by[c]);
    }

    /// How the picture lies: `-Y 512 +X 1024` is from the top down, each line from left to right.
    fn lie(&mut self, line: &str) -> Result<(), String> {
        let refuse = || format!("its size is '{}', where '-Y height +X width' is expected", shown(line));
        let words: Vec<&str> = line.split_whitespace().collect();
        let [first, lines, second, length] = words[..] else { return Err(refuse()) };
        let count = |word: &str| word.parse::<usize>().map_err(|_| refuse());
        let (lines, length) = (count(lines)?, count(length)?);
        // Rows count from the top, columns from the left.
        let reversed = |axis: &str| matches!(axis, "+Y" | "-X");
        (self.upright, self.size) = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => (false, [length, lines]),
            ("-X" | "+X", "-Y" | "+Y") => (true, [lines, length]),
            _ => return Err(refuse()),
        };
        self.reversed = [reversed(second), reversed(first)];
        Ok(())
    }

    /// Texels as radiance in linear sRGB.
    fn correct(&self, texels: &mut [[f32; 3]]) -> Result<(), String> {
        if self.gamma != 1.0 || self.gain != [1.0; 3] {
            for texel in &mut *texels {
                *texel =
                    std::array::from_fn(|c| (f64::from(texel[c]).powf(self.gamma) / self.gain[c]) as f32);
            }
        }
        match self.primaries {
            Some(given) if given == XYZ => chromaticity::adapt(texels, &XYZ),
            Some(given) => chromaticity::convert(texels, &given),
            None => Ok(()),
        }
    }

    /// Texels from the top down, each row from left to right.
    fn laid(&self, texels: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
        if !self.upright && self.reversed == [false; 2] {
            return texels;
        }
        let [width, height] = self.size;
        let [length, lines] = if self.upright { [height, width] } else { [width, height] };
        let turn = |k: usize, count: usize, reversed: bool| if reversed { count - 1 - k } else { k };
        let texel = |(x, y): (usize, usize)| {
            let (along, line) = if self.upright { (y, x) } else { (x, y) };
            texels[turn(line, lines, self.reversed[1]) * length + turn(along, length, self.reversed[0])]
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(texel).collect()
    }
}

/// `N` positive numbers.
fn numbers<const N: usize>(key: &str, value: &str) -> Result<[f64; N], String> {
    let read: Option<Vec<f64>> = value.split_whitespace().map(|word| word.parse().ok()).collect();
    let read = read.filter(|read| read.iter().all(|v: &f64| v.is_finite() && *v > 0.0));
    let refuse = || {
        format!(
            "its {key} is '{}', where {N} positive number{} expected",
            shown(value.trim()),
            if N == 1 { " is" } else { "s are" }
        )
    };
    read.and_then(|read| read.try_into().ok()).ok_or_else(refuse)
}

fn primaries(value: &str) -> Result<Chromaticities, String> {
    let read: Vec<f64> = value.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let refuse = || format!("its PRIMARIES are '{}', where eight numbers are expected", shown(value.trim()));
    let [rx, ry, gx, gy, bx, by, wx, wy] = read[..] else { return Err(refuse()) };
    Ok([[rx, ry], [gx, gy], [bx, by], [wx, wy]])
}
