//! SHA-256 digests as text.

use sha2::{Digest, Sha256};

/// SHA-256 of the texts' concatenation, in lower-case hexadecimal.
pub(crate) fn sha256(texts: &[&str]) -> String {
    let mut hash = Sha256::new();
    texts.iter().for_each(|text| hash.update(text));
    hexadecimal(hash.finalize())
}

/// Two lower-case digits per byte.
pub(crate) fn hexadecimal(bytes: impl AsRef<[u8]>) -> String {
    bytes.as_ref().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digests_are_those_of_the_standard() {
        // FIPS 180-2, appendix B.1.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(&["abc"]), expected);
        assert_eq!(sha256(&["a", "", "bc"]), expected);
    }
}
