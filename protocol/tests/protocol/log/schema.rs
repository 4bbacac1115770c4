//! The folder `schema` is what its `.proto` texts give: the messages in Rust, and the descriptor sets that
//! the log carries. So the library needs no compiler of them. To renew it after a change of a text:
//! `RENEW=1 cargo test -p bedload-protocol --test protocol schema`.

use std::path::Path;

use prost::Message as _;

/// Text, and the file of its messages: prost names it by the package.
const TEXTS: [(&str, &str); 2] = [("foxglove", "foxglove.rs"), ("viewer", "bedload.viewer.rs")];

#[test]
fn messages_and_descriptors_are_those_of_the_texts() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema");
    let made = std::env::temp_dir().join(format!("bedload-schema-{}", std::process::id()));
    std::fs::create_dir_all(&made).expect("a folder");
    for (name, messages) in TEXTS {
        let mut compiler = protox::Compiler::new([&folder]).expect("the folder of the texts");
        compiler.include_imports(true).include_source_info(false);
        let text = folder.join(format!("{name}.proto"));
        let set = compiler.open_file(text).expect("compiles").file_descriptor_set();
        compare(&folder.join(format!("{name}.bin")), &set.encode_to_vec());
        prost_build::Config::new().out_dir(&made).compile_fds(set).expect("generates");
        compare(&folder.join(messages), &std::fs::read(made.join(messages)).expect("generated"));
    }
    std::fs::remove_dir_all(&made).expect("removed");
}

/// Holds a committed file against its bytes made anew, or writes it.
fn compare(path: &Path, bytes: &[u8]) {
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(path, bytes).expect("written");
    }
    let committed = std::fs::read(path).unwrap_or_default();
    assert!(committed == bytes, "{} is not of its text: RENEW=1 writes it anew", path.display());
}
