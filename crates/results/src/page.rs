//! Pages for a browser: one file each, which loads nothing over the network.
//!
//! The content security policy of a page allows only its own script and style, by their hashes. Texts from
//! outside, such as the name of a file, are escaped.

pub mod network;
pub(crate) mod run;
pub mod sweep;

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

pub use crate::picture::svg::escape;

/// Style of all pages.
pub const STYLE: &str = include_str!("page/style.css");

/// Script of all pages that have one.
pub(crate) const SHARED: &str = include_str!("page/shared.js");

/// The common parts of all pages with a script: head, heading, footer. The places for the parts of a kind of
/// page are filled by [`PageParts::page`].
const SHELL: &str = include_str!("page/shell.html");

/// The parts in which kinds of pages differ. All but the style and the script are templates, in which
/// `{{names}}` are replaced.
pub(crate) struct PageParts<'a> {
    /// Suffix of the title after the title of the page.
    pub(crate) kind: &'a str,
    /// The command that makes such pages.
    pub(crate) command: &'a str,
    /// The first link: its target and its text.
    pub(crate) skip: [&'a str; 2],
    pub(crate) main: &'a str,
    /// Elements with data for the script.
    pub(crate) data: &'a str,
    pub(crate) style: String,
    pub(crate) scripts: &'a [&'a str],
}

impl PageParts<'_> {
    /// Returns a page. `value` returns the texts of places but those of the policy, the style, the script and
    /// the version.
    pub(crate) fn page<E>(&self, value: impl Fn(&str) -> Result<String, E>) -> Result<String, E> {
        let mut template = SHELL.to_owned();
        for (name, part) in [
            ("{{kind}}", self.kind),
            ("{{command}}", self.command),
            ("{{skip}}", self.skip[0]),
            ("{{skipping}}", self.skip[1]),
            ("{{main}}", self.main),
            ("{{data}}", self.data),
        ] {
            template = template.replace(name, part);
        }
        let script = format!("(() => {{\n\"use strict\";\n{SHARED}\n{}\n}})();", self.scripts.concat());
        filled(&template, |name| {
            Ok(match name {
                "policy" => format!(
                    "default-src 'none'; script-src '{}'; style-src '{}'; img-src data:; base-uri 'none'; form-action 'none'",
                    hash(&script),
                    hash(&self.style)
                ),
                "style" => self.style.clone(),
                "script" => script.clone(),
                "version" => env!("CARGO_PKG_VERSION").to_owned(),
                _ => return value(name),
            })
        })
    }
}

/// Replaces the `{{names}}` of a template by their values. Values are not searched for names.
pub(crate) fn filled<E>(template: &str, value: impl Fn(&str) -> Result<String, E>) -> Result<String, E> {
    let mut parts = template.split("{{");
    let mut page = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once("}}").unwrap_or((part, ""));
        let value = value(name)?;
        // Reserves only the necessary memory: a growing string could take twice as much.
        page.reserve_exact(value.len() + rest.len());
        page += &value;
        page += rest;
    }
    Ok(page)
}

/// Hash of a script or a style for the content security policy.
pub fn hash(text: &str) -> String {
    format!("sha256-{}", STANDARD.encode(Sha256::digest(text)))
}

/// Rows of a table of facts. One without a name continues the row before.
pub(crate) fn rows(facts: &[(&str, &str)]) -> String {
    let mut rows = String::new();
    for (name, text) in facts {
        // Writing to a string does not fail.
        let _ = writeln!(rows, "<tr><th scope=\"row\">{}</th><td>{}</td></tr>", escape(name), escape(text));
    }
    rows
}
