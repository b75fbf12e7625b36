//! The entry point of `gemtrace`.

#![forbid(unsafe_code)]

use clap::Parser as _;
use gemtrace_cli::{commands, console::Interrupt};
use std::process::ExitCode;
use std::sync::Arc;

fn main() -> ExitCode {
    let cli = match commands::Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let json = std::env::args_os()
                .take_while(|argument| argument != "--")
                .any(|argument| argument == "--json");
            return ExitCode::from(commands::refuse(&error, json, &mut std::io::stdout()));
        }
    };
    let interrupt = Arc::new(Interrupt::default());
    let requested = Arc::clone(&interrupt);
    let handler = move || {
        if !requested.request() {
            // Nothing is running that could save its work: files are only ever complete or temporary.
            std::process::exit(130);
        }
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        eprintln!("warning: Ctrl-C will lose the picture ({error})");
    }
    ExitCode::from(commands::main(&cli, &mut std::io::stdout().lock(), &mut std::io::stderr(), &interrupt))
}
