//! The entry point of `gemtrace`.

#![forbid(unsafe_code)]

use clap::Parser as _;
use gemtrace::{import, output};
use gemtrace_cli::{commands, console::Interrupt};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// How long the work may take to look at a request to stop.
const PATIENCE: Duration = Duration::from_millis(600);

fn main() -> ExitCode {
    silence_decoders();
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
    if let Err(error) = ignore_size_signal() {
        eprintln!("warning: a file that grows too large will end the program ({error})");
    }
    ExitCode::from(commands::main(&cli, &mut std::io::stdout().lock(), &mut std::io::stderr(), &interrupt))
}

/// A panic of a decoder becomes an error with a message; nothing else is printed about it.
fn silence_decoders() {
    let tell = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !import::is_decoding() {
            tell(panic);
        }
    }));
}

/// Ctrl-C, or SIGTERM from a scheduler. Work that looks at the request saves what is finished. Where none looks in time,
/// nothing is saved and the process ends. A second request ends it at once.
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
fn ignore_size_signal() -> std::io::Result<()> {
    let exceeded = Arc::default();
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, exceeded).map(drop)
}
