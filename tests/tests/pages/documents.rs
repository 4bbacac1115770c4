//! Lines of documents and comments are short enough to read, and links of documents lead somewhere.

use std::path::{Path, PathBuf};

/// Longest line of prose, in characters. Tables, code blocks and links of documents may be longer.
const LONGEST: usize = 110;

/// Files below `folder` with this ending, but for what is built or hidden.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder of the repository");
    let mut found = Vec::new();
    for path in entries.map(|entry| entry.expect("an entry").path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && !name.starts_with('.') && !["target", "out"].contains(&name.as_str()) {
            found.extend(files(&path, ending));
        } else if path.is_file() && name.ends_with(ending) {
            found.push(path);
        }
    }
    found
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Lines of a document that are prose, with their numbers from 1.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut code = false;
    text.lines().enumerate().filter_map(move |(number, line)| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        let free =
            code || fence || line.trim_start().starts_with(['|', '!', '#', '<']) || line.starts_with("    ");
        (!free).then_some((number + 1, line))
    })
}

/// The text of a comment; nothing of a line of code.
fn comment(line: &str) -> &str {
    let line = line.trim_start();
    let text =
        line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).or_else(|| line.strip_prefix("//"));
    text.map_or("", |text| text.strip_prefix(' ').unwrap_or(text))
}

/// Does a line have words that could stand on the next one?
fn could_be_shorter(line: &str) -> bool {
    line.chars().count() > LONGEST && line.trim().chars().take(LONGEST).filter(|c| *c == ' ').count() > 2
}

#[test]
fn prose_has_short_lines() {
    let mut found = Vec::new();
    // A page that a study writes has the texts of its cases as they are.
    for path in files(&repository(), ".md").into_iter().filter(|path| !path.ends_with("docs/validation.md")) {
        let text = read(&path);
        let long = prose(&text).filter(|(_, line)| could_be_shorter(line));
        found.extend(long.map(|(number, _)| format!("{}:{number}", path.display())));
    }
    for path in files(&repository(), ".rs") {
        let text = read(&path);
        let comments: String = text.lines().map(|line| comment(line).to_owned() + "\n").collect();
        let lines: Vec<&str> = text.lines().collect();
        let long =
            prose(&comments).filter(|(number, line)| !line.is_empty() && could_be_shorter(lines[number - 1]));
        found.extend(long.map(|(number, _)| format!("{}:{number}", path.display())));
    }
    assert!(found.is_empty(), "longer than {LONGEST} characters:\n{}", found.join("\n"));
}

#[test]
fn links_lead_somewhere() {
    let mut broken = Vec::new();
    for path in
        files(&repository(), ".md").into_iter().filter(|path| !path.to_string_lossy().contains("/templates/"))
    {
        let text = read(&path);
        for link in text.split("](").skip(1).filter_map(|rest| rest.split([')', '#', ' ', '\n']).next()) {
            let outside = link.is_empty() || link.contains("://");
            if !outside && !path.parent().expect("a file lies in a folder").join(link).exists() {
                broken.push(format!("{}: {link}", path.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Files that the links of a document name.
fn links(text: &str) -> Vec<String> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
    links.map(str::to_owned).collect()
}

#[test]
fn the_summary_of_the_site_names_every_page_once() {
    let docs = repository().join("docs");
    let page = |path: PathBuf| path.strip_prefix(&docs).expect("below docs").to_string_lossy().into_owned();
    let mut pages: Vec<_> = files(&docs, ".md").into_iter().map(page).collect();
    pages.retain(|page| page != "SUMMARY.md");
    let mut named = links(&read(&docs.join("SUMMARY.md")));
    pages.sort();
    named.sort();
    assert_eq!(pages, named, "docs/SUMMARY.md");
}

/// Up to twelve, small, each below the commands that make it, which `.ci/gallery` does.
#[test]
fn the_gallery_is_small_and_says_how_it_was_made() {
    let docs = repository().join("docs");
    let text = read(&docs.join("gallery.md"));
    let parts: Vec<_> = text.split("\n## ").skip(1).collect();
    assert!((8..=12).contains(&parts.len()), "{} pictures", parts.len());
    let maker = read(&repository().join(".ci/gallery"));
    let mut all = 0;
    for part in parts {
        let name = part.split("figures/gallery/").nth(1).and_then(|rest| rest.split([')', '"']).next());
        let name = name.unwrap_or_else(|| panic!("no picture: {part}"));
        let bytes = std::fs::metadata(docs.join("figures/gallery").join(name)).expect(name).len();
        assert!(bytes <= 200_000, "{name}: {bytes} bytes");
        assert!(maker.contains(name.trim_end_matches(".png")), ".ci/gallery does not make {name}");
        assert!(part.contains("```sh\nbedload ") && part.contains(" s.\n"), "no command or no time: {part}");
        all += bytes;
    }
    assert!(all <= 1_500_000, "{all} bytes");
}

/// Scripts in documents, such as that for SLURM, are ones that bash can read.
#[test]
fn scripts_of_documents_are_bash() {
    let mut found = 0;
    for path in files(&repository().join("docs"), ".md") {
        for block in read(&path).split("\n```bash\n").skip(1) {
            let script = block.split("\n```").next().expect("a block");
            let check = std::process::Command::new("bash").args(["-n", "-c", script]).status();
            assert!(check.expect("bash").success(), "{}", path.display());
            found += 1;
        }
    }
    assert!(found > 0);
}

#[test]
fn only_prose_counts() {
    let text = "a\n```\ncode\n```\n| table |\nb\n";
    assert_eq!(prose(text).collect::<Vec<_>>(), [(1, "a"), (6, "b")]);
    assert!(could_be_shorter(&"word ".repeat(30)) && !could_be_shorter(&"x".repeat(200)));
}

/// A page of so many lines begins with its contents.
const LONG: usize = 400;

#[test]
fn long_pages_begin_with_their_contents() {
    let mut without = Vec::new();
    for path in files(&repository().join("docs"), ".md") {
        let text = read(&path);
        let parts = text.split("\n## ").count() - 1;
        let begin = text.split("\n## ").next().unwrap_or_default();
        let named = begin.split("**Contents.**").nth(1).map_or(0, |list| list.matches("](#").count());
        if text.lines().count() > LONG && named < parts {
            without.push(format!("{}: {parts} parts, {named} in its contents", path.display()));
        }
    }
    assert!(without.is_empty(), "{}", without.join("\n"));
}

#[test]
fn pictures_of_the_readme_are_small() {
    let text = read(&repository().join("README.md"));
    let pictures: Vec<_> = text.split("![").skip(1).flat_map(links).collect();
    let size = |name: &String| std::fs::metadata(repository().join(name)).expect(name).len();
    let shown: Vec<_> = pictures.iter().filter(|name| name.contains("/figures/")).collect();
    assert!(!shown.is_empty());
    for name in shown {
        assert!(size(name) <= 200_000, "{name}: {} bytes", size(name));
    }
}
