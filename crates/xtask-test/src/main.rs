//! `cargo xtask`: runs the tests itself, and hands every other task on to the program `xtask`, which cargo builds for it.

use std::ffi::OsString;
use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    match arguments.as_slice() {
        [task] if task == "test" => match xtask_test::run() {
            Ok(()) => ExitCode::SUCCESS,
            Err(message) => {
                eprintln!("xtask: {message}");
                ExitCode::FAILURE
            }
        },
        _ => hand_on(&arguments),
    }
}

/// Runs the program `xtask`, in the profile of the tests: exact arithmetic is far too slow unoptimised.
fn hand_on(arguments: &[OsString]) -> ExitCode {
    let status = Command::new(env!("CARGO"))
        .args("run --quiet --profile ci --package xtask --".split(' '))
        .args(arguments)
        .status();
    match status {
        Ok(status) => match status.code() {
            Some(0) => ExitCode::SUCCESS,
            Some(code) => u8::try_from(code).map_or(ExitCode::FAILURE, ExitCode::from),
            None => ExitCode::FAILURE,
        },
        Err(e) => {
            eprintln!("xtask: {} cannot be started: {e}", env!("CARGO"));
            ExitCode::FAILURE
        }
    }
}
