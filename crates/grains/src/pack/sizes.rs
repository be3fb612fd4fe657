//! Radii of spheres that are drawn from a distribution.

use std::f64::consts::SQRT_2;

use fdem_scenes::random::Random;

/// Deviations from the mean at which a normal distribution is cut.
const CUT: f64 = 3.0;

/// Parts of equal probability over which means are summed.
const PARTS: usize = 4096;

/// Stream of a seed from which radii are drawn.
const RADII: u64 = 4;

/// Distribution of radii.
#[derive(Clone, Debug, PartialEq)]
pub enum SphereSizes {
    /// All have the same radius, m.
    Equal(f64),
    /// Radii between two, m, all equally frequent by number.
    Uniform([f64; 2]),
    /// A normal distribution by number, cut off at 3 deviations from the mean.
    Normal {
        /// m.
        mean: f64,
        /// Standard deviation, m.
        deviation: f64,
    },
    /// A grading curve: radii, m, ascending, each with the share of the mass that smaller spheres have. The
    /// last share is 1. It is linear between the entries; a first share above 0 is that of spheres with the
    /// first radius.
    Grading(Vec<[f64; 2]>),
}

/// A part of a grading curve, with the shares of the number of spheres up to its beginning and its end.
struct CurvePart {
    radii: [f64; 2],
    numbers: [f64; 2],
}

impl SphereSizes {
    /// Says why the distribution is impossible; `None` if it is not.
    pub fn fault(&self) -> Option<String> {
        let is_positive = |radius: f64| radius > 0.0 && radius.is_finite();
        match self {
            Self::Equal(radius) if !is_positive(*radius) => Some("a radius is above 0".to_owned()),
            Self::Uniform([least, most]) if !(is_positive(*least) && least <= most && most.is_finite()) => {
                Some("the least radius is above 0, and at most the largest".to_owned())
            }
            Self::Normal { mean, deviation }
                if !(is_positive(*mean) && *deviation >= 0.0 && mean - CUT * deviation > 0.0) =>
            {
                Some("the mean is more than 3 deviations above 0: the smallest radius is positive".to_owned())
            }
            Self::Grading(curve) => grading_fault(curve),
            _ => None,
        }
    }

    /// The smallest and the largest radius, m.
    pub fn range(&self) -> [f64; 2] {
        match self {
            Self::Equal(radius) => [*radius; 2],
            Self::Uniform(range) => *range,
            Self::Normal { mean, deviation } => [mean - CUT * deviation, mean + CUT * deviation],
            Self::Grading(curve) => {
                let radius = |entry: Option<&[f64; 2]>| entry.map_or(0.0, |entry| entry[0]);
                [radius(curve.first()), radius(curve.last())]
            }
        }
    }

    /// The mean volume of the spheres, m³, or the mean area of discs, m².
    pub fn mean_measure(&self, discs: bool) -> f64 {
        let parts = self.parts(discs);
        let share = |part: usize| (part as f64 + 0.5) / PARTS as f64;
        let sum: f64 = (0..PARTS).map(|part| measure(self.quantile(share(part), &parts, discs), discs)).sum();
        sum / PARTS as f64
    }

    /// Radii of `count` spheres, m, in random order. Each part of the distribution of the probability
    /// 1/`count` has one of them, so that even few spheres follow it.
    pub fn draw(&self, count: usize, discs: bool, seed: u64) -> Vec<f64> {
        let mut random = Random::with_stream(seed, RADII);
        let parts = self.parts(discs);
        let mut radii: Vec<f64> = (0..count)
            .map(|number| self.quantile((number as f64 + random.uniform()) / count as f64, &parts, discs))
            .collect();
        for last in (1..count).rev() {
            radii.swap(last, random.below(last as u64 + 1) as usize);
        }
        radii
    }

    /// The radius below which a share of the number of spheres is, m.
    fn quantile(&self, share: f64, parts: &[CurvePart], discs: bool) -> f64 {
        match self {
            Self::Equal(radius) => *radius,
            Self::Uniform([least, most]) => least + share * (most - least),
            Self::Normal { mean, deviation } => mean + deviation * normal_quantile(share),
            Self::Grading(_) => {
                let place = parts.partition_point(|part| part.numbers[1] < share);
                let Some(part) = parts.get(place).or(parts.last()) else { return 0.0 };
                let width = part.numbers[1] - part.numbers[0];
                let inner =
                    if width > 0.0 { ((share - part.numbers[0]) / width).clamp(0.0, 1.0) } else { 0.0 };
                let [a, b] = part.radii;
                // The number of spheres per radius falls as 1/r³, that of discs as 1/r².
                let radius = if discs {
                    1.0 / (1.0 / a - inner * (1.0 / a - 1.0 / b))
                } else {
                    1.0 / (1.0 / (a * a) - inner * (1.0 / (a * a) - 1.0 / (b * b))).sqrt()
                };
                radius.clamp(a, b)
            }
        }
    }

