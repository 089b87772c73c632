use std::io::{IsTerminal, Write};

/// What people see: how much, and whether with colours and moving bars.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    /// Only errors are told.
    pub quiet: bool,
    /// Every warning is told.
    pub verbose: bool,
    /// stderr is a terminal that can move its cursor.
    pub terminal: bool,
    /// Colours are welcome.
    pub color: bool,
}

impl Console {
    /// As the flags, the terminal and `NO_COLOR` (no-color.org) say.
    pub fn new(quiet: bool, verbose: bool) -> Self {
        let terminal = std::io::stderr().is_terminal() && std::env::var("TERM").as_deref() != Ok("dumb");
        let no_color = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
        Self { quiet, verbose, terminal, color: terminal && !no_color }
    }

    /// Text in an ANSI colour, where colours are welcome.
    pub fn paint(&self, text: &str, color: Color) -> String {
        if self.color { format!("\x1b[{}m{text}\x1b[0m", color as u8) } else { text.into() }
    }
}

/// A text with nothing in it that a terminal obeys, line ends too: names of files may hold anything.
pub fn harmless(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}

/// ANSI colours.
#[derive(Clone, Copy, Debug)]
pub enum Color {
    /// For failures.
    Red = 31,
    /// For what is done.
    Green = 32,
    /// For warnings.
    Yellow = 33,
}

/// Prints a line on stdout. A reader that has gone away is no reason to stop.
pub fn print_line(line: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "{line}");
}
