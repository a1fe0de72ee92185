//! The command line. Exit codes: 0 done, 1 a comparison failed, 2 the case is wrong, 3 the run failed
//! numerically, 4 input/output, 130 interrupted.

// They panic where nobody listens: `cli::show` and `cli::say` don't.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod cli;

use clap::{CommandFactory, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// Flow and fluid-structure interaction with particles: the material point method with membranes, and the particle
/// finite element method (PFEM-2) for several fluids and for elastic and rigid solids in them.
#[derive(Parser)]
#[command(version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a case
    Run(cli::run::Arguments),
    /// Validate a case without running it; print it resolved, its sizes, memory, first step and steps
    Check(cli::check::Arguments),
    /// Write a commented starter case (each built-in case is a starter)
    New {
        /// A built-in case
        name: String,
        /// Folder of the case [default: a directory of that name]
        dir: Option<PathBuf>,
    },
    /// List the built-in cases: method, size, measured run time
    Cases,
    /// Run validation cases and compare them with their references
    Verify(cli::verify::Arguments),
    /// Print the JSON Schema of the case file (editors complete and check it)
    Schema,
    /// List all keys of the case file: materials, meshes, boundaries, outputs, with units and defaults
    Laws,
    /// Print completions for a shell
    Completions {
        /// Your shell
        shell: clap_complete::Shell,
    },
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Run(arguments) => cli::run::run(arguments),
        Command::Check(arguments) => cli::check::check(&arguments),
        Command::New { name, dir } => cli::new::new(&name, dir),
        Command::Cases => cli::new::cases(),
        Command::Verify(arguments) => cli::verify::verify(&arguments),
        Command::Schema => cli::show(&format!("{:#}\n", lateen::case::schema())),
        Command::Laws => cli::show(&lateen::case::laws()),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "lateen", &mut script);
            cli::show(&String::from_utf8_lossy(&script))
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ExitCode::from(failure.report()),
    }
}
