//! Golden hashes: one per generator, the same on every platform.
//!
//! A changed hash means that the same seed now gives another scene. That invalidates every recorded
//! measurement and every stored scene. Change a number here only together with a line in the change log.

use fdem_scenes::random::Random;
use fdem_scenes::{
    Boxes, Cloud, Error, Sizes, book, boxes, clusters, deposit, gas, jittered_lattice, lattice, peers,
};

/// FNV-1a, 64 bits.
fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes
        .into_iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn hash<const D: usize>(cloud: &Cloud<D>) -> u64 {
    fnv1a(cloud.centres.iter().flatten().chain(&cloud.radii).flat_map(|x| x.to_bits().to_le_bytes()))
}

fn hash_of_boxes<const D: usize>(boxes: &Boxes<D>) -> u64 {
    fnv1a(
        boxes.min.iter().flatten().chain(boxes.max.iter().flatten()).flat_map(|x| x.to_bits().to_le_bytes()),
    )
}

const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };
const POWER: Sizes = Sizes::PowerLaw { min: 1.0, max: 50.0, exponent: -2.5 };
const RISING: Sizes = Sizes::PowerLaw { min: 1.0, max: 50.0, exponent: 0.5 };
const EVEN: Sizes = Sizes::PowerLaw { min: 1.0, max: 50.0, exponent: -1.0 };
const LOGNORMAL: Sizes = Sizes::Lognormal { median: 0.5, sigma: 0.3 };

/// Every seeded generator, for the given seed.
fn seeded(seed: u64) -> Result<Vec<(&'static str, u64)>, Error> {
    Ok(vec![
        ("gas 2D", hash(&gas::<2>(5_000, seed, 6.0, POWER)?)),
        ("gas 3D", hash(&gas::<3>(5_000, seed, 12.0, LOGNORMAL)?)),
        ("gas 4D", hash(&gas::<4>(5_000, seed, 12.0, RISING)?)),
        ("gas 3D, even logarithms", hash(&gas::<3>(5_000, seed, 12.0, EVEN)?)),
        ("jittered lattice 2D", hash(&jittered_lattice::<2>(5_000, seed, 1.1, 0.3, POWER)?)),
        ("jittered lattice 3D", hash(&jittered_lattice::<3>(5_000, seed, 1.1, 0.3, EQUAL)?)),
        ("clusters 2D", hash(&clusters::<2>(5_000, seed, 300, 1e4, 3.0, LOGNORMAL)?)),
        ("clusters 3D", hash(&clusters::<3>(5_000, seed, 300, 1e5, 0.8, EQUAL)?)),
        ("deposit, equal", hash(&deposit(2_000, seed, EQUAL, 30.0, 1e-3)?)),
        ("deposit, lognormal", hash(&deposit(2_000, seed, LOGNORMAL, 30.0, 1e-3)?)),
        ("peers::gas", hash(&peers::gas(5_000, seed)?)),
        ("peers::sparse", hash(&peers::sparse(5_000, seed)?)),
        ("peers::dense", hash(&peers::dense(5_000, seed)?)),
        ("peers::poly", hash(&peers::poly(5_000, seed)?)),
        ("peers::lognormal", hash(&peers::lognormal(5_000, seed)?)),
        ("peers::unlike", hash(&peers::unlike(5_000, seed, 100.0)?)),
        ("peers::boxes", hash_of_boxes(&peers::boxes(5_000, seed)?)),
        ("boxes 2D", hash_of_boxes(&boxes::<2>(5_000, seed, 6.0, 3.0)?)),
    ])
}

fn unseeded() -> Result<Vec<(&'static str, u64)>, Error> {
    Ok(vec![
        ("lattice 2D", hash(&lattice::<2>(1_000, 1.1, 0.3)?)),
        ("lattice 3D", hash(&lattice::<3>(1_000, 1.1, 0.3)?)),
        ("packing A", hash(&book::packing_a::<2>(1_000)?)),
        ("packing B", hash(&book::packing_b::<2>(1_000, 3.3)?)),
        ("packing C", hash(&book::packing_c::<3>(1_000, 3.3)?)),
        ("packing D", hash(&book::packing_d::<3>(1_000, 3.3)?)),
        ("ten bodies", hash(&book::ten_bodies())),
    ])
}

#[test]
fn hash_is_fnv1a() {
    assert_eq!(fnv1a(*b"foobar"), 0x8594_4171_f739_67e8);
}

#[test]
fn same_seed_same_bits() {
    assert_eq!(
        seeded(42).unwrap(),
        [
            ("gas 2D", 0xc1e8_9e80_a0bb_050b),
            ("gas 3D", 0x7e09_7d17_4a00_80a2),
            ("gas 4D", 0xbaa0_2001_b784_9f09),
            ("gas 3D, even logarithms", 0x7b3c_3cb1_1a70_11be),
            ("jittered lattice 2D", 0x5aab_fc04_60f8_b02b),
            ("jittered lattice 3D", 0x7a60_005d_db34_21f9),
            ("clusters 2D", 0x220d_ba12_8e9b_f103),
            ("clusters 3D", 0x0d7c_17f7_5625_1bbd),
            ("deposit, equal", 0x95ee_4a76_0c3e_ef76),
            ("deposit, lognormal", 0x865e_43de_4143_fd84),
            ("peers::gas", 0xcc07_1731_6308_c5de),
            ("peers::sparse", 0xfb75_c82a_223e_eddc),
            ("peers::dense", 0x5318_92fe_34ba_14be),
            ("peers::poly", 0x2e05_ef89_e544_0e27),
            ("peers::lognormal", 0x3381_f573_38af_31e4),
            ("peers::unlike", 0xec82_d4ef_cf64_5333),
            ("peers::boxes", 0x8450_751c_226f_afa2),
            ("boxes 2D", 0xc8c5_2e3a_9cf3_4cc7),
        ]
    );
}

#[test]
fn scenes_without_a_seed_have_their_bits() {
    assert_eq!(
        unseeded().unwrap(),
        [
            ("lattice 2D", 0x30e6_a20b_b98a_d33d),
            ("lattice 3D", 0x1fbe_0852_c470_1e15),
            ("packing A", 0x4221_9e6f_0e11_0755),
            ("packing B", 0xf513_2971_812e_4f3d),
            ("packing C", 0x55b1_fe89_182f_484d),
            ("packing D", 0xd40e_ac8c_06f3_9b5d),
            ("ten bodies", 0xd076_8b39_e358_b0fd),
        ]
    );
}

#[test]
fn random_numbers_have_their_bits() {
    let mut random = Random::with_stream(42, 7);
    let mut bytes = Vec::new();
    for _ in 0..10_000 {
        bytes.extend(random.uniform().to_bits().to_le_bytes());
        bytes.extend(random.normal().to_bits().to_le_bytes());
        bytes.extend(random.between(-1.0, 3.0).to_bits().to_le_bytes());
        bytes.extend(random.below(1_000_003).to_le_bytes());
    }
    assert_eq!(fnv1a(bytes), 0x8d8f_d3d3_c0b2_6c3e);
}

#[test]
fn other_seed_other_bits() {
    for ((name, one), (_, other)) in seeded(1).unwrap().into_iter().zip(seeded(2).unwrap()) {
        assert_ne!(one, other, "{name}");
    }
}

#[test]
fn centres_do_not_depend_on_how_sizes_are_drawn() {
    let still = Sizes::Lognormal { median: 0.5, sigma: 0.0 };
    assert_eq!(gas::<3>(1_000, 9, 12.0, still).unwrap(), gas::<3>(1_000, 9, 12.0, EQUAL).unwrap());
}
