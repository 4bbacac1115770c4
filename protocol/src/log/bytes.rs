//! MCAP record bodies, read without trusting any length in them.
//!
//! The `mcap` crate frames the file and checks its sums; its record parser, though, reserves what a
//! string claims to need, so the few records that matter here are taken apart with these.
//! Layout: <https://mcap.dev/spec#records>.

use std::collections::BTreeMap;

/// What is left of a record body. Each call takes from its front, `None` when it does not fit.
pub(crate) struct Bytes<'a>(pub(crate) &'a [u8]);

impl<'a> Bytes<'a> {
    pub(crate) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.0.split_at_checked(count)?;
        self.0 = tail;
        Some(head)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes with their length in front, 32 bits.
    pub(crate) fn short(&mut self) -> Option<&'a [u8]> {
        let count = self.u32()?;
        self.take(usize::try_from(count).ok()?)
    }

    /// Bytes with their length in front, 64 bits.
    pub(crate) fn long(&mut self) -> Option<&'a [u8]> {
        let count = self.u64()?;
        self.take(usize::try_from(count).ok()?)
    }

    /// UTF-8 text with its length in front.
    pub(crate) fn text(&mut self) -> Option<&'a str> {
        std::str::from_utf8(self.short()?).ok()
    }

    /// Text by key.
    pub(crate) fn map(&mut self) -> Option<BTreeMap<String, String>> {
        let mut pairs = Bytes(self.short()?);
        let mut map = BTreeMap::new();
        while !pairs.0.is_empty() {
            let key = pairs.text()?.to_owned();
            map.insert(key, pairs.text()?.to_owned());
        }
        Some(map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_beyond_the_body_are_none() {
        let mut claim = Bytes(&[0xff, 0xff, 0xff, 0xff, b'a']);
        assert_eq!(claim.text(), None);
        assert_eq!(Bytes(&[0xff; 9]).long(), None);
        assert_eq!(Bytes(&[2, 0, 0, 0, 1, 0]).map(), None);
        let mut good = Bytes(&[1, 0, 0, 0, b'a', 7, 0]);
        assert_eq!(good.text(), Some("a"));
        assert_eq!(good.u16(), Some(7));
        assert_eq!(good.u16(), None);
    }
}
