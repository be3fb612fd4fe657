//! Elements whose facets are not checked for failure, because they are too far from their strength.

use fdem_simulation::*;

use crate::common::{granite, held, nodes_where, rectangle, rock};
use crate::{resume, space};

/// Runs a model, and beside it a run that is resumed before each step: it has not yet checked a facet, and so
/// checks all of them. Both have the same states.
macro_rules! as_if_all_were_checked {
    ($model:expr, $dimensions:literal, $corners:literal, $steps:expr) => {{
        let model: Model<$dimensions, $corners> = $model;
        let mut run = Simulation::new(model.clone(), 1).expect("a model");
        let mut other = Simulation::new(model.clone(), 1).expect("a model");
        let (mut awake, mut all) = (0, 0);
        for step in 0..$steps {
            run.advance(1).expect("a step");
            other = Simulation::resume(model.clone(), other.state(), 1).expect("the same model");
            assert_eq!(other.awake(), model.mesh.elements.len());
            other.advance(1).expect("a step");
            awake += run.awake();
            all += model.mesh.elements.len();
            if step % 50 == 0 || step == $steps - 1 {
                let [state, expected] =
                    [&other, &run].map(|run| postcard::to_allocvec(&run.state()).expect("bytes"));
                assert!(state == expected, "after {step} steps");
            }
        }
        let counts = run.counts();
        assert!(counts.joints > 5, "it should have broken: {counts:?}");
        assert!(4 * awake < 3 * all, "elements should have slept: {awake} of {all}");
    }};
}

/// A strip that is drawn until it breaks at its weakest places.
fn drawn() -> Model {
    let mesh = rectangle([0.0; 2], [0.08, 0.16], 4, 8);
    let end = |name: &str, at: f64| {
        let nodes = nodes_where(&mesh, |[_, y]| (y - at).abs() < 1e-9);
        held(name, nodes, [None, Some(0.8 * at)], Schedule::Constant)
    };
    Model {
        boundaries: vec![end("bottom", 0.0), end("top", 0.16)],
        velocities: mesh.nodes.iter().map(|[_, y]| [0.0, 0.8 * y]).collect(),
        materials: vec![Material {
            strength: Some(Strength { weibull_modulus: Some(8.0), ..rock() }),
            damping: 0.05,
            ..granite()
        }],
        mesh,
        ..Model::default()
    }
}

#[test]
fn facets_in_the_plane_that_are_not_checked_do_not_fail() {
    as_if_all_were_checked!(resume::crash(Insertion::Adaptive), 2, 3, 1600);
    as_if_all_were_checked!(drawn(), 2, 3, 900);
}

#[test]
fn facets_in_space_that_are_not_checked_do_not_fail() {
    as_if_all_were_checked!(space::crash(Insertion::Adaptive), 3, 4, 400);
}
