//! The verification ladder at its reduced size, and the harness around it: a wrong answer must fail.

use crate::{Case, CaseReport, Outcome, Size, cases, html, table};

fn passes(name: &str) {
    let case = cases().iter().find(|case| case.name == name).expect("a case of this name");
    let report = case.report(Size::Reduced);
    assert!(report.passed(), "\n{}", table(&[report]));
}

#[test]
fn waves_in_bars_are_those_of_theory() {
    passes("waves in bars");
}

#[test]
fn ground_under_its_stress_stays_at_rest() {
    passes("ground at rest");
}

#[test]
fn an_excavated_hole_has_the_stresses_of_kirsch() {
    passes("excavation");
}

#[test]
fn a_sudden_excavation_sets_the_energy_of_salamon_free() {
    passes("sudden excavation");
}

#[test]
fn a_sheared_joint_set_shows_its_cohesion_and_friction() {
    passes("direct shear of a joint set");
}

#[test]
fn a_block_slides_where_the_factor_of_safety_is_one() {
    passes("plane failure");
}

#[test]
fn blocks_under_pressure_break_on_the_line_of_mohr_and_coulomb() {
    passes("triaxial envelope");
}

#[test]
fn an_arch_stands_from_the_thickness_of_couplet_on() {
    passes("arch");
}

#[test]
fn waves_in_bedded_rock_have_the_speeds_of_its_constants() {
    passes("waves in bedded rock");
}

#[test]
fn bedded_rock_is_weakest_where_its_bedding_slides() {
    passes("compression of bedded rock");
}

#[test]
fn joints_soften_as_springs_in_series_do_and_adaptive_ones_not_at_all() {
    passes("artificial compliance");
}

#[test]
fn a_turn_makes_no_strain_and_loses_nothing() {
    passes("rotation");
}

#[test]
fn a_strip_breaks_at_its_strength_with_its_fracture_energy() {
    passes("uniaxial tension");
}

#[test]
fn a_shear_box_peaks_and_ends_as_mohr_and_coulomb_say() {
    passes("shear under normal stress");
}

#[test]
fn collisions_keep_energy_and_momentum() {
    passes("impact");
}

#[test]
fn heaps_of_fragments_keep_energy_and_momentum() {
    passes("heaps of fragments");
}

#[test]
fn a_block_on_an_incline_rests_or_slides() {
    passes("block on an incline");
}

#[test]
fn a_disc_on_a_plane_presses_as_hertz_says() {
    passes("Hertz contact");
}

#[test]
fn a_brazilian_disc_splits_at_its_tensile_strength() {
    passes("Brazilian disc");
}

#[test]
fn a_block_in_compression_fails_at_the_bound_of_mohr_and_coulomb() {
    passes("uniaxial compression");
}

#[test]
fn a_double_cantilever_opens_as_fracture_mechanics_says() {
    passes("double cantilever beam");
}

#[test]
fn a_thick_ring_grows_as_lame_says() {
    passes("thick ring");
}

#[test]
fn the_edge_of_a_hole_bears_three_times_the_tension() {
    passes("plate with a hole");
}

#[test]
fn a_model_that_is_turned_does_the_same() {
    passes("objectivity");
}

#[test]
fn friction_turns_a_disc_that_strikes_obliquely() {
    passes("oblique impact");
}

#[test]
fn a_disc_on_an_incline_rolls_or_slides() {
    passes("disc on an incline");
}

#[test]
fn a_block_on_its_corner_falls_back_when_housner_says() {
    passes("rocking block");
}

#[test]
fn waves_in_bars_of_tetrahedra_are_those_of_theory() {
    passes("waves in bars of tetrahedra");
}

#[test]
fn a_bar_of_tetrahedra_shortens_as_hooke_says() {
    passes("bar of tetrahedra at rest");
}

#[test]
fn two_rods_touch_as_long_as_their_waves_take() {
    passes("rods of tetrahedra that meet");
}

#[test]
fn a_turn_in_space_makes_no_strain_and_loses_nothing() {
    passes("rotation in space");
}

#[test]
fn tetrahedra_that_collide_keep_energy_and_momentum() {
    passes("impact of tetrahedra");
}

#[test]
fn debris_in_the_plane_that_is_shaken_keeps_its_energy() {
    passes("debris in the plane");
}

#[test]
fn debris_that_is_shaken_keeps_its_energy() {
    passes("debris");
}

#[test]
fn a_block_on_a_plane_that_is_inclined_anywhere_rests_or_slides() {
    passes("block on an incline in space");
}

#[test]
fn a_sphere_on_a_block_presses_as_hertz_says() {
    passes("Hertz contact in space");
}

#[test]
fn a_prism_breaks_at_its_strength_with_its_fracture_energy() {
    passes("direct tension of a prism");
}

#[test]
fn friction_on_joints_follows_the_motion_in_their_plane() {
    passes("shear under normal stress in space");
}

#[test]
fn a_round_crack_opens_as_sneddon_says() {
    passes("penny-shaped crack");
}

#[test]
fn a_pressure_opens_a_line_crack_as_sneddon_says() {
    passes("pressure in a line crack");
}

#[test]
fn a_pressure_opens_a_round_crack_as_sneddon_says() {
    passes("pressure in a penny-shaped crack");
}

#[test]
fn a_gas_keeps_its_pressure_times_the_power_of_its_volume() {
    passes("gas in a hole");
}

#[test]
fn a_thick_sphere_grows_as_lame_says() {
    passes("thick sphere");
}

