//! Figures of speed on the README and in the book are those of the tables in `bench/`, and there are no
//! others.
//!
//! [`FIGURES`] lists sentences with the cells that their figures come from, [`OTHERS`] numbers that look like
//! figures of speed but are not. After new timings, the test says which sentences disagree: change them, and
//! the list.

use super::{pages, read};

/// Figures of documents, in braces, and their values in the tables.
const FIGURES: &[(&str, &str, &[Value])] = &[
    ("README.md", "Measured on one core: contacts of an {AMD EPYC}", &[Machine("RESULTS.md")]),
    ("README.md", "simulations of an {Intel Xeon} ([bench/SIMULATION.md]", &[Machine("SIMULATION.md")]),
    (
        "README.md",
        "| all {5.9} million contacts of a million spheres | {36} ms | {40} ms | fastest of {nine} libraries: {13} and {12} times as long |",
        &[
            Millions(RESULTS, &["gas1m"], "couples"),
            Cell(MEDIAN, &["rows"], "gas1m"),
            Cell(MEDIAN, &["rows-avx2"], "gas1m"),
            Peers(MEDIAN, "gas1m"),
            Cell(FASTEST, &["gas1m"], "times ours"),
            Cell(FASTEST, &["gas1m"], "times rows-avx2"),
        ],
    ),
    (
        "README.md",
        "| elastic triangles per second | {64} million | {60} million | Akantu: {11} times as long as AVX-512 |",
        &[
            Cell(STEPS, &["disc", "100,352"], "1 thread"),
            Cell(LEVELS, &["disc", "100,352"], "avx2"),
            Bracket(PROGRAMS, &["disc", "100,352"], "akantu"),
        ],
    ),
    (
        "README.md",
        "| elastic tetrahedra per second | {32} million | {24} million | Akantu: {7.3} times as long as AVX-512 |",
        &[
            Cell(STEPS, &["cube", "105,456"], "1 thread"),
            Cell(LEVELS, &["cube", "105,456"], "avx2"),
            Bracket(PROGRAMS, &["cube", "105,456"], "akantu"),
        ],
    ),
    (
        "README.md",
        "| triangles with a joint on every edge, per second | {12} million | {12} million | Akantu: {9.8} times as long as AVX-512 |",
        &[
            Cell(STEPS, &["joined", "100,352"], "1 thread"),
            Cell(LEVELS, &["joined", "100,352"], "avx2"),
            Bracket(PROGRAMS, &["joined", "100,352"], "akantu"),
        ],
    ),
    (
        "README.md",
        "| tetrahedra with a joint on every face, per second | {5.2} million | {5.0} million | Akantu: {9.7} times as long as AVX-512 |",
        &[
            Cell(STEPS, &["cube-joined", "105,456"], "1 thread"),
            Cell(LEVELS, &["cube-joined", "105,456"], "avx2"),
            Bracket(PROGRAMS, &["cube-joined", "105,456"], "akantu"),
        ],
    ),
    (
        "README.md",
        "| triangles of fragments in contact, {1.57} contacts each, per second | {3.3} million | {2.6} million | |",
        &[
            Cell(STEPS, &["heap", "101,250"], "for each element"),
            Cell(STEPS, &["heap", "101,250"], "1 thread"),
            Cell(LEVELS, &["heap", "101,250"], "avx2"),
        ],
    ),
    (
        "book/src/performance.md",
        "| on an {AMD EPYC} | AVX-512 | AVX2 | the fastest of {nine} other libraries |",
        &[Machine("RESULTS.md"), Peers(MEDIAN, "gas1m")],
    ),
    (
        "book/src/performance.md",
        "| one thread | {36} ms | {40} ms | {479} ms: {13} and {12} times as long |",
        &[
            Cell(MEDIAN, &["rows"], "gas1m"),
            Cell(MEDIAN, &["rows-avx2"], "gas1m"),
            Cell(FASTEST, &["gas1m"], "its time [ms]"),
            Cell(FASTEST, &["gas1m"], "times ours"),
            Cell(FASTEST, &["gas1m"], "times rows-avx2"),
        ],
    ),
    (
        "book/src/performance.md",
        "| two threads | {19} ms | {22} ms | {257} ms: {13} and {12} times as long |",
        &[
            Cell(MEDIAN_2, &["rows"], "gas1m"),
            Cell(MEDIAN_2, &["rows-avx2"], "gas1m"),
            Cell(FASTEST_2, &["gas1m"], "its time [ms]"),
            Cell(FASTEST_2, &["gas1m"], "times ours"),
            Cell(FASTEST_2, &["gas1m"], "times rows-avx2"),
        ],
    ),
    (
        "book/src/performance.md",
        "| working memory of a search | about {30} |",
        &[Cell((RESULTS.0, "Memory of"), &["gas1m", "1"], "bytes per element")],
    ),
    (
        "book/src/how/rows.md",
        "each take {36} nanoseconds per point on one core with AVX-512, and {40} with AVX2,",
        &[
            Cell(FASTEST, &["gas1m"], "ns per element"),
            // Milliseconds for a million points.
            Cell(MEDIAN, &["rows-avx2"], "gas1m"),
        ],
    ),
    (
        "book/src/how/multilevel.md",
        "take {1.7} times as long as a million equal ones",
        &[Ratio(Place(UNLIKE, &["auto"], "ratio1000"), Place(UNLIKE, &["auto"], "ratio1"))],
    ),
    (
        "book/src/faq.md",
        "the search takes about {21} per cent longer",
        &[More(Place(MEDIAN, &["rows"], "outlier1m"), Place(MEDIAN, &["rows"], "gas1m"))],
    ),
    (
        "book/src/faq.md",
        "finds the contacts of a million spheres in less than {100} ms",
        &[Below(MEDIAN, &["rows-avx2"], "gas1m")],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 10 ranks | {207,280} | {8.5} % | {7.8}, {9} | {305} kB | {140} kB |",
        &[
            Cell(PATTERN, &["elastic", "10"], "own elements, mean"),
            Cell(PATTERN, &["elastic", "10"], "halo share"),
            Cell(PATTERN, &["elastic", "10"], "neighbours, mean"),
            Cell(PATTERN, &["elastic", "10"], "neighbours, most"),
            Cell(PATTERN, &["elastic", "10"], "kB sent, mean"),
            Cell(PATTERN, &["elastic", "10"], "largest message [kB]"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 100 ranks | {20,728} | {24.8} % | {14.0}, {24} | {91.8} kB | {33.3} kB |",
        &[
            Cell(PATTERN, &["elastic", "100"], "own elements, mean"),
            Cell(PATTERN, &["elastic", "100"], "halo share"),
            Cell(PATTERN, &["elastic", "100"], "neighbours, mean"),
            Cell(PATTERN, &["elastic", "100"], "neighbours, most"),
            Cell(PATTERN, &["elastic", "100"], "kB sent, mean"),
            Cell(PATTERN, &["elastic", "100"], "largest message [kB]"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 1,000 ranks | {2,073} | {60.1} % | {17.7}, {30} | {23.8} kB | {9.74} kB |",
        &[
            Cell(PATTERN, &["elastic", "1,000"], "own elements, mean"),
            Cell(PATTERN, &["elastic", "1,000"], "halo share"),
            Cell(PATTERN, &["elastic", "1,000"], "neighbours, mean"),
            Cell(PATTERN, &["elastic", "1,000"], "neighbours, most"),
            Cell(PATTERN, &["elastic", "1,000"], "kB sent, mean"),
            Cell(PATTERN, &["elastic", "1,000"], "largest message [kB]"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 1,000 ranks, joints on all faces | {2,073} | {72.3} % | {17.8}, {29} | {288} kB | {146} kB |",
        &[
            Cell(PATTERN, &["joined", "1,000"], "own elements, mean"),
            Cell(PATTERN, &["joined", "1,000"], "halo share"),
            Cell(PATTERN, &["joined", "1,000"], "neighbours, mean"),
            Cell(PATTERN, &["joined", "1,000"], "neighbours, most"),
            Cell(PATTERN, &["joined", "1,000"], "kB sent, mean"),
            Cell(PATTERN, &["joined", "1,000"], "largest message [kB]"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 10,000, elastic | {62.3} % | {56.9} % | {55.9} % | {54.5} % |",
        &[
            Cell(WEAK, &["elastic", "10,000"], "10 ranks"),
            Cell(WEAK, &["elastic", "10,000"], "100 ranks"),
            Cell(WEAK, &["elastic", "10,000"], "1,000 ranks"),
            Cell(WEAK, &["elastic", "10,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 100,000, elastic | {80.2} % | {79.2} % | {79.0} % | {78.7} % |",
        &[
            Cell(WEAK, &["elastic", "100,000"], "10 ranks"),
            Cell(WEAK, &["elastic", "100,000"], "100 ranks"),
            Cell(WEAK, &["elastic", "100,000"], "1,000 ranks"),
            Cell(WEAK, &["elastic", "100,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 1,000,000, elastic | {90.0} % | {89.9} % | {89.8} % | {89.8} % |",
        &[
            Cell(WEAK, &["elastic", "1,000,000"], "10 ranks"),
            Cell(WEAK, &["elastic", "1,000,000"], "100 ranks"),
            Cell(WEAK, &["elastic", "1,000,000"], "1,000 ranks"),
            Cell(WEAK, &["elastic", "1,000,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 10,000, joints on all faces | {57.4} % | {56.7} % | {56.6} % | {56.4} % |",
        &[
            Cell(WEAK, &["joined", "10,000"], "10 ranks"),
            Cell(WEAK, &["joined", "10,000"], "100 ranks"),
            Cell(WEAK, &["joined", "10,000"], "1,000 ranks"),
            Cell(WEAK, &["joined", "10,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 100,000, joints on all faces | {74.7} % | {74.5} % | {74.5} % | {74.5} % |",
        &[
            Cell(WEAK, &["joined", "100,000"], "10 ranks"),
            Cell(WEAK, &["joined", "100,000"], "100 ranks"),
            Cell(WEAK, &["joined", "100,000"], "1,000 ranks"),
            Cell(WEAK, &["joined", "100,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 1,000,000, joints on all faces | {86.4} % | {86.4} % | {86.4} % | {86.4} % |",
        &[
            Cell(WEAK, &["joined", "1,000,000"], "10 ranks"),
            Cell(WEAK, &["joined", "1,000,000"], "100 ranks"),
            Cell(WEAK, &["joined", "1,000,000"], "1,000 ranks"),
            Cell(WEAK, &["joined", "1,000,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 1,000,000, elastic | {80.2} % | {56.9} % | {20.5} % | {2.8} % |",
        &[
            Cell(STRONG, &["elastic", "1,000,000"], "10 ranks"),
            Cell(STRONG, &["elastic", "1,000,000"], "100 ranks"),
            Cell(STRONG, &["elastic", "1,000,000"], "1,000 ranks"),
            Cell(STRONG, &["elastic", "1,000,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 10,000,000, elastic | {90.0} % | {79.2} % | {55.9} % | {18.8} % |",
        &[
            Cell(STRONG, &["elastic", "10,000,000"], "10 ranks"),
            Cell(STRONG, &["elastic", "10,000,000"], "100 ranks"),
            Cell(STRONG, &["elastic", "10,000,000"], "1,000 ranks"),
            Cell(STRONG, &["elastic", "10,000,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 100,000,000, elastic | {95.1} % | {89.9} % | {79.0} % | {54.5} % |",
        &[
            Cell(STRONG, &["elastic", "100,000,000"], "10 ranks"),
            Cell(STRONG, &["elastic", "100,000,000"], "100 ranks"),
            Cell(STRONG, &["elastic", "100,000,000"], "1,000 ranks"),
            Cell(STRONG, &["elastic", "100,000,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "| 1,000,000,000, elastic | {97.7} % | {95.1} % | {89.8} % | {78.7} % |",
        &[
            Cell(STRONG, &["elastic", "1,000,000,000"], "10 ranks"),
            Cell(STRONG, &["elastic", "1,000,000,000"], "100 ranks"),
            Cell(STRONG, &["elastic", "1,000,000,000"], "1,000 ranks"),
            Cell(STRONG, &["elastic", "1,000,000,000"], "10,000 ranks"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "about {2,693} bytes for an elastic tetrahedron then, and {5,088} for one with joints on all faces; later each rank needs {550} or {1,922} for each of its elements",
        &[
            Cell(INPUTS, &["elastic"], "on rank 0 at the beginning"),
            Cell(INPUTS, &["joined"], "on rank 0 at the beginning"),
            Cell(INPUTS, &["elastic"], "bytes per element"),
            Cell(INPUTS, &["joined"], "bytes per element"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "{7,413} elastic elements on each rank, and 80 % with {120,562}. At 50 %, the halo takes {26.9} % of the step, messages {12.7} %, and the agreement {10.5} %.",
        &[
            Cell(BENDS, &["elastic", "50 %"], "elements of a rank"),
            Cell(BENDS, &["elastic", "80 %"], "elements of a rank"),
            Cell(BENDS, &["elastic", "50 %"], "halo"),
            Cell(BENDS, &["elastic", "50 %"], "messages"),
            Cell(BENDS, &["elastic", "50 %"], "agreement"),
        ],
    ),
    (
        "book/src/simulation/ranks.md",
        "A billion elastic elements would need {2,693} GB there.",
        &[Cell(INPUTS, &["elastic"], "on rank 0 at the beginning")],
    ),
    (
        "book/src/simulation/ranks.md",
        "so messages are {12} times as large.",
        &[Ratio(
            Place(PATTERN, &["joined", "1,000"], "kB sent, mean"),
            Place(PATTERN, &["elastic", "1,000"], "kB sent, mean"),
        )],
    ),
];

/// Numbers that look like figures of speed, and the reason why no table has them.
const OTHERS: &[(&str, &str, &str)] = &[
    ("README.md", "Compiling takes three to seven minutes on 2 cores", "the reader's machine"),
    ("README.md", "in 13 to 25 minutes on 2 cores", "the reader's machine"),
    ("book/src/how/cgrid.md", "at least six times as fast", "a rule by which `auto` chooses"),
    ("book/src/simulation/first.md", "Ten minutes, from an empty folder", "the reader's time"),
    ("book/src/simulation/first-3d.md", "Ten minutes, from an empty folder", "the reader's time"),
    ("book/src/simulation/trust.md", "four times the speed", "a speed of the model"),
    ("book/src/simulation/model-file.md", "after 10 minutes", "a limit"),
    ("book/src/simulation/model-file.md", "20 times as long as a wave needs", "a duration of the model"),
    ("book/src/simulation/verification.md", "took 28 minutes", "told by `fdem validate`"),
];

type Section = (&'static str, &'static str);
const RESULTS: Section = ("RESULTS.md", "");
const MEDIAN: Section = ("RESULTS.md", "1 thread, points: median");
const MEDIAN_2: Section = ("RESULTS.md", "2 threads, points: median");
const FASTEST: Section = ("RESULTS.md", "1 thread, points: `rows` and the fastest peer");
const FASTEST_2: Section = ("RESULTS.md", "2 threads, points: `rows` and the fastest peer");
const UNLIKE: Section = ("UNLIKE.md", "1 thread, unlike sizes: median");
const STEPS: Section = ("SIMULATION.md", "");
const LEVELS: Section = ("SIMULATION.md", "Vector instructions");
const PATTERN: Section = ("SCALING.md", "Communication pattern");
const INPUTS: Section = ("SCALING.md", "Inputs");
const WEAK: Section = ("SCALING.md", "Model: weak");
const STRONG: Section = ("SCALING.md", "Model: strong");
const BENDS: Section = ("SCALING.md", "Model: where it bends");
const PROGRAMS: Section = ("SIMULATION.md", "Other programs");

/// A cell: a file of `bench/` and the start of a heading in it (empty for any), the first cells of a row, and
/// the name of a column.
struct Place(Section, &'static [&'static str], &'static str);

/// The required value of a figure.
enum Value {
    /// The number of a cell.
    Cell(Section, &'static [&'static str], &'static str),
    /// The number in brackets in a cell.
    Bracket(Section, &'static [&'static str], &'static str),
    /// The number of a cell, in millions.
    Millions(Section, &'static [&'static str], &'static str),
    /// More than the number of a cell.
    Below(Section, &'static [&'static str], &'static str),
    /// The first cell over the second.
    Ratio(Place, Place),
    /// By how many per cent the first cell exceeds the second.
    More(Place, Place),
    /// The number of other programs with a time in this column.
    Peers(Section, &'static str),
    /// The processor at the head of a file.
    Machine(&'static str),
}

use Value::{Below, Bracket, Cell, Machine, Millions, More, Peers, Ratio};

/// The text of a file, by its path from the root of the repository.
type Files<'a> = &'a dyn Fn(&str) -> String;

#[test]
fn figures_of_speed_are_those_of_the_tables() {
    let found = problems(&read);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_figure_that_no_table_has_is_found() {
    let changed = |file: &'static str, from: &'static str, to: &'static str| {
        assert!(read(file).contains(from), "{file}: {from}");
        move |name: &str| if name == file { read(name).replace(from, to) } else { read(name) }
    };
    for (file, from, to, says) in [
        ("README.md", "36 ms", "37 ms", "README.md: 37 "),
        ("README.md", "13 and 12 times", "13 and 9.2 times", "README.md: 9.2 "),
        ("README.md", "| 64 million |", "| 64 million, 9 times as fast as before |", "README.md: 9 "),
        ("book/src/introduction.md", "many times faster", "40 times faster", "book/src/introduction.md: 40 "),
        ("book/src/how/rows.md", "36 nanoseconds", "some 60 nanoseconds", "book/src/how/rows.md: 60 "),
        ("bench/RESULTS.md", "35.7 (1.00)", "38.1 (1.00)", "README.md: 36, but bench/RESULTS.md says 38.1"),
        ("bench/RESULTS.md", "AMD EPYC", "Intel(R) Xeon(R)", "README.md: AMD EPYC, but"),
        ("bench/SIMULATION.md", "5.72 (11.2)", "5.72 (11.7)", "README.md: 11, but"),
    ] {
        let replaced = changed(file, from, to);
        let found = problems(&replaced);
        assert!(found.iter().any(|problem| problem.contains(says)), "{says}: {found:?}");
    }
}

/// Sentences that disagree with the tables, and figures of speed without a table.
fn problems(files: Files<'_>) -> Vec<String> {
    let mut found = Vec::new();
    for (page, sentence, values) in FIGURES {
        let plain = sentence.replace(['{', '}'], "");
        if !one_line(&files(page)).contains(&plain) {
            found.push(format!("{page} no longer says {plain:?}: change the list of figures, too"));
        }
        let figures: Vec<&str> =
            sentence.split('{').skip(1).filter_map(|rest| rest.split('}').next()).collect();
        assert_eq!(figures.len(), values.len(), "{sentence}");
        found.extend(figures.iter().zip(*values).filter_map(|(figure, value)| {
            value.disagrees(figure, files).map(|why| format!("{page}: {figure}, but {why}"))
        }));
    }
    for page in std::iter::once("README.md".to_owned()).chain(pages()) {
        let mut text = one_line(&prose(&files(&page)));
        let listed = FIGURES.iter().map(|(of, sentence, _)| (*of, *sentence));
        for (_, known) in
            listed.chain(OTHERS.iter().map(|&(of, says, _)| (of, says))).filter(|(of, _)| *of == page)
        {
            text = text.replace(&known.replace(['{', '}'], ""), " ; ");
        }
        for (_, says, why) in OTHERS.iter().filter(|(of, _, _)| *of == page) {
            if !one_line(&files(&page)).contains(says) {
                found.push(format!("{page} no longer says {says:?} ({why}): take it off the list"));
            }
        }
        found.extend(figures_of_speed(&text).into_iter().map(|figure| {
            format!("{page}: {figure} is a figure of speed that is not in the list with its table")
        }));
    }
    found
}

/// A text without code, in which line breaks are blanks.
fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect::<Vec<_>>().join(" ; ")
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Numbers followed by words of speed, together with these words.
fn figures_of_speed(text: &str) -> Vec<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let bare = |word: &&str| word.trim_matches(|c: char| !c.is_alphanumeric()).to_lowercase();
    let plain: Vec<String> = words.iter().map(bare).collect();
    let starts = |at: usize, phrase: &str| {
        phrase.split(' ').enumerate().all(|(k, word)| plain.get(at + k).is_some_and(|other| other == word))
    };
    let units = ["ms", "ns", "nanoseconds", "microseconds", "milliseconds", "minutes", "hours"];
    let phrases = [
        "times as fast",
        "times as long",
        "times as slow",
        "times faster",
        "times slower",
        "times the speed",
        "per cent faster",
        "per cent longer",
        "s on",
        "seconds on",
        "million element-steps",
    ];
    let rates = ["a second", "per second", "each second"];
    let mut found = Vec::new();
    for at in 0..plain.len() {
        if number(&plain[at]).is_none() {
            continue;
        }
        // A rate may have some words between number and unit, but no other sentence.
        let rate = (at + 1..words.len().min(at + 8))
            .take_while(|&next| next == at + 1 || !words[next - 1].ends_with('.'));
        let is_rate = rate.clone().any(|next| rates.iter().any(|phrase| starts(next, phrase)))
            && plain.get(at + 1).is_some_and(|word| word == "million" || word == "thousand");
        if units.iter().chain(&phrases).any(|phrase| starts(at + 1, phrase)) || is_rate {
            found.push(words[at..words.len().min(at + 8)].join(" "));
        }
    }
    found
}

/// A number in digits, with commas between thousands, or in a word.
fn number(text: &str) -> Option<f64> {
    const WORDS: [&str; 13] = [
        "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven",
        "twelve",
    ];
    let word = WORDS.iter().position(|word| *word == text).map(|number| number as f64);
    word.or_else(|| {
        text.replace(',', "").parse().ok().filter(|_| text.starts_with(|c: char| c.is_ascii_digit()))
    })
}

impl Value {
    /// Value of the tables that differs from a figure; `None` if they agree.
    fn disagrees(&self, figure: &str, files: Files<'_>) -> Option<String> {
        let (value, from) = match self {
            Machine(file) => {
                let text = files(&format!("bench/{file}")).replace("(R)", "");
                let head = text.lines().find(|line| line.starts_with("fdem")).unwrap_or_default().to_owned();
                return (!head.contains(figure)).then(|| format!("bench/{file} is of {head}"));
            }
            Peers(section, column) => (peers(*section, column, files), section.0),
            Cell(section, row, column) | Below(section, row, column) => {
                (Place(*section, row, column).number(files), section.0)
            }
            Millions(section, row, column) => {
                (Place(*section, row, column).number(files).map(|number| number / 1e6), section.0)
            }
            Bracket(section, row, column) => (
                Place(*section, row, column)
                    .text(files)
                    .and_then(|text| number(text.split_once('(')?.1.trim_end_matches(')'))),
                section.0,
            ),
            Ratio(first, second) => (ratio(first, second, files), first.0.0),
            More(first, second) => {
                (ratio(first, second, files).map(|ratio| 100.0 * (ratio - 1.0)), first.0.0)
            }
        };
        let Some(value) = value else { return Some(format!("bench/{from} has no such cell")) };
        let Some(told) = number(figure) else { return Some("that is no number".to_owned()) };
        let decimals = figure.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let agrees = match self {
            Below(..) => value < told,
            // Rounded to the digits of the figure.
            _ => (value - told).abs() <= 0.5 * (0..decimals).fold(1.0, |unit, _| 0.1 * unit) + 1e-9,
        };
        (!agrees).then(|| format!("bench/{from} says {value}"))
    }
}

fn ratio(first: &Place, second: &Place, files: Files<'_>) -> Option<f64> {
    Some(first.number(files)? / second.number(files)?)
}

impl Place {
    /// The number at the beginning of the cell.
    fn number(&self, files: Files<'_>) -> Option<f64> {
        number(self.text(files)?.split([' ', '†']).next()?)
    }

    /// The text of the cell in the first table that has the row and the column.
    fn text(&self, files: Files<'_>) -> Option<String> {
        let Self(section, row, column) = self;
        tables(*section, files).into_iter().find_map(|table| {
            let column = table[0].iter().position(|name| name == column)?;
            let found = table.iter().find(|cells| row.iter().zip(*cells).all(|(a, b)| a == b))?;
            found.get(column).cloned()
        })
    }
}

/// The number of searches with a time in a column that are not ours.
fn peers(section: Section, column: &str, files: Files<'_>) -> Option<f64> {
    let table = tables(section, files).into_iter().next()?;
    let column = table[0].iter().position(|name| name == column)?;
    let ours = |name: &str| name.starts_with("rows") || name == "nbs";
    let others = table[1..].iter().filter(|row| !ours(&row[0]) && row[column] != "-");
    Some(others.count() as f64)
}

/// The tables of a section: rows of cells, the names of the columns first.
fn tables((file, heading): Section, files: Files<'_>) -> Vec<Vec<Vec<String>>> {
    let text = files(&format!("bench/{file}"));
    let mut tables: Vec<Vec<Vec<String>>> = Vec::new();
    let (mut inside, mut open) = (heading.is_empty(), false);
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("## ") {
            inside = heading.is_empty() || name.starts_with(heading);
        }
        let is_row = inside && line.starts_with('|');
        if is_row && !line.starts_with("|-") {
            if !open {
                tables.push(Vec::new());
            }
            let cells = line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect();
            tables.last_mut().unwrap().push(cells);
        }
        open = is_row;
    }
    tables
}
