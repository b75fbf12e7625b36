//! The one error type of the program, and the exit codes that scripts see.

use spectral_core::shown_lines;
use std::path::{Path, PathBuf};

/// Why a command did not do what it was asked to.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// An input file that is missing, unreadable, truncated, or not what its name says.
    #[error("{}: {message}", told(path))]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what would be right.
        message: String,
    },
    /// A scene file that does not say what a scene file can say.
    #[error("{}, line {line}: {message}", told(path))]
    Scene {
        /// The scene file.
        path: PathBuf,
        /// 1-based line.
        line: usize,
        /// What is wrong there and what would be right.
        message: String,
    },
    /// What the core refuses where no file is to blame, such as a figure of the command line, and devices that fail.
    #[error(transparent)]
    Core(#[from] spectral_core::Error),
    /// A device that cannot be opened or that failed while rendering.
    #[error("{device}: {message}")]
    Render {
        /// The backend or the device.
        device: String,
        /// What failed.
        message: String,
    },
    /// A file that cannot be written.
    #[error("{}: {message}", told(path))]
    Output {
        /// The file.
        path: PathBuf,
        /// Why, and what can be done.
        message: String,
    },
    /// A scene that is in no file, being one of a batch, and does not say what a scene can say.
    #[error("{0}")]
    Item(String),
    /// Items of a batch that failed or are missing, by their names.
    #[error("{0}")]
    Items(String),
    /// A command line that does not make sense.
    #[error("{0}")]
    Usage(String),
    /// Ctrl-C; what was finished has been written.
    #[error("interrupted")]
    Interrupted,
}

/// A path as a message shows it.
fn told(path: &Path) -> String {
    shown_lines(&path.display().to_string())
}

impl Error {
    /// An [`Error::File`].
    pub fn file(path: impl Into<PathBuf>, message: impl ToString) -> Self {
        Error::File { path: path.into(), message: message.to_string() }
    }

    /// An [`Error::Output`].
    pub fn output(path: impl Into<PathBuf>, message: impl ToString) -> Self {
        Error::Output { path: path.into(), message: message.to_string() }
    }

    /// What the process returns to the shell: 0 is success, 1 a render or device that failed, 2 a command
    /// line that does not make sense, 3 bad input, 4 output that cannot be written, 5 a batch of which some items
    /// failed or are missing, 130 an interruption.
    ///
    /// ```
    /// assert_eq!(gemtrace::Error::Usage("which scene?".into()).exit_code(), 2);
    /// ```
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Render { .. } => 1,
            Error::Core(spectral_core::Error::Device { .. } | spectral_core::Error::Memory { .. }) => 1,
            Error::Usage(_) => 2,
            Error::File { .. } | Error::Scene { .. } | Error::Item(_) | Error::Core(_) => 3,
            Error::Output { .. } => 4,
            Error::Items(_) => 5,
            Error::Interrupted => 130,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_file_and_the_line() {
        let error = Error::Scene { path: "a/b.toml".into(), line: 12, message: "unknown key".into() };
        assert_eq!(error.to_string(), "a/b.toml, line 12: unknown key");
        assert_eq!(Error::file("x.obj", "no such file").to_string(), "x.obj: no such file");
    }

    #[test]
    fn every_failure_has_its_exit_code() {
        let core = spectral_core::Error::value("fov", 0, "more");
        let codes = [
            Error::Render { device: "cpu".into(), message: String::new() },
            Error::Usage(String::new()),
            Error::Core(core),
            Error::Core(spectral_core::Error::Device { device: "cpu".into(), message: String::new() }),
            Error::Core(spectral_core::Error::Memory { what: String::new(), bytes: 0 }),
            Error::output("x.png", ""),
            Error::Item(String::new()),
            Error::Items(String::new()),
            Error::Interrupted,
        ]
        .map(|e| e.exit_code());
        assert_eq!(codes, [1, 2, 3, 1, 1, 4, 3, 5, 130]);
    }
}
