//! ARCHITECTURE.md and the book print the time step as the simulation takes it.

use super::read;

/// Longest step, lines.
const LONGEST: usize = 40;

#[test]
fn documents_print_the_time_step() {
    let source = read("crates/simulation/src/simulation.rs");
    let (_, rest) = source.split_once("    fn step(").unwrap();
    let (step, rest) = rest.split_once("\n    }\n").unwrap();
    let lines = step.lines().count() + 1;
    assert!(lines <= LONGEST, "a step has {lines} lines, more than {LONGEST}");
    let (press, _) = rest.split_once("\n    }\n").unwrap();
    let both = format!("    fn step({step}\n    }}\n{press}\n    }}\n");
    let block: Vec<&str> = both.lines().map(|line| line.strip_prefix("    ").unwrap_or(line)).collect();
    let block = block.join("\n");
    for document in ["ARCHITECTURE.md", "book/src/simulation/how.md"] {
        let code = format!("```rust,ignore\n{block}\n```\n");
        assert!(
            read(document).contains(&code),
            "{document} does not print `step` and `press` of crates/simulation/src/simulation.rs as they are:\n{code}"
        );
    }
}
