//! `gemtrace view`.

use crate::console::{Console, Report};
use gemtrace::view::{Options, View};
use gemtrace::{Error, registry};
use serde_json::json;
use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Arguments of `view`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Scenes (.toml), cuts (.asc, .gem, .gcs) or meshes (.obj, .stl, .ply); the second is shown beside the first
    /// [default: a round brilliant].
    pub files: Vec<PathBuf>,
    /// Do not open the browser; print the address only.
    #[arg(long)]
    pub no_open: bool,
    /// The port [default: a free one].
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    /// Listen at another address than 127.0.0.1: who knows the token can then look on from other machines.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST), hide_default_value = true)]
    pub listen: IpAddr,
    /// The folder that pictures and scenes are saved to; nothing is written elsewhere.
    #[arg(short, long, value_name = "FOLDER", default_value = "views")]
    pub output: PathBuf,
    /// What renders: auto, or a name that `gemtrace devices` lists.
    #[arg(long, value_name = "NAME", default_value = registry::AUTO)]
    pub backend: String,
    /// Which of the backend's devices, counted from 0.
    #[arg(long, value_name = "N")]
    pub device: Option<usize>,
    /// Worker threads [default: one a core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
}

/// Shows scenes live in a browser, until Ctrl-C.
///
/// # Errors
/// [`Error`] of the files, the address or the device.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    let options = Options {
        backend: args.backend.clone(),
        device: args.device,
        open: crate::arguments::open_options(args.threads),
        listen: args.listen,
        port: args.port,
        output: args.output.clone(),
        ..Options::default()
    };
    let view = View::open(&args.files, &options)?;
    let address = view.address();
    console.announce(&address);
    if !args.listen.is_loopback() {
        console.warn(format!(
            "{} lets in every machine that knows the token, and what is sent can be read on the way",
            args.listen
        ));
    }
    if !args.no_open && !open(&address) {
        console.say("no browser could be opened; open the address above");
    }
    console.interrupt.heed();
    view.serve(&|| console.interrupt.is_requested())?;
    Ok(Report::new("", json!({ "address": address })))
}

/// Opens an address with the program that the system has for it.
fn open(address: &str) -> bool {
    let (program, arguments): (_, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().is_ok()
}
