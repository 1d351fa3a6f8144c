//! Whether two things are the same, told by 64 bits.

/// FNV-1a over 64 bits (Fowler, Noll, Vo): the same on every machine and in every version of the standard library.
#[derive(Clone, Copy)]
pub struct Fingerprint(u64);

impl Default for Fingerprint {
    fn default() -> Self {
        Fingerprint(0xcbf2_9ce4_8422_2325)
    }
}

impl Fingerprint {
    /// Takes `bytes` in, with their number: so that parts cannot run into each other.
    pub fn bytes(&mut self, bytes: &[u8]) {
        for byte in (bytes.len() as u64).to_le_bytes().iter().chain(bytes) {
            self.0 = (self.0 ^ *byte as u64).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
    /// Takes `text` in.
    pub fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }
    /// The value so far.
    pub fn value(self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fingerprint_worked_by_hand() {
        // FNV-1a of "a", after its length as eight bytes: bytes 1, 0 x 7, 0x61.
        let mut one = Fingerprint::default();
        one.text("a");
        let by_hand = [1u8, 0, 0, 0, 0, 0, 0, 0, 0x61].iter();
        let step = |hash: u64, byte: &u8| (hash ^ *byte as u64).wrapping_mul(0x100000001b3);
        assert_eq!(one.value(), by_hand.fold(0xcbf29ce484222325, step));
    }
}
