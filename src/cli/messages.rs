//! What goes to standard error: warnings, errors and what `--log` asks for, through the common logging crate; as text, or as a
//! JSON object a line for programs that drive this one. **Law:** nothing of a file or name reaches the terminal but through
//! [`crate::shown`].

use crate::image::Image;
use crate::shown::shown;
use env_logger::{Builder, Target, WriteStyle};
use log::{Level, LevelFilter};
use serde_json::json;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// Messages are JSON objects.
static JSON: AtomicBool = AtomicBool::new(false);

/// Sets the logger up; `main` calls it first of all.
pub fn begin() {
    let format = |out: &mut env_logger::fmt::Formatter, record: &log::Record| {
        let text = record.args().to_string();
        let kind = match record.level() {
            Level::Error => "error",
            Level::Warn => "warning",
            Level::Info => "info",
            Level::Debug => "debug",
            Level::Trace => "trace",
        };
        match JSON.load(Ordering::Relaxed) {
            true => writeln!(out, "{}", json!({ "event": kind, "message": shown(&text) })),
            false => writeln!(out, "{kind}: {}", shown(&text)),
        }
    };
    let mut builder = Builder::new();
    // Our own alone: crates below log for their authors.
    builder.filter_module("octray", LevelFilter::Trace).target(Target::Stderr).write_style(WriteStyle::Never);
    // Set up twice, as tests do, it stays as it is.
    let _ = builder.format(format).try_init();
    set_level(LevelFilter::Warn);
}

/// Lets through what is at least as important as `level`.
pub fn set_level(level: LevelFilter) {
    log::set_max_level(level);
}

/// Makes every message from now on a JSON object.
pub fn as_json() {
    JSON.store(true, Ordering::Relaxed);
}

/// Whether messages are JSON objects.
pub fn are_json() -> bool {
    JSON.load(Ordering::Relaxed)
}

/// An event for a program that reads JSON; nobody else hears of it.
pub fn event(event: &serde_json::Value) {
    if are_json() {
        let _ = writeln!(std::io::stderr(), "{event}");
    }
}

/// What went wrong.
pub fn report(error: &impl std::fmt::Display) {
    log::error!(target: "octray", "{error}");
}

/// What the user should know.
pub fn warn(message: &str) {
    log::warn!(target: "octray", "{message}");
}

/// What the user should know of an image, which `name` names.
pub fn warn_of(name: &impl std::fmt::Display, image: &Image) {
    image.warnings.iter().for_each(|warning| warn(&format!("{name}: {warning}")));
}

/// What is going on, for those who asked.
pub fn tell(message: &str) {
    log::info!(target: "octray", "{message}");
}
