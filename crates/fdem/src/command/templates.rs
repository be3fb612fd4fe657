//! Models that `fdem new` writes: two to start from, the examples, and a direct shear test.

use fdem_model::{STARTER, STARTER_3D};

/// A model to start from. Its first line is its title.
pub(crate) struct Template {
    pub(crate) name: &'static str,
    pub(crate) text: &'static str,
    /// A file that the model reads: its name and its bytes.
    pub(crate) file: Option<(&'static str, &'static [u8])>,
}

impl Template {
    /// Description of the model: the first sentence of its first line.
    pub(crate) fn about(&self) -> &'static str {
        let line = self.text.lines().next().unwrap_or("").trim_start_matches(['#', ' ']);
        line.split_once(". ").map_or(line, |(sentence, _)| sentence).trim_end_matches('.')
    }
}

/// Most of them are copies of examples, which the package of this crate cannot reach: a test compares them.
macro_rules! template {
    ($name:literal) => {
        Template { name: $name, text: include_str!(concat!("templates/", $name, ".toml")), file: None }
    };
    ($name:literal, $file:literal) => {
        Template { file: Some(($file, include_bytes!(concat!("templates/", $file)))), ..template!($name) }
    };
}

/// All templates: two dimensions first, then three.
pub(crate) const TEMPLATES: [Template; 34] = [
    Template { name: "starter", text: STARTER, file: None },
    template!("bar_impact"),
    template!("bedded_rock"),
    template!("borehole"),
    template!("brazilian_disc"),
    template!("compression"),
    template!("dam_seepage"),
    template!("direct_shear"),
    template!("falling_blocks"),
    template!("fluid_borehole"),
    template!("fragment_heap"),
    template!("hydraulic_fracture"),
    template!("jaw_crusher"),
    template!("jointed_slope"),
    template!("masonry_wall"),
    template!("ring_on_plate"),
    template!("rock_slope"),
    template!("sliding_block"),
    template!("three_point_bending"),
    template!("tunnel"),
    Template { name: "starter_3d", text: STARTER_3D, file: None },
    template!("ballast_3d"),
    template!("brazilian_disc_3d"),
    template!("compression_3d"),
    template!("crushed_ball_3d"),
    template!("funnel_3d", "funnel.stl"),
    template!("gravel_cushion_3d"),
    template!("impact_3d"),
    template!("periodic_triaxial_3d"),
    template!("pillar_3d"),
    template!("projectile_3d"),
    template!("rotating_drum_3d"),
    template!("stairs_3d"),
    template!("triaxial_3d"),
];
