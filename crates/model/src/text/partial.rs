//! Reads the valid parts of a model file with errors, so that users see all errors together.
//!
//! Keys with faults are taken out of their tables. A table that cannot be read without them is replaced by
//! one that has its name and nothing to complain of. Faults that are found in such a table later, or that
//! follow from it, are no news.

use std::ops::Range;

use fdem_simulation::{ContactOptions, FractureOptions};
use serde::de::DeserializeOwned;
use toml::de::ValueDeserializer;
use toml::{Table as Toml, Value};

use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{
    Body, Boundary, Curve, Domain, Fluid, General, Grains, History, Initial, Injection, Interface, JointSet,
    Material, ModelFile, Output, PoreSurface, Pores, SHAPES, SphereInsertion, SphereOptions, SphereRemoval,
    Stage, Wall,
};

/// Represents a name that could not be read. No name in a file can be this: it would have to be written as an
/// escape.
const NAMELESS: &str = "\u{1}";

/// A file with faults.
pub(crate) struct Partial {
    pub(crate) file: ModelFile,
    /// The parts of the text that have faults.
    broken: Vec<Range<usize>>,
    /// Tables of which one has no name that can be read.
    nameless: Vec<&'static str>,
    /// Keys that were taken out of tables that come once.
    missing: Vec<String>,
}

impl Partial {
    /// Reads the valid parts. `faults`: the errors that the schema found.
    pub(crate) fn read(document: &Document<'_>, faults: &[Fault]) -> Option<Self> {
        let mut root: Toml = document.read().ok()?;
        root.retain(|key, _| ModelFile::TABLES.contains(&key));
        let mut reader =
            Reader { document, broken: Vec::new(), nameless: Vec::new(), missing: Vec::new(), faults };
        reader.list::<Material>(&mut root, "material", |_| {
            [("density", Value::from(1.0)), ("youngs_modulus", 1.0.into()), ("poissons_ratio", 0.0.into())]
                .into()
        });
        reader.list::<Body>(&mut root, "body", |body| {
            let material = body.get("material").filter(|name| name.is_str()).cloned();
            let mut instead = vec![("material", material.unwrap_or_else(|| NAMELESS.into()))];
            if let Some(mesh) = body.get("mesh").filter(|name| name.is_str()) {
                instead.push(("mesh", mesh.clone()));
            } else {
                // A shape of the same dimensions, or all that fits the body would be faults.
                let round: Toml = [("radius".to_owned(), Value::from(1.0))].into_iter().collect();
                instead.push((if is_in_space(body) { "sphere" } else { "disc" }, round.into()));
                instead.push(("mesh_size", 1.0.into()));
            }
            instead
        });
        reader.list::<Interface>(&mut root, "interface", |_| {
            vec![("materials", Value::Array(vec![NAMELESS.into(), NAMELESS.into()]))]
        });
        reader.list::<JointSet>(&mut root, "joint_set", |_| {
            let line: Vec<Value> = [0.0, 0.0, 1.0, 0.0].map(Value::from).into();
            vec![("lines", Value::Array(vec![Value::Array(line)])), ("friction_angle", 0.0.into())]
        });
        reader.list::<Boundary>(&mut root, "boundary", |_| vec![("fixed", "x".into())]);
        reader.list::<Injection>(&mut root, "injection", |_| vec![("group", "holes".into())]);
        reader.list::<PoreSurface>(&mut root, "pore_surface", |_| {
            vec![("side", "top".into()), ("pressure", 0.0.into())]
        });
        reader.list::<Grains>(&mut root, "grains", |grains| {
            let material = grains.get("material").filter(|name| name.is_str()).cloned();
            vec![("material", material.unwrap_or_else(|| NAMELESS.into()))]
        });
        reader.list::<SphereInsertion>(&mut root, "insertion", |insertion| {
            let material = insertion.get("material").filter(|name| name.is_str()).cloned();
            let mut instead = vec![("material", material.unwrap_or_else(|| NAMELESS.into()))];
            instead.extend([("within", unit_box(insertion)), ("radius", 0.1.into())]);
            instead
        });
        reader.list::<SphereRemoval>(&mut root, "delete", |of| vec![("within", unit_box(of))]);
        reader.list::<Wall>(&mut root, "wall", |wall| {
            let material = wall.get("material").filter(|name| name.is_str()).cloned();
            vec![("material", material.unwrap_or_else(|| NAMELESS.into()))]
        });
        reader.list::<History>(&mut root, "history", |_| vec![("energy", true.into())]);
        reader.list::<Stage>(&mut root, "stage", |_| vec![("equilibrium", 1.0.into())]);
        reader.list::<Curve>(&mut root, "curve", |_| vec![("x", "time".into()), ("y", "time".into())]);
        reader.one::<General>(&mut root, "model", &[("end_time", Value::from(1.0))]);
        reader.one::<SphereOptions>(&mut root, "spheres", &[]);
        reader.one::<Domain>(&mut root, "domain", &[]);
        reader.one::<Initial>(&mut root, "initial", &[]);
        reader.one::<ContactOptions>(&mut root, "contact", &[]);
        reader.one::<FractureOptions>(&mut root, "fracture", &[]);
        reader.one::<Fluid>(&mut root, "fluid", &[]);
        reader.one::<Pores>(&mut root, "pores", &[]);
        reader.one::<Output>(&mut root, "output", &[]);
        if !root.contains_key("model") {
            root.insert(
                "model".to_owned(),
                [("end_time".to_owned(), Value::from(1.0))].into_iter().collect::<Toml>().into(),
            );
        }
        for list in ["material", "body"] {
            let has_spheres = root.contains_key("grains") || root.contains_key("insertion");
            let is_needed = list == "material" || !has_spheres;
            if !root.contains_key(list) && is_needed {
                reader.nameless.push(list);
                root.insert(list.to_owned(), Value::Array(Vec::new()));
            }
        }
        let Reader { broken, nameless, missing, .. } = reader;
        let file = value_as(&Value::Table(root))?;
        Some(Self { file, broken, nameless, missing })
    }

