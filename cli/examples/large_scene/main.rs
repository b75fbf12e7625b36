//! Writes the scenes that `scripts/memory.sh` measures: a closed mesh of many triangles, a large environment, and both.
//!
//!     cargo run --release -p gemtrace-cli --example large_scene -- FOLDER [TRIANGLES [WIDTH]]
//!
//! The mesh is a globe of `TRIANGLES` triangles, round (`round.ply`) and with hills (`hills.ply`, and `hills.stl`, where
//! each corner is written out); the environment is a sky of `WIDTH × WIDTH/2` texels with lamps in it (`sky.exr` in half
//! floats, `sky.hdr`). Everything is written as it is computed, so that the files may be larger than the memory.

mod globe;
mod sky;

use globe::Globe;
use sky::Sky;
use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, rest @ ..] = arguments.as_slice() else {
        return Err("give a folder, and optionally the numbers of triangles and of texels across".into());
    };
    let number = |at: usize, otherwise| rest.get(at).map_or(Ok(otherwise), |text| text.parse::<usize>());
    let (triangles, width) = (number(0, 10_000_000)?.max(64), number(1, 16_384)?.max(8));
    let folder = Path::new(folder);
    std::fs::create_dir_all(folder)?;
    for (name, height) in [("round", 0.0), ("hills", 0.08)] {
        Globe::new(triangles, height).write_ply(create(folder, &format!("{name}.ply"))?)?;
    }
    Globe::new(triangles, 0.08).write_stl(create(folder, "hills.stl")?)?;
    let sky = Sky { width, height: width / 2 };
    sky.write_exr(&folder.join("sky.exr"))?;
    sky.write_hdr(create(folder, "sky.hdr")?)?;
    let small = "uniform = [0.6, 0.7, 0.8]";
    let glass = "[[stone]]\nshape = \"round-brilliant\"\nwidth = 2.0\nmaterial = \"diamond\"\n";
    let stone = |file: &str| format!("[[stone]]\nmesh = \"{file}\"\nmaterial = \"diamond\"\n");
    for (name, light, stone) in [
        ("round", small, stone("round.ply")),
        ("hills", small, stone("hills.ply")),
        ("stl", small, stone("hills.stl")),
        ("exr", "image = \"sky.exr\"", glass.into()),
        ("hdr", "image = \"sky.hdr\"", glass.into()),
        ("both", "image = \"sky.exr\"", stone("hills.ply")),
        ("both-stl", "image = \"sky.hdr\"", stone("hills.stl")),
    ] {
        let scene = format!(
            "format = 1\n[camera]\nposition = [0.0, -8.0, 3.0]\nlook_at = [0.0, 0.0, 0.0]\nfov = 20.0\n\
             [film]\nwidth = 64\nheight = 64\n[environment]\n{light}\n{stone}\
             [render]\nsamples = 1\nwavelengths = {{ count = 4 }}\nmax_depth = 8\n"
        );
        std::fs::write(folder.join(format!("{name}.toml")), scene)?;
    }
    Ok(())
}

fn create(folder: &Path, name: &str) -> std::io::Result<BufWriter<File>> {
    File::create(folder.join(name)).map(BufWriter::new)
}
