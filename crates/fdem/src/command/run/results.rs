//! Differences between the results of two and of three dimensions.

use fdem_results::{
    Animation, AnimationError, Field, Fragments, Frame, FrameError, FrameView, MOST_INSIDE, Names, Outlines,
    Pictures, Plot, Range, Report, Shell, Show, SnapshotError, SpaceAnimation, SpaceFrame, SpacePictures,
    SpaceReport, SpaceView,
};
use fdem_simulation::Snapshot;

use crate::command::run::checkpoint::Checkpoint;
use fdem_model::{AnyPrepared, Modelled, Prepared};

/// Time between two pictures of an animation, in hundredths of a second.
const DELAY: u16 = 8;

/// Elements in all frames of a run in space for which a page has room: about 25 bytes each.
const INSIDE: usize = 1_500_000;

/// Results of a run in `D` dimensions.
pub(crate) trait Results<const D: usize, const N: usize>: Modelled<D, N> {
    /// Outlines that are drawn as lines, found once for a mesh.
    type Outlines: Send + 'static;

    /// A compressed snapshot.
    type Frame;

    /// Measure of a crack, and its unit.
    const CRACKED: (&'static str, &'static str);

    fn checkpoint(bytes: &[u8]) -> Result<Checkpoint<D, N>, postcard::Error>;

    fn checkpoint_bytes(checkpoint: &Checkpoint<D, N>) -> Result<Vec<u8>, postcard::Error>;

    /// The model, if it has `D` dimensions.
    fn of_any(prepared: AnyPrepared) -> Option<Prepared<D, N>>;

    fn outlines(prepared: &Prepared<D, N>) -> Self::Outlines;

    /// The bytes of a frame; `frames` is the number of all frames.
    fn frame(
        snapshot: &Snapshot<D, N>,
        outlines: &Self::Outlines,
        shown: [usize; 2],
        frames: usize,
    ) -> Result<Vec<u8>, SnapshotError>;

    fn opened(bytes: &[u8]) -> Result<Self::Frame, FrameError>;

    fn draw(run: &DrawnRun<'_, D>, frames: &[Self::Frame]) -> RunDrawings;

    /// A snapshot alone, as PNG. `width`: in pixels.
    fn picture(
        snapshot: &Snapshot<D, N>,
        outlines: &Self::Outlines,
        title: &str,
        field: Field,
        width: Option<u32>,
    ) -> Result<Vec<u8>, String>;
}

/// The data of the drawings of a run, apart from its frames.
pub(crate) struct DrawnRun<'a, const D: usize> {
    pub(crate) title: &'a str,
    pub(crate) facts: &'a [(&'a str, &'a str)],
    pub(crate) plots: &'a [Plot],
    pub(crate) fragments: &'a Fragments<D>,
    pub(crate) field: Field,
    /// Field of the animation; `None` for no animation.
    pub(crate) animate: Option<Field>,
    pub(crate) names: &'a Names,
}

/// The drawings of a run, or the reasons why they are missing.
pub(crate) struct RunDrawings {
    pub(crate) picture: Option<Result<Vec<u8>, String>>,
    pub(crate) animation: Option<Result<Vec<u8>, String>>,
    pub(crate) report: Result<String, String>,
}

impl Results<2, 3> for [[f64; 2]; 3] {
    type Outlines = Outlines;
    type Frame = Frame;

    const CRACKED: (&'static str, &'static str) = ("crack_length", "m");

    fn checkpoint(bytes: &[u8]) -> Result<Checkpoint<2, 3>, postcard::Error> {
        postcard::from_bytes(bytes)
    }

