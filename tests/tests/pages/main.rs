//! Inputs and pages against the code, mostly in place: wrong scenes, files changed at random, documents,
//! imports.

mod bad_input;
mod coupling_docs;
mod documents;
mod files;
mod keys;
mod maps;
mod mutations;
mod scene_docs;
mod structure;
