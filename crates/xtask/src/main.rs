//! What people run while developing: `cargo xtask help`.

mod agree;
mod bits;
mod fuzz;
mod generate;
mod instructions;
mod mutants;
mod plant;
mod random;
mod sanitize;
mod scenes;
mod tidy;
mod truth;
mod verify;
mod verify_contacts;
mod verify_critical;
mod verify_split;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

#[derive(Parser)]
#[command(about = "Tasks for feeler's developers")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Install what the tests need, then run all of them.
    Test,
    /// Write the corpus's queries, and the models made here, again from fixed seeds; then run `truth`.
    Scenes(scenes::Args),
    /// Compute the truth of the corpus, or of one suite, with the oracle.
    Truth(truth::Args),
    /// Ask the kernel and the oracle the same random queries about a file, and compare.
    Agree(agree::Args),
    /// Run fuzz targets, and make what they find a corpus.
    Fuzz(fuzz::Args),
    /// Put mistakes into the kernel, one at a time, and tell which tests notice.
    Plant(plant::Args),
    /// Ask the kernel's tests about a seeded sample of small changes to some of its modules.
    Mutants(mutants::Args),
    /// Run the oracle's tests with its C++ under the address, undefined-behaviour and thread sanitizers.
    Sanitize(sanitize::Args),
    /// Count the instructions of some queries under valgrind, and hold them against the stored counts.
    Instructions(instructions::Args),
    /// Build the program with other code generation, and hold its answers to the corpora against those of the first build.
    Bits(bits::Args),
    /// Hold the oracle's C++ to clang-format and clang-tidy.
    Tidy(tidy::Args),
}

fn main() -> ExitCode {
    if std::env::var_os(fuzz::instrument::VARIABLE).is_some() {
        return fuzz::instrument::wrapped(std::env::args_os().skip(1).collect());
    }
    let result = match Arguments::parse().task {
        Task::Test => xtask_test::run(),
        Task::Scenes(args) => scenes::run(&xtask_test::root().join("corpora"), &args),
        Task::Truth(args) if args.verify.verify => verify::run(
            &args.verify,
            args.sample,
            args.slow,
            &args.corpora,
            args.suite.as_deref(),
        ),
        Task::Truth(args) => truth::run(&args),
        Task::Agree(args) => agree::run(&args),
        Task::Fuzz(args) => fuzz::run(&args),
        Task::Plant(args) => plant::run(&args),
        Task::Mutants(args) => mutants::run(&args),
        Task::Sanitize(args) => sanitize::run(&args),
        Task::Instructions(args) => instructions::run(&args),
        Task::Bits(args) => bits::run(&args),
        Task::Tidy(args) => tidy::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    /// clap looks for contradictions among the arguments in debug builds only.
    #[test]
    fn the_arguments_do_not_contradict_each_other() {
        super::Arguments::command().debug_assert();
    }
}
