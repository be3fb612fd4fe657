//! The texts of a picture that its caller gives.

/// Title and unit of a picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct Caption<'a> {
    /// First line of the picture, for example the name of the file.
    pub title: &'a str,
    /// Unit of length, if it is known.
    pub unit: Option<&'a str>,
}
