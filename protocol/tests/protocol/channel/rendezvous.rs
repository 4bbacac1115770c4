//! The token that solvers join with.

use protocol::channel::Rendezvous;
use protocol::participant::ExchangeError;

#[test]
fn token_survives_the_way_and_refuses_other_builds() {
    let ours = Rendezvous::new(7).unwrap();
    assert_eq!(Rendezvous::parse(&ours.token()).unwrap(), ours);

    let mut older = ours.clone();
    older.protocol += 1;
    let error = Rendezvous::parse(&older.token()).unwrap_err();
    assert!(matches!(&error, ExchangeError::Mismatch { what, .. } if what == "protocol"));

    let mut other = ours.clone();
    other.layout = "0123456789abcdef".into();
    let error = Rendezvous::parse(&other.token()).unwrap_err().to_string();
    assert!(error.contains("0123456789abcdef") && error.contains(&ours.layout), "{error}");
}

#[test]
fn token_of_a_hostile_run_is_refused() {
    for (run, prefix) in [("../x", "bl../x_"), ("a", "other_"), ("", "bl_")] {
        let mut bad = Rendezvous::new(1).unwrap();
        bad.run = run.into();
        bad.prefix = prefix.into();
        assert!(Rendezvous::parse(&bad.token()).is_err(), "{run} {prefix}");
    }
    assert!(Rendezvous::parse("{}").is_err());
}
