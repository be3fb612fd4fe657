//! Forecasts of runs on many ranks: the ranks then have and send the predicted numbers.

use fdem_distributed::{Communicator, threads};
use fdem_simulation::*;

use crate::common::{granite, rectangle};

/// Predicts a run of a model after some steps on these numbers of ranks, and compares with the ranks. Returns
/// the last forecast.
macro_rules! as_foretold {
    ($model:expr, $dimensions:literal, $corners:literal, $steps:expr, $ranks:expr) => {{
        let model: Model<$dimensions, $corners> = $model;
        let whole = || {
            let mut whole = Simulation::new(model.clone(), 1).expect("a model");
            whole.advance($steps).expect("steps");
            whole
        };
        let mut last = None;
        for &size in $ranks {
            let forecast = Forecast::of(&mut whole(), size).expect("not too many ranks");
            let traffic = threads::run(size, |communicator: &dyn Communicator| {
                let run = (communicator.rank() == 0).then(whole);
                let mut run = Distributed::new(communicator, run, 1).expect("threads");
                let before = run.traffic();
                run.advance(1).expect("a step");
                assert_eq!((before.bytes, run.traffic().spreads), (0, 0));
                run.traffic()
            });
            assert_eq!(forecast.ranks(), size);
            for (rank, traffic) in forecast.of_ranks.iter().zip(&traffic) {
                let foretold = [rank.own, rank.halo, rank.neighbours, rank.neighbours, rank.bytes];
                let [messages, bytes] = [traffic.messages, traffic.bytes].map(|number| number as usize);
                assert_eq!(
                    foretold,
                    [traffic.own, traffic.halo, traffic.neighbours, messages, bytes],
                    "{size} ranks: own and halo elements, neighbours, messages and bytes of a step"
                );
            }
            let sum = |of: fn(&RankForecast) -> usize| forecast.of_ranks.iter().map(of).sum::<usize>();
            assert_eq!(sum(|rank| rank.own), forecast.elements);
            assert_eq!(sum(|rank| rank.nodes), forecast.nodes);
            assert_eq!(sum(|rank| rank.sent), sum(|rank| rank.received));
            last = Some(forecast);
        }
        last.expect("a forecast")
    }};
}

fn model(breaks: bool, insertion: Insertion) -> Model {
    let mut rock = granite();
    rock.strength = breaks.then(|| Strength { energy_i: 1e3, energy_ii: 5e3, ..crate::common::rock() });
    Model {
        mesh: rectangle([0.0; 2], [3.0, 2.0], 30, 20),
        materials: vec![rock],
        fracture: FractureOptions { insertion, ..FractureOptions::default() },
        ..Model::default()
    }
}

#[test]
fn whole_bodies_in_the_plane_are_divided_as_foretold() {
    let shared = as_foretold!(model(false, Insertion::Adaptive), 2, 3, 0, &[1, 2, 3, 8]);
    assert!(shared.imbalance() < 1.15, "{}", shared.imbalance());
    assert!(shared.of_ranks.iter().any(|rank| rank.near > 0), "outer elements are near those of other ranks");
    // With joints everywhere each corner has a separate node.
    let joined = as_foretold!(model(true, Insertion::Intrinsic), 2, 3, 0, &[2, 3, 8]);
    assert!(joined.mean(|rank| rank.sent) > 2.0 * shared.mean(|rank| rank.sent));
    assert!(joined.sizes.all() > 2.0 * shared.sizes.all());
}

#[test]
fn whole_bodies_in_space_are_divided_as_foretold() {
    let mesh = crate::space::cuboid([0.0; 3], [1.0, 0.7, 0.6], [10, 7, 6]);
    let model = Model { mesh, materials: vec![granite()], ..Model::default() };
    let forecast = as_foretold!(model, 3, 4, 0, &[2, 3, 8]);
    assert!(forecast.halo_share() > 0.3, "{}", forecast.halo_share());
}

/// Before the first step, and when joints have broken and fragments touch.
#[test]
fn a_crash_is_divided_as_foretold() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        as_foretold!(crate::resume::crash(insertion), 2, 3, 0, &[2, 3, 8]);
        as_foretold!(crate::resume::crash(insertion), 2, 3, 1000, &[2, 3, 8]);
        as_foretold!(crate::space::crash(insertion), 3, 4, 0, &[2, 3, 8]);
        as_foretold!(crate::space::crash(insertion), 3, 4, 400, &[2, 3, 8]);
    }
}

/// A run continues with the same bits after a forecast.
#[test]
fn a_forecast_changes_no_result() {
    let run = |looks: bool| {
        let mut run = Simulation::new(crate::resume::crash(Insertion::Adaptive), 1).expect("a model");
        for _ in 0..20 {
            run.advance(40).expect("steps");
            if looks {
                Forecast::of(&mut run, 4).expect("not too many ranks");
            }
        }
        run.snapshot()
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn no_ranks_and_too_many_are_refused() {
    let mut run = Simulation::new(model(false, Insertion::Adaptive), 1).expect("a model");
    for (ranks, says) in [(0, "0 ranks"), (1201, "1201 ranks are more than the 1200 elements")] {
        let refused = Forecast::of(&mut run, ranks).expect_err("no such division");
        assert!(refused.to_string().contains(says), "{refused}");
    }
    assert!(Forecast::of(&mut run, 1200).is_ok());
}

/// The predicted memory of a rank is that of its lists.
#[test]
fn memory_is_that_of_the_lists_of_a_rank() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let whole = || Simulation::new(model(true, insertion), 1).expect("a model");
        let forecast = Forecast::of(&mut whole(), 4).expect("not too many ranks");
        let of_ranks = threads::run(4, |communicator: &dyn Communicator| {
            let run = (communicator.rank() == 0).then(whole);
            Distributed::new(communicator, run, 1).expect("threads").memory()
        });
        let of_element = forecast.sizes.all() - forecast.sizes.contacts;
        for (rank, bytes) in forecast.of_ranks.iter().zip(of_ranks) {
            let foretold = of_element * rank.held() as f64;
            let ratio = foretold / bytes as f64;
            assert!((0.93..1.07).contains(&ratio), "{insertion:?}: {foretold} instead of {bytes}");
        }
    }
}
