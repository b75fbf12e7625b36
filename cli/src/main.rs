//! The entry point of `gemtrace`.

#![forbid(unsafe_code)]

use clap::Parser as _;
use gemtrace::{import, output};
use gemtrace_cli::{commands, console::Interrupt};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// How long the work may take to hear that it is to stop.
const PATIENCE: Duration = Duration::from_millis(600);

fn main() -> ExitCode {
    quieten_decoders();
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
    if let Err(error) = ctrlc::set_handler(move || stop(&requested)) {
        eprintln!("warning: Ctrl-C will lose the picture ({error})");
    }
    #[cfg(unix)]
    if let Err(error) = outlive_full_quotas() {
        eprintln!("warning: a file that grows too large will end the program ({error})");
    }
    ExitCode::from(commands::main(&cli, &mut std::io::stdout().lock(), &mut std::io::stderr(), &interrupt))
}

/// What a decoder panics about is told as an error.
fn quieten_decoders() {
    let tell = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !import::is_decoding() {
            tell(panic);
        }
    }));
}

/// Ctrl-C, or a scheduler's wish. Work that heeds it saves what is finished; where nothing does, or too late, there is
/// nothing to save, and the process ends. A second wish is granted at once.
fn stop(interrupt: &Arc<Interrupt>) {
    if !interrupt.request() {
        end();
    }
    let interrupt = Arc::clone(interrupt);
    std::thread::spawn(move || {
        // What is being written may be the finished picture.
        while !interrupt.is_heard_within(PATIENCE) {
            if !output::is_writing() {
                end();
            }
        }
    });
}

/// Files are only ever complete or temporary: nothing is left behind.
fn end() -> ! {
    output::abandon();
    eprintln!("error: interrupted");
    std::process::exit(130)
}

/// A file that outgrows its limit is then an error of the write, like a full disk, and not the end of the process.
#[cfg(unix)]
fn outlive_full_quotas() -> std::io::Result<()> {
    let exceeded = Arc::default();
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, exceeded).map(drop)
}
