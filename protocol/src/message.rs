//! What crosses between the processes: plain `repr(C)` records of `f64` and `u64`, no padding.
//!
//! Frame: laboratory, components (x, y, z). A plane run keeps y at zero; an axisymmetric run puts
//! its axis on z and keeps x and y at zero. Units: SI (or the scene's consistent set).
//! `docs/coupling.md` prints every byte offset; [`layout_hash`] is what both ends compare.

use iceoryx2::prelude::ZeroCopySend;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Version of the exchange: rises whenever a record, a topic or the order of calls changes.
pub const PROTOCOL_VERSION: u64 = 1;

/// A record with a described layout, so that two builds can tell whether they agree.
pub trait Record: Copy + Default + PartialEq + std::fmt::Debug + Send + Sync + 'static {
    /// Name of the record as printed in `docs/coupling.md` and in the log's schema.
    const NAME: &'static str;
    /// Fields in memory order: name, number of 8-byte words, unit.
    const FIELDS: &'static [Field];

    /// The record as 8-byte words in memory order, for comparing bit by bit.
    fn words(&self) -> Vec<u64>;

    /// The field that holds word `index`, and the component that the word is.
    fn field_at(index: usize) -> Option<(&'static Field, usize)> {
        let mut words = Self::FIELDS.iter().flat_map(|field| (0..field.words).map(move |part| (field, part)));
        words.nth(index)
    }

    /// Name of the field, with its component, that holds word `index` (`force[2]`).
    fn field_of_word(index: usize) -> String {
        match Self::field_at(index) {
            Some((field, _)) if field.words == 1 => field.name.to_owned(),
            Some((field, part)) => format!("{}[{part}]", field.name),
            None => format!("word {index}"),
        }
    }
}

/// One field of a [`Record`].
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Name.
    pub name: &'static str,
    /// Length in 8-byte words.
    pub words: usize,
    /// `f64` or `u64`.
    pub kind: &'static str,
    /// Unit, `-` where there is none.
    pub unit: &'static str,
    /// Meaning.
    pub meaning: &'static str,
}

/// Word access by type: `f64`, `u64` and arrays of them.
pub trait Words {
    /// Number of 8-byte words.
    const COUNT: usize;
    /// `f64` or `u64`.
    const KIND: &'static str;
    /// Appends the words in memory order.
    fn append(&self, out: &mut Vec<u64>);
}

impl Words for f64 {
    const COUNT: usize = 1;
    const KIND: &'static str = "f64";
    fn append(&self, out: &mut Vec<u64>) {
        out.push(self.to_bits());
    }
}

impl Words for u64 {
    const COUNT: usize = 1;
    const KIND: &'static str = "u64";
    fn append(&self, out: &mut Vec<u64>) {
        out.push(*self);
    }
}

impl<T: Words, const N: usize> Words for [T; N] {
    const COUNT: usize = N * T::COUNT;
    const KIND: &'static str = T::KIND;
    fn append(&self, out: &mut Vec<u64>) {
        self.iter().for_each(|value| value.append(out));
    }
}

