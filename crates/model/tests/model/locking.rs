//! How much too stiff triangles of constant strain are in bending: measured against beam theory, and compared
//! with the check and the book.

use crate::right;

/// Length of the beam over its thickness.
const SLENDERNESS: f64 = 8.0;

/// Stiffness of a beam of `count` elements through its thickness under the loads of a cantilever, over that
/// of beam theory with shear, less 1.
///
/// Both ends have the tractions of the exact solution, so that the difference is that of the mesh alone. At
/// small strains the elements are linear elastic.
fn excess(plane: &str, nu: f64, count: f64) -> f64 {
    let text = format!(
        "[model]\nplane = \"{plane}\"\nend_time = 1e-6\n[[body]]\nname = \"beam\"\nmaterial = \"m\"\n\
         rectangle = {{ min = [0, -0.5], max = [{SLENDERNESS}, 0.5] }}\nmesh_size = {}\n\
         [[material]]\nname = \"m\"\ndensity = 1\nyoungs_modulus = 1\npoissons_ratio = {nu}\n",
        1.0 / count
    );
    let mesh = right(&text).model.mesh;
    let elements: Vec<_> = mesh
        .elements
        .iter()
        .map(|nodes| (*nodes, stiffness(nodes.map(|node| mesh.nodes[node as usize]), plane, nu)))
        .collect();
    let mut force = vec![[0.0; 2]; mesh.nodes.len()];
    load(&mesh.nodes, 0.0, &mut force);
    load(&mesh.nodes, SLENDERNESS, &mut force);
    // Load 1, thickness 1 both ways: I = 1/12, A = 1.
    let modulus = if plane == "strain" { 1.0 / (1.0 - nu * nu) } else { 1.0 };
    let shear = 1.0 / (2.0 * (1.0 + nu));
    let exact = SLENDERNESS.powi(3) * 4.0 / modulus + 1.2 * SLENDERNESS / shear;
    exact / compliance(&elements, &force) - 1.0
}

/// Adds the forces on the end at `x`: a shear force of 1 that is distributed as a parabola, and the moment
/// that goes with it.
fn load(nodes: &[[f64; 2]], x: f64, force: &mut [[f64; 2]]) {
    let sign = if x == 0.0 { -1.0 } else { 1.0 };
    let mut end: Vec<usize> = (0..nodes.len()).filter(|&node| nodes[node][0] == x).collect();
    end.sort_by(|&a, &b| nodes[a][1].total_cmp(&nodes[b][1]));
    for pair in end.windows(2) {
        let [low, high] = [nodes[pair[0]][1], nodes[pair[1]][1]];
        // Two points of Gauss and Legendre: exact for a parabola times a line.
        for point in [-1.0, 1.0] {
            let share = 0.5 * (1.0 + point / 3.0_f64.sqrt());
            let y = low + share * (high - low);
            let bending = -12.0 * (SLENDERNESS - x) * y;
            let traction = [sign * bending, sign * 1.5 * (1.0 - 4.0 * y * y)];
            for (node, weight) in [(pair[0], 1.0 - share), (pair[1], share)] {
                for axis in 0..2 {
                    force[node][axis] += 0.5 * (high - low) * weight * traction[axis];
                }
            }
        }
    }
}

/// Stiffness of a triangle, rows and columns x1, y1, x2, y2, x3, y3.
fn stiffness([a, b, c]: [[f64; 2]; 3], plane: &str, nu: f64) -> [[f64; 6]; 6] {
    let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    let gradient = [[b, c], [c, a], [a, b]].map(|[p, q]| [(p[1] - q[1]) / twice, (q[0] - p[0]) / twice]);
    // Lame's constants of the plane.
    let shear = 1.0 / (2.0 * (1.0 + nu));
    let lambda = if plane == "strain" { nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) } else { nu / (1.0 - nu * nu) };
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let (p, q) = (gradient[row / 2], gradient[column / 2]);
            let (i, k) = (row % 2, column % 2);
            let dot = if i == k { p[0] * q[0] + p[1] * q[1] } else { 0.0 };
            0.5 * twice * (lambda * p[i] * q[k] + shear * (p[k] * q[i] + dot))
        })
    })
}

