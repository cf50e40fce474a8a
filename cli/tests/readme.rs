//! The readme's commands, run as they stand there on the repository's data.

use std::fs;
use std::path::PathBuf;

use crate::support::Folder;

/// A command line's words, as a shell takes it apart that knows double quotation marks and nothing else.
fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (i, part) in line.split('"').enumerate() {
        if i % 2 == 1 {
            words.push(part.to_owned());
        } else {
            words.extend(part.split_whitespace().map(str::to_owned));
        }
    }
    words
}

/// The arguments of every run of the program in the readme's shell examples.
fn commands(readme: &str) -> Vec<Vec<String>> {
    let blocks = readme.split("```sh\n").skip(1).filter_map(|b| b.split("```").next());
    let text = blocks.collect::<String>().replace("\\\n", " ");
    let arguments = |line: &str| {
        line.strip_prefix("collinear ")
            .or_else(|| line.strip_prefix("cargo run --release -p collinear-cli -- "))
            .map(words)
    };
    text.lines().filter_map(arguments).collect()
}

#[test]
fn the_commands_of_the_readme_run_as_they_stand() {
    let repository: PathBuf = [env!("CARGO_MANIFEST_DIR"), ".."].iter().collect();
    let readme = fs::read_to_string(repository.join("README.md")).unwrap();
    let folder = Folder::new();
    fs::create_dir_all(folder.path("examples/town")).unwrap();
    for entry in fs::read_dir(repository.join("examples/town")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let name = path.file_name().unwrap();
            fs::copy(&path, folder.path("examples/town").join(name)).unwrap();
        }
    }
    fs::create_dir_all(folder.path("examples/town/block")).unwrap();
    for entry in fs::read_dir(repository.join("examples/town/block")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap();
        fs::copy(&path, folder.path("examples/town/block").join(name)).unwrap();
    }
    let commands = commands(&readme);
    let used: Vec<_> = commands.iter().map(|c| c[0].as_str()).collect();
    assert_eq!(
        used,
        [
            "render",
            "render",
            "render",
            "reproject",
            "rectify",
            "rectify",
            "warp",
            "project",
            "project",
            "resect",
            "intersect",
            "adjust",
            "adjust",
            "overlay",
            "convert"
        ],
        "the readme's tasks"
    );
    for command in commands {
        let arguments: Vec<&str> = command.iter().map(String::as_str).collect();
        let run = folder.succeed(&arguments);
        assert!(!run.stderr.contains("warning"), "{command:?}: {}", run.stderr);
        let named = command.iter().skip_while(|a| *a != "-o").nth(1);
        let output = named.or(command.get(2)).unwrap();
        assert!(fs::metadata(folder.path(output)).unwrap().len() > 0, "{command:?}");
    }
    // What went to the picture and back: the foot of the town hall lies in the façade's plane.
    let table = folder.text("target/ground.csv");
    let foot = table.lines().find(|l| l.starts_with("\"town hall, right foot\"")).unwrap();
    let numbers: Vec<f64> = foot.split(',').skip(2).take(3).map(|n| n.parse().unwrap()).collect();
    for (n, expected) in numbers.iter().zip([389_411.0, 5_819_722.9, 34.0]) {
        assert!((n - expected).abs() < 1e-6, "{foot}");
    }
}