/// Declares a record once: the struct, its layout table and its words.
macro_rules! record {
    ($(#[$doc:meta])* $name:ident { $($field:ident : $kind:ty, $unit:literal, $meaning:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ZeroCopySend)]
        #[repr(C)]
        pub struct $name {
            $(#[doc = $meaning] #[doc = concat!(" Unit: ", $unit, ".")] pub $field: $kind,)*
        }

        impl Record for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [Field] = &[$(Field {
                name: stringify!($field),
                words: <$kind as Words>::COUNT,
                kind: <$kind as Words>::KIND,
                unit: $unit,
                meaning: $meaning,
            },)*];

            fn words(&self) -> Vec<u64> {
                let mut out = Vec::with_capacity(size_of::<Self>() / 8);
                $(self.$field.append(&mut out);)*
                out
            }
        }

        // `repr(C)` over 8-byte words has no padding; this holds it to that.
        const _: () = assert!(size_of::<$name>() == 8 * (0 $(+ <$kind as Words>::COUNT)*));
    };
}

record! {
    /// What the fluid does to one grain over a window, fluid → DEM. Everything the fluid does is in
    /// it, buoyancy included, so a DEM adds gravity, contact and lubrication and nothing else.
    Loads {
        force: [f64; 3], "N", "Mean force of the fluid on the grain over the window, buoyancy included.";
        torque: [f64; 3], "N m", "Mean torque of the fluid on the grain about its centre.";
        added_mass: f64, "kg", "Virtual mass C_v m_f (Schwarz et al. 2015): add to the grain's mass, and m_a \
            A_prev to its force. A solver may ignore it (narrower stable range).";
        added_inertia: f64, "kg m^2", "Virtual moment of inertia, used likewise for the spin.";
    }
}

record! {
    /// Motion of one grain at the end of a window, DEM → fluid. The first four fields are the
    /// coupling; the others are for observers, and a foreign solver may leave them zero.
    Kinematics {
        position: [f64; 3], "m", "Centre.";
        orientation: [f64; 4], "-", "Unit quaternion (w, x, y, z), body to laboratory.";
        velocity: [f64; 3], "m/s", "Velocity of the centre.";
        spin: [f64; 3], "rad/s", "Angular velocity, laboratory frame.";
        contact_force: [f64; 3], "N", "Observation: mean contact force over the window.";
        lubrication_force: [f64; 3], "N", "Observation: mean modelled lubrication force over the window.";
        gap: f64, "m", "Observation: gap to the nearest neighbour or wall at the end of the window \
            (negative: overlap).";
        impact_speed: f64, "m/s", "Observation: normal approach speed when a contact last began within the \
            window, 0 if none.";
        rebound_speed: f64, "m/s", "Observation: normal separation speed when a contact last ended within \
            the window, 0 if none.";
    }
}

record! {
    /// Stands before every slice of `Loads` or `Kinematics`.
    Header {
        step: u64, "-", "Window number, from 0.";
        attempt: u64, "-", "0 for the first try of the window, one more for each `Repeat`.";
        time: f64, "s", "Start of the window.";
        dt: f64, "s", "Length of the window.";
        substeps: u64, "-", "DEM sub-steps really done in the window (0 in loads): the coupler compares it \
            with what it asked for.";
        smallest_gap: f64, "m", "Smallest gap seen in the window over all pairs and walls (0 in loads).";
        largest_overlap: f64, "m", "Largest overlap seen in the window (0 in loads).";
    }
}

record! {
    /// An order of the coupler to both solvers.
    Command {
        order: u64, "-", "One of the `Order` codes.";
        step: u64, "-", "Window number.";
        attempt: u64, "-", "Try of this window.";
        time: f64, "s", "Start of the window.";
        dt: f64, "s", "Length of the window.";
        substeps: u64, "-", "DEM sub-steps to do in the window, exactly.";
        output: u64, "-", "1: write fields after this window; 0: do not.";
    }
}

record! {
    /// A solver's answer to a command.
    Status {
        state: u64, "-", "One of the `State` codes.";
        step: u64, "-", "Window the answer is about.";
        attempt: u64, "-", "Try of that window.";
        dt_limit: f64, "s", "Largest window this solver would accept next (fluid: CFL and viscous bound); \
            infinite if it does not care.";
        solver_s: f64, "s", "CPU time of solver work since start, without waiting, output and log.";
        exchange_s: f64, "s", "Wall time since start spent sending and receiving, waiting for the peer excluded.";
        residual: f64, "-", "Fluid: largest divergence after projection; DEM: largest overlap over radius.";
        peak_rss: u64, "bytes", "Peak resident memory of the process.";
        process: u64, "-", "Process id.";
        grains: u64, "-", "Number of grains it knows.";
        substeps: u64, "-", "DEM: sub-steps done since start.";
        pressure_gradient: f64, "Pa/m", "Fluid: mean pressure gradient that held `medium.flow_rate` in the \
            window, 0 without one; DEM: 0.";
        text: [[u64; 8]; 8], "-", "UTF-8 text, zero-padded, 512 bytes: last words of a failed solver; of a \
            window that is done the numbers that `observe.totals` asks for, apart by spaces.";
    }
}

/// Codes of [`Command::order`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Order {
    /// Do the window of this command.
    Advance = 1,
    /// Go back to the start of the last window and do it again with this command's values.
    Repeat = 2,
    /// The last window stands; forget how to go back.
    Accept = 3,
    /// Write a checkpoint of the present state.
    Checkpoint = 4,
    /// Finish: leave the run in order.
    Stop = 5,
}

/// Codes of [`Status::state`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum State {
    /// Connected, scene read, waiting for orders.
    Ready = 1,
    /// The ordered window is done.
    Done = 2,
    /// The checkpoint is written.
    Saved = 3,
    /// Leaving on `Stop`.
    Stopped = 4,
    /// Cannot go on; `text` says why.
    Failed = 5,
}

/// Error of a code that no [`Order`] or [`State`] has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("code {0} is not part of protocol {PROTOCOL_VERSION}: rebuild the peer against this version")]
pub struct UnknownCode(pub u64);

impl TryFrom<u64> for Order {
    type Error = UnknownCode;
    fn try_from(code: u64) -> Result<Self, UnknownCode> {
        [Self::Advance, Self::Repeat, Self::Accept, Self::Checkpoint, Self::Stop]
            .into_iter()
            .find(|order| *order as u64 == code)
            .ok_or(UnknownCode(code))
    }
}

