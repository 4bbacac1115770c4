//! Messages of the viewer channels and their descriptor sets, made from the texts in `protocol/schema`;
//! `tests/schema.rs` makes them anew.

/// Serialised `FileDescriptorSet` of the `foxglove.*` messages, as MCAP wants it.
pub(crate) const FOXGLOVE: &[u8] = include_bytes!("../../schema/foxglove.bin");
/// The same of the messages for plots.
pub(crate) const VIEWER: &[u8] = include_bytes!("../../schema/viewer.bin");

/// Messages that Foxglove, Lichtblick and Rerun know by name.
#[allow(unreachable_pub, clippy::all)]
pub(crate) mod foxglove {
    include!("../../schema/foxglove.rs");
}

/// Messages for plots.
#[allow(unreachable_pub, clippy::all)]
pub(crate) mod viewer {
    include!("../../schema/bedload.viewer.rs");
}
