//! Models that `fdem new` writes: two to start from, the examples, and a direct shear test.

use fdem_model::{STARTER, STARTER_3D};

/// A model to start from. Its first line is its title.
pub(crate) struct Template {
    pub(crate) name: &'static str,
    pub(crate) text: &'static str,
}

impl Template {
    /// Description of the model: the first sentence of its first line.
    pub(crate) fn about(&self) -> &'static str {
        let line = self.text.lines().next().unwrap_or("").trim_start_matches(['#', ' ']);
        line.split_once(". ").map_or(line, |(sentence, _)| sentence).trim_end_matches('.')
    }
}

macro_rules! example {
    ($name:literal, $file:literal) => {
        Template { name: $name, text: include_str!(concat!("../../../../examples/", $file, ".toml")) }
    };
}

/// All templates: two dimensions first, then three.
pub(crate) const TEMPLATES: [Template; 22] = [
    Template { name: "starter", text: STARTER },
    example!("bar_impact", "bar_impact"),
    example!("borehole", "borehole"),
    example!("brazilian_disc", "brazilian_disc"),
    example!("compression", "compression"),
    Template { name: "direct_shear", text: include_str!("templates/direct_shear.toml") },
    example!("falling_blocks", "falling_blocks"),
    example!("fragment_heap", "fragment_heap"),
    example!("jointed_slope", "jointed_slope"),
    example!("masonry_wall", "masonry_wall"),
    example!("ring_on_plate", "ring_on_plate"),
    example!("rock_slope", "rock_slope"),
    example!("sliding_block", "sliding_block"),
    example!("three_point_bending", "three_point_bending"),
    example!("tunnel", "tunnel"),
    Template { name: "starter_3d", text: STARTER_3D },
    example!("brazilian_disc_3d", "space/brazilian_disc"),
    example!("compression_3d", "space/compression"),
    example!("crushed_ball_3d", "space/crushed_ball"),
    example!("impact_3d", "space/impact"),
    example!("pillar_3d", "space/pillar"),
    example!("stairs_3d", "space/stairs"),
];
