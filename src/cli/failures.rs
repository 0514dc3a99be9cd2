//! Failed frames: their messages, and the exit code.

use std::{collections::BTreeSet, fmt};

use batch_render::{
    batch::{FrameError, FrameRange, Plan, Summary},
    error::{Blame, Error},
    math::sorting,
};

use super::{preview::is_animated, replay::Replay};

/// Some frames are not on disk.
#[derive(Debug)]
pub struct FramesFailed {
    count: usize,
    /// Frames that were denoised without a failed one beside them.
    unhelped: usize,
    /// Who must act, if it is the same for all frames and no frame succeeded.
    pub blame: Option<Blame>,
}

impl FramesFailed {
    /// An error if a frame of the job failed.
    pub fn check(summary: Summary) -> anyhow::Result<()> {
        let count = summary.failures.len();
        if count == 0 {
            return Ok(());
        }
        let (unhelped, has_others) = (summary.unhelped, summary.written + summary.skipped > 0);
        let mut blames = summary.failures.into_iter().map(|failure| blame(failure.cause));
        let first = blames.next().flatten();
        let is_common = !has_others && blames.all(|blame| blame == first);
        let blame = first.filter(|_| is_common);
        Err(anyhow::Error::new(Self { count, unhelped, blame }))
    }
}

/// Who must act; `None` for a fault of the program.
fn blame(cause: FrameError) -> Option<Blame> {
    match cause {
        FrameError::Panic(_) => None,
        FrameError::Output(error) => Some(Error::Output(error).blame()),
        FrameError::Scene(error) => Some(error.blame()),
    }
}

impl fmt::Display for FramesFailed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count {
            1 => f.write_str("1 frame failed")?,
            n => write!(f, "{n} frames failed")?,
        }
        match self.unhelped {
            0 => Ok(()),
            n => write!(
                f,
                "; {n} beside them were denoised without them: repeat the job with --skip-existing"
            ),
        }
    }
}

impl std::error::Error for FramesFailed {}

/// The line about frames that were denoised without those that other jobs render, of this job with this command and of others, with
/// the command to type once all are there.
pub fn unfinished(summary: &Summary, plan: &Plan, typed: &Replay) -> Option<String> {
    let (own, missing) = (list(&summary.unfinished), list(&summary.missing));
    let own = format!("denoised without the frames beside them, which are not there: {own} (without {missing})");
    let outdated = list(&summary.outdated);
    let others = format!("denoised by other jobs before the frames beside them were rendered: {outdated}");
    let facts = [(own, &summary.missing), (others, &summary.outdated)].into_iter();
    let facts: Vec<String> = facts
        .filter(|(_, frames)| !frames.is_empty())
        .map(|(fact, _)| fact)
        .collect();
    // Without a range the job would leave out frames beyond its extent.
    let own = || plan.all_frames().iter().map(|frame| i64::from(frame.number));
    let is_beyond = own().any(|frame| !plan.extent.contains(&frame));
    let outdated = summary.outdated.iter().map(|frame| i64::from(*frame));
    let range = is_beyond.then(|| FrameRange::of(sorting::ordered::<_, BTreeSet<i64>>(own().chain(outdated))));
    (!facts.is_empty()).then(|| unfinished_line(typed.clone(), &facts.join("; "), range))
}

/// These frames, as `--range` has them.
pub fn list(frames: &[i32]) -> String {
    FrameRange::of(frames.iter().map(|frame| i64::from(*frame))).to_string()
}

/// The line with these facts and the command that denoises the frames of the range, or the whole job.
fn unfinished_line(typed: Replay, facts: &str, range: Option<FrameRange>) -> String {
    let mut replay = typed.without(&["range", "part", "part-base", "overwrite", "fail-existing"]);
    if let Some(range) = range {
        replay = replay.with("range", range.to_string());
    }
    let command = replay
        .with("denoise-step", "denoise")
        .with_flag("skip-existing")
        .shell_line();
    format!("{facts}. Once all frames are rendered: {command}")
}

