//! Wavefront OBJ: the vertices and faces, which are all that geometry needs, and what they are called.
//!
//! Read here and not by a crate so that messages can name the file's own line and vertex: `tobj` gives no
//! lines, renumbers vertices, and overflows on texture indices that do not exist.

use super::soup::{Names, Soup};
use super::utf8;
use glam::DVec3;
use spectral_core::{mesh::polygon, shown};
use std::borrow::Cow;

/// The triangles of an OBJ file, or what is wrong with it.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, String> {
    let bytes = utf8(bytes);
    let text = String::from_utf8_lossy(&bytes);
    let (mut soup, mut names, mut called) = (Soup::default(), Names::default(), None);
    // From the first face on that names a vertex which is still to come: those are triangulated in the end, so that
    // triangles stay in the order of the file.
    let mut later = Vec::new();
    for (number, line) in records(&text) {
        let at = |message: String| format!("line {number}: {message}");
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => soup.positions.push(vertex(words).map_err(at)?),
            Some(kind @ ("o" | "g" | "usemtl")) => {
                let rest = line.trim_start()[kind.len()..].trim().to_owned();
                match kind {
                    "o" => names.objects = vec![rest],
                    "g" => names.groups = rest.split_whitespace().map(str::to_owned).collect(),
                    _ => names.material = Some(rest),
                }
                called = Some(soup.number(names.clone()));
            }
            Some("f") => {
                let corners = face(words, soup.positions.len()).map_err(at)?;
                if later.is_empty() && corners.iter().all(|c| (*c as usize) < soup.positions.len()) {
                    called.into_iter().for_each(|called| soup.resume(called));
                    polygon::triangulate(&soup.positions, &corners, &mut soup.triangles).map_err(at)?;
                } else {
                    later.push((number, called, corners));
                }
            }
            // Texture and shading vertices, lines, points and smoothing bound nothing.
            _ => {}
        }
    }
    for (number, called, corners) in later {
        if let Some(missing) = corners.iter().find(|c| **c as usize >= soup.positions.len()) {
            let (missing, count) = (u64::from(*missing) + 1, soup.positions.len());
            return Err(format!("line {number}: vertex {missing} is not there; the file has {count}"));
        }
        called.into_iter().for_each(|called| soup.resume(called));
        polygon::triangulate(&soup.positions, &corners, &mut soup.triangles)
            .map_err(|m| format!("line {number}: {m}"))?;
    }
    Ok(soup)
}

/// Lines with their 1-based numbers, comments dropped and those that end in a backslash joined.
fn records<'a>(text: &'a str) -> impl Iterator<Item = (usize, Cow<'a, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (first, line) = lines.next()?;
        let open = |line: &'a str| line.trim_end().strip_suffix('\\');
        let Some(start) = open(line) else { return Some((first + 1, Cow::Borrowed(remark_off(line)))) };
        let mut joined = start.to_owned();
        for (_, next) in lines.by_ref() {
            joined.push(' ');
            joined.push_str(open(next).unwrap_or(next));
            if open(next).is_none() {
                break;
            }
        }
        joined.truncate(remark_off(&joined).len());
        Some((first + 1, Cow::Owned(joined)))
    })
}

/// A line without the remark at its end.
fn remark_off(line: &str) -> &str {
    line.split('#').next().unwrap_or_default()
}

fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, String> {
    let mut next = |axis: char| {
        let word =
            words.next().ok_or_else(|| format!("a vertex needs three coordinates; {axis} is missing"))?;
        word.parse::<f64>().map_err(|_| format!("'{}' is not a number", shown(word)))
    };
    let v = DVec3::new(next('x')?, next('y')?, next('z')?);
    if !v.is_finite() {
        return Err(format!("vertex ({}, {}, {}) is not finite", v.x, v.y, v.z));
    }
    Ok(v)
}

/// Corner indices from 0; each word is `v`, `v/vt`, `v//vn` or `v/vt/vn`, from 1, negative counting back.
fn face<'a>(words: impl Iterator<Item = &'a str>, so_far: usize) -> Result<Vec<u32>, String> {
    let corners = words
        .map(|word| {
            let number = word.split('/').next().unwrap_or_default();
            let index: i64 =
                number.parse().map_err(|_| format!("'{}' is not a vertex number", shown(word)))?;
            let from_zero = if index < 0 { so_far as i64 + index } else { index - 1 };
            u32::try_from(from_zero)
                .map_err(|_| format!("vertex {index} is not there; vertices count from 1, or back from -1"))
        })
        .collect::<Result<Vec<_>, String>>()?;
    if corners.len() < 3 {
        return Err(format!("a face needs at least 3 corners, this one has {}", corners.len()));
    }
    Ok(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_count_from_either_end_and_ignore_what_follows_a_slash() {
        let text = "# a tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1 # apex\nvt 1 1\n\
                    f 1/1 3 2\nf -4//7 2/9/9 \\\n -1\nf 2 3 4\nf 3 1 4\n";
        let soup = read(text.as_bytes()).unwrap();
        assert_eq!(soup.triangles, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    }

    #[test]
    fn messages_name_the_line() {
        for (text, message) in [
            ("v 0 0", "line 1: a vertex needs three coordinates; z is missing"),
            ("v 0 0 six", "line 1: 'six' is not a number"),
            ("\nv 0 nan 0", "line 2: vertex (0, NaN, 0) is not finite"),
            ("v 0 0 1e999", "line 1: vertex (0, 0, inf) is not finite"),
            ("v 0 0 0\nf 1 1 2", "line 2: vertex 2 is not there; the file has 1"),
            ("v 0 0 0\nf 1 1", "line 2: a face needs at least 3 corners, this one has 2"),
            ("f 0 1 2", "line 1: vertex 0 is not there; vertices count from 1, or back from -1"),
            ("f 1 2 -9223372036854775808", "line 1: vertex -9223372036854775808 is not there"),
        ] {
            let error = read(text.as_bytes()).unwrap_err();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
