//! Several small pictures with their names beneath, as one picture.

use crate::output::Picture;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use spectral_core::color::{srgb_decode, srgb_encode};

const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [40; 3];
/// White around every picture, pixels.
const MARGIN: usize = 8;
/// From one line of lettering to the next, pixels.
const LEADING: usize = 20;
const HEIGHT: RasterHeight = RasterHeight::Size16;
const WEIGHT: FontWeight = FontWeight::Regular;

/// A picture on a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Pixels a row.
    pub width: u32,
    /// Encoded sRGB with straight alpha, row by row.
    pub pixels: Vec<[u8; 4]>,
    /// What stands beneath, a line each; what is too long for the picture ends in "..", since the font has no ellipsis.
    pub label: Vec<String>,
}

/// A sheet: encoded sRGB, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Pixels a row.
    pub width: u32,
    /// All rows.
    pub pixels: Vec<[u8; 3]>,
}

impl Sheet {
    /// White, with the cells in rows of `columns`, each as large as the largest.
    ///
    /// ```
    /// use gemtrace::sheet::{Cell, Sheet};
    /// let cell = Cell { width: 20, pixels: vec![[255, 0, 0, 255]; 20 * 10], label: vec!["ruby".into()] };
    /// let sheet = Sheet::new(&[cell.clone(), cell], 2);
    /// assert_eq!(sheet.width, 2 * (20 + 8) + 8);
    /// assert_eq!(sheet.pixels.iter().filter(|p| **p == [255, 0, 0]).count(), 2 * 20 * 10);
    /// ```
    pub fn new(cells: &[Cell], columns: usize) -> Self {
        let most = |of: fn(&Cell) -> usize| cells.iter().map(of).max().unwrap_or(0);
        let (width, height, lines) =
            (most(|c| c.width as usize), most(Cell::height), most(|c| c.label.len()));
        let columns = columns.clamp(1, cells.len().max(1));
        let (across, down) = (width + MARGIN, height + lines * LEADING + MARGIN);
        let all = columns * across + MARGIN;
        let rows = cells.len().div_ceil(columns) * down + MARGIN;
        let mut sheet = Sheet { width: all as u32, pixels: vec![PAPER; all * rows] };
        for (i, cell) in cells.iter().enumerate() {
            let (x, y) = (MARGIN + i % columns * across, MARGIN + i / columns * down);
            sheet.place(cell, x, y);
            for (line, text) in cell.label.iter().enumerate() {
                sheet.letter(text, x, y + height + line * LEADING + (LEADING - HEIGHT.val()) / 2, width);
            }
        }
        sheet
    }

    fn place(&mut self, cell: &Cell, left: usize, top: usize) {
        let (stride, width) = (self.width as usize, cell.width.max(1) as usize);
        for (y, row) in cell.pixels.chunks(width).enumerate() {
            let start = (top + y) * stride + left;
            for (below, &[r, g, b, alpha]) in self.pixels[start..start + row.len()].iter_mut().zip(row) {
                *below = blend(*below, [r, g, b], alpha);
            }
        }
    }

    fn letter(&mut self, text: &str, left: usize, top: usize, width: usize) {
        let advance = get_raster_width(WEIGHT, HEIGHT);
        let room = width / advance;
        let fits = text.chars().count() <= room;
        let kept = if fits { room } else { room.saturating_sub(2) };
        let end = if fits { "" } else { ".." };
        for (place, letter) in text.chars().take(kept).chain(end.chars()).take(room).enumerate() {
            let Some(raster) = get_raster(letter, WEIGHT, HEIGHT).or_else(|| get_raster('?', WEIGHT, HEIGHT))
            else {
                continue;
            };
            for (y, row) in raster.rows().enumerate() {
                let start = (top + y) * self.width as usize + left + place * advance;
                for (below, &shade) in self.pixels[start..start + row.len()].iter_mut().zip(row) {
                    *below = blend(*below, INK, shade);
                }
            }
        }
    }
}

impl Cell {
    /// A picture as its PNG would show it, with one line beneath.
    pub fn new(picture: &Picture, label: String) -> Self {
        Cell { width: picture.film.width(), pixels: picture.rgba(), label: vec![label] }
    }

    fn height(&self) -> usize {
        self.pixels.len() / self.width.max(1) as usize
    }
}

/// One colour over another, mixed as light.
fn blend(below: [u8; 3], above: [u8; 3], alpha: u8) -> [u8; 3] {
    match alpha {
        0 => below,
        255 => above,
        _ => std::array::from_fn(|c| {
            let [below, above] = [below, above].map(|colour| srgb_decode(f64::from(colour[c]) / 255.0));
            let share = f64::from(alpha) / 255.0;
            (srgb_encode(below + (above - below) * share) * 255.0).round() as u8
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(label: &str) -> Cell {
        Cell { width: 40, pixels: vec![[0, 0, 255, 0]; 40 * 5], label: vec![label.to_owned()] }
    }

    #[test]
    fn what_is_transparent_shows_paper_and_lettering_stays_in_its_cell() {
        let sheet = Sheet::new(&[cell("a label that is far too long"), cell("")], 2);
        let right = |i: usize| i % sheet.width as usize >= MARGIN + 40;
        let inked = |(i, p): (usize, &[u8; 3])| (*p != PAPER).then_some(i);
        let ink: Vec<usize> = sheet.pixels.iter().enumerate().filter_map(inked).collect();
        assert!(!ink.is_empty() && !ink.iter().any(|&i| right(i)));
    }

    #[test]
    fn cells_fill_rows() {
        let sheet = Sheet::new(&[cell("a"), cell("b"), cell("c")], 2);
        let row = 5 + LEADING + MARGIN;
        assert_eq!((sheet.width as usize, sheet.pixels.len()), (2 * 48 + 8, (2 * 48 + 8) * (2 * row + 8)));
        assert_eq!(Sheet::new(&[], 3).width as usize, MARGIN * 2);
    }

    #[test]
    fn light_is_mixed_as_light() {
        // Half of white over black: 0.5 encoded.
        assert_eq!(blend([0; 3], [255; 3], 128), [188; 3]);
    }
}
