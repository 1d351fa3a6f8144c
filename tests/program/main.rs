//! The ladder, top rung: the program and its files, from outside.

#[path = "../common/program.rs"]
mod program;

mod bench;
mod check;
mod cli;
mod converge;
mod diff;
mod frames;
mod help;
mod hostile;
mod images;
mod layers;
mod learned;
mod lights;
mod long;
mod view;
