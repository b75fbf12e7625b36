//! One measurement for each call, with one line of JSON as the result: `peers WHAT [ARGUMENT…]`, see [`run`]. Times are CPU
//! seconds of this process without preparations, so the load of the machine has little effect.

mod baseline;
mod exits;
mod gem;
mod light;
mod meshes;
mod ours;
mod peak;
mod record;
mod scene;
mod store;
mod throughput;

use serde_json::Value;
use spectral_core::settings::RenderSettings;
use std::{path::Path, process::ExitCode};

/// Why a measurement was not made.
type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments.iter().map(String::as_str).collect::<Vec<_>>()) {
        Ok(result) => {
            println!("{result}");
            ExitCode::SUCCESS
        }
        Err(failure) => {
            eprintln!("peers {}: {failure}", arguments.join(" "));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[&str]) -> Result<Value, Failure> {
    match arguments {
        ["peak"] => peak::measure(),
        ["render", instructions, mode, threads] => {
            ours::render(scene::instructions(instructions)?, mode, threads.parse()?)
        }
        ["baseline", mode] => baseline::render(mode),
        ["record", folder] => record::write(Path::new(folder)),
        ["exits", instructions, folder] => {
            exits::measure(scene::instructions(instructions)?, Path::new(folder))
        }
        ["heap", instructions] => exits::heap(scene::instructions(instructions)?),
        ["bandwidth"] => Ok(peak::bandwidth()),
        ["meshes", folder] => meshes::write(Path::new(folder)),
        ["build", mesh] => meshes::build(Path::new(mesh)),
        ["trace", mesh, rays] => meshes::trace(Path::new(mesh), Path::new(rays)),
        ["describe", folder] => ours::describe(Path::new(folder)),
        ["picture", mode, samples, wavelengths, depth, threshold, file] => {
            let settings = scene::deep(mode, samples.parse()?, wavelengths.parse()?)?;
            let (max_depth, threshold) = (depth.parse()?, threshold.parse()?);
            ours::picture(&RenderSettings { max_depth, threshold, ..settings }, Path::new(file))
        }
        ["indicatrix", samples, first, file] => {
            gem::picture(samples.parse()?, first.parse()?, Path::new(file))
        }
        _ => Err("no such measurement; src/main.rs lists them".into()),
    }
}