    /// Whether a fault that was found later is news.
    pub(crate) fn is_news(&self, fault: &Fault) -> bool {
        let unknown = fault.label.strip_prefix("unknown ");
        let mut words = fault.message.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        let follows = fault.message.contains(NAMELESS)
            || unknown.is_some_and(|table| self.nameless.contains(&table))
            || words.any(|word| self.missing.iter().any(|key| key == word));
        !follows && (unknown.is_some() || !self.is_broken(fault.span.as_ref()))
    }

    /// Whether a part of the text has faults.
    fn is_broken(&self, span: Option<&Range<usize>>) -> bool {
        span.is_some_and(|span| {
            self.broken.iter().any(|broken| broken.start <= span.start && span.end <= broken.end)
        })
    }
}

/// Reads a value as its type, through its text: types are then compiled for one source of values, that of
/// `Document::read`.
fn value_as<T: DeserializeOwned>(value: &Value) -> Option<T> {
    T::deserialize(ValueDeserializer::parse(&value.to_string()).ok()?).ok()
}

/// A box with the dimensions that the `within` of a table seems to have.
fn unit_box(table: &Toml) -> Value {
    let corner = |key: &str| table.get("within")?.get(key)?.as_array().map(Vec::len);
    let dimensions = corner("min").or_else(|| corner("max")).unwrap_or(2).clamp(2, 3);
    let all = |x: f64| Value::Array(vec![x.into(); dimensions]);
    [("min".to_owned(), all(0.0)), ("max".to_owned(), all(1.0))].into_iter().collect::<Toml>().into()
}

/// Whether a body, or its outline, has a shape in three dimensions.
fn is_in_space(body: &Toml) -> bool {
    let is_solid = |key: &str| SHAPES.iter().any(|(shape, of)| *shape == key && **of == [3]);
    body.iter().any(|(key, value)| is_solid(key) || value.as_table().is_some_and(is_in_space))
}

struct Reader<'d, 'f> {
    document: &'d Document<'d>,
    faults: &'f [Fault],
    broken: Vec<Range<usize>>,
    nameless: Vec<&'static str>,
    missing: Vec<String>,
}

impl Reader<'_, '_> {
    /// Replaces entries of a list of tables that cannot be read. `rest`: keys of the table to put in its
    /// place, beside its name.
    fn list<T: DeserializeOwned>(
        &mut self,
        root: &mut Toml,
        name: &'static str,
        rest: impl Fn(&Toml) -> Vec<(&'static str, Value)>,
    ) {
        let Some(value) = root.get_mut(name) else { return };
        let Value::Array(list) = value else {
            self.nameless.push(name);
            root.remove(name);
            return;
        };
        for (index, item) in list.iter_mut().enumerate() {
            self.look(Table::of(name, index));
            if value_as::<T>(item).is_some() {
                continue;
            }
            // A body without one of its keys could be of another shape, or of none.
            if let Some(table) = item.as_table().filter(|_| name != "body") {
                let mut table = table.clone();
                self.take_out(Table::of(name, index), &mut table);
                let mended = Value::Table(table);
                if value_as::<T>(&mended).is_some() {
                    *item = mended;
                    continue;
                }
            }
            let empty = Toml::new();
            let table = item.as_table().unwrap_or(&empty);
            let title = table.get("name").filter(|name| name.is_str()).cloned();
            if title.is_none() {
                self.nameless.push(name);
            }
            let mut instead: Toml =
                rest(table).into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
            if name != "interface" {
                instead.insert("name".to_owned(), title.unwrap_or_else(|| NAMELESS.into()));
            }
            *item = instead.into();
        }
    }

    /// Takes keys with faults out of a table that comes once, or all of it if it still cannot be read.
    /// `rest`: keys that it needs.
    fn one<T: DeserializeOwned>(&mut self, root: &mut Toml, name: &'static str, rest: &[(&str, Value)]) {
        let Some(value) = root.get_mut(name) else { return };
        self.look(Table::one(name));
        if value_as::<T>(value).is_some() {
            return;
        }
        let mended = value.as_table_mut().is_some_and(|table| {
            let missing = self.take_out(Table::one(name), table);
            self.missing.extend(missing);
            for (key, value) in rest {
                table.entry((*key).to_owned()).or_insert_with(|| value.clone());
            }
            value_as::<T>(&Value::Table(table.clone())).is_some()
        });
        if !mended {
            root.remove(name);
        }
    }

    /// Takes the keys with faults out of a table, and returns them.
    fn take_out(&self, place: Table, table: &mut Toml) -> Vec<String> {
        let has_fault = |key: &str| {
            let extent = self.document.key(place, key).start..self.document.value(place, key).end;
            let within = |span: &Range<usize>| extent.start <= span.start && span.end <= extent.end;
            self.faults.iter().any(|fault| fault.span.as_ref().is_some_and(within))
        };
        let wrong: Vec<String> = table.keys().filter(|key| has_fault(key)).cloned().collect();
        for key in &wrong {
            table.remove(key);
        }
        wrong
    }

    /// Notes whether a table has faults.
    fn look(&mut self, table: Table) {
        let extent = self.document.extent(table);
        let within = |span: &Range<usize>| extent.start <= span.start && span.end <= extent.end;
        if self.faults.iter().any(|fault| fault.span.as_ref().is_some_and(within)) {
            self.broken.push(extent);
        }
    }
}
