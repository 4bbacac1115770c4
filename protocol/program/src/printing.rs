//! Standard output that takes no more: a reader that has seen enough, a full disk.

use std::process::exit;

/// From here on a program that cannot print ends, where the standard library would panic: with code 0 and
/// without a word where its reader has seen enough (`bedload check SCENE | head -1`), with code 5 where there
/// is no room, else with code 1.
pub fn end_where_nothing_is_printed() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let text = panic.payload().downcast_ref::<String>().map_or("", String::as_str);
        let Some(cause) = text.strip_prefix("failed printing to stdout: ") else { return usual(panic) };
        if cause.contains("Broken pipe") {
            exit(0);
        }
        protocol::say!("cannot print: {cause}");
        // ENOSPC, EFBIG and EDQUOT of Linux, which the text ends with.
        let is_full = [28, 27, 122].iter().any(|code| cause.contains(&format!("os error {code})")));
        exit(if is_full { 5 } else { 1 });
    }));
}
