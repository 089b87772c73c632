use kiln::batch::{Status, Tally};
use std::process::ExitCode;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// All done.
    Done = 0,
    /// Nothing done.
    Failed = 1,
    /// Asked for wrongly.
    Usage = 2,
    /// Done in part.
    Partial = 3,
    /// Stopped by Ctrl-C.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

impl Exit {
    /// For what became of assets; `whole` tells whether everything that was asked for is among them.
    pub fn of(tally: &Tally, whole: bool, interrupted: bool) -> Self {
        let done = tally.done();
        if interrupted {
            Self::Interrupted
        } else if done == 0 && tally.count(Status::Partial) == 0 {
            Self::Failed
        } else if done == tally.all() && whole {
            Self::Done
        } else {
            Self::Partial
        }
    }
}

/// Why a command could not be done, in a sentence.
#[derive(Debug)]
pub struct Fatal {
    exit: Exit,
    message: String,
}

impl Fatal {
    /// Asked for wrongly.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { exit: Exit::Usage, message: message.into() }
    }

    /// Could not be done.
    pub fn failed(message: impl Into<String>) -> Self {
        Self { exit: Exit::Failed, message: message.into() }
    }

    /// Prints it and gives the exit code.
    pub fn report(self) -> Exit {
        eprintln!("error: {}", self.message);
        self.exit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kiln::batch::Outcome;

    fn outcomes(statuses: &[Status]) -> Tally {
        let outcomes = statuses.iter().map(|s| Outcome { status: *s, ..Outcome::skipped("a.glb", 0) });
        Tally::of(&outcomes.collect::<Vec<_>>())
    }

    #[test]
    fn codes_tell_how_much_was_done() {
        use Status::{Failed, Ok, Partial, Skipped, Warned};
        assert_eq!(Exit::of(&outcomes(&[Ok, Warned]), true, false), Exit::Done);
        assert_eq!(Exit::of(&outcomes(&[Ok, Warned]), false, false), Exit::Partial);
        assert_eq!(Exit::of(&outcomes(&[Ok, Failed]), true, false), Exit::Partial);
        assert_eq!(Exit::of(&outcomes(&[Partial]), true, false), Exit::Partial);
        assert_eq!(Exit::of(&outcomes(&[Failed, Failed]), true, false), Exit::Failed);
        assert_eq!(Exit::of(&outcomes(&[]), true, false), Exit::Failed);
        assert_eq!(Exit::of(&outcomes(&[Ok, Skipped]), true, true), Exit::Interrupted);
    }
}
