//! Search of near pairs, and the lists that are made of it.

pub(crate) mod cells;
pub(crate) mod contact_list;
pub(crate) mod lists;
pub(crate) mod pairs;
