//! Mutants of valid files.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Numbers that replace a number.
const NUMBERS: [&str; 20] = [
    "0",
    "-0",
    "1",
    "-1",
    "3",
    "1e-300",
    "1e300",
    "-1e308",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "0.1",
    "1e-9",
    "1e15",
    "255",
    "65536",
    "4294967296",
    "18446744073709551615",
    "6148914691236517206",
];
/// Tokens that are put anywhere.
const TOKENS: [&str; 24] = [
    "[", "]", "{", "}", "(", ")", "\"", "'", "=", ",", ";", "\n", "\r\n", "\0", "$", "$$$$", "#", "!", "\t", ":", "[[",
    "null", "true", "\u{feff}",
];
/// Bytes of a mutant at most.
const LONGEST: usize = 60_000;

/// A file of a corpus, changed at one to six places.
pub(super) fn mutant(corpus: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = corpus[random.random_range(0..corpus.len())].clone();
    for _ in 0..random.random_range(1..=6) {
        change(&mut bytes, corpus, random);
        bytes.truncate(LONGEST);
    }
    bytes
}

/// A range of some of the bytes, most often a short one.
fn part(bytes: &[u8], random: &mut ChaCha8Rng) -> std::ops::Range<usize> {
    let begin = random.random_range(0..=bytes.len());
    let most = if random.random_bool(0.8) { 16 } else { bytes.len() };
    begin..(begin + random.random_range(0..=most)).min(bytes.len())
}

fn change(bytes: &mut Vec<u8>, corpus: &[Vec<u8>], random: &mut ChaCha8Rng) {
    let range = part(bytes, random);
    match random.random_range(0..9) {
        0 if !bytes.is_empty() => {
            let place = random.random_range(0..bytes.len());
            bytes[place] ^= 1 << random.random_range(0..8);
        }
        1 => bytes.truncate(range.start),
        2 => drop(bytes.drain(range)),
        3 => {
            let copy = bytes[range.clone()].repeat(random.random_range(1..4));
            bytes.splice(range.start..range.start, copy);
        }
        4 => {
            let other = &corpus[random.random_range(0..corpus.len())];
            let taken = other[part(other, random)].to_vec();
            bytes.splice(range, taken);
        }
        5 => {
            let token = TOKENS[random.random_range(0..TOKENS.len())].repeat(random.random_range(1..3));
            bytes.splice(range.start..range.start, token.into_bytes());
        }
        _ => number(bytes, range.start, random),
    }
}

/// Replaces the next number from a place on.
fn number(bytes: &mut Vec<u8>, from: usize, random: &mut ChaCha8Rng) {
    let is_part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e' | b'E');
    let Some(begin) = bytes[from..].iter().position(u8::is_ascii_digit).map(|place| from + place) else { return };
    let end = bytes[begin..].iter().position(|byte| !is_part(byte)).map_or(bytes.len(), |length| begin + length);
    let new = NUMBERS[random.random_range(0..NUMBERS.len())];
    bytes.splice(begin..end, new.bytes());
}
