//! Selection of frames of a file by the indices and slices of Python.

use std::str::FromStr;

/// Value of `--frames`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Frames {
    /// One frame; negative numbers count from the end.
    One(i64),
    /// `START:STOP:STEP`, each of which may be left out.
    Slice { start: Option<i64>, stop: Option<i64>, step: i64 },
}

/// The selected frames of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Selection {
    /// One frame: outputs are those of a single packing.
    One(usize),
    /// A series: outputs are marked with their frame.
    Series(Vec<usize>),
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| -> Result<Option<i64>, String> {
            let text = text.trim();
            if text.is_empty() {
                return Ok(None);
            }
            let wrong = |_| format!("'{text}' is not a frame: expected a whole number, or START:STOP:STEP");
            text.parse().map(Some).map_err(wrong)
        };
        let parts: Vec<&str> = text.split(':').collect();
        match parts[..] {
            [one] => number(one)?.map(Self::One).ok_or_else(|| "no frame is given".to_owned()),
            [start, stop] => Ok(Self::Slice { start: number(start)?, stop: number(stop)?, step: 1 }),
            [start, stop, step] => match number(step)? {
                Some(0) => Err("the step must not be 0".to_owned()),
                step => {
                    Ok(Self::Slice { start: number(start)?, stop: number(stop)?, step: step.unwrap_or(1) })
                }
            },
            _ => Err(format!("'{text}' has more parts than START:STOP:STEP")),
        }
    }
}

impl Frames {
    /// Selects among `count` frames. Without `--frames`, a file of one frame is a single packing, and any
    /// other file a series of all its frames.
    pub(crate) fn select(frames: Option<Self>, count: usize) -> Result<Selection, String> {
        let n = count as i128;
        match frames {
            None if count == 1 => Ok(Selection::One(0)),
            None => Ok(Selection::Series((0..count).collect())),
            Some(Self::One(wanted)) => {
                let from_start = if wanted < 0 { i128::from(wanted) + n } else { i128::from(wanted) };
                usize::try_from(from_start)
                    .ok()
                    .filter(|frame| *frame < count)
                    .map(Selection::One)
                    .ok_or_else(|| match count {
                        1 => format!("--frames {wanted}: the file has one frame, 0"),
                        _ => format!("--frames {wanted}: the file has {count} frames, 0 to {}", count - 1),
                    })
            }
            Some(Self::Slice { start, stop, step }) => {
                let up = step > 0;
                let (low, high) = if up { (0, n) } else { (-1, n - 1) };
                let place = |limit: Option<i64>, default: i128| {
                    limit.map_or(default, |limit| {
                        let limit = i128::from(limit);
                        (if limit < 0 { limit + n } else { limit }).clamp(low, high)
                    })
                };
                let first = place(start, if up { low } else { high });
                let end = place(stop, if up { high } else { low });
                let mut frames = Vec::new();
                let mut at = first;
                while if up { at < end } else { at > end } {
                    frames.push(at as usize);
                    at += i128::from(step);
                }
                if frames.is_empty() {
                    let frames = if count == 1 { "1 frame" } else { &format!("{count} frames") };
                    return Err(format!("--frames selects no frame: the file has {frames}"));
                }
                Ok(Selection::Series(frames))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(text: &str, count: usize) -> Vec<usize> {
        match Frames::select(Some(text.parse().unwrap()), count) {
            Ok(Selection::Series(frames)) => frames,
            other => panic!("{text}: {other:?}"),
        }
    }

    /// The expected lists are the output of Python for `list(range(5))[…]`.
    #[test]
    fn slices_are_those_of_python() {
        for (text, expected) in [
            (":", &[0, 1, 2, 3, 4][..]),
            ("::", &[0, 1, 2, 3, 4]),
            ("1:3", &[1, 2]),
            ("0:100:2", &[0, 2, 4]),
            ("-2:", &[3, 4]),
            (":-3", &[0, 1]),
            ("::-1", &[4, 3, 2, 1, 0]),
            ("3:0:-2", &[3, 1]),
            ("-100:2", &[0, 1]),
            ("100:-100:-3", &[4, 1]),
            ("2::-9223372036854775808", &[2]),
        ] {
            assert_eq!(series(text, 5), expected, "{text}");
        }
        for empty in ["3:3", "4:1", "7:", "0:3:-1"] {
            let error = Frames::select(Some(empty.parse().unwrap()), 5).unwrap_err();
            assert_eq!(error, "--frames selects no frame: the file has 5 frames", "{empty}");
        }
        let error = Frames::select(Some("1:".parse().unwrap()), 1).unwrap_err();
        assert!(error.ends_with("the file has 1 frame"), "{error}");
    }

    #[test]
    fn one_frame_counts_from_either_end() {
        let one = |text: &str, count| Frames::select(Some(text.parse().unwrap()), count);
        assert_eq!(one("-1", 5), Ok(Selection::One(4)));
        assert_eq!(one("0", 1), Ok(Selection::One(0)));
        assert_eq!(one("0:1", 1), Ok(Selection::Series(vec![0])));
        assert!(one("5", 5).unwrap_err().contains("0 to 4"));
        assert!(one("-6", 5).is_err() && one("1", 1).is_err());
        assert_eq!(Frames::select(None, 1), Ok(Selection::One(0)));
        assert_eq!(Frames::select(None, 2), Ok(Selection::Series(vec![0, 1])));
    }

    #[test]
    fn what_is_no_slice_is_refused() {
        for bad in ["", "a", "1:b", "1:2:0", "1:2:3:4", "1.5", "99999999999999999999"] {
            assert!(bad.parse::<Frames>().is_err(), "{bad}");
        }
    }
}