    fn checkpoint_bytes(checkpoint: &Checkpoint<2, 3>) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_allocvec(checkpoint)
    }

    fn of_any(prepared: AnyPrepared) -> Option<Prepared> {
        match prepared {
            AnyPrepared::Plane(prepared) => Some(*prepared),
            AnyPrepared::Space(_) => None,
        }
    }

    fn outlines(prepared: &Prepared) -> Outlines {
        Outlines::new(&prepared.model.mesh, &prepared.grains)
    }

    fn frame(
        snapshot: &Snapshot,
        outlines: &Outlines,
        [most, sample]: [usize; 2],
        _: usize,
    ) -> Result<Vec<u8>, SnapshotError> {
        // The report shows a sample of a mesh that is too large for a page; files for ParaView are complete.
        let most = if snapshot.elements.len() > most { sample } else { usize::MAX };
        Ok(Frame::sampled(snapshot, outlines, most)?.to_bytes())
    }

    fn opened(bytes: &[u8]) -> Result<Frame, FrameError> {
        Frame::from_bytes(bytes)
    }

    fn picture(
        snapshot: &Snapshot,
        outlines: &Outlines,
        title: &str,
        field: Field,
        width: Option<u32>,
    ) -> Result<Vec<u8>, String> {
        let frame = Frame::outlined(snapshot, outlines).map_err(|error| error.to_string())?;
        let field = field.among(frame.counts());
        let frames = std::slice::from_ref(&frame);
        let pictures =
            Pictures { title, field, range: Range::of(frames, field), view: FrameView::of(frames) };
        pictures.png(&frame, width).map_err(|error| error.to_string())
    }

    fn draw(run: &DrawnRun<'_, 2>, frames: &[Frame]) -> RunDrawings {
        let &DrawnRun { title, facts, plots, fragments, field, animate, names } = run;
        let view = FrameView::of(frames);
        let field = frames.last().map_or(field, |last| field.among(last.counts()));
        let pictures = |field| Pictures { title, field, range: Range::of(frames, field), view };
        let animation = |asked: Field| {
            let asked = frames.last().map_or(asked, |last| asked.among(last.counts()));
            let mut animation = Animation::new(pictures(asked), None, DELAY);
            frames.iter().try_for_each(|frame| animation.push(frame))?;
            animation.finish()
        };
        RunDrawings {
            picture: frames
                .last()
                .map(|last| pictures(field).png(last, None).map_err(|error| error.to_string())),
            animation: animate.map(|asked| animation(asked).map_err(|error| error.to_string())),
            report: Report { title, facts, plots, frames, fragments, field, names }
                .html()
                .map_err(|error| error.to_string()),
        }
    }
}

impl Results<3, 4> for [[f64; 3]; 4] {
    type Outlines = Shell;
    type Frame = SpaceFrame;

    const CRACKED: (&'static str, &'static str) = ("crack_area", "m²");

    fn checkpoint(bytes: &[u8]) -> Result<Checkpoint<3, 4>, postcard::Error> {
        postcard::from_bytes(bytes)
    }

    fn checkpoint_bytes(checkpoint: &Checkpoint<3, 4>) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_allocvec(checkpoint)
    }

    fn of_any(prepared: AnyPrepared) -> Option<Prepared<3, 4>> {
        match prepared {
            AnyPrepared::Plane(_) => None,
            AnyPrepared::Space(prepared) => Some(*prepared),
        }
    }

    fn outlines(prepared: &Prepared<3, 4>) -> Shell {
        Shell::new(&prepared.model.mesh, &prepared.grains)
    }

    fn frame(
        snapshot: &Snapshot<3, 4>,
        shell: &Shell,
        _: [usize; 2],
        frames: usize,
    ) -> Result<Vec<u8>, SnapshotError> {
        let most = MOST_INSIDE.min(INSIDE / frames.max(1));
        Ok(SpaceFrame::with_inside(snapshot, shell, most)?.to_bytes())
    }

    fn opened(bytes: &[u8]) -> Result<SpaceFrame, FrameError> {
        SpaceFrame::from_bytes(bytes)
    }

    fn picture(
        snapshot: &Snapshot<3, 4>,
        shell: &Shell,
        title: &str,
        field: Field,
        width: Option<u32>,
    ) -> Result<Vec<u8>, String> {
        // Only the surface is drawn.
        let frame = SpaceFrame::with_inside(snapshot, shell, 0).map_err(|error| error.to_string())?;
        let field = field.among(frame.counts());
        let frames = std::slice::from_ref(&frame);
        let (range, view) = (Range::of_space(frames, field), SpaceView::of(frames));
        let pictures = SpacePictures { title, field, range, view, show: Show::Solid, cut: None };
        pictures.png(&frame, width).map_err(|error| error.to_string())
    }

    fn draw(run: &DrawnRun<'_, 3>, frames: &[SpaceFrame]) -> RunDrawings {
        let &DrawnRun { title, facts, plots, fragments, field, animate, names } = run;
        let view = SpaceView::of(frames);
        let field = frames.last().map_or(field, |last| field.among(last.counts()));
        let pictures = |field| SpacePictures {
            title,
            field,
            range: Range::of_space(frames, field),
            view,
            show: Show::Solid,
            cut: None,
        };
        let animation = |asked: Field| {
            let asked = frames.last().map_or(asked, |last| asked.among(last.counts()));
            let mut animation = SpaceAnimation::new(pictures(asked), None, DELAY);
            frames.iter().try_for_each(|frame| animation.push(frame))?;
            animation.finish()
        };
        let picture =
            frames.last().map(|last| pictures(field).png(last, None).map_err(|error| error.to_string()));
        let preview = picture.as_ref().and_then(|picture| picture.as_deref().ok());
        let report = SpaceReport { title, facts, plots, frames, fragments, field, names };
        RunDrawings {
            report: report.html(preview).map_err(|error| error.to_string()),
            picture,
            animation: animate
                .map(|asked| animation(asked).map_err(|error: AnimationError| error.to_string())),
        }
    }
}
