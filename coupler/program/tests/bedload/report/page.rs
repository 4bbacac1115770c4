//! What the page holds, and that it needs nothing else.

use std::fs;
use std::path::Path;

use bedload_output::{RunStatus, Summary};
use study::report::report;

use super::sample;

fn page(root: &Path) -> String {
    let pages = report(&[root]).expect("a page");
    assert_eq!(pages, [root.join("report.html")]);
    fs::read_to_string(&pages[0]).expect("text")
}

/// Every element is closed in order; attributes are quoted: enough of XML for HTML without void
/// elements other than those named.
fn assert_balanced(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = html;
    while let Some(start) = rest.find('<') {
        if let Some(comment) = rest[start..].strip_prefix("<!--") {
            rest = &comment[comment.find("-->").expect("a comment ends") + 3..];
            continue;
        }
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes in <{tag}>");
        let name = tag.trim_start_matches('/').split([' ', '/', '\n']).next().unwrap_or("");
        if tag.starts_with('!') || tag.ends_with('/') || ["meta", "link"].contains(&name) {
            continue;
        }
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closing </{name}>");
        } else {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

#[test]
fn the_page_holds_every_part() {
    let html = page(&sample::folder("parts"));
    for id in ["metrics", "curves", "vorticity", "steps", "bounds", "cost"] {
        assert!(html.contains(&format!("<section id=\"{id}\">")), "no section {id}");
    }
    for text in [
        "completed",
        "rebound_velocity_ratio",
        "Courant",
        "t_c / dt of the DEM",
        "Cost split",
        "sub-steps per window",
    ] {
        assert!(html.contains(text), "no {text}");
    }
    for caption in [
        "Velocity<",
        "Velocity around the first bounce",
        "Gap to the nearest",
        "Forces on grain 0: ",
        "Forces on grain 0 around the first bounce",
        "DEM sub-steps",
    ] {
        assert!(html.contains(&format!("<figcaption>{caption}")), "no chart {caption}");
    }
    assert!(html.contains("warned of") && !html.contains(">broken<"), "a bound that warns is not broken");
    assert_eq!(html.matches("<image ").count(), 14, "a picture of each file of fields");
    // dt_f/t_c and t_c/dt_dem as planned; 3500 windows done.
    assert!(html.contains("<td>125</td>") && html.contains("<td>0.2</td>") && html.contains("3\u{202f}500"));
    assert_balanced(&html);
}

#[test]
fn the_page_needs_nothing_but_itself() {
    let html = page(&sample::folder("alone"));
    for outside in ["<script", "src=", "@import", "<iframe", "@font-face"] {
        assert!(!html.contains(outside), "the page has {outside}");
    }
    let links: Vec<&str> = html.match_indices("href=\"").map(|(at, _)| &html[at + 6..at + 14]).collect();
    assert!(links.iter().all(|link| link.starts_with("data:")), "{links:?}");
    // Clips point into the page.
    assert_eq!(html.matches("url(").count(), html.matches("url(#").count());
    // Addresses appear as names of namespaces only.
    assert_eq!(html.matches("http").count(), html.matches("xmlns=\"http").count());
}

#[test]
fn text_of_the_scene_is_never_markup() {
    let html = page(&sample::folder("escaped"));
    assert!(html.contains("a &lt;bounce&gt; &amp; &quot;more&quot;"));
    assert!(!html.contains("<bounce>") && !html.contains("<none>") && !html.contains("<td><b></td>"));
}

#[test]
fn a_failed_run_without_series_fields_or_plan_still_has_a_page() {
    let root = sample::folder("failed");
    let mut summary = Summary::read(&root.join("summary.json")).expect("the summary");
    summary.fail(&"fluid died <here> during window 3");
    assert_eq!(summary.status, RunStatus::Failed);
    summary.write(&root.join("summary.json")).expect("the summary");
    for name in ["series.csv", "plan.json", "scene.toml"] {
        fs::remove_file(root.join(name)).expect("removes");
    }
    fs::remove_dir_all(root.join("fields")).expect("removes");
    fs::write(root.join("exchange.mcap"), "not a log").expect("writes");
    let html = page(&root);
    assert!(html.contains("fluid died &lt;here&gt; during window 3"));
    assert!(html.contains("There are no curves") && html.contains("The scene is not shown"));
    assert!(!html.contains("id=\"curves\"") && !html.contains("id=\"vorticity\""));
    assert!(html.contains("id=\"log\""));
    assert_balanced(&html);
}

#[test]
fn a_folder_without_a_run_is_an_error_that_names_it() {
    let error = report(&[Path::new("/nonexistent/run")]).expect_err("no run").to_string();
    assert!(error.contains("/nonexistent/run") && error.contains("summary.json"), "{error}");
    assert!(report(&[]).is_err());
}
