//! Unsafe code is where the documentation of the crate says, and nowhere else.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Adds the paths of all Rust files in `folder`, relative to `root`, that allow unsafe code. The workspace
/// denies it elsewhere.
fn collect(root: &Path, folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(root, &path, found);
        } else if path.extension().is_some_and(|end| end == "rs")
            && fs::read_to_string(&path).unwrap().contains("unsafe_code,")
        {
            found.insert(path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/"));
        }
    }
}

#[test]
fn unsafe_code_is_in_the_listed_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = BTreeSet::new();
    collect(root, &root.join("src"), &mut found);
    let text = fs::read_to_string(root.join("src/lib.rs")).unwrap();
    let (_, section) = text.split_once("//! # Unsafe code\n").unwrap();
    let listed = section.lines().take_while(|line| !line.starts_with("//! # ")).flat_map(|line| {
        line.split('`').filter(|word| word.starts_with("src/")).map(str::to_owned).collect::<Vec<_>>()
    });
    assert_eq!(found, listed.collect(), "files that allow unsafe code, and those in the documentation");
}
