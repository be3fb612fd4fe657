//! Names of bodies and materials in results.

/// Names of bodies and materials, by their numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// Names of the materials.
    pub materials: Vec<String>,
}

impl Names {
    /// Returns the names with the numbers that have them: `body: floor` with 0,
    /// `bodies: stones-1 to stones-60` with 1 and 60, `material: rock` with 0.
    ///
    /// The pieces of a packing are one entry, because thousands of entries would fill the lists of ParaView.
    pub(crate) fn numbered(&self) -> Vec<(String, Vec<i64>)> {
        let whole = |number: usize| number.cast_signed() as i64;
        let mut entries = Vec::new();
        let mut first = 0;
        while let Some(name) = self.bodies.get(first) {
            let last = first + self.row(first);
            entries.push(if last > first {
                let text = format!("bodies: {name} to {}", self.bodies[last]);
                (text, vec![whole(first), whole(last)])
            } else {
                (format!("body: {name}"), vec![whole(first)])
            });
            first = last + 1;
        }
        let materials = self.materials.iter().enumerate();
        entries.extend(materials.map(|(number, name)| (format!("material: {name}"), vec![whole(number)])));
        entries
    }

    /// Returns the number of bodies after this one that continue its numbering: `heap-2`, `heap-3`, … after
    /// `heap-1`.
    fn row(&self, first: usize) -> usize {
        let Some(base) = self.bodies[first].strip_suffix("-1") else { return 0 };
        let continues = |&(k, name): &(usize, &String)| {
            name.strip_prefix(base).and_then(|rest| rest.strip_prefix('-'))
                == Some((k + 2).to_string().as_str())
        };
        self.bodies[first + 1..].iter().enumerate().take_while(continues).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_of_a_packing_are_one_entry() {
        let texts = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let names = Names {
            bodies: texts(&["floor", "a-1", "a-2", "a-3", "b-1", "wall", "c-1", "c-3"]),
            materials: texts(&["rock"]),
        };
        let found: Vec<(String, Vec<i64>)> = names.numbered();
        let expected = [
            ("body: floor", vec![0]),
            ("bodies: a-1 to a-3", vec![1, 3]),
            ("body: b-1", vec![4]),
            ("body: wall", vec![5]),
            ("body: c-1", vec![6]),
            ("body: c-3", vec![7]),
            ("material: rock", vec![0]),
        ];
        assert_eq!(found, expected.map(|(name, numbers)| (name.to_owned(), numbers)));
        assert_eq!(Names::default().numbered(), []);
    }
}
