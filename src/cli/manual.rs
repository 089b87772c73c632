use super::Cli;
use super::exit::{Exit, Fatal};
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use kiln::write::atomic;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

const COMPLETIONS: &str = "\
Examples:
  kiln completions bash > ~/.local/share/bash-completion/completions/kiln
  kiln completions zsh > ~/.zfunc/_kiln                 with fpath+=~/.zfunc before compinit in ~/.zshrc
  kiln completions fish > ~/.config/fish/completions/kiln.fish
  kiln completions powershell >> $PROFILE";

/// `kiln completions`.
#[derive(Args)]
#[command(after_help = COMPLETIONS)]
pub struct CompletionsCommand {
    /// The shell
    shell: Shell,
}

impl CompletionsCommand {
    /// Does it.
    ///
    /// # Errors
    /// When stdout cannot be written to.
    pub fn run(self) -> Result<Exit, Fatal> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "kiln", &mut script);
        print(&script)
    }
}

const MAN: &str = "\
Examples:
  kiln man | man -l -                                   kiln(1)
  kiln man batch | man -l -                             kiln-batch(1)
  kiln man --out ~/.local/share/man/man1                all pages, so that man kiln-batch finds them";

/// `kiln man`.
#[derive(Args)]
#[command(after_help = MAN)]
pub struct ManCommand {
    /// The page of a subcommand, instead of the program's
    subcommand: Option<String>,
    /// Write all pages into this folder
    #[arg(long, value_name = "DIR", conflicts_with = "subcommand")]
    out: Option<PathBuf>,
}

impl ManCommand {
    /// Does it.
    ///
    /// # Errors
    /// When there is no such subcommand or something cannot be written.
    pub fn run(self) -> Result<Exit, Fatal> {
        let pages = pages().map_err(|e| Fatal::failed(e.to_string()))?;
        if let Some(folder) = &self.out {
            for (name, page) in &pages {
                let path = folder.join(format!("{name}.1"));
                let unwritable = |e| Fatal::failed(format!("{}: cannot be written: {e}", path.display()));
                atomic::write(&path, page).map_err(unwritable)?;
            }
            return Ok(Exit::Done);
        }
        let wanted = self.subcommand.as_ref().map_or("kiln".into(), |name| format!("kiln-{name}"));
        match pages.iter().find(|(name, _)| *name == wanted) {
            Some((_, page)) => print(page),
            None => Err(Fatal::usage(format!("there is no subcommand '{}'", self.subcommand.unwrap_or_default()))),
        }
    }
}

/// Name and text of each page.
fn pages() -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let mut command = Cli::command();
    command.build();
    let visible = command.get_subcommands().filter(|s| !s.is_hide_set() && s.get_name() != "help").cloned();
    let subcommands = visible.map(|s| (format!("kiln-{}", s.get_name()), s));
    let all = std::iter::once(("kiln".to_owned(), command.clone())).chain(subcommands);
    all.map(|(name, command)| {
        let mut page = Vec::new();
        Man::new(command).render(&mut page)?;
        Ok((name, page))
    })
    .collect()
}

fn print(bytes: &[u8]) -> Result<Exit, Fatal> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        // A reader that has seen enough.
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(Exit::Done),
        Err(e) => Err(Fatal::failed(format!("stdout cannot be written to: {e}"))),
        Ok(()) => Ok(Exit::Done),
    }
}
