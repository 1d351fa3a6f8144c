//! `--help`: what it says is what the settings have.

use crate::program::{octray, stderr};

/// What `--help` of `command` says, each run of white space one blank.
fn help_of(command: &str) -> String {
    let output = octray(&[command, "--help"]);
    assert!(output.status.success(), "{}", stderr(&output));
    String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn help_names_the_choices_and_defaults_that_settings_have() {
    let default = octray::Settings::default();
    let names = |all: Vec<String>| all.join(", ");
    let lights = names(octray::Lights::ALL.iter().map(|lights| lights.to_string()).collect());
    let samplers = names(octray::Sampler::ALL.iter().map(|sampler| sampler.to_string()).collect());
    let depth = |depth: Option<u32>, none: &str| depth.map_or(none.to_owned(), |depth| depth.to_string());
    let roulette = format!("or `off` [default: the scene's, else {}]", depth(default.rr_depth, "off"));
    let events = format!("[default: the scene's, else {}]", depth(default.max_depth, "unbounded"));
    let render = help_of("render");
    for text in [
        format!("chooses its light: {lights} [default: the scene's, else {}]", default.lights),
        format!("come from: {samplers} [default: the scene's, else {}]", default.sampler),
        format!("[default: the scene's, else {}] --lights", default.strategy),
        format!("Samples a pixel [default: the scene's, else {};", default.spp),
        format!("Seed of all random numbers [default: the scene's, else {}]", default.seed),
        format!("Both give the same bits [default: {}]", default.engine),
    ] {
        assert!(render.contains(&text), "{text}: {render}");
    }
    let converge = help_of("converge");
    for text in [
        format!("or `all`: {lights} [default: the scene's, else {}]", octray::Settings::plain().lights),
        format!("or `all`: {samplers} [default: the scene's, else {}]", default.sampler),
        format!("[default: {}] --only-light", default.engine),
    ] {
        assert!(converge.contains(&text), "{text}: {converge}");
    }
    for help in [&render, &converge] {
        assert!(help.contains(&roulette) && help.contains(&events), "{help}");
        assert!(octray::Strategy::ALL.iter().all(|strategy| help.contains(strategy.name())), "{help}");
    }
}

/// Every command of every `Examples:` section that writes no file does what it says; all are parsed by a test of the program's
/// own.
#[test]
fn examples_of_help_run() {
    let mut run = 0;
    for command in ["info", "trace"] {
        let output = octray(&[command, "--help"]);
        let help = String::from_utf8_lossy(&output.stdout).into_owned();
        let examples = help.split_once("\nExamples:\n").unwrap_or_else(|| panic!("{help}")).1;
        for line in examples.lines().filter_map(|line| line.strip_prefix("  octray ")) {
            if line.contains("--json=") {
                continue;
            }
            let example = std::process::Command::new(env!("CARGO_BIN_EXE_octray"))
                .args(line.split(' '))
                .current_dir(env!("CARGO_MANIFEST_DIR"))
                .output()
                .unwrap();
            assert!(example.status.success(), "{line}: {}", stderr(&example));
            run += 1;
        }
    }
    assert!(run >= 4, "{run}");
}

/// One word for one thing.
#[test]
fn what_is_rendered_is_called_an_image() {
    for command in ["render", "info", "trace", "check", "bench", "diff", "converge", "merge"] {
        let help = help_of(command);
        assert!(!help.contains("picture"), "{command}: {help}");
    }
}
