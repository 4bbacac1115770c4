//! The channels of a log and the schema of each.

use crate::message::{Command, Field, Header, Kinematics, Loads, Record, Status};

/// Message encoding of the data channels.
pub const DATA_ENCODING: &str = "bedload-bincode";

/// Encoding of the textual schema of the data channels.
pub const DATA_SCHEMA_ENCODING: &str = "bedload-layout";

/// A channel of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// Orders of the coupler.
    Command,
    /// Fluid → DEM.
    Loads,
    /// DEM → fluid.
    Kinematics,
    /// Answers of both solvers.
    Status,
    /// Viewer: grains as spheres.
    Scene,
    /// Viewer: grains as points with their motion.
    Points,
    /// Viewer: numbers of the window, for plots.
    Window,
    /// Viewer: numbers of the first grains, for plots.
    Grains,
}

impl Topic {
    /// All of them, in the order of their channels.
    pub const ALL: [Self; 8] = [
        Self::Command,
        Self::Loads,
        Self::Kinematics,
        Self::Status,
        Self::Scene,
        Self::Points,
        Self::Window,
        Self::Grains,
    ];

    /// Name in the file, and of the schema.
    fn names(self) -> [&'static str; 2] {
        match self {
            Self::Command => ["bedload/command", "bedload.Command"],
            Self::Loads => ["bedload/loads", "bedload.Loads"],
            Self::Kinematics => ["bedload/kinematics", "bedload.Kinematics"],
            Self::Status => ["bedload/status", "bedload.Status"],
            Self::Scene => ["viewer/scene", "foxglove.SceneUpdate"],
            Self::Points => ["viewer/points", "foxglove.PointCloud"],
            Self::Window => ["viewer/window", "bedload.viewer.Window"],
            Self::Grains => ["viewer/grains", "bedload.viewer.Grains"],
        }
    }

    /// Name in the file.
    pub fn name(self) -> &'static str {
        self.names()[0]
    }

    /// The topic of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// Name of the schema.
    pub fn schema_name(self) -> &'static str {
        self.names()[1]
    }

    /// Whether a replay needs it (else it is for viewers).
    pub fn is_data(self) -> bool {
        self <= Self::Status
    }

    /// The textual schema of a data channel: one field per line, in byte order, no padding.
    pub fn layout(self) -> String {
        match self {
            Self::Command => text(self, &[("", Command::FIELDS)], None),
            Self::Loads => text(self, &[("header.", Header::FIELDS)], Some(Loads::FIELDS)),
            Self::Kinematics => text(self, &[("header.", Header::FIELDS)], Some(Kinematics::FIELDS)),
            Self::Status => text(self, &[("", &[ROLE]), ("", Status::FIELDS)], None),
            Self::Scene | Self::Points | Self::Window | Self::Grains => String::new(),
        }
    }
}

/// The word before a logged [`Status`]: who speaks.
const ROLE: Field =
    Field { name: "role", words: 1, kind: "u64", unit: "-", meaning: "Who speaks: 0 fluid, 1 DEM." };

fn text(topic: Topic, parts: &[(&str, &[Field])], repeated: Option<&[Field]>) -> String {
    let mut out = format!(
        "# {}: little-endian, no padding; a line is: name, type, words of 8 bytes, unit, meaning\n",
        topic.schema_name()
    );
    for (prefix, fields) in parts {
        fields.iter().for_each(|field| line(prefix, field, &mut out));
    }
    if let Some(fields) = repeated {
        out.push_str("count u64 1 - Number of records that follow.\nrepeat count\n");
        fields.iter().for_each(|field| line("", field, &mut out));
        out.push_str("end\n");
    }
    out
}

fn line(prefix: &str, field: &Field, out: &mut String) {
    // Units may contain blanks ("N m"), which would break the columns.
    let unit = field.unit.replace(' ', "_");
    out.push_str(&format!(
        "{prefix}{} {} {} {unit} {}\n",
        field.name, field.kind, field.words, field.meaning
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layout_text_counts_every_byte() {
        let layout = Topic::Kinematics.layout();
        let words =
            |line: &str| -> usize { line.split(' ').nth(2).and_then(|word| word.parse().ok()).unwrap_or(0) };
        let (before, after) = layout.split_once("repeat count\n").unwrap();
        let skip_comment = before.lines().skip(1).map(words).sum::<usize>();
        assert_eq!(8 * skip_comment, size_of::<Header>() + 8);
        let body: usize = after.lines().filter(|line| *line != "end").map(words).sum();
        assert_eq!(8 * body, size_of::<Kinematics>());
        let status: usize = Topic::Status.layout().lines().skip(1).map(words).sum();
        assert_eq!(8 * status, 8 + size_of::<Status>());
    }
}
