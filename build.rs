//! Finds the pair styles and fixes: every file in `src/pair/styles` and `src/dynamics/fixes` is one, so that adding a
//! file is all it takes to register it.

use std::fs;
use std::path::{Path, PathBuf};

fn main() {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    for (folder, file) in [("src/pair/styles", "pair_styles.rs"), ("src/dynamics/fixes", "fixes.rs")] {
        println!("cargo:rerun-if-changed={folder}");
        fs::write(out.join(file), registry(&root.join(folder))).expect("the build folder is writable");
    }
}

/// `#[path] pub mod NAME;` for each file and a `for_each` macro over their `Style` types.
fn registry(folder: &Path) -> String {
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .expect("the folder of styles exists")
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .collect();
    files.sort();
    let names: Vec<String> =
        files.iter().map(|f| f.file_stem().expect("a file has a name").to_string_lossy().into_owned()).collect();
    let mut text = String::new();
    for (file, name) in files.iter().zip(&names) {
        text += &format!("#[path = {:?}]\npub mod {name};\n", file.display().to_string());
    }
    text +=
        "/// Calls `$action!(Style)` for every registered style.\nmacro_rules! for_each {\n    ($action:ident) => {\n";
    for name in &names {
        text += &format!("        $action!({name}::Style);\n");
    }
    text += "    };\n}\n";
    text
}
