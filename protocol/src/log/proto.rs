//! Protocol Buffers' wire format, the part that viewers need: append-only, no generated code.
//!
//! Encoding: <https://protobuf.dev/programming-guides/encoding/>.

/// Appends fields to a message.
pub(crate) struct Proto<'a>(pub(crate) &'a mut Vec<u8>);

impl Proto<'_> {
    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push((value as u8) | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    fn tag(&mut self, field: u32, wire: u32) {
        self.varint(u64::from(field << 3 | wire));
    }

    /// An integer, a bool or an enum.
    pub(crate) fn integer(&mut self, field: u32, value: u64) {
        self.tag(field, 0);
        self.varint(value);
    }

    /// A double.
    pub(crate) fn double(&mut self, field: u32, value: f64) {
        self.tag(field, 1);
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// A fixed32.
    pub(crate) fn fixed32(&mut self, field: u32, value: u32) {
        self.tag(field, 5);
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// Text or bytes.
    pub(crate) fn bytes(&mut self, field: u32, value: &[u8]) {
        self.tag(field, 2);
        self.varint(value.len() as u64);
        self.0.extend_from_slice(value);
    }

    /// Three doubles, fields 1 to 3: a `Vector3`.
    pub(crate) fn vector(&mut self, field: u32, value: [f64; 3]) {
        self.doubles(field, &value);
    }

    /// A message of doubles, fields 1, 2, …
    pub(crate) fn doubles(&mut self, field: u32, values: &[f64]) {
        self.tag(field, 2);
        self.varint(9 * values.len() as u64);
        for (number, value) in (1..).zip(values) {
            self.double(number, *value);
        }
    }

    /// A packed repeated double.
    pub(crate) fn packed(&mut self, field: u32, values: impl ExactSizeIterator<Item = f64>) {
        self.tag(field, 2);
        self.varint(8 * values.len() as u64);
        for value in values {
            self.0.extend_from_slice(&value.to_le_bytes());
        }
    }

    /// A nested message. Its length is known only afterwards, and is put in front then.
    pub(crate) fn message(&mut self, field: u32, fill: impl FnOnce(&mut Proto<'_>)) {
        self.tag(field, 2);
        let start = self.0.len();
        fill(&mut Proto(self.0));
        let end = self.0.len();
        self.varint((end - start) as u64);
        let length = self.0.len() - end;
        self.0[start..].rotate_right(length);
    }

    /// A `google.protobuf.Timestamp`.
    pub(crate) fn timestamp(&mut self, field: u32, ns: u64) {
        self.message(field, |time| {
            time.integer(1, ns / 1_000_000_000);
            time.integer(2, ns % 1_000_000_000);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_of_the_specification() {
        let mut out = Vec::new();
        Proto(&mut out).integer(1, 150);
        assert_eq!(out, [0x08, 0x96, 0x01]);
        out.clear();
        Proto(&mut out).bytes(2, b"testing");
        assert_eq!(out, *b"\x12\x07testing");
        out.clear();
        Proto(&mut out).message(3, |nested| nested.integer(1, 150));
        assert_eq!(out, [0x1a, 0x03, 0x08, 0x96, 0x01]);
    }

    #[test]
    fn a_long_nested_message_has_its_length_in_front() {
        let mut out = vec![7];
        Proto(&mut out).message(1, |nested| nested.bytes(1, &[9; 300]));
        // 300 + 1 tag + 2 length bytes = 303 = 0xAF 0x02.
        assert_eq!(out[..6], [7, 0x0a, 0xaf, 0x02, 0x0a, 0xac]);
        assert_eq!(out.len(), 1 + 1 + 2 + 303);
    }
}