/// The command to type after this frame of a job with this command has failed: the one that renders it alone. A frame that is
/// denoised needs those around it: the job goes on with what is missing.
pub fn advice(typed: &Replay, frame: i32) -> String {
    if typed.has("denoise") {
        let replay = typed.clone().without(&["overwrite", "fail-existing"]);
        return format!("to go on: {}", replay.with_flag("skip-existing").shell_line());
    }
    // A film of this frame alone would replace that of all.
    let alone = typed.clone().retain("output", |path| !is_animated(path));
    if typed.has("output") && !alone.has("output") {
        return format!("to repeat the job: {}", typed.clone().shell_line());
    }
    let replay = alone.without(&["part", "part-base", "preview"]);
    let command = replay.with("range", frame.to_string()).shell_line();
    format!("to repeat it alone: {command}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_of_a_frame_has_its_range_alone() {
        let typed = "batch-render --frames p.csv -vr 1-100 --part=2/4 --samples 4 --preview film.png";
        let words = typed.split(' ').map(Into::into).chain(["it's here.toml".into()]);
        let replay = Replay::parse(words).expect("the command line is right");
        let advice = advice(&replay, -5);
        let command = advice.strip_prefix("to repeat it alone: ").expect("advice");
        let words = shlex::split(command).expect("a command line");
        assert_eq!(words[..2], ["batch-render", "it's here.toml"]);
        let mut flags = words[2..].to_vec();
        flags.sort();
        assert_eq!(flags, ["--frames=p.csv", "--range=-5", "--samples=4", "--verbose"]);
    }

    #[test]
    fn the_command_of_a_frame_makes_no_film_of_it() {
        let advice_on = |typed: &str| {
            let replay = Replay::parse(typed.split(' ').map(Into::into)).expect("the command line is right");
            advice(&replay, 2)
        };
        let found = advice_on("b s.toml -o film.gif -o f.#.png -o film.apng --samples 4");
        let words = shlex::split(&found).expect("a command line");
        assert!(found.starts_with("to repeat it alone: "), "{found}");
        assert!(
            words.contains(&"--output=f.#.png".to_owned()) && !found.contains("film"),
            "{found}"
        );
        assert_eq!(
            advice_on("b s.toml -o film.gif"),
            "to repeat the job: b s.toml --output=film.gif"
        );
    }

    #[test]
    fn the_command_for_unfinished_frames_denoises_the_whole_job() {
        let typed = "b s.toml --frames p.csv --part 1/4 --part-base 0 -r 1-9 --denoise --denoise-step denoise --overwrite -o f.#.exr";
        let replay = Replay::parse(typed.split(' ').map(Into::into)).expect("the command line is right");
        let line = unfinished_line(replay, "not there: 8-9 (without 10,11)", None);
        let (facts, command) = line.split_once(" Once all frames are rendered: ").expect("a command");
        assert!(facts.ends_with(": 8-9 (without 10,11)."), "{facts}");
        let words = "b s.toml --frames=p.csv --output=f.#.exr --denoise=nlm --denoise-step=denoise --skip-existing";
        let mut words: Vec<&str> = words.split(' ').collect();
        let mut found = shlex::split(command).expect("a command line");
        words.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, words);
    }

    #[test]
    fn the_command_of_a_denoised_frame_goes_on_with_the_whole_job() {
        let typed = "b s.toml --frames p.csv -r 1-4 --denoise --fail-existing -o f.#.exr";
        let replay = Replay::parse(typed.split(' ').map(Into::into)).expect("the command line is right");
        let words = "b s.toml --frames=p.csv --range=1-4 --output=f.#.exr --denoise=nlm --skip-existing";
        let mut words: Vec<&str> = words.split(' ').collect();
        let advice = advice(&replay, 2);
        let line = advice.strip_prefix("to go on: ").expect("advice");
        let mut found = shlex::split(line).expect("a command line");
        words.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, words);
    }
}
