//! Messages on standard error: the one place that writes there.
//!
//! A message that cannot be written (a full disk behind a redirection, a closed pipe) must not end a run, as
//! `eprintln!` would: clippy refuses that and its kin everywhere in the program and the library.

use std::io::{self, Write};

/// Writes a message and a line end; one that cannot be written is lost.
pub(super) fn write_message(message: &str) {
    write_message_to(&mut io::stderr(), message);
}

fn write_message_to(out: &mut impl Write, message: &str) {
    // In one piece, so that messages of several threads do not mix.
    let _ = out.write_all(format!("{message}\n").as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_a_line_and_one_that_cannot_be_written_is_lost() {
        let mut paper = Vec::new();
        write_message_to(&mut paper, "note: it rains");
        assert_eq!(paper, b"note: it rains\n");
        write_message_to(&mut &mut [0_u8; 3][..], "note: it rains");
    }
}
