//! Places near which elements are smaller: meshes in two and three dimensions, and errors in such places.

use fdem_mesh::{Corners, Mesh};
use fdem_model::{AnyPrepared, prepare_any};

const STONE: &str =
    "[[material]]\nname = \"stone\"\ndensity = 2500\nyoungs_modulus = 10e9\npoissons_ratio = 0.2\n";

fn text(shape: &str, refine: &str) -> String {
    format!(
        "[model]\nend_time = 1e-3\n[[body]]\nname = \"b\"\nmaterial = \"stone\"\n{shape}\nmesh_size = 0.1\nrefine = {refine}\n{STONE}"
    )
}

fn any(shape: &str, refine: &str) -> Result<AnyPrepared, String> {
    let mut none = |_: &str| Err("there is none".to_owned());
    prepare_any(&text(shape, refine), "m.toml", &mut none, None).map_err(|errors| errors.to_string())
}

/// Longest edge of the elements that are nearer to a place than `near`, and the mean edge of those farther
/// than `far`.
fn edges<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    distance: impl Fn([f64; D]) -> f64,
    [near, far]: [f64; 2],
) -> [f64; 2] {
    let (mut longest, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
    for element in &mesh.elements {
        let corners = element.map(|node| mesh.nodes[node as usize]);
        let middle =
            std::array::from_fn(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / N as f64);
        for edge in fdem_mesh::edges(&corners) {
            if distance(middle) < near {
                longest = longest.max(edge);
            } else if distance(middle) > far {
                (sum, count) = (sum + edge, count + 1.0);
            }
        }
    }
    [longest, sum / count]
}

fn smallest_angle<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> f64
where
    [[f64; D]; N]: Corners<D, N>,
{
    let corners = |element: &[u32; N]| element.map(|node| mesh.nodes[node as usize]);
    mesh.elements.iter().flat_map(|element| corners(element).angles()).fold(180.0, f64::min)
}

#[test]
fn flat_bodies_are_fine_near_places_and_coarse_far_away() {
    for (shape, refine) in [
        ("rectangle = { min = [0, 0], max = [1, 1] }", "[{ point = [0.5, 0.5], size = 0.01, reach = 0.02 }]"),
        (
            "disc = { centre = [0.5, 0.5], radius = 0.6 }",
            "[{ line = [[0.5, 0.5], [0.5, 0.5]], size = 0.01, reach = 0.02 }]",
        ),
        (
            "voronoi = { outline = { rectangle = { min = [0, 0], max = [1, 1] } }, grains = 6 }",
            "[{ box = [0.5, 0.5, 0.5, 0.5], size = 0.01, reach = 0.02 }]",
        ),
    ] {
        let AnyPrepared::Plane(prepared) = any(shape, refine).unwrap() else { panic!("{shape} is not flat") };
        let mesh = &prepared.model.mesh;
        let distance = |[x, y]: [f64; 2]| (x - 0.5).hypot(y - 0.5);
        let [longest, mean] = edges(mesh, distance, [0.02, 0.4]);
        assert!(longest < 0.02 && longest > 0.008, "{shape}: {longest}");
        assert!((mean / 0.1 - 1.0).abs() < 0.25, "{shape}: {mean}");
        assert!(smallest_angle(mesh) > 12.0, "{shape}: {}", smallest_angle(mesh));
    }
}

#[test]
fn bodies_in_space_are_fine_near_places_and_coarse_far_away() {
    for (shape, refine) in [
        (
            "box = { min = [0, 0, 0], max = [1, 1, 1] }",
            "[{ point = [0.5, 0.5, 0.5], size = 0.02, reach = 0.03 }]",
        ),
        (
            "cylinder = { from = [0.5, 0.5, 0], to = [0.5, 0.5, 1], radius = 0.5 }",
            "[{ line = [[0.5, 0.5, 0.5], [0.5, 0.5, 0.5]], size = 0.02, reach = 0.03 }]",
        ),
        (
            "sphere = { centre = [0.5, 0.5, 0.5], radius = 0.55 }",
            "[{ box = [0.5, 0.5, 0.5, 0.5, 0.5, 0.5], size = 0.02, reach = 0.03 }]",
        ),
    ] {
        let AnyPrepared::Space(prepared) = any(shape, refine).unwrap() else { panic!("{shape} is flat") };
        let mesh = &prepared.model.mesh;
        let distance = |place: [f64; 3]| place.iter().map(|x| (x - 0.5) * (x - 0.5)).sum::<f64>().sqrt();
        let [longest, mean] = edges(mesh, distance, [0.03, 0.4]);
        assert!(longest < 0.045 && longest > 0.016, "{shape}: {longest}");
        assert!((mean / 0.1 - 1.0).abs() < 0.25, "{shape}: {mean}");
        assert!(smallest_angle(mesh) > 8.0, "{shape}: {}", smallest_angle(mesh));
    }
}

#[test]
fn a_place_that_cannot_be_is_an_error_at_its_key() {
    let rectangle = "rectangle = { min = [0, 0], max = [1, 1] }";
    let block = "box = { min = [0, 0, 0], max = [1, 1, 1] }";
    for (shape, refine, message) in [
        (
            rectangle,
            "[{ size = 0.01 }]",
            "place 1 to refine: it has to be exactly one of point, line and box",
        ),
        (
            rectangle,
            "[{ point = [0, 0], box = [0, 0, 1, 1], size = 0.01 }]",
            "exactly one of point, line and box",
        ),
        (
            rectangle,
            "[{ point = [0, 0, 0], size = 0.01 }]",
            "a point has 3 numbers, where a model in 2 dimensions has 2",
        ),
        (
            block,
            "[{ point = [0, 0, 0], size = 0.01 }, { line = [[0, 0, 0], [1, 1]], size = 0.01 }]",
            "place 2 to refine: a point has 2 numbers",
        ),
        (
            block,
            "[{ box = [0, 0, 1, 1], size = 0.01 }]",
            "the box has 4 numbers, where a model in 3 dimensions has 6",
        ),
        (rectangle, "[{ box = [1, 0, 0, 1], size = 0.01 }]", "the box is inside out"),
        (rectangle, "[{ point = [0, 0], size = 0.1 }]", "its size of 0.1 m is not below mesh_size = 0.1 m"),
        (
            rectangle,
            "[{ point = [0, 0], size = 0.05 }, { point = [7, 0], size = 0.01 }]",
            "place 2 to refine changes nothing: it is too far from the body",
        ),
        (
            rectangle,
            "[{ box = [0, 0, 1, 1], size = 1e-6 }]",
            "place 1 to refine: a size of 1e-6 m gives about",
        ),
        (block, "[{ box = [0, 0, 0, 1, 1, 1], size = 1e-4 }]", "the most are 20,000,000"),
        (block, "[{ point = [0, 0, 0], size = 1e-9 }]", "place 1 to refine: a size of 1e-9 m gives about"),
        (
            rectangle,
            "[{ point = [0, 0], size = 0.01 }, { point = [0, 0], size = 1e-9 }]",
            "place 2 to refine: a size of 1e-9 m is too small for this body",
        ),
        // Sizes that rounding loses, which had no end.
        (rectangle, "[{ point = [0, 0], size = 1e-300 }]", "a size of 1e-300 m is too small for this body"),
        (rectangle, "[{ point = [1, 0.5], size = 1e-20 }]", "a size of 1e-20 m is too small for this body"),
        (block, "[{ point = [0, 0, 0], size = 1e-20 }]", "a size of 1e-20 m is too small for this body"),
    ] {
        let error = any(shape, refine).err().unwrap_or_else(|| panic!("{refine} is allowed"));
        assert!(error.starts_with("m.toml:8: ") && error.contains(message), "{refine}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}
