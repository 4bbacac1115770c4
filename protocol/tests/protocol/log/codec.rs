//! Payloads of a log: their words, wrong counts, cuts.

use protocol::log::codec::{CodecError, decode, decode_slice, encode_slice};
use protocol::message::{Header, Loads, Record};

fn sample() -> Vec<u8> {
    let header = Header { step: 7, time: 0.5, ..Header::default() };
    let records = [Loads { force: [1.0, -0.0, f64::NAN], ..Loads::default() }; 2];
    let mut out = Vec::new();
    encode_slice(&header, &records, &mut out).unwrap();
    out
}

#[test]
fn payload_is_the_words_in_order() {
    let bytes = sample();
    assert_eq!(bytes.len(), 56 + 8 + 2 * 64);
    assert_eq!(bytes[..8], 7u64.to_le_bytes());
    assert_eq!(bytes[16..24], 0.5f64.to_le_bytes());
    assert_eq!(bytes[56..64], 2u64.to_le_bytes());
    assert_eq!(bytes[64..72], 1.0f64.to_le_bytes());
    assert_eq!(bytes[72..80], (-0.0f64).to_le_bytes());
    let (_, records) = decode_slice::<Loads>(&bytes).unwrap();
    assert_eq!(records[1].words()[2], f64::NAN.to_bits());
}

#[test]
fn hostile_counts_are_refused_without_asking_for_memory() {
    let mut bytes = sample();
    for claim in [u64::MAX, 1 << 60, 1 << 32, 3, 1, 0] {
        bytes[56..64].copy_from_slice(&claim.to_le_bytes());
        assert!(matches!(
            decode_slice::<Loads>(&bytes),
            Err(CodecError::Count { count, .. }) if count == claim
        ));
        // The limit alone must hold too, for payloads that are plain bincode.
        assert!(decode::<Vec<Loads>>(&bytes[56..]).is_err());
    }
}

#[test]
fn any_cut_is_an_error() {
    let bytes = sample();
    for end in 0..bytes.len() {
        assert!(decode_slice::<Loads>(&bytes[..end]).is_err(), "cut at {end}");
    }
}
