//! `batch-render compare`: pictures beside their references.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use batch_render::{
    assets::{Files, MemoryBudget},
    compare::{
        CompareError, ComparedPass, Comparison, Measures, PassMeasures, compare, compare_passes, heat, pairs::Pairs,
    },
    error::Error,
    output::atomic,
};
use serde::Serialize;

use super::{
    closed_pipe::is_closed_pipe, compare_args::CompareArgs, create::cannot_create, log::warn, memory, summary::plural,
    threads::threads,
};

/// Runs the command. Pictures beyond the tolerance are an error, after all have been compared.
pub fn run(args: &CompareArgs, quiet: bool) -> anyhow::Result<()> {
    let pool = threads(args.threads)?;
    let mut run = Run {
        args,
        files: Files::new(true, MemoryBudget::new(Some(memory::default_limit()))),
        quiet,
        beyond: 0,
        updated: 0,
    };
    if args.update && args.test.is_dir() && !args.reference.exists() {
        // The first references.
        fs::create_dir_all(&args.reference).map_err(|source| cannot_create(source, &args.reference))?;
    }
    let compared = match (args.reference.is_dir(), args.test.is_dir()) {
        (true, true) => pool.install(|| run.folders())?,
        (false, false) => {
            pool.install(|| run.pair(&args.reference, &args.test, args.output.as_deref(), true))?;
            1
        }
        _ => {
            for path in [&args.reference, &args.test] {
                fs::metadata(path).map_err(|source| {
                    let path = path.clone();
                    Error::Compare(CompareError::Read { source, path })
                })?;
            }
            return Err(Error::Usage("one path is a folder and the other is none".to_owned()).into());
        }
    };
    if run.updated > 0 && !quiet && !args.json {
        super::progress::say(&format!("{} updated", plural(run.updated, "reference")));
    }
    match run.beyond {
        0 => Ok(()),
        beyond => anyhow::bail!("{beyond} of {} beyond the tolerance", plural(compared, "picture")),
    }
}

struct Run<'a> {
    args: &'a CompareArgs,
    files: Files,
    quiet: bool,
    beyond: usize,
    updated: usize,
}

/// The result of a pair, as JSON.
#[derive(Serialize)]
struct Line<'a> {
    reference: &'a Path,
    test: &'a Path,
    #[serde(flatten)]
    measures: Option<Measures>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reference_mean: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    test_mean: Option<[f64; 3]>,
    /// Numbers of the reference and of the test that are NaN or infinite.
    #[serde(skip_serializing_if = "Option::is_none")]
    not_finite: Option<[u64; 2]>,
    within_tolerance: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

/// The result of a pass of a pair, as JSON.
#[derive(Serialize)]
struct PassLine<'a> {
    reference: &'a Path,
    test: &'a Path,
    pass: &'a str,
    #[serde(flatten)]
    measures: Option<PassMeasures>,
    within_tolerance: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'static str>,
}

