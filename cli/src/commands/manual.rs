//! `gemtrace completions` and `gemtrace man`: what the command line says about itself.

use super::Cli;
use crate::console::Report;
use clap::CommandFactory as _;
use clap_complete::Shell;
use gemtrace::Error;
use serde_json::json;

/// Arguments of `completions`.
#[derive(Debug, Clone, clap::Args)]
pub struct CompletionArgs {
    /// The shell.
    pub shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The command, such as `render` or `sheet sizes` [default: the program].
    pub command: Vec<String>,
}

/// The script of a shell.
pub fn completions(args: &CompletionArgs) -> Report {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "gemtrace", &mut script);
    let script = String::from_utf8_lossy(&script);
    Report::new(script.trim_end(), json!({ "shell": args.shell.to_string(), "script": script }))
}

/// A manual page in the format of `man`.
///
/// # Errors
/// [`Error::Usage`] for a command that does not exist.
pub fn run(args: &Args) -> Result<Report, Error> {
    let mut command = Cli::command();
    command.build();
    let mut found = &command;
    for name in &args.command {
        let names = || found.get_subcommands().map(|command| command.get_name());
        let unknown = || Error::Usage(spectral_core::Error::unknown("command", name, names()).to_string());
        found = found.find_subcommand(name).ok_or_else(unknown)?;
    }
    let mut page = Vec::new();
    let written = clap_mangen::Man::new(found.clone()).render(&mut page);
    written.map_err(|e| Error::output("the manual page", e))?;
    let page = String::from_utf8_lossy(&page);
    Ok(Report::new(page.trim_end(), json!({ "page": page })))
}
