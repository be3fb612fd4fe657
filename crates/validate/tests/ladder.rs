//! The harness of the verification ladder: a wrong answer must fail. `.ci/run` runs all cases, with
//! `fdem validate` of a release build; here are some of the fast ones.

use fdem_validate::{Case, CaseReport, Outcome, Size, cases, html, table};

#[test]
fn some_fast_cases_pass() {
    for name in [
        "waves in bars",
        "rotation",
        "uniaxial tension",
        "grains: oblique impact",
        "grains: adhesion",
        "fluid: steady flow",
        "fluid: invariants",
    ] {
        let case = cases().iter().find(|case| case.name == name).expect("a case of this name");
        let report = case.report(Size::Reduced);
        assert!(report.passed(), "\n{}", table(&[report]));
    }
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
fn an_outcome_without_published_data_passes_and_says_so() {
    let skipped = Outcome::skipped("curve", "its data are absent");
    assert!(skipped.passed());
    let report = CaseReport { case: &EMPTY, result: Ok(vec![skipped]) };
    let text = table(&[report]);
    assert!(text.contains("curve: its data are absent") && text.trim_end().ends_with("skipped"), "{text}");
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
