//! The command line. Exit codes: 0 done, 1 a comparison failed, 2 the case is wrong, 3 the run failed
//! numerically, 4 input/output, 130 interrupted.

mod cli;

use clap::{CommandFactory, Parser, Subcommand};
use cli::Failure;
use std::path::PathBuf;
use std::process::ExitCode;

/// Fluid-structure interaction with particles: the material point method with membranes.
#[derive(Parser)]
#[command(version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write a commented starter case (each built-in case is a starter)
    New {
        /// A built-in case
        name: String,
        /// Where to [default: a directory of that name]
        dir: Option<PathBuf>,
    },
    /// List the built-in cases: method, size, measured run time
    Cases,
    /// Print completions for a shell
    Completions {
        /// Your shell
        shell: clap_complete::Shell,
    },
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::New { name, dir } => cli::new::new(&name, dir),
        Command::Cases => cli::new::cases(),
        Command::Completions { shell } => {
            clap_complete::generate(shell, &mut Arguments::command(), "lateen", &mut std::io::stdout());
            Ok(())
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Comparison) => ExitCode::from(1),
        Err(Failure::Error(error)) => {
            eprintln!("{error}");
            ExitCode::from(error.exit_code())
        }
    }
}
