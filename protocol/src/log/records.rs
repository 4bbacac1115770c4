//! The records of either solver as one type, for code that works on both sides of an exchange.

use serde::Serialize;

use crate::message::{Kinematics, Loads, Record};

/// Records of one solver, one per grain.
#[derive(Clone, Debug)]
pub enum Records {
    /// Of the fluid.
    Loads(Vec<Loads>),
    /// Of the DEM.
    Kinematics(Vec<Kinematics>),
}

/// A record that a log holds: that of the fluid or that of the DEM.
pub trait Logged: Record + Serialize {
    /// The loads, if these are loads.
    fn loads(_records: &[Self]) -> &[Loads] {
        &[]
    }

    /// The kinematics, if these are kinematics.
    fn kinematics(_records: &[Self]) -> &[Kinematics] {
        &[]
    }

    /// The records of this kind; none of the other kind.
    fn of(records: Records) -> Vec<Self>;
}

impl Logged for Loads {
    fn loads(records: &[Self]) -> &[Loads] {
        records
    }

    fn of(records: Records) -> Vec<Self> {
        if let Records::Loads(loads) = records { loads } else { Vec::new() }
    }
}

impl Logged for Kinematics {
    fn kinematics(records: &[Self]) -> &[Kinematics] {
        records
    }

    fn of(records: Records) -> Vec<Self> {
        if let Records::Kinematics(kinematics) = records { kinematics } else { Vec::new() }
    }
}
