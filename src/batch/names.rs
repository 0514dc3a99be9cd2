//! Values that are selected by name, on the command line or in the scene file.

use std::str::FromStr;

use crate::{
    error::Error,
    value::{Problem, Spanned, UnknownName},
};

/// The value of the name that `flag` gives on the command line, or else of the name in the scene file; `None` without a name.
///
/// # Errors
/// The command line's name is unknown. The inner error is about that of the scene file.
pub(super) fn choose<T: FromStr<Err = UnknownName>>(
    flag: &str,
    (requested, described): (&Option<String>, &Option<Spanned<String>>),
) -> Result<Result<Option<T>, Problem>, Error> {
    if let Some(name) = requested {
        let value = name
            .parse()
            .map_err(|unknown| Error::Usage(format!("{flag}: {unknown}")))?;
        return Ok(Ok(Some(value)));
    }
    let described = described.as_ref().map(|name| {
        let value = name.get_ref().parse();
        value.map_err(|unknown: UnknownName| unknown.at(name.span()))
    });
    Ok(described.transpose())
}
