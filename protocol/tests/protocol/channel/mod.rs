//! The exchange over shared memory, with real processes: this binary starts itself again as the
//! toy solvers, and as a coupler that is to be killed.

mod content;
mod faults;
mod leftovers;
mod participants;
mod refusals;
mod rendezvous;
mod stage;

/// Entry of the child processes; on its own it has nothing to play and checks just that.
#[test]
fn as_child() {
    let Ok(role) = std::env::var("TOY_ROLE") else {
        assert!(std::env::var(protocol::channel::CONNECT_VARIABLE).is_err());
        return;
    };
    let out = std::env::var("TOY_OUT").unwrap_or_default();
    let outcome = match role.as_str() {
        "coupler" => {
            leftovers::conduct_until_killed();
            Ok(())
        }
        role => participants::play(role, std::path::Path::new(&out)),
    };
    if let Err(error) = outcome {
        eprintln!("{error}");
        std::process::exit(3);
    }
}
