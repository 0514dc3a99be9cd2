//! Values that a name chooses: the command line's before the scene file's.

use crate::{
    error::Error,
    value::{Problem, Spanned, UnknownName},
};

/// The value that the name given on the command line has, or else the one in the scene file; `None` where there is neither. The
/// first of `what` is what it is a name of, the second the flag.
///
/// # Errors
/// The command line's name is unknown. The inner error is about that of the scene file.
pub(super) fn choose<T>(
    what: (&str, &str),
    (requested, described): (&Option<String>, &Option<Spanned<String>>),
    from_name: impl Fn(&str) -> Option<T>,
    known: impl Iterator<Item = &'static str>,
) -> Result<Result<Option<T>, Problem>, Error> {
    let (kind, flag) = what;
    let value = |name: &str| from_name(name).ok_or_else(|| UnknownName::new(kind, name, known));
    match (requested, described) {
        (Some(name), _) => match value(name) {
            Ok(value) => Ok(Ok(Some(value))),
            Err(unknown) => Err(Error::Usage(format!("{flag}: {unknown}"))),
        },
        (None, Some(name)) => Ok(value(name.get_ref())
            .map(Some)
            .map_err(|unknown| unknown.at(name.span()))),
        (None, None) => Ok(Ok(None)),
    }
}
