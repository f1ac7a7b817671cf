//! The numbers behind an OpenCRG header.
//!
//! Text: 80-character records, fields of 10 (R) or 20 (D) characters cut by column; a field that is no number is
//! missing (NaN). Binary: big-endian IEEE 754, filled with NaN to whole records of 80 bytes.

use super::header::CrgFormat;
use crate::road::file_fault::{FileFault, LikelyCause};

/// Bytes of a record.
const RECORD: usize = 80;
/// No road has elevations or slopes beyond this; coordinates may be larger.
pub(super) const ABSURD: f64 = 1e8;

/// The numbers, row-major, rows x `channels`. `promised`: the number of rows that the header states, if it does.
/// `first_line` is the line number of the first text record.
///
/// # Errors
/// Too few or too many bytes, rows or fields; numbers beyond 1e8.
pub(super) fn decode(
    payload: &[u8],
    format: CrgFormat,
    channels: usize,
    promised: Option<u64>,
    first_line: usize,
) -> Result<Vec<f64>, FileFault> {
    let values = if format.text {
        decode_text(payload, format, channels, promised, first_line)?
    } else {
        decode_binary(payload, format, channels, promised)?
    };
    match values.iter().position(|value| value.abs() > ABSURD) {
        Some(place) => Err(FileFault::Absurd {
            row: place / channels,
            channel: place % channels + 1,
            value: values[place],
            hint: if format.text { LikelyCause::Unknown } else { converted(payload, LikelyCause::Unknown) },
        }),
        None => Ok(values),
    }
}

fn decode_binary(
    payload: &[u8],
    format: CrgFormat,
    channels: usize,
    promised: Option<u64>,
) -> Result<Vec<f64>, FileFault> {
    let size = if format.double { 8 } else { 4 };
    // Bytes from one row to the next.
    let stride = if format.aligned { (channels * size).next_multiple_of(RECORD) } else { channels * size };
    let rows = promised.unwrap_or((payload.len() / stride) as u64);
    let expected = rows.saturating_mul(stride as u64);
    let padded = expected.saturating_add(RECORD as u64 - 1) / RECORD as u64 * RECORD as u64;
    let found = payload.len() as u64;
    let complete = match promised {
        Some(_) => found == expected || found == padded,
        None => rows > 0 && found - expected < RECORD as u64,
    };
    if !complete {
        let other = if found < expected { LikelyCause::Truncated } else { LikelyCause::Unknown };
        // Conversion of line ends removes a few bytes, truncation any number.
        let few = padded.saturating_sub(found) <= 16 + found / 1000 && found < padded;
        let hint = if few { converted(payload, other) } else { other };
        return Err(FileFault::Payload { rows, channels, expected, padded, found, hint });
    }
    let mut values = Vec::with_capacity(rows as usize * channels);
    for row in payload.chunks_exact(stride).take(rows as usize) {
        let numbers = row[..channels * size].chunks_exact(size);
        if format.double {
            values.extend(numbers.map(|bytes| f64::from_be_bytes(bytes.try_into().unwrap_or([0xff; 8]))));
        } else {
            values.extend(numbers.map(|bytes| f64::from(f32::from_be_bytes(bytes.try_into().unwrap_or([0xff; 4])))));
        }
    }
    if promised.is_none() {
        // The padding of narrow rows looks like rows of missing values.
        while values.len() > channels && values[values.len() - channels..].iter().all(|value| value.is_nan()) {
            values.truncate(values.len() - channels);
        }
    }
    Ok(values)
}

/// [`LikelyCause::LineEndsConverted`] if CR LF pairs are absent where random bytes would contain some; otherwise the
/// given cause.
fn converted(payload: &[u8], otherwise: LikelyCause) -> LikelyCause {
    let pairs = payload.windows(2).any(|pair| pair == b"\r\n");
    if !pairs && payload.len() > 100_000 { LikelyCause::LineEndsConverted } else { otherwise }
}

