//! Memory that may not be there: what a scene asks for is asked of the system first, so that a lack of it is an error.

use crate::Error;

/// Whether so many bytes can be had at once.
///
/// # Errors
/// [`Error::Memory`] naming them.
///
/// ```
/// use spectral_core::memory;
/// assert!(memory::check(1 << 20, || "a megabyte".into()).is_ok());
/// let error = memory::check(u64::MAX, || "everything".into()).unwrap_err();
/// assert_eq!(error.to_string(), "not enough memory: everything needs 17179869184.0 GiB");
/// ```
pub fn check(bytes: u64, what: impl FnOnce() -> String) -> Result<(), Error> {
    reserved::<u8>(usize::try_from(bytes).unwrap_or(usize::MAX), what).map(drop)
}

/// An empty list with room for `count` items.
///
/// # Errors
/// [`Error::Memory`] naming what does not fit.
pub fn reserved<T>(count: usize, what: impl FnOnce() -> String) -> Result<Vec<T>, Error> {
    let mut list = Vec::new();
    match list.try_reserve_exact(count) {
        Ok(()) => Ok(list),
        Err(_) => Err(Error::Memory { what: what(), bytes: count as u64 * size_of::<T>().max(1) as u64 }),
    }
}