/// Work of the force on the displacements that it makes, by conjugate gradients.
fn compliance(elements: &[([u32; 3], [[f64; 6]; 6])], force: &[[f64; 2]]) -> f64 {
    let times = |x: &[[f64; 2]]| {
        let mut sum = vec![[0.0; 2]; x.len()];
        for (nodes, matrix) in elements {
            let local: [f64; 6] = std::array::from_fn(|k| x[nodes[k / 2] as usize][k % 2]);
            for (row, values) in matrix.iter().enumerate() {
                sum[nodes[row / 2] as usize][row % 2] +=
                    values.iter().zip(local).map(|(a, b)| a * b).sum::<f64>();
            }
        }
        sum
    };
    let mut diagonal = vec![[0.0; 2]; force.len()];
    for (nodes, matrix) in elements {
        for k in 0..6 {
            diagonal[nodes[k / 2] as usize][k % 2] += matrix[k][k];
        }
    }
    let dot =
        |a: &[[f64; 2]], b: &[[f64; 2]]| a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum::<f64>();
    let scaled = |r: &[[f64; 2]]| -> Vec<[f64; 2]> {
        r.iter().zip(&diagonal).map(|(r, d)| [r[0] / d[0], r[1] / d[1]]).collect()
    };
    let mut found = vec![[0.0; 2]; force.len()];
    let mut rest = force.to_vec();
    let mut direction = scaled(&rest);
    let mut product = dot(&rest, &direction);
    let enough = 1e-10 * product;
    while product > enough {
        let image = times(&direction);
        let step = product / dot(&direction, &image);
        let add = |to: &mut [[f64; 2]], by: &[[f64; 2]], factor: f64| {
            for (to, by) in to.iter_mut().zip(by) {
                *to = [to[0] + factor * by[0], to[1] + factor * by[1]];
            }
        };
        add(&mut found, &direction, step);
        add(&mut rest, &image, -step);
        let next = scaled(&rest);
        let now = dot(&rest, &next);
        for (direction, next) in direction.iter_mut().zip(next) {
            *direction = [0, 1].map(|k| next[k] + now / product * direction[k]);
        }
        product = now;
    }
    dot(force, &found)
}

/// The output of the check for a model with a cantilever.
fn told(plane: &str, nu: f64, count: f64) -> Vec<String> {
    let text = format!(
        "[model]\nplane = \"{plane}\"\nend_time = 1e-6\n[[body]]\nname = \"beam\"\nmaterial = \"m\"\n\
         rectangle = {{ min = [0, -0.5], max = [{SLENDERNESS}, 0.5] }}\nmesh_size = {}\n\
         [[material]]\nname = \"m\"\ndensity = 1000\nyoungs_modulus = 1e9\npoissons_ratio = {nu}\n\
         [[boundary]]\nname = \"wall\"\nside = \"left\"\nfixed = \"xy\"\n",
        1.0 / count
    );
    right(&text).warnings
}

/// The number before " % too stiff" in a text.
fn percent(text: &str) -> f64 {
    text.split(" % too stiff").next().unwrap().rsplit(' ').next().unwrap().parse().unwrap()
}

#[test]
fn the_check_tells_how_much_too_stiff_a_coarse_member_is() {
    for (plane, nu, count) in
        [("strain", 0.2, 4.0), ("stress", 0.3, 3.0), ("strain", 0.4, 5.0), ("strain", 0.49, 4.0)]
    {
        let measured = 100.0 * excess(plane, nu, count);
        let warnings = told(plane, nu, count);
        let warning =
            warnings.iter().find(|warning| warning.contains("through its thickness of 1 m")).unwrap();
        let said = percent(warning);
        // Meshes scatter, more so where elements lock.
        let scatter = if nu > 0.45 { 0.25 } else { 0.15 };
        assert!((said / measured - 1.0).abs() < scatter, "{plane} {nu} {count}: {measured} {warning}");
    }
    assert_eq!(told("strain", 0.3, 9.0), Vec::<String>::new());
}

#[test]
fn nearly_incompressible_materials_are_told_to_lock_in_plane_strain() {
    let measured = 100.0 * excess("strain", 0.499, 8.0);
    let warnings = told("strain", 0.499, 9.0);
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("elements lock where Poisson's ratio is 0.499 in plane strain"), "{warning}");
    let said = percent(warning);
    assert!((said / measured - 1.0).abs() < 0.15, "{measured} {warning}");
    assert_eq!(told("stress", 0.499, 9.0), Vec::<String>::new());
}

/// A platen whose whole side is driven cannot bend, and a block does not.
#[test]
fn what_is_held_along_its_length_is_no_member() {
    let beam = "[model]\nend_time = 1e-6\n[[body]]\nname = \"beam\"\nmaterial = \"m\"\nrectangle = { min = [0, 0], max = [8, 1] }\nmesh_size = 0.3\n\
        [[material]]\nname = \"m\"\ndensity = 1000\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n";
    let boundary = |keys: &str| format!("{beam}[[boundary]]\nname = \"b\"\nfixed = \"xy\"\n{keys}\n");
    let bends = |text: &str| right(text).warnings.iter().any(|warning| warning.contains("if it bends"));
    assert!(bends(&boundary("side = \"left\"")));
    assert!(!bends(beam), "where nothing is held, bodies hit each other");
    assert!(!bends(&boundary("side = \"top\"")));
    let left = boundary("side = \"left\"");
    assert!(!bends(&left.replace("max = [8, 1]", "max = [3, 1]")));
}
