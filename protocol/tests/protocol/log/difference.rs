//! A replay against its log.

use protocol::log::Comparison;
use protocol::message::{Header, Kinematics};

/// Of window 3.
fn header() -> Header {
    Header { step: 3, substeps: 10, ..Header::default() }
}

#[test]
fn signed_zero_and_nan_payload_are_differences() {
    let logged = Kinematics { velocity: [0.0, 1.0, f64::NAN], ..Kinematics::default() };
    let mut sent = [logged; 2];
    let mut comparison = Comparison::default();
    comparison.message((&header(), &[logged; 2]), (&header(), &sent));
    assert_eq!(comparison.first(), None);
    sent[1].velocity[0] = -0.0;
    comparison.message((&header(), &[logged; 2]), (&header(), &sent));
    let first = comparison.first().unwrap();
    assert_eq!((first.step, first.grain, first.field.as_str()), (3, Some(1), "velocity[0]"));
    let velocity = comparison.fields()["velocity"];
    assert_eq!((velocity.words, velocity.differing, velocity.largest), (12, 1, 0.0));
}

#[test]
fn a_header_names_its_field_and_integers_print_as_such() {
    let sent = Header { substeps: 12, ..header() };
    let mut comparison = Comparison::default();
    comparison.message::<Kinematics>((&header(), &[]), (&sent, &[]));
    let text = comparison.first().unwrap().to_string();
    assert_eq!(text, "step 3, header, field header.substeps: logged 10, sent 12");
    assert_eq!(comparison.fields()["header.substeps"].largest, 2.0);
}
