use kiln::batch::{Outcome, Status};
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
    /// For these outcomes; `whole` tells whether everything that was asked for is among them.
    pub fn of(outcomes: &[Outcome], whole: bool, interrupted: bool) -> Self {
        let done = outcomes.iter().filter(|o| o.status.is_done()).count();
        let some = outcomes.iter().any(|o| o.status == Status::Partial);
        if interrupted {
            Self::Interrupted
        } else if done == 0 && !some {
            Self::Failed
        } else if done == outcomes.len() && whole {
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

    fn outcomes(statuses: &[Status]) -> Vec<Outcome> {
        statuses.iter().map(|s| Outcome { status: *s, ..Outcome::skipped("a.glb", 0) }).collect()
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
