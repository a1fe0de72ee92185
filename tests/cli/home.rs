//! A folder with a case, in which the program is called.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

pub struct Home(tempfile::TempDir);

impl Home {
    pub fn new(case: &str) -> Self {
        let home = Self(tempfile::tempdir().unwrap());
        fs::write(home.path("case.toml"), case).unwrap();
        home
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lateen"));
        command.args(arguments).current_dir(self.0.path());
        command
    }

    pub fn lateen(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// A command of the shell, in which `lateen` stands for the program.
    #[cfg(target_os = "linux")]
    pub fn shell(&self, script: &str) -> Command {
        let mut command = Command::new("bash");
        let script = script.replace("lateen", env!("CARGO_BIN_EXE_lateen"));
        command.args(["-c", &script]).current_dir(self.0.path());
        command
    }
}

/// Output of the program.
pub fn messages(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
