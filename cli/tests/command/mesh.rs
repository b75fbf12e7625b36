//! `cut` and `check` of meshes that are easily taken for something else.

use super::support::{Workplace, assert_refused, command, cut, number};

/// A box between two corners as OBJ, its vertices counted from `first`.
fn block(low: [f64; 3], high: [f64; 3], first: usize) -> String {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let vertices = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads
        .iter()
        .map(|q| format!("f {} {} {} {}\n", q[0] + first, q[1] + first, q[2] + first, q[3] + first));
    vertices.chain(faces).collect()
}

#[test]
fn overlapping_shells_are_one_solid() {
    let both = block([-1.0; 3], [1.0; 3], 1) + &block([0.5, -0.5, -0.5], [1.5, 0.5, 0.5], 9);
    let place = Workplace::holding(&[("boxes.obj", &both)]);
    let report = command(&["cut", &place.name("boxes.obj")]).unwrap();
    let solid = &report.json["solid"];
    assert!(
        (number(&solid["volume"]) - 8.5).abs() < 1e-6 && (number(&solid["area"]) - 26.0).abs() < 1e-6,
        "{solid}"
    );
    assert!(report.json["warnings"][0].as_str().unwrap().contains("overlap or touch"), "{}", report.json);
}

#[test]
fn a_mesh_is_described_with_its_own_axis_up() {
    let place = Workplace::holding(&[("slab.obj", &block([-2.0, 0.0, -3.0], [2.0, 1.0, 3.0], 1))]);
    let width = |up: &[&str]| {
        let report = command(&[&["cut", &place.name("slab.obj")], up].concat()).unwrap();
        [number(&report.json["solid"]["width"]), number(&report.json["solid"]["length"])]
    };
    assert_eq!(width(&[]), [1.0, 4.0]);
    assert_eq!(width(&["--up", "y"]), [4.0, 6.0]);
    assert_eq!(width(&["--up", "x"]), [1.0, 6.0]);
    assert_refused(command(&["cut", &cut("srb_diamond_57.asc"), "--up", "y"]), 2, "--up is for meshes*");
}

#[test]
fn too_many_stones_over_one_point_are_refused_by_check_and_render() {
    let stone = "[[stone]]\nshape = \"round-brilliant\"\nwidth = 6.5\nmaterial = \"diamond\"\n";
    let scene = |count| {
        format!("format = 1\n[camera]\nposition = [0, -20, 26]\nlook_at = [0, 0, 0]\n{}", stone.repeat(count))
    };
    let place = Workplace::holding(&[("six.toml", &scene(6)), ("seven.toml", &scene(7))]);
    command(&["check", &place.name("six.toml")]).unwrap();
    let expected = "*over the point (*at most 6 may overlap at one point, but these do: stone 1 (shape), stone 2 (shape)*";
    for name in ["check", "render"] {
        assert_refused(command(&[name, &place.name("seven.toml")]), 3, expected);
    }
}