impl Run<'_> {
    /// Compares the pictures of two folders; returns their number.
    fn folders(&mut self) -> anyhow::Result<usize> {
        let (reference, test) = (&self.args.reference, &self.args.test);
        let pairs = Pairs::of(reference, test).map_err(|e| Error::Usage(format!("cannot list the folders: {e}")))?;
        let count = pairs.both.len() + pairs.missing.len() + pairs.added.len();
        if pairs.arrays > 0 {
            let files = plural(pairs.arrays, "NPZ file");
            warn(&format!("{files} left out: `compare` reads pictures alone"));
        }
        if count == 0 {
            return Err(Error::Usage("there is no picture in the folders".to_owned()).into());
        }
        for name in &pairs.both {
            let map = self.args.output.as_ref().map(|folder| map_path(folder, name));
            self.pair(&reference.join(name), &test.join(name), map.as_deref(), false)?;
        }
        for name in &pairs.missing {
            self.fail(&reference.join(name), &test.join(name), "the picture is missing")?;
        }
        for name in &pairs.added {
            if !self.updates(&reference.join(name), &test.join(name))? {
                self.fail(&reference.join(name), &test.join(name), "there is no reference")?;
            }
        }
        Ok(count)
    }

    /// Compares two pictures. Where they cannot be compared, that is the error of a pair `alone`, and one of a folder is counted.
    fn pair(&mut self, reference: &Path, test: &Path, map: Option<&Path>, alone: bool) -> anyhow::Result<()> {
        match compare(reference, test, self.args.limit as f32, &self.files) {
            Ok(comparison) => self.compared(reference, test, map, &comparison),
            Err(
                error @ (CompareError::Size { .. }
                | CompareError::Window { .. }
                | CompareError::Range
                | CompareError::DataRange
                | CompareError::Data { .. }),
            ) => {
                if self.updates(reference, test)? {
                    return Ok(());
                }
                self.fail(reference, test, &error.to_string())
            }
            Err(CompareError::Image(error))
                if alone && self.args.update && error.is_missing() && !reference.exists() =>
            {
                self.updates(reference, test).map(drop)
            }
            Err(error) if alone => Err(Error::from(error).into()),
            Err(error) => self.fail(reference, test, &error.to_string()),
        }
    }

    fn compared(
        &mut self,
        reference: &Path,
        test: &Path,
        map: Option<&Path>,
        comparison: &Comparison,
    ) -> anyhow::Result<()> {
        let Comparison {
            measures,
            means,
            not_finite,
            ..
        } = comparison;
        let within = self.args.accepts(measures) && not_finite[0] == not_finite[1];
        if let Some(map) = map {
            write_map(map, comparison)?;
        }
        let line = Line {
            reference,
            test,
            measures: Some(*measures),
            reference_mean: Some(means[0]),
            test_mean: Some(means[1]),
            not_finite: Some(*not_finite),
            within_tolerance: within,
            error: None,
        };
        self.print(&line, test, || {
            let mut text = format!(
                "FLIP {:.5}, RMSE {:.5}, relMSE {:.5}, largest difference {:.5}, {:.3} % of pixels differ; mean {} (reference {})",
                measures.flip,
                measures.rmse,
                measures.relmse,
                measures.largest,
                100.0 * measures.pixels,
                triple(means[1]),
                triple(means[0]),
            );
            if measures.alpha_rmse > 0.0 {
                text.push_str(&format!("; alpha RMSE {:.5}", measures.alpha_rmse));
            }
            if *not_finite != [0, 0] {
                let [reference, test] = not_finite;
                text.push_str(&format!("; {test} numbers are not finite (reference {reference})"));
            }
            if !within {
                text.push_str("; beyond the tolerance");
            }
            text
        })?;
        let within = self.passes(reference, test)? && within;
        if !within && !self.updates(reference, test)? {
            self.beyond += 1;
        }
        Ok(())
    }

    /// Compares the passes that were asked for, a line each; returns whether all are within the tolerance.
    fn passes(&self, reference: &Path, test: &Path) -> anyhow::Result<bool> {
        let Some(names) = &self.args.passes else {
            return Ok(true);
        };
        // As `--aovs all`.
        let names = if names == &["all"] { &[][..] } else { names };
        let passes = compare_passes([reference, test], names, self.args.limit, &self.files);
        let mut all_within = true;
        for ComparedPass { name, measures } in passes.map_err(CompareError::from).map_err(Error::from)? {
            let within = measures.is_ok_and(|measures| self.args.accepts_pass(&measures));
            all_within &= within;
            let line = PassLine {
                reference,
                test,
                pass: &name,
                measures: measures.ok(),
                within_tolerance: within,
                error: measures.err(),
            };
            self.print(&line, test, || {
                let shown = if name.is_empty() { "R, G, B, A" } else { &name };
                let mut text = match &measures {
                    Err(error) => format!("{shown}: {error}"),
                    Ok(PassMeasures { rmse, largest, pixels }) => {
                        let numbers = rmse.zip(*largest).map_or_else(String::new, |(rmse, largest)| {
                            format!("RMSE {rmse:.5}, largest difference {largest:.5}, ")
                        });
                        format!("{shown}: {numbers}{:.3} % of pixels differ", 100.0 * pixels)
                    }
                };
                if measures.is_ok() && !within {
                    text.push_str("; beyond the tolerance");
                }
                text
            })?;
        }
        Ok(all_within)
    }

    /// Copies a test over its reference where that was asked for.
    fn updates(&mut self, reference: &Path, test: &Path) -> anyhow::Result<bool> {
        if !self.args.update {
            return Ok(false);
        }
        let bytes = self
            .files
            .read(test)
            .map_err(|source| Error::Usage(format!("cannot read the picture: {source}: {}", test.display())))?;
        create_folder_of(reference)?;
        atomic::write(reference, |out| Ok(out.write_all(&bytes)?)).map_err(Error::Output)?;
        self.updated += 1;
        Ok(true)
    }

    fn fail(&mut self, reference: &Path, test: &Path, error: &str) -> anyhow::Result<()> {
        self.beyond += 1;
        let line = Line {
            reference,
            test,
            measures: None,
            reference_mean: None,
            test_mean: None,
            not_finite: None,
            within_tolerance: false,
            error: Some(error.to_owned()),
        };
        self.print(&line, test, || error.to_owned())
    }

    fn print(&self, line: &impl Serialize, test: &Path, text: impl FnOnce() -> String) -> anyhow::Result<()> {
        if self.quiet && !self.args.json {
            return Ok(());
        }
        let text = if self.args.json {
            serde_json::to_string(line)?
        } else {
            format!("{}: {}", test.display(), text())
        };
        match writeln!(io::stdout().lock(), "{text}") {
            Err(error) if !is_closed_pipe(&error) => Err(Error::Stdout(error).into()),
            _ => Ok(()),
        }
    }
}

fn triple(mean: [f64; 3]) -> String {
    mean.map(|v| format!("{v:.4}")).join(" ")
}

/// The map of the picture `name`: `differences/a/frame.0001.exr.png`, because pictures may differ by their endings only.
fn map_path(folder: &Path, name: &Path) -> PathBuf {
    let mut path = folder.join(name).into_os_string();
    path.push(".png");
    path.into()
}

fn write_map(path: &Path, comparison: &Comparison) -> anyhow::Result<()> {
    create_folder_of(path)?;
    let [width, height] = comparison.size;
    let bytes: Vec<u8> = comparison.flip.iter().flat_map(|error| heat::color(*error)).collect();
    let written = atomic::write(path, |out| {
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        Ok(writer.finish()?)
    });
    Ok(written.map_err(Error::Output)?)
}

fn create_folder_of(path: &Path) -> Result<(), Error> {
    let folder = atomic::folder_of(path);
    fs::create_dir_all(&folder).map_err(|source| cannot_create(source, &folder))
}
