//! Bodies of the plane that are not round: how they stand, and where they touch.

pub(crate) mod meeting;
pub(crate) mod placed;
pub(crate) mod plane;
pub(crate) mod points;
