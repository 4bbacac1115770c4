//! How a command ends, besides well. What a part fails with becomes a [`Failure`] in the file of that part.

pub use bedload_program::Failure;

/// Prints a failure on stderr: a fault of a scene is drawn with its place.
pub fn explain(failure: Failure) {
    match failure {
        Failure::Scene(error) => protocol::say!("{:?}", miette::Report::new(*error)),
        Failure::Passed(_) => {}
        other => other.explain("bedload"),
    }
}
