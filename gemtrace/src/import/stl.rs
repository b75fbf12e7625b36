//! STL, text and binary, through the crate `stl_io`.

use super::{soup::Soup, utf8};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::borrow::Cow;
use std::io::Cursor;

const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// The triangles of an STL file, or what is wrong with it.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, String> {
    let text = utf8(bytes);
    // Any two bytes may begin a binary file.
    let bytes = if text.starts_with(b"solid") { &text } else { bytes };
    let mut source = Cursor::new(prepared(bytes)?);
    let incomplete = |e: std::io::Error| format!("not a complete STL file: {e}");
    let mut soup = Soup::default();
    // An STL file repeats each corner in every triangle around it: six times, and more in memory.
    let mut known: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    for triangle in stl_io::create_stl_reader(&mut source).map_err(incomplete)? {
        let corners = triangle.map_err(incomplete)?.vertices.map(|vertex| {
            *known.entry(vertex.0.map(f32::to_bits)).or_insert_with(|| {
                soup.positions.push(DVec3::from_array(vertex.0.map(f64::from)));
                soup.positions.len() as u32 - 1
            })
        });
        // A file of MAX_FILE_BYTES holds fewer corners than a u32 counts.
        soup.triangles.push(corners);
    }
    Ok(soup)
}

/// `stl_io` takes a file for text if it starts with `"solid "`. Some programs write that into the header of
/// binary files, and some write text files without a name (`"solid\n"`): both are told apart here, by the
/// length that a binary file must have.
fn prepared(bytes: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let promised = bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let whole = promised.map(|n| HEADER as u64 + TRIANGLE as u64 * u64::from(n));
    if !bytes.starts_with(b"solid") {
        let (Some(count), Some(whole)) = (promised, whole) else {
            return Err(format!("truncated: {} bytes are too few for an STL file", bytes.len()));
        };
        if (bytes.len() as u64) < whole {
            let held = (bytes.len() - HEADER) / TRIANGLE;
            return Err(format!("truncated: its header announces {count} triangles, it holds {held}"));
        }
        return Ok(bytes.into());
    }
    let text_follows = bytes.iter().take(1024).all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace());
    if whole == Some(bytes.len() as u64) && !text_follows {
        let mut binary = bytes.to_vec();
        binary[..5].fill(b' ');
        return Ok(binary.into());
    }
    if bytes.starts_with(b"solid ") {
        return Ok(bytes.into());
    }
    Ok([b"solid ", &bytes[5..]].concat().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary(header: &[u8], count: u32, triangles: usize) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, 0);
        bytes.extend(count.to_le_bytes());
        for _ in 0..triangles {
            for v in [0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
                bytes.extend(v.to_le_bytes());
            }
            bytes.extend([0, 0]);
        }
        bytes
    }

    #[test]
    fn binary_files_are_known_by_their_length() {
        for header in ["made by us", "solid but binary"] {
            assert_eq!(read(&binary(header.as_bytes(), 2, 2)).unwrap().triangles.len(), 2, "{header}");
        }
    }

    #[test]
    fn text_needs_no_name() {
        let facet =
            "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
        for start in ["solid\n", "solid \n", "solid a b\n"] {
            let soup = read(format!("{start}{facet}endsolid\n").as_bytes()).unwrap();
            assert_eq!(soup.triangles, [[0, 1, 2]]);
            let cut = read(format!("{start}{facet}").as_bytes()).unwrap_err();
            assert!(cut.contains("EOF while expecting facet"), "{cut}");
        }
    }

    #[test]
    fn truncated_files_say_how_much_is_missing() {
        let error = read(&binary(b"x", u32::MAX, 3)).unwrap_err();
        assert_eq!(error, "truncated: its header announces 4294967295 triangles, it holds 3");
        assert!(read(b"").unwrap_err().contains("too few"));
    }
}
