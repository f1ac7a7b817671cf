//! Tables of a results folder, column by column.

use std::ops::Range;

/// Columns of names that the user has given: read as words even where they look like numbers.
const NAMES: [&str; 3] = ["receiver", "field", "frame"];

/// Cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum StoredColumn {
    /// Numbers; an empty cell is NaN.
    Numbers(Vec<f64>),
    /// Words.
    Words(Vec<String>),
}

/// Columns of a CSV file, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredTable {
    /// Names and cells of the columns, from the left.
    pub columns: Vec<(String, StoredColumn)>,
}

impl StoredTable {
    /// Reads the text of a file of comma-separated values.
    ///
    /// # Errors
    /// Rows of different lengths.
    pub fn parse(text: &str) -> Result<Self, csv::Error> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let names: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        let mut cells = vec![Vec::new(); names.len()];
        for record in reader.records() {
            for (cells, cell) in cells.iter_mut().zip(&record?) {
                cells.push(cell.to_owned());
            }
        }
        let columns = names.into_iter().zip(cells).map(|(name, cells)| {
            let number = |cell: &String| if cell.is_empty() { Some(f64::NAN) } else { cell.parse().ok() };
            let numbers: Option<Vec<f64>> = cells.iter().map(number).collect();
            let column = match numbers.filter(|_| !NAMES.contains(&name.as_str())) {
                Some(numbers) => StoredColumn::Numbers(numbers),
                None => StoredColumn::Words(cells),
            };
            (name, column)
        });
        Ok(Self { columns: columns.collect() })
    }

    /// A column of numbers; `None` if there is none of that name.
    pub fn numbers(&self, wanted: &str) -> Option<&[f64]> {
        self.columns.iter().find_map(|(name, column)| match column {
            StoredColumn::Numbers(numbers) if name == wanted => Some(&numbers[..]),
            _ => None,
        })
    }

    /// Name and rows of each signal, whose rows follow each other; the name consists of the cells before the first
    /// column of frequencies.
    pub(crate) fn signals(&self) -> Vec<(String, Range<usize>)> {
        let before = self.columns.iter().take_while(|(name, _)| !name.ends_with("_hz"));
        let before: Vec<&StoredColumn> = before.map(|(_, column)| column).collect();
        let rows = self.columns.first().map_or(0, |(_, column)| match column {
            StoredColumn::Numbers(numbers) => numbers.len(),
            StoredColumn::Words(words) => words.len(),
        });
        let mut signals: Vec<(String, Range<usize>)> = Vec::new();
        for row in 0..rows {
            let cells = before.iter().filter_map(|column| match column {
                StoredColumn::Numbers(numbers) => {
                    Some(numbers[row]).filter(|number| !number.is_nan()).map(|n| n.to_string())
                }
                StoredColumn::Words(words) => Some(words[row].clone()).filter(|word| !word.is_empty()),
            });
            let name = cells.collect::<Vec<_>>().join(", ");
            match signals.last_mut() {
                Some((last, rows)) if *last == name => rows.end = row + 1,
                _ => signals.push((name, row..row + 1)),
            }
        }
        signals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_kinds_and_signals_their_rows() {
        let text = "receiver,position_m,nominal_hz,level\n7,0.5,100,50\n7,0.5,125,\n8,,100,-1e3\n";
        let table = StoredTable::parse(text).unwrap();
        assert_eq!(table.columns[0].1, StoredColumn::Words(["7", "7", "8"].map(str::to_owned).to_vec()));
        assert_eq!(table.numbers("nominal_hz").unwrap(), [100.0, 125.0, 100.0]);
        let level = table.numbers("level").unwrap();
        assert!(level[1].is_nan() && level[2].to_bits() == (-1e3_f64).to_bits());
        assert_eq!(table.signals(), [("7, 0.5".to_owned(), 0..2), ("8".to_owned(), 2..3)]);
        assert!(table.numbers("receiver").is_none() && StoredTable::parse("a,b\n1\n").is_err());
    }
}
