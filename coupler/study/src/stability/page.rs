//! The page of a map: counts, map, where each method ends, every run.

use super::counts::Counts;
use super::ends;
use super::map::Frame;
use crate::page::{context, render};
use crate::table::Table;
use coupler::failure::Failure;

pub(super) fn page(table: &Table, frame: &Frame<'_>, about: &str, map: &str) -> Result<String, Failure> {
    render(
        "stability.html",
        context! {
            about, map,
            title => frame.title,
            counts => Counts::of(&table.rows),
            x => frame.x.1,
            y => frame.y.1,
            // None where y has names.
            ends => ends::of(table, frame.x.0, frame.y.0),
            keys => table.keys,
            runs => table.rows,
        },
    )
}

#[cfg(test)]
mod tests {
    use super::super::classify::Class;
    use super::*;
    use crate::table::Row;

    #[test]
    fn the_page_is_whole_by_itself_and_says_what_is_wrong() {
        let row = |class, refused| Row {
            values: ["0.1", "<b>"].map(str::to_owned).to_vec(),
            class: Some(class),
            margin: Some(0.5),
            label: "run".into(),
            note: "a \"note\"".into(),
            refused,
            ..Row::default()
        };
        let rows = vec![row(Class::Failed, false), row(Class::Stable, true)];
        let table = Table {
            kind: crate::kind::Kind::Stability,
            keys: vec!["x".into(), "y".into()],
            metrics: Vec::new(),
            rows,
        };
        let frame = Frame { title: "T", x: (0, "x"), y: (1, "y"), bound: "any" };
        let page = super::page(&table, &frame, "Read this.", "<svg></svg>").unwrap();
        assert!(page.contains("Read this.") && page.contains("<svg") && page.contains("&lt;b&gt;"));
        let wrong = page.split("wrong: failed, and accepted").nth(1).expect("the line of what is wrong");
        assert!(wrong.split("</tr>").next().is_some_and(|line| line.contains("class=\"bad\">1<")), "{page}");
        for outside in ["http://", "https://", "<script", "<link rel=\"stylesheet\""] {
            assert_eq!(
                page.replace("http://www.w3.org/2000/svg", "").matches(outside).count(),
                0,
                "{outside}"
            );
        }
        assert_eq!(page.matches("<section").count(), page.matches("</section>").count());
    }
}
