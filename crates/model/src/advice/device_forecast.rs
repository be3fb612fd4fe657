//! Estimates of a run on a graphics processor, before it starts.

use std::fmt;

use fdem_io::numbers::{brief, grouped};
use fdem_simulation::Counts;
use serde::Serialize;

use crate::advice::amounts::{duration, size};

/// Guessed time of a step on one NVIDIA H200: starts of kernels and copies of sums, s; an element and a
/// joint, s. No run on a card has been measured; `just gpu` would measure some.
const STEP: f64 = 60e-6;
const ELEMENT: f64 = 0.2e-9;
const JOINT: f64 = 0.5e-9;

/// Guessed memory that the driver takes for itself and the kernels, bytes.
const DRIVER: f64 = 0.6e9;

/// A graphics processor of this machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Card {
    /// Name of the card, such as "NVIDIA H200".
    pub name: String,
    /// Memory of the card, bytes.
    pub memory: f64,
}

/// Estimates of a run on a graphics processor. Displays as lines of text.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceForecast {
    /// Number of the device.
    pub number: usize,
    /// The card with this number; none if this machine does not have it.
    pub card: Option<Card>,
    /// Why there is no card.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing: Option<String>,
    /// Number of elements.
    pub elements: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of joints that hold.
    pub joints: usize,
    /// Memory of all arrays of the run on the device, counted, bytes.
    pub memory: f64,
    /// Whether the run fits into the memory of the card; none without a card.
    pub fits: Option<bool>,
    /// Number of elements like those of the model that would fit into the memory of the card.
    pub elements_that_fit: Option<usize>,
    /// Time of a step on an H200 while the processor has nothing to do, s. A guess, not measured.
    pub guessed_step: f64,
    /// Run time in such steps, s.
    pub guessed_seconds: f64,
    /// Whether the model has stages: the memory is that of the first.
    pub has_stages: bool,
}

impl DeviceForecast {
    /// Estimates for a run of `steps` steps whose arrays take `memory` bytes. `card`: the graphics processor
    /// with this number, or why there is none.
    pub fn of(
        number: usize,
        card: Result<Card, String>,
        (elements, counts): (usize, &Counts),
        memory: usize,
        steps: u64,
    ) -> Self {
        let (card, missing) = match card {
            Ok(card) => (Some(card), None),
            Err(why) => (None, Some(why)),
        };
        let memory = memory as f64;
        let room = card.as_ref().map(|card| (card.memory - DRIVER).max(0.0));
        let step = STEP + ELEMENT * elements as f64 + JOINT * counts.joints as f64;
        Self {
            number,
            fits: room.map(|room| memory <= room),
            elements_that_fit: room.filter(|_| elements > 0).map(|room| elements_in(room, elements, memory)),
            card,
            missing,
            elements,
            nodes: counts.nodes,
            joints: counts.joints,
            memory,
            guessed_step: step,
            guessed_seconds: step * steps as f64,
            has_stages: false,
        }
    }
}

/// Number of elements that fit into a memory, if `elements` of them take `bytes`.
fn elements_in(room: f64, elements: usize, bytes: f64) -> usize {
    (room / (bytes / elements as f64)) as usize
}

/// Says that a run of `elements` elements takes more memory than a card can give, and how many elements would
/// fit. `needed` and `free`: bytes.
pub fn too_little_memory(card: &str, [needed, free]: [f64; 2], elements: usize) -> String {
    format!(
        "the run takes {} of the memory of {card}, which has {} free: about {} of its {} elements would fit. Take a coarser mesh, another card, or the processor",
        size(needed),
        size(free),
        grouped(elements_in(free, elements.max(1), needed) as u64),
        grouped(elements as u64)
    )
}

