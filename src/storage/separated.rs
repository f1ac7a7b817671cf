//! Tables that people wrote or a program exported: one record a line, cells parted by commas, semicolons or tabs.

/// The delimiters, in the order in which a tie is lost.
const DELIMITERS: [u8; 3] = [b';', b'\t', b','];

/// Returns a reader of a table's records, the first of which may be titles. Their delimiter is the one that the first
/// of them has most of; cells are trimmed, blank lines and lines that begin with # left out.
pub(crate) fn reader(bytes: &[u8]) -> csv::Reader<&[u8]> {
    let first = bytes.split(|&byte| byte == b'\n').find(|line| !is_skipped(line)).unwrap_or_default();
    let occurrences = |delimiter: u8| first.iter().filter(|&&byte| byte == delimiter).count();
    let delimiter = DELIMITERS.into_iter().max_by_key(|&delimiter| occurrences(delimiter)).unwrap_or(b',');
    csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes)
}

/// Returns the line, from 1, of a record that was read from the bytes: the reader's own count is that of the first
/// blank line or comment before it.
pub(crate) fn line_of(bytes: &[u8], record: &csv::ByteRecord) -> u64 {
    record.position().map_or(0, |position| {
        let rest = bytes.get(position.byte() as usize..).unwrap_or_default();
        let skipped = rest.split(|&byte| byte == b'\n').take_while(|line| is_skipped(line)).count();
        position.line() + skipped as u64
    })
}

fn is_skipped(line: &[u8]) -> bool {
    line.trim_ascii().is_empty() || line.starts_with(b"#")
}
