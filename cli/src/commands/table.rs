//! Columns of text.

use spectral_core::shown;

/// Rows as lines of columns that are as wide as they must be; the first `left` columns are set flush
/// left, the others, which hold numbers, flush right. Long names are shortened.
pub fn columns(left: usize, rows: &[Vec<String>]) -> String {
    let rows: Vec<Vec<String>> =
        rows.iter().map(|row| row.iter().map(|cell| shown(cell)).collect()).collect();
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width =
        |c: usize| rows.iter().filter_map(|row| row.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells = cells.map(|(c, (s, &w))| if c < left { format!("{s:<w$}") } else { format!("{s:>w$}") });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_are_flush_left_and_numbers_flush_right() {
        let rows = [["λ", "1.5"], ["long", "12.25"]].map(|row| row.map(str::to_owned).to_vec());
        assert_eq!(super::columns(1, &rows), "λ       1.5\nlong  12.25");
    }
}
