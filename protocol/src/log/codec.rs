//! Payload bytes of the data channels: the only module that knows bincode.
//!
//! Fixed-width little-endian integers, so the layout is the records' words one after the other
//! (`docs/exchange-log.md` prints it): a slice is its header, the number of records as `u64`, the records.
//! Decoding has a byte limit: without one, a hostile length makes bincode ask for memory that no
//! machine has, and the process is aborted.

use std::io::{Read, Write};

use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::message::{Header, Record};

/// Most bytes a payload may claim, 1 GiB (5.8 million grains).
pub const LIMIT: usize = 1 << 30;

/// A payload that does not decode.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum CodecError {
    /// Bytes missing, left over, or over the limit.
    #[error("payload of {bytes} bytes does not hold {wanted}: {what}")]
    Decode { bytes: usize, wanted: &'static str, what: String },
    /// The count before a slice disagrees with the payload's length.
    #[error("payload of {bytes} bytes claims {count} records of {size} bytes")]
    Count { bytes: usize, count: u64, size: usize },
    /// A value that bincode cannot write.
    #[error("cannot encode: {0}")]
    Encode(String),
}

fn config() -> Configuration<LittleEndian, Fixint, Limit<LIMIT>> {
    bincode::config::standard().with_little_endian().with_fixed_int_encoding().with_limit::<LIMIT>()
}

/// Writes `value` to `out`.
///
/// # Errors
/// [`CodecError::Encode`] if `out` refuses; a list of bytes never does.
pub fn encode<T: Serialize>(value: &T, out: &mut impl Write) -> Result<(), CodecError> {
    bincode::serde::encode_into_std_write(value, out, config())
        .map(drop)
        .map_err(|error| CodecError::Encode(error.to_string()))
}

/// Reads one `T` and leaves what follows. There is no limit to its length: for files that a digest vouches
/// for.
///
/// # Errors
/// [`CodecError::Decode`] if bytes are missing or are not those of a `T`.
pub fn decode_from<T: DeserializeOwned>(from: &mut impl Read) -> Result<T, CodecError> {
    bincode::serde::decode_from_std_read(from, config().with_no_limit()).map_err(|error| CodecError::Decode {
        bytes: 0,
        wanted: std::any::type_name::<T>(),
        what: error.to_string(),
    })
}

/// Appends a header and its records to `out`.
///
/// # Errors
/// As [`encode`].
pub fn encode_slice<R: Record + Serialize>(
    header: &Header,
    records: &[R],
    out: &mut Vec<u8>,
) -> Result<(), CodecError> {
    out.reserve(size_of::<Header>() + 8 + size_of_val(records));
    encode(header, out)?;
    encode(&records, out)
}

/// Decodes a payload that holds one `T` and nothing else.
///
/// # Errors
/// [`CodecError::Decode`] if bytes are missing, left over or over [`LIMIT`].
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    let fail =
        |what: String| CodecError::Decode { bytes: bytes.len(), wanted: std::any::type_name::<T>(), what };
    let (value, used) =
        bincode::serde::decode_from_slice(bytes, config()).map_err(|error| fail(error.to_string()))?;
    match bytes.len() - used {
        0 => Ok(value),
        left => Err(fail(format!("{left} bytes are left over"))),
    }
}

/// Decodes the header in front of a slice, leaving the records alone.
///
/// # Errors
/// [`CodecError::Decode`] if the payload is shorter than a header.
pub fn decode_header(bytes: &[u8]) -> Result<Header, CodecError> {
    decode(&bytes[..bytes.len().min(size_of::<Header>())])
}

/// Decodes a header and its records.
///
/// ```
/// use protocol::log::codec::{decode_slice, encode_slice};
/// use protocol::message::{Header, Loads};
///
/// let header = Header { step: 7, ..Header::default() };
/// let loads = vec![Loads { force: [0.0, 0.0, 1.0], ..Loads::default() }];
/// let mut payload = Vec::new();
/// encode_slice(&header, &loads, &mut payload)?;
/// assert_eq!(decode_slice(&payload)?, (header, loads));
/// # Ok::<(), protocol::log::codec::CodecError>(())
/// ```
///
/// # Errors
/// [`CodecError::Count`] if the count and the length disagree, else [`CodecError::Decode`].
pub fn decode_slice<R: Record + DeserializeOwned>(bytes: &[u8]) -> Result<(Header, Vec<R>), CodecError> {
    let header = decode_header(bytes)?;
    let rest = &bytes[size_of::<Header>()..];
    let count: u64 = decode(&rest[..rest.len().min(8)])?;
    let size = size_of::<R>();
    // Asked before bincode reads on: its own limit would first let it reserve the claimed room.
    if count.checked_mul(size as u64) != Some((rest.len() - 8) as u64) {
        return Err(CodecError::Count { bytes: bytes.len(), count, size });
    }
    Ok((header, decode(rest)?))
}

/// Whether a command's payload is an `Advance`: the window before it stands for good.
pub(crate) fn begins_window(bytes: &[u8]) -> bool {
    bytes.get(..8) == Some(&(crate::message::Order::Advance as u64).to_le_bytes()[..])
}
