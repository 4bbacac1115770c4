//! Search of near pairs, and the lists that are made of it.

pub mod cells;
pub mod contact_list;
pub mod lists;
pub mod pairs;
