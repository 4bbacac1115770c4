//! The bulk engine, for many grains: linear contacts, symplectic Euler, no lubrication.
//!
//! | file | what it holds |
//! |---|---|
//! | `requirements` | which scenes it takes, and which engine `auto` takes |
//! | `records` | a grain is a record of 12 numbers, eight contacts are a pack |
//! | `law`, `pair`, `wall` | the contact law, contacts of grains and with walls, many at once |
//! | `integrate`, `block` | kick and drift; one sub-step of a block |
//! | `spatial_order` | the order of the grains |
//! | `block_search`, `candidates`, `candidate_search` | pairs within a wide skin, and how long they are good |
//! | `block_list`, `skins`, `list_build` | the lists taken from the candidates: how wide, and when they are built |
//! | `batch`, `sync` | sub-steps between two looks at the lists: wavefront and threads |
//! | `engine`, `substeps`, `window` | the whole: its parts, its sub-steps, start and end of a window |
//! | `history`, `insertion` | springs in and out; grains inserted during a run |
//!
//! Grains stand in an order of cells and are cut into blocks of 512, by their number alone. Each block
//! has its own list; a contact between two blocks stands in both, each with its own spring, and since every
//! expression changes sign or stays when the partners change places, the copies stay equal. Sums run in the
//! order of the contacts, so the bits depend on the order of the grains and on nothing else: not on skins,
//! moments of building lists, threads or the depth of the wavefront. The order is part of the saved state.
//! Fixed grains come first in it: their blocks are inactive unless the forces on them are asked for, and a
//! contact with one of them then stands in the other block alone.

mod batch;
mod block;
mod block_list;
mod block_search;
mod candidate_search;
mod candidates;
pub(crate) mod engine;
mod history;
mod insertion;
mod integrate;
mod law;
mod list_build;
mod observed;
mod pair;
mod records;
pub(crate) mod requirements;
mod skins;
mod spatial_order;
mod substeps;
mod sync;
mod wall;
pub(crate) mod window;
