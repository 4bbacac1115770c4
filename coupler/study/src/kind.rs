//! The kinds of studies.

/// What is made of the runs of a study; its name is that of its section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Error against cost.
    Chart,
    /// Where a method is stable, beside the bound.
    Stability,
    /// Values against published ones.
    Case,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Chart, Self::Stability, Self::Case];

    /// Name of the section, of the table and of the figure.
    pub fn name(self) -> &'static str {
        match self {
            Self::Chart => "chart",
            Self::Stability => "stability",
            Self::Case => "case",
        }
    }

    /// File of the table in the folder of a study.
    pub fn table(self) -> String {
        format!("{}.csv", self.name())
    }

    /// Folder of the committed tables, seen from the root of the repository.
    pub fn tables(self) -> &'static str {
        match self {
            Self::Chart => "docs/charts",
            Self::Stability => "docs/maps",
            Self::Case => "docs/cases",
        }
    }
}
