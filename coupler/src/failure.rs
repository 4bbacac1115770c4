//! How a command ends, besides well. What a part fails with becomes a [`Failure`] in the file of that part.

use std::io::Write as _;

pub use bedload_program::Failure;

/// Prints a failure on stderr: a fault of a scene is drawn with its place.
pub fn explain(failure: Failure) {
    match failure {
        // Drawn in colours, so that only what is drawn is made printable.
        Failure::Scene(error) => {
            let drawn = format!("{:?}\n", miette::Report::new(error.printable()));
            let _ = std::io::stderr().write_all(drawn.as_bytes());
        }
        Failure::Passed(_) => {}
        other => other.explain("bedload"),
    }
}