impl TryFrom<u64> for State {
    type Error = UnknownCode;
    fn try_from(code: u64) -> Result<Self, UnknownCode> {
        [Self::Ready, Self::Done, Self::Saved, Self::Stopped, Self::Failed]
            .into_iter()
            .find(|state| *state as u64 == code)
            .ok_or(UnknownCode(code))
    }
}

impl Status {
    /// Puts `text` in, cut at 512 bytes on a character's boundary.
    pub fn set_text(&mut self, text: &str) {
        let mut end = text.len().min(512);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        self.text = Default::default();
        for (word, chunk) in self.text.as_flattened_mut().iter_mut().zip(text.as_bytes()[..end].chunks(8)) {
            let mut bytes = [0; 8];
            bytes[..chunk.len()].copy_from_slice(chunk);
            *word = u64::from_le_bytes(bytes);
        }
    }

    /// Puts numbers in as text that reads back to the same bits: at most 20, apart by spaces.
    pub fn set_numbers(&mut self, numbers: &[f64]) {
        let words: Vec<String> = numbers.iter().map(|number| format!("{number:e}")).collect();
        self.set_text(&words.join(" "));
    }

    /// Adds the `count` numbers of the text; what is missing, or no number, is NaN.
    pub fn numbers(&self, count: usize, out: &mut Vec<f64>) {
        let text = if count > 0 { self.text() } else { String::new() };
        let words = text.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN));
        out.extend(words.chain(std::iter::repeat(f64::NAN)).take(count));
    }

    /// The text, without its padding; bytes that are not UTF-8 are replaced.
    pub fn text(&self) -> String {
        let bytes: Vec<u8> = self.text.as_flattened().iter().flat_map(|word| word.to_le_bytes()).collect();
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        String::from_utf8_lossy(&bytes[..end]).into_owned()
    }
}

/// Hash of every record's name, field names, types, order and units: the first 8 bytes of SHA-256.
/// Carried as an attribute of each service, because iceoryx2 itself compares only name, size and
/// alignment of a type.
pub fn layout_hash() -> u64 {
    let mut digest = Sha256::new();
    digest.update(PROTOCOL_VERSION.to_le_bytes());
    for (name, fields) in [
        (Loads::NAME, Loads::FIELDS),
        (Kinematics::NAME, Kinematics::FIELDS),
        (Header::NAME, Header::FIELDS),
        (Command::NAME, Command::FIELDS),
        (Status::NAME, Status::FIELDS),
    ] {
        digest.update(name);
        for field in fields {
            digest.update(format!("|{}:{}x{}:{}", field.name, field.words, field.kind, field.unit));
        }
    }
    let bytes = digest.finalize();
    bytes.iter().take(8).fold(0, |hash, byte| (hash << 8) | u64::from(*byte))
}

impl Kinematics {
    /// A grain at rest with its centre at `position`, not turned.
    pub fn at_rest(position: [f64; 3]) -> Self {
        Self { position, orientation: [1.0, 0.0, 0.0, 0.0], ..Self::default() }
    }

    /// ½ m v² + ½ I ω², J.
    pub fn kinetic_energy(&self, mass: f64, inertia: f64) -> f64 {
        let square = |vector: &[f64; 3]| vector.iter().map(|x| x * x).sum::<f64>();
        0.5 * (mass * square(&self.velocity) + inertia * square(&self.spin))
    }

    /// Is the grain in the run yet? One that is still to be inserted has no orientation.
    pub fn is_there(&self) -> bool {
        self.orientation != [0.0; 4]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn status_text_survives_a_cut_inside_a_character() {
        let mut status = Status::default();
        let long = "é".repeat(400);
        status.set_text(&long);
        assert_eq!(status.text(), "é".repeat(256));
        status.set_text("short");
        assert_eq!(status.text(), "short");
    }

    #[test]
    fn numbers_in_a_text_keep_their_bits() {
        let mut status = Status::default();
        let long = -1.234_567_890_123_456_7e-308;
        let numbers: Vec<f64> =
            (0..20).map(|i| if i == 3 { f64::INFINITY } else { long * f64::from(i) }).collect();
        status.set_numbers(&numbers);
        let mut read = vec![7.0];
        status.numbers(20, &mut read);
        assert_eq!(
            read[1..].iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        );
        read.clear();
        Status::default().numbers(2, &mut read);
        assert!(read.len() == 2 && read.iter().all(|x| x.is_nan()));
    }

    #[test]
    fn words_name_their_field() {
        assert_eq!(Loads::field_of_word(2), "force[2]");
        assert_eq!(Loads::field_of_word(6), "added_mass");
        assert_eq!(Kinematics::field_of_word(3), "orientation[0]");
        let loads = Loads { added_inertia: 2.5, ..Loads::default() };
        assert_eq!(loads.words()[7], 2.5f64.to_bits());
        assert_eq!(loads.words().len() * 8, size_of::<Loads>());
    }
}
