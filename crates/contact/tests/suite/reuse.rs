//! A search that has been used before finds the result of a new one, in the same order.

use std::panic::{AssertUnwindSafe, catch_unwind};

use fdem_contact::{Couple, Elements, Rows, Search};
use fdem_scenes::{Cloud, Sizes, clusters, gas};

/// Searches that are used repeatedly, with different numbers of threads.
struct Reused<const D: usize>(Vec<Rows<f64, D>>);

impl<const D: usize> Reused<D> {
    fn new() -> Self {
        Self([1, 2, 3, 8].map(|threads| Rows::new().with_threads(threads).unwrap()).into())
    }

    /// Searches `elements`, and compares each list with that of a new search.
    fn finds_the_same_as_new(&mut self, elements: &Elements<'_, f64, D>, what: &str) {
        let mut expected = Vec::new();
        Rows::new().couples(elements, &mut expected).unwrap();
        assert!(!expected.is_empty(), "{what} has couples to lose");
        for (rows, threads) in self.0.iter_mut().zip([1, 2, 3, 8]) {
            let mut found: Vec<Couple> = Vec::new();
            rows.couples(elements, &mut found).unwrap();
            assert!(found == expected, "{what}, D = {D}, {threads} threads");
        }
    }

    /// A visitor that panics at the first couple.
    fn are_cut_short(&mut self, elements: &Elements<'_, f64, D>) {
        for rows in &mut self.0 {
            let cut = catch_unwind(AssertUnwindSafe(|| rows.for_each(elements, |_| panic!("cut short"))));
            assert!(cut.is_err());
        }
    }
}

/// The shapes that are made from centres and radii.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Equal,
    Radii,
    Boxes,
}

fn with_elements<const D: usize>(cloud: &Cloud<D>, kind: Kind, search: impl FnOnce(&Elements<'_, f64, D>)) {
    match kind {
        Kind::Equal => search(&Elements::points(&cloud.centres, 1.0).unwrap()),
        Kind::Radii => search(&Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap()),
        Kind::Boxes => {
            let far: Vec<_> = cloud.centres.iter().map(|centre| centre.map(|x| x + 0.75)).collect();
            search(&Elements::boxes(&cloud.centres, &far).unwrap());
        }
    }
}

const SIZES: Sizes = Sizes::Lognormal { median: 0.5, sigma: 0.2 };

fn a_story<const D: usize>(kind: Kind) {
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut reused = Reused::<D>::new();
    let mut search = |cloud: &Cloud<D>, what: &str| {
        with_elements(cloud, kind, |elements| {
            reused.finds_the_same_as_new(elements, &format!("{what}, {kind:?}"));
            if what == "a walk" {
                reused.are_cut_short(elements);
                reused.finds_the_same_as_new(elements, &format!("after a search cut short, {kind:?}"));
            }
        });
    };

    let mut cloud = gas::<D>(22_000, 1, 6.0, SIZES).unwrap();
    search(&cloud, "first");
    for motion in [0.0, 0.02, 0.2, 2.0] {
        cloud.centres.iter_mut().flatten().for_each(|x| *x += motion * (random() - 0.5));
        search(&cloud, "a walk");
    }

    let before = cloud.centres[777];
    cloud.centres[777] = [1e7; D];
    search(&cloud, "one that jumps");
    cloud.centres[777] = before;
    search(&cloud, "one that jumps back");

    // The same positions with other numbers: only the ids show that something changed.
    cloud.centres.reverse();
    cloud.radii.reverse();
    search(&cloud, "other numbers");
    cloud.centres.iter_mut().flatten().for_each(|x| *x = x.floor() * 0.75);
    search(&cloud, "many in one place");

    cloud.centres.truncate(300);
    cloud.radii.truncate(300);
    search(&cloud, "fewer");
    search(&gas::<D>(23_000, 2, 6.0, SIZES).unwrap(), "more");
    search(&clusters::<D>(23_000, 3, 100, 1e5, 4.0, SIZES).unwrap(), "as many, unrelated");
    search(&gas::<D>(23_000, 4, 6.0, SIZES).unwrap(), "unrelated again");
}

#[test]
fn spheres_of_one_radius() {
    a_story::<2>(Kind::Equal);
    a_story::<3>(Kind::Equal);
}

#[test]
fn spheres_with_radii() {
    a_story::<2>(Kind::Radii);
    a_story::<3>(Kind::Radii);
}

#[test]
fn boxes() {
    a_story::<2>(Kind::Boxes);
    a_story::<3>(Kind::Boxes);
}
