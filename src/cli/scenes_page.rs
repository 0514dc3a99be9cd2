//! The page about all scenes of a command, with links to the pages of each (`--report` without `{scene}`).

use std::{fmt::Write, time::Duration};

use super::{
    arguments::arguments,
    figure_files::PAGE,
    figures::{Report, SceneReport, State, Status},
    replay::shell_line,
    report_page::{STYLE, escape, refresh},
    summary::{plural, seconds},
};

/// The row of a loaded scene in the table of the page.
#[derive(Clone)]
pub struct SceneRow {
    /// The frames that are written, were skipped, and have failed.
    frames: [usize; 3],
    total: usize,
    wall_s: f64,
    /// A picture, as the address of an image.
    thumbnail: Option<String>,
}

impl SceneRow {
    /// The row of a job with these figures, and a picture of one of its frames.
    pub fn new(report: &Report, thumbnail: Option<&String>) -> Self {
        let count = |status| report.frames.iter().filter(|frame| frame.status == status).count();
        Self {
            frames: [Status::Written, Status::Skipped, Status::Failed].map(count),
            total: report.total,
            wall_s: report.wall_s,
            thumbnail: thumbnail.cloned(),
        }
    }
}

/// The page of a command that is in this state after so many seconds, with this word for a scene.
pub fn scenes_page<'a>(
    noun: &str,
    state: State,
    wall: Duration,
    scenes: impl Iterator<Item = (&'a SceneReport, Option<&'a SceneRow>)> + Clone,
) -> String {
    let count = |wanted| scenes.clone().filter(|(scene, _)| scene.state == wanted).count();
    let (total, [finished, failed]) = (scenes.clone().count(), [State::Finished, State::Failed].map(count));
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\">{}<title>{scenes}: {state}</title><style>{STYLE}td img{{width:6rem}}</style></head><body>\n\
         <h1>{scenes}</h1>\n<p>{state}: {finished} finished, {failed} failed, of {total}; {}</p>\n\
         <progress max=\"{total}\" value=\"{}\"></progress>\n<p class=\"faint\">batch-render {}</p>\n<code>{}</code>\n\
         <table><tr><th>{noun}</th><th>state</th><th>frames</th><th>failed</th><th>time</th><th></th></tr>\n",
        refresh(state),
        seconds(wall),
        finished + failed,
        env!("CARGO_PKG_VERSION"),
        escape(&shell_line(arguments())),
        scenes = plural(total, noun),
        state = state.name(),
    );
    for (scene, row) in scenes {
        let name = escape(&scene.name);
        let name = match row {
            Some(_) => format!("<a href=\"{}/{PAGE}\">{name}</a>", address(&scene.name)),
            None => name,
        };
        let _ = write!(out, "<tr><td>{name}</td><td>{}</td>", scene.state.name());
        match row {
            Some(row) => {
                let [written, skipped, failed] = row.frames;
                let time = seconds(Duration::from_secs_f64(row.wall_s));
                let image = row.thumbnail.as_ref();
                let image = image
                    .map(|address| format!("<img src=\"{address}\" alt=\"\">"))
                    .unwrap_or_default();
                let (there, total) = (written + skipped, row.total);
                let _ = writeln!(
                    out,
                    "<td>{there} of {total}</td><td>{failed}</td><td>{time}</td><td>{image}</td></tr>"
                );
            }
            None => {
                let _ = writeln!(out, "<td></td><td></td><td></td><td></td></tr>");
            }
        }
        if let Some(reason) = &scene.reason {
            let _ = writeln!(out, "<tr><td class=\"bad\" colspan=\"6\">{}</td></tr>", escape(reason));
        }
    }
    out.push_str("</table></body></html>\n");
    out
}

/// The address of a relative path.
fn address(path: &str) -> String {
    let mut address = String::new();
    for byte in path.bytes() {
        match byte {
            b'/' | b'-' | b'_' | b'.' | b'~' | b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' => address.push(byte.into()),
            other => address += &format!("%{other:02X}"),
        }
    }
    address
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_of_odd_names_are_those_of_their_folders() {
        assert_eq!(address("a/x-1.v2"), "a/x-1.v2");
        assert_eq!(address("50 % \"é#?"), "50%20%25%20%22%C3%A9%23%3F");
    }
}