#[test]
fn the_edge_of_a_hole_through_a_block_bears_three_times_the_tension() {
    passes("hole through a block");
}

#[test]
fn plane_waves_leave_through_absorbing_faces() {
    passes("absorbing faces");
}

#[test]
fn a_bar_spalls_where_the_tension_first_reaches_its_strength() {
    passes("spall");
}

#[test]
fn tetrahedra_are_as_stiff_in_bending_as_was_measured() {
    passes("locking");
}

#[test]
fn the_tension_in_a_thick_disc_varies_through_its_thickness() {
    passes("thick disc under two loads");
}

#[test]
fn a_thick_disc_splits_at_its_tensile_strength() {
    passes("strength of a thick disc");
}

#[test]
fn a_cylinder_in_compression_fails_at_the_bound_of_mohr_and_coulomb() {
    passes("compression of a cylinder");
}

#[test]
fn a_sphere_through_a_plate_keeps_energy_and_momentum() {
    passes("sphere through a plate");
}

#[test]
fn a_double_cantilever_in_space_is_as_soft_and_as_strong_as_beams() {
    passes("double cantilever in space");
}

#[test]
fn each_case_has_its_own_name_and_comes_in_the_order_of_the_ladder() {
    let mut names: Vec<_> = cases().iter().map(|case| case.name).collect();
    assert!(cases().windows(2).all(|pair| pair[0].number <= pair[1].number));
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), cases().len());
}

#[test]
fn an_outcome_beyond_its_bound_or_not_a_number_fails() {
    let relative = |found| Outcome::relative("speed", -2.0, found, 0.01, "m/s").passed();
    assert!(relative(-2.0) && relative(-2.019) && relative(-1.981));
    assert!(!relative(-2.021) && !relative(-1.979) && !relative(2.0));
    assert!(!relative(f64::NAN) && !relative(f64::INFINITY));
    let absolute = |found| Outcome::absolute("drift", 0.0, found, 1e-9, "").passed();
    assert!(absolute(0.0) && absolute(-1e-9) && !absolute(1.1e-9) && !absolute(f64::NAN));
    // A bound of 0 requires the exact number.
    assert!(Outcome::absolute("joints", 0.0, 0.0, 0.0, "").passed());
    assert!(!Outcome::absolute("joints", 0.0, 1.0, 0.0, "").passed());
}

#[test]
fn bounds_tell_one_law_from_the_next() {
    let case = cases().iter().find(|case| case.name == "artificial compliance").expect("a case");
    let outcomes = case.report(Size::Reduced).result.expect("it runs");
    for pair in outcomes.windows(2) {
        let [one, two] = pair else { continue };
        let other_law = Outcome::relative("", two.expected, one.found, two.bound, "");
        assert!(!other_law.passed(), "{one:?} would do for {two:?}");
    }
}

static WRONG: Case = Case {
    number: 11,
    name: "a law that is <wrong>",
    what: "Not so.",
    source: "none",
    run: |_| {
        let right = Outcome::relative("right", 1.0, 1.0, 0.01, "m");
        Ok(vec![right, Outcome::relative("wrong", 1.0, 1.5, 0.01, "m")])
    },
};

static STUCK: Case = Case {
    number: 12,
    name: "stuck",
    what: "It does not run.",
    source: "none",
    run: |_| Err("element 3 is inverted".to_owned()),
};

static EMPTY: Case =
    Case { number: 13, name: "empty", what: "Nothing is compared.", source: "none", run: |_| Ok(Vec::new()) };

#[test]
fn a_case_with_one_wrong_answer_or_none_fails() {
    for case in [&WRONG, &STUCK, &EMPTY] {
        assert!(!case.report(Size::Reduced).passed(), "{}", case.name);
    }
}

fn failing() -> [CaseReport; 2] {
    [WRONG.report(Size::Full), STUCK.report(Size::Full)]
}

#[test]
fn the_table_has_what_was_expected_and_found_and_what_failed() {
    let text = table(&failing());
    let lines: Vec<_> = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>()).collect();
    assert_eq!(lines[0], ["quantity", "expected", "found", "error", "bound", "verdict"]);
    assert_eq!(lines[2], ["right", "1", "m", "1", "m", "0", "1.000", "%", "passed"]);
    assert_eq!(lines[3], ["wrong", "1", "m", "1.5", "m", "50.000", "%", "1.000", "%", "FAILED"]);
    assert!(text.contains("12. stuck\n  FAILED: element 3 is inverted\n"));
    // Columns are aligned.
    let ends: Vec<_> = text.lines().filter_map(|line| line.find(" m ")).collect();
    assert!(ends.windows(2).all(|pair| pair[0] == pair[1]), "{text}");
}

#[test]
fn the_page_says_what_failed_and_holds_no_script() {
    let page = html(&failing(), Size::Full);
    assert!(page.contains("2 of 2 cases failed") && page.contains("element 3 is inverted"));
    assert!(page.contains("a law that is &lt;wrong&gt;") && !page.contains("<wrong>"));
    assert!(!page.contains("<script") && page.contains("Content-Security-Policy"));
    for tag in ["html", "head", "body", "main", "section", "table", "tbody", "tr", "td", "p"] {
        let count = |text: String| page.matches(&text).count();
        let opened = count(format!("<{tag}>")) + count(format!("<{tag} "));
        assert_eq!(opened, count(format!("</{tag}>")), "{tag}");
    }
}
