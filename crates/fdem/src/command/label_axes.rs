//! The axes of an image, and why the work on it stops.

use fdem_contact::Error;
use fdem_io::LabelError;

use crate::command::failure::Failure;

/// Order of x, y and z among the axes of the stored array.
#[derive(Clone, Copy)]
pub(crate) struct AxisOrder {
    pub(crate) reversed: bool,
}

impl AxisOrder {
    /// Sorts values of the stored axes into the order x, y, z. x is the last axis of the array, which is the
    /// fastest in C order.
    pub(crate) fn xyz<T: Copy, const D: usize>(self, mut axes: [T; D]) -> [T; D] {
        if !self.reversed {
            axes.reverse();
        }
        axes
    }
}

/// Why the work on an image stopped.
pub(crate) enum ImageStop {
    Unreadable(LabelError),
    Refused(Error),
    /// An option does not fit the image.
    Option(String),
    Failed(Failure),
}

impl From<LabelError> for ImageStop {
    fn from(error: LabelError) -> Self {
        Self::Unreadable(error)
    }
}

impl From<Error> for ImageStop {
    fn from(error: Error) -> Self {
        Self::Refused(error)
    }
}

impl ImageStop {
    /// The failure with the message of the command.
    pub(crate) fn told(self, name: &str) -> Failure {
        let text = match self {
            Self::Failed(failure) => return failure,
            Self::Unreadable(LabelError::Read(error)) => return Failure::reading(name, &error),
            Self::Unreadable(LabelError::Member { wanted: None, present }) => format!(
                "the archive has {} arrays: choose one with --member: {}",
                present.len(),
                present.join(", ")
            ),
            Self::Unreadable(error) => error.to_string(),
            Self::Refused(error @ Error::NoEdgesIn2D) => format!("--neighbourhood edge: {error}"),
            Self::Refused(error @ Error::InvalidSpacing { .. }) => format!("--spacing: {error}"),
            Self::Refused(error @ Error::NoThreads { .. }) => format!("--threads: {error}"),
            Self::Refused(error) => error.to_string(),
            Self::Option(text) => text,
        };
        Failure::Unusable(format!("{name}: {text}"))
    }
}