fn decode_text(
    payload: &[u8],
    format: CrgFormat,
    channels: usize,
    promised: Option<u64>,
    first_line: usize,
) -> Result<Vec<f64>, FileFault> {
    let width = if format.double { 20 } else { 10 };
    let per_record = RECORD / width;
    // 1. Lines to records, without empty ones at the end.
    let mut records: Vec<&[u8]> = payload.split(|&byte| byte == b'\n').map(|line| line.trim_ascii_end()).collect();
    let ended = payload.last() == Some(&b'\n');
    while records.last().is_some_and(|record| record.is_empty()) {
        records.pop();
    }
    // 2. A last record that was cut off.
    if let (false, Some(last)) = (ended, records.last()) {
        // Fields are right-justified: a last record that ends inside a field was cut off.
        if last.len() % width != 0 {
            let expected = last.len() / width + 1;
            return Err(FileFault::Record { line: first_line + records.len() - 1, expected, width, found: last.len() });
        }
    }
    // 3. Fields of the records, cut by column.
    let mut values = Vec::new();
    // Number of fields of the current row read so far; kernel formats have no rows, only one stream.
    let mut pending = 0;
    for (index, record) in records.iter().enumerate() {
        let wanted = if format.aligned {
            per_record.min(channels - pending)
        } else {
            per_record.min(record.len().div_ceil(width))
        };
        if record.len() <= (wanted.max(1) - 1) * width {
            return Err(FileFault::Record { line: first_line + index, expected: wanted, width, found: record.len() });
        }
        for field in record.chunks(width).take(wanted) {
            values.push(
                std::str::from_utf8(field.trim_ascii())
                    .ok()
                    .and_then(|text| text.parse().ok())
                    .filter(|value: &f64| value.is_finite())
                    .unwrap_or(f64::NAN),
            );
        }
        pending = (pending + wanted) % channels;
    }
    // 4. The number of rows must be that of the header.
    let found = (values.len() / channels) as u64;
    let expected = promised.unwrap_or(found.max(1));
    // The last record of a kernel stream may be padded.
    let filled = !format.aligned
        && values.len() as u64 > expected * channels as u64
        && values.len() as u64 - expected * (channels as u64) < per_record as u64;
    if !filled && (found != expected || values.len() % channels != 0) {
        return Err(FileFault::Rows { expected: expected.max(found + u64::from(found == expected)), found });
    }
    values.truncate(expected as usize * channels);
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBERS: [f64; 6] = [1.0, 2.5, -3.0, 0.25, 5.0, -6.5];

    #[test]
    fn aligned_binary_rows_start_at_records() {
        let format = CrgFormat { aligned: true, double: true, text: false };
        let mut bytes = Vec::new();
        for row in NUMBERS.chunks(3) {
            row.iter().for_each(|value| bytes.extend(value.to_be_bytes()));
            bytes.resize(bytes.len().next_multiple_of(RECORD), 0xff);
        }
        assert_eq!(decode(&bytes, format, 3, Some(2), 1).unwrap(), NUMBERS);
        assert!(matches!(decode(&bytes[1..], format, 3, Some(2), 1), Err(FileFault::Payload { found: 159, .. })));
    }

    #[test]
    fn kernel_text_rows_follow_each_other() {
        let format = CrgFormat { aligned: false, double: true, text: true };
        let text: String = NUMBERS
            .chunks(4)
            .map(|record| record.iter().map(|value| format!("{value:20.10}")).collect::<String>() + "\n")
            .collect();
        assert_eq!(decode(text.as_bytes(), format, 3, Some(2), 1).unwrap(), NUMBERS);
        assert_eq!(decode(text.as_bytes(), format, 3, None, 1).unwrap(), NUMBERS);
        assert!(matches!(
            decode(text.as_bytes(), format, 3, Some(3), 1),
            Err(FileFault::Rows { expected: 3, found: 2 })
        ));
    }

    #[test]
    fn padding_of_narrow_binary_rows_is_no_row() {
        let format = CrgFormat { aligned: false, double: false, text: false };
        let mut bytes: Vec<u8> = NUMBERS.iter().flat_map(|&value| (value as f32).to_be_bytes()).collect();
        while bytes.len() < RECORD {
            bytes.extend(f32::NAN.to_be_bytes());
        }
        assert_eq!(decode(&bytes, format, 2, None, 1).unwrap(), NUMBERS);
        assert_eq!(decode(&bytes, format, 2, Some(3), 1).unwrap(), NUMBERS);
    }
}