    /// The parts of a grading curve, none for other distributions.
    fn parts(&self, discs: bool) -> Vec<CurvePart> {
        let Self::Grading(curve) = self else { return Vec::new() };
        let mut parts = Vec::new();
        let mut number = 0.0;
        let mut add = |[a, b]: [f64; 2], share: f64| {
            // Spheres of the mass 1 at the radius r are 1/r³ (discs 1/r²) up to a factor.
            let per_mass = if a == b {
                if discs { 1.0 / (a * a) } else { 1.0 / (a * a * a) }
            } else if discs {
                (1.0 / a - 1.0 / b) / (b - a)
            } else {
                0.5 * (1.0 / (a * a) - 1.0 / (b * b)) / (b - a)
            };
            let before = number;
            number += share * per_mass;
            parts.push(CurvePart { radii: [a, b], numbers: [before, number] });
        };
        if let Some(&[radius, share]) = curve.first()
            && share > 0.0
        {
            add([radius; 2], share);
        }
        for pair in curve.windows(2) {
            if let [[a, from], [b, to]] = *pair
                && to > from
            {
                add([a, b], to - from);
            }
        }
        for part in &mut parts {
            part.numbers = part.numbers.map(|of| of / number);
        }
        parts
    }
}

/// Says why a grading curve is impossible.
fn grading_fault(curve: &[[f64; 2]]) -> Option<String> {
    let [radii, shares] = [0, 1].map(|of| curve.iter().map(|entry| entry[of]).collect::<Vec<f64>>());
    if curve.is_empty() || !radii.iter().all(|radius| *radius > 0.0 && radius.is_finite()) {
        return Some("a grading curve has radii above 0".to_owned());
    }
    if !radii.is_sorted() {
        return Some("the radii of a grading curve ascend".to_owned());
    }
    if !shares.is_sorted() || shares.first().is_some_and(|share| *share < 0.0) {
        return Some("the shares of a grading curve ascend from 0 or more".to_owned());
    }
    if shares.last().is_none_or(|share| (share - 1.0).abs() > 1e-9) {
        return Some(
            "the last share of a grading curve is 1: all of the mass is below the last radius".to_owned(),
        );
    }
    None
}

/// The quantile of the normal distribution that is cut at [`CUT`] deviations.
fn normal_quantile(share: f64) -> f64 {
    let below = |x: f64| 0.5 * (1.0 + libm::erf(x / SQRT_2));
    let [least, most] = [below(-CUT), below(CUT)];
    let wanted = least + share * (most - least);
    let [mut low, mut high] = [-CUT, CUT];
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if below(middle) < wanted { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Volume of a sphere, m³, or area of a disc, m².
pub(crate) fn measure(radius: f64, discs: bool) -> f64 {
    use std::f64::consts::PI;
    if discs { PI * radius * radius } else { 4.0 / 3.0 * PI * radius * radius * radius }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grading_curve_is_kept_by_mass() {
        let curve = vec![[0.002, 0.1], [0.004, 0.3], [0.006, 0.3], [0.01, 1.0]];
        let sizes = SphereSizes::Grading(curve.clone());
        for discs in [false, true] {
            let radii = sizes.draw(20_000, discs, 3);
            let all: f64 = radii.iter().map(|&radius| measure(radius, discs)).sum();
            for &[radius, share] in &curve {
                let passing = radii.iter().filter(|&&of| of <= radius);
                let found = passing.map(|&of| measure(of, discs)).sum::<f64>() / all;
                assert!((found - share).abs() < 0.02, "{discs} {radius} {share} {found}");
            }
            let mean = all / 20_000.0;
            assert!((mean / sizes.mean_measure(discs) - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn a_normal_distribution_has_its_moments() {
        let radii = SphereSizes::Normal { mean: 0.01, deviation: 0.001 }.draw(5000, false, 1);
        let mean = radii.iter().sum::<f64>() / 5000.0;
        let variance = radii.iter().map(|radius| (radius - mean).powi(2)).sum::<f64>() / 5000.0;
        assert!((mean / 0.01 - 1.0).abs() < 1e-3, "{mean}");
        // A normal distribution that is cut at 3 deviations has 0.9866 of the deviation.
        assert!((variance.sqrt() / 0.000_986_6 - 1.0).abs() < 5e-3, "{}", variance.sqrt());
        assert!(radii.iter().all(|radius| (0.007..=0.013).contains(radius)));
    }

    #[test]
    fn impossible_distributions_are_refused() {
        for sizes in [
            SphereSizes::Equal(0.0),
            SphereSizes::Uniform([0.2, 0.1]),
            SphereSizes::Normal { mean: 1.0, deviation: 0.4 },
            SphereSizes::Grading(vec![[1.0, 0.0], [2.0, 0.9]]),
            SphereSizes::Grading(vec![[2.0, 0.0], [1.0, 1.0]]),
            SphereSizes::Grading(Vec::new()),
        ] {
            assert!(sizes.fault().is_some(), "{sizes:?}");
        }
    }
}
