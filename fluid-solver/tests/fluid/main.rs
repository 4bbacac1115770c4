//! The fluid from outside: the flow alone, and with immersed grains.

mod flow;
mod immersed;
