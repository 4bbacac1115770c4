//! The page: frame, style, sections, and how text and numbers become HTML.

use bedload_output::RunStatus;

use super::run_files::RunFiles;
use super::snapshot::Snapshot;
use super::{pictures, plots, sheet, tables};

/// Pictures of the grains on a page.
const MOST_SNAPSHOTS: usize = 12;

const STYLE: &str = "
:root { color-scheme: light; }
body { margin: 0 auto; max-width: 76rem; padding: 0 1rem 3rem; background: #fff; color: #1a1a1a;
  font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 1.5rem 0 .3rem; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 .6rem; border-bottom: 1px solid #ddd; }
.status { display: inline-block; padding: .1rem .6rem; border-radius: .3rem; font-weight: 600; }
.completed { background: #d9f2e3; color: #0b5230; }
.failed { background: #fbdada; color: #8a1212; }
.interrupted { background: #fdeecb; color: #6b4700; }
.good { color: #0b5230; } .bad { color: #8a1212; font-weight: 600; }
.note { color: #555; font-size: .9rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .92rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .25rem .9rem .25rem 0; border-bottom: 1px solid #eee; vertical-align: top; }
th, td { white-space: nowrap; }
td.text { white-space: normal; min-width: 11rem; }
pre { overflow-x: auto; background: #f6f6f6; padding: .6rem .8rem; font-size: .85rem; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 30rem), 1fr)); gap: 1rem; }
.panel { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(45%, 13rem), 1fr)); gap: .8rem; }
figure { margin: 0; }
figure svg { display: block; width: 100%; height: auto; }
.keys { margin: .1rem 0; text-align: center; font-size: .9rem; }
.keys span { margin: 0 .6rem; white-space: nowrap; }
.keys i { display: inline-block; width: 1.2rem; height: .25rem; margin: 0 .35rem .2rem 0; }
figcaption { font-size: .9rem; color: #444; text-align: center; }
";

/// The whole page of a run.
pub(super) fn page(run: &RunFiles) -> String {
    frame(run.title(), &(head(run) + &sections(run)))
}

/// A page around `body`, which is HTML; the title is text.
pub(crate) fn frame(title: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{title}</h1>\n{body}</body>\n</html>\n"
    )
}

fn head(run: &RunFiles) -> String {
    let summary = &run.summary;
    let status = match summary.status {
        RunStatus::Completed => "completed",
        RunStatus::Failed => "failed",
        RunStatus::Interrupted => "interrupted",
    };
    let mut html = format!("<p><span class=\"status {status}\">{status}</span></p>\n");
    if let Some(error) = &summary.error {
        html += &format!("<p class=\"bad\">{}</p>\n", escape(error));
    }
    let source = run.scene.as_ref().map_or("", |scene| scene.scene.source.as_str());
    if !source.is_empty() {
        html += &format!("<p class=\"note\">After {}</p>\n", escape(source));
    }
    let identity = summary.scene_sha256.get(..12).unwrap_or(&summary.scene_sha256);
    html += &format!(
        "<p class=\"note\">{} · Bedload {} · scene {}</p>\n",
        escape(&run.name),
        escape(&summary.version),
        escape(identity)
    );
    for remark in &run.remarks {
        html += &format!("<p class=\"note\">{}</p>\n", escape(remark));
    }
    html
}

fn sections(run: &RunFiles) -> String {
    let summary = &run.summary;
    let plan = run.plan.as_ref();
    let charts = plots::all(run).concat();
    let charts = (!charts.is_empty()).then(|| format!("<div class=\"charts\">\n{charts}</div>\n"));
    let cost =
        format!("<div class=\"charts\">\n{}{}</div>\n", tables::cost_split(summary), tables::cost(summary));
    let log = run.log.as_ref().map(|text| format!("<pre>{}</pre>\n", escape(text)));
    let parts = [
        ("Metrics", tables::metrics(summary)),
        ("Curves", charts),
        ("Vorticity", pictures::panel(run)),
        ("Grains", grains(run)),
        ("Steps", Some(tables::steps(summary, plan))),
        ("Bounds", tables::bounds(plan)),
        ("Cost", Some(cost)),
        ("Log", log),
    ];
    let section = |(name, body): (&str, Option<String>)| {
        body.map(|body| {
            let id = name.to_lowercase();
            format!("<section id=\"{id}\">\n<h2>{name}</h2>\n{body}</section>\n")
        })
    };
    parts.into_iter().filter_map(section).collect()
}

/// The grains at up to [`MOST_SNAPSHOTS`] of the times at which they were written.
fn grains(run: &RunFiles) -> Option<String> {
    let files = &run.grain_files;
    let step = files.len().div_ceil(MOST_SNAPSHOTS).max(1);
    // From the last backwards: the final state is always there.
    let chosen = files.iter().rev().step_by(step).collect::<Vec<_>>().into_iter().rev();
    let (read, faults): (Vec<_>, Vec<_>) = chosen.map(|path| Snapshot::read(path)).partition(Result::is_ok);
    let snapshots: Vec<Snapshot> = read.into_iter().filter_map(Result::ok).collect();
    let faults: String = faults
        .into_iter()
        .filter_map(Result::err)
        .map(|fault| format!("<p class=\"note\">{}</p>\n", escape(&fault)))
        .collect();
    let Some(sheet) = sheet::sheet(&snapshots) else { return (!faults.is_empty()).then_some(faults) };
    let cut = snapshots.iter().find_map(|snapshot| snapshot.cut);
    let cut = cut.map_or(String::new(), |y| format!(" Spheres are cut by the plane y = {} m.", number(y)));
    Some(format!(
        "<figure>{sheet}</figure>\n<p class=\"note\">Coloured by speed, to scale; held grains are grey, single ones \
         far away are left out.{cut} {} of {} files of grains.</p>\n{faults}",
        snapshots.len(),
        files.len()
    ))
}

/// Text as HTML, also within quotes.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            // Controls have no place in HTML.
            other if other.is_control() && !matches!(other, '\n' | '\t') => escaped.push('\u{fffd}'),
            other => escaped.push(other),
        }
    }
    escaped
}

/// Four digits, with a power of ten where that is shorter.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string().replace("inf", "∞");
    }
    let size = value.abs().log10().floor() as i32;
    if (-3..6).contains(&size) {
        let text = format!("{value:.*}", usize::try_from(3 - size).unwrap_or(0));
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        return text.replace('-', "−");
    }
    let text = format!("{value:.3e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    let power: String = power.chars().map(superscript).collect();
    format!("{digits}·10{power}").replace('-', "−")
}

/// A digit or sign, raised.
pub(crate) fn superscript(character: char) -> char {
    match character {
        '-' => '⁻',
        digit => digit
            .to_digit(10)
            .map_or(digit, |place| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][place as usize]),
    }
}

/// A count with its thousands apart.
pub(super) fn integer(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_four_digits() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(1.0), "1");
        assert_eq!(number(-0.012345), "−0.01235");
        assert_eq!(number(123456.0), "123456");
        assert_eq!(number(1.5e-7), "1.5·10⁻⁷");
        assert_eq!(number(-2.0e9), "−2·10⁹");
        assert_eq!(number(f64::INFINITY), "∞");
        assert_eq!(integer(1234567), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn no_character_of_a_text_becomes_markup() {
        assert_eq!(escape("<a href=\"x\">'&\u{7}"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;\u{fffd}");
    }
}
