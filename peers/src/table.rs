//! Numbers for a person to read.

/// Rows of cells, the first row the heading, as columns that line up.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let length = |row: &Vec<String>, column: usize| row.get(column).map_or(0, |cell| cell.chars().count());
    let width = |column| rows.iter().map(|row| length(row, column)).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

/// Three digits that count.
pub fn short(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 {
        "0".into()
    } else if !(1e-3..1e5).contains(&magnitude) {
        format!("{value:.2e}")
    } else {
        let digits = (2 - magnitude.log10().floor() as i32).max(0) as usize;
        format!("{value:.digits$}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!(short(0.0), "0");
        assert_eq!(short(0.024_04), "0.0240");
        assert_eq!(short(13.46), "13.5");
        assert_eq!(short(1072.0), "1072");
        assert_eq!(short(-0.1796), "-0.180");
        assert_eq!(short(3.71e-11), "3.71e-11");
    }

    #[test]
    fn columns_line_up() {
        let rows = [vec!["a".into(), "bbb".into()], vec!["cc".into(), "d".into()]];
        assert_eq!(table(&rows), "a   bbb\ncc  d\n");
    }
}