impl fmt::Display for DeviceForecast {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.card, &self.missing) {
            (Some(card), _) => {
                writeln!(out, "device           gpu:{}, {}, {}", self.number, card.name, size(card.memory))?;
            }
            (None, Some(why)) => {
                writeln!(out, "device           gpu:{} is not on this machine: {why}", self.number)?;
            }
            (None, None) => writeln!(out, "device           gpu:{}", self.number)?,
        }
        let of_stages = if self.has_stages { " in the first stage" } else { "" };
        writeln!(
            out,
            "  arrays         {}{of_stages}: {} elements, {} nodes, {} joints; {} bytes for each element",
            size(self.memory),
            grouped(self.elements as u64),
            grouped(self.nodes as u64),
            grouped(self.joints as u64),
            brief((self.memory / self.elements.max(1) as f64).round())
        )?;
        let most = self.elements_that_fit.map(|most| grouped(most as u64));
        match (self.fits, most) {
            (Some(true), Some(most)) => writeln!(
                out,
                "  memory         it fits, beside about {} of the driver (a guess); up to {most} such elements would",
                size(DRIVER)
            )?,
            (Some(false), Some(most)) => writeln!(
                out,
                "  memory         too little: about {most} such elements would fit, beside about {} of the driver (a guess)",
                size(DRIVER)
            )?,
            _ => {}
        }
        writeln!(
            out,
            "  run time       perhaps {} on an NVIDIA H200: a guess of {} µs a step, because no run on a card has been measured",
            duration(self.guessed_seconds),
            brief((1e6 * self.guessed_step).round())
        )?;
        writeln!(
            out,
            "                 contacts, loads, spheres, and joints that begin to soften or break stay on the processor, and take more time"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run of 1,000 elements with 1,000 bytes each.
    fn forecast(card: Result<Card, String>) -> DeviceForecast {
        let counts = Counts { nodes: 600, joints: 1500, ..Counts::default() };
        DeviceForecast::of(2, card, (1000, &counts), 1_000_000, 10_000)
    }

    #[test]
    fn a_run_fits_into_a_card_or_does_not() {
        let card = |memory| Ok(Card { name: "NVIDIA H200".to_owned(), memory });
        let large = forecast(card(DRIVER + 5e6));
        assert_eq!((large.fits, large.elements_that_fit), (Some(true), Some(5000)));
        let text = large.to_string();
        for part in
            ["gpu:2, NVIDIA H200, 605.0 MB", "it fits", "up to 5,000", "1000 bytes for each", "a guess"]
        {
            assert!(text.contains(part), "{part:?} is not in\n{text}");
        }
        let small = forecast(card(DRIVER + 0.5e6));
        assert_eq!((small.fits, small.elements_that_fit), (Some(false), Some(500)));
        assert!(small.to_string().contains("too little: about 500 such elements would fit"));
        let tiny = forecast(card(0.0));
        assert_eq!((tiny.fits, tiny.elements_that_fit), (Some(false), Some(0)));
    }

    #[test]
    fn the_memory_is_known_without_a_card() {
        let none = forecast(Err("there is no driver".to_owned()));
        assert_eq!((none.fits, none.memory), (None, 1e6));
        let text = none.to_string();
        assert!(
            text.starts_with("device           gpu:2 is not on this machine: there is no driver\n"),
            "{text}"
        );
        assert!(text.contains("1.0 MB: 1,000 elements, 600 nodes, 1,500 joints"), "{text}");
        // 60 µs, and 0.2 and 0.75 µs for elements and joints.
        assert!((none.guessed_seconds - 0.60950).abs() < 1e-9, "{}", none.guessed_seconds);
    }

    #[test]
    fn too_little_memory_says_what_would_fit() {
        let text = too_little_memory("NVIDIA H200", [4e9, 1e9], 2_000_000);
        assert!(text.contains("takes 4.0 GB of the memory of NVIDIA H200, which has 1.0 GB free"), "{text}");
        assert!(text.contains("about 500,000 of its 2,000,000 elements would fit"), "{text}");
    }
}
