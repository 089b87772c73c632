//! `kiln.toml`: flags that a project writes down once.
//!
//! A key is a flag's long name, at the top for every command that has the flag, or in the table of one command. What the
//! command line says counts more. The file is looked for in the current folder and those above it, never where the assets
//! are: a folder from somewhere else must not decide what a command does.

use super::Cli;
use super::exit::Fatal;
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command, CommandFactory};
use kiln::settings::EnvironmentSettings;
use std::any::TypeId;
use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The file's name.
const NAME: &str = "kiln.toml";
/// Flags that are about the file, or ask for something else than work.
const NOT_IN_FILE: [&str; 5] = ["config", "no-config", "print-config", "help", "version"];

/// The program's arguments with those of the file put in.
pub struct Arguments {
    /// All of them, the program's name first.
    pub list: Vec<OsString>,
    /// The file, where there is one.
    pub file: Option<PathBuf>,
    /// Keys that count, each with its line.
    taken: Vec<(String, usize)>,
}

/// A key of the file.
struct Entry {
    key: String,
    /// The command whose table it is in.
    section: Option<String>,
    /// A flag's values; `None`: it is switched off.
    values: Option<Vec<String>>,
    line: usize,
}

/// Puts the flags of `kiln.toml`, or of the file that `--config` names, before those of the command line.
///
/// # Errors
/// When the file cannot be read or has a key or a value that no flag takes, with the line.
pub fn arguments(list: Vec<OsString>) -> Result<Arguments, Fatal> {
    let mut command = Cli::command();
    command.build();
    let plain = |list| Ok(Arguments { list, file: None, taken: Vec::new() });
    // What is wrong with the command line is told when it is parsed for good.
    let Ok(matches) = command.clone().ignore_errors(true).try_get_matches_from(&list) else { return plain(list) };
    let Some((name, given)) = matches.subcommand() else { return plain(list) };
    let Some(subcommand) = command.find_subcommand(name).filter(|s| !s.is_hide_set()) else { return plain(list) };
    if given.get_flag("no_config") {
        return plain(list);
    }
    let Some(path) = given.get_one::<PathBuf>("config").cloned().or_else(search) else { return plain(list) };
    let wrong = |line: usize, message: String| Fatal::usage(format!("{}:{line}: {message}", path.display()));
    let text =
        std::fs::read_to_string(&path).map_err(|e| Fatal::usage(format!("{}: cannot be read: {e}", path.display())))?;
    let entries = parse(&text).map_err(|(line, message)| wrong(line, message))?;
    for entry in &entries {
        known(&command, entry).map_err(|message| wrong(entry.line, message))?;
    }
    // A command's own table counts more than the top.
    let own = |key: &str| entries.iter().any(|e| e.key == key && e.section.as_deref() == Some(name));
    let mut put_in = Vec::new();
    let mut taken = Vec::new();
    for entry in &entries {
        let here = entry.section.as_deref().map_or(!own(&entry.key), |section| section == name);
        let Some(arg) = find(subcommand, &entry.key).filter(|_| here) else { continue };
        if is_overruled(subcommand, arg, given) {
            continue;
        }
        let Some(values) = &entry.values else { continue };
        let tokens = tokens(arg, values, path.parent().unwrap_or(Path::new("")));
        check(&command, name, &tokens).map_err(|message| wrong(entry.line, message))?;
        put_in.extend(tokens);
        taken.push((entry.key.clone(), entry.line));
    }
    let mut list = list;
    let place = place_of(&list, name);
    list.splice(place..place, put_in);
    Ok(Arguments { list, file: Some(path), taken })
}

/// The file in the current folder or the nearest one above it.
fn search() -> Option<PathBuf> {
    let here = std::env::current_dir().ok()?;
    here.ancestors().map(|folder| folder.join(NAME)).find(|path| path.is_file())
}

fn find<'a>(command: &'a Command, key: &str) -> Option<&'a Arg> {
    command.get_arguments().find(|a| a.get_long() == Some(key) && !NOT_IN_FILE.contains(&key))
}

/// That some command has the flag.
fn known(command: &Command, entry: &Entry) -> Result<(), String> {
    let key = &entry.key;
    match &entry.section {
        None => {
            let some = command.get_subcommands().any(|s| find(s, key).is_some());
            if some { Ok(()) } else { Err(format!("no command has a flag '{key}'")) }
        }
        Some(name) => match command.find_subcommand(name) {
            None => Err(format!("there is no command '{name}'")),
            Some(subcommand) if find(subcommand, key).is_none() => Err(format!("kiln {name} has no flag '{key}'")),
            Some(_) => Ok(()),
        },
    }
}

/// Whether the command line has the flag itself, or one that it cannot stand beside.
fn is_overruled(command: &Command, arg: &Arg, given: &ArgMatches) -> bool {
    let is_given = |a: &Arg| given.value_source(a.get_id().as_str()) == Some(ValueSource::CommandLine);
    let excludes = |a: &Arg, b: &Arg| command.get_arg_conflicts_with(a).iter().any(|c| c.get_id() == b.get_id());
    let others = || command.get_arguments().filter(|a| is_given(a));
    is_given(arg) || others().any(|other| excludes(arg, other) || excludes(other, arg))
}

/// A flag as the command line has it. Paths are relative to the file's folder.
fn tokens(arg: &Arg, values: &[String], folder: &Path) -> Vec<OsString> {
    let key = arg.get_long().unwrap_or_default();
    if !arg.get_action().takes_values() {
        return vec![format!("--{key}").into()];
    }
    let is_path = arg.get_value_parser().type_id() == TypeId::of::<PathBuf>();
    let is_picture = |value: &str| key == "env" && matches!(value.parse(), Ok(EnvironmentSettings::File(_)));
    let token = |value: &String| {
        let mut token = OsString::from(format!("--{key}="));
        if is_path || is_picture(value) {
            token.push(folder.join(value))
        } else {
            token.push(value)
        }
        token
    };
    values.iter().map(token).collect()
}

/// That the flag takes the value.
fn check(command: &Command, name: &str, tokens: &[OsString]) -> Result<(), String> {
    let list = [OsString::from("kiln"), name.into()].into_iter().chain(tokens.iter().cloned());
    match command.clone().try_get_matches_from(list) {
        Err(e) if e.kind() != ErrorKind::MissingRequiredArgument => {
            let text = e.to_string();
            let first = text.lines().next().unwrap_or_default();
            Err(first.trim_start_matches("error: ").to_owned())
        }
        _ => Ok(()),
    }
}

/// Where a command's flags begin.
fn place_of(list: &[OsString], name: &str) -> usize {
    let is_value = |index: usize| index > 0 && list[index - 1] == "--config";
    let found = (1..list.len()).find(|i| list[*i] == name && !is_value(*i));
    found.map_or(list.len(), |index| index + 1)
}

/// The keys of a file, or the line and what is wrong there.
fn parse(text: &str) -> Result<Vec<Entry>, (usize, String)> {
    let line =
        |span: Range<usize>| 1 + text.as_bytes()[..span.start.min(text.len())].iter().filter(|b| **b == b'\n').count();
    let table = DeTable::parse(text).map_err(|e| (line(e.span().unwrap_or(0..0)), e.message().to_owned()))?;
    let mut entries = Vec::new();
    for (key, value) in table.get_ref() {
        match value.get_ref() {
            DeValue::Table(section) => {
                for (inner, value) in section {
                    let at = line(inner.span());
                    let values = values(value).map_err(|message| (at, format!("'{}': {message}", inner.get_ref())))?;
                    let (key, section) = (inner.get_ref().to_string(), Some(key.get_ref().to_string()));
                    entries.push(Entry { key, section, values, line: at });
                }
            }
            _ => {
                let at = line(key.span());
                let values = values(value).map_err(|message| (at, format!("'{}': {message}", key.get_ref())))?;
                entries.push(Entry { key: key.get_ref().to_string(), section: None, values, line: at });
            }
        }
    }
    // Tables are sorted by name; people read lines.
    entries.sort_by_key(|e| e.line);
    Ok(entries)
}

fn values(value: &Spanned<DeValue>) -> Result<Option<Vec<String>>, String> {
    let one = |value: &DeValue| match value {
        DeValue::String(text) => Ok(text.to_string()),
        DeValue::Integer(number) => Ok(number.as_str().to_owned()),
        DeValue::Float(number) => Ok(number.as_str().to_owned()),
        DeValue::Boolean(true) => Ok(String::new()),
        _ => Err("is neither a text, a number, true, false nor a list of them".to_owned()),
    };
    match value.get_ref() {
        DeValue::Boolean(false) => Ok(None),
        DeValue::Array(list) => list.iter().map(|v| one(v.get_ref())).collect::<Result<_, _>>().map(Some),
        other => one(other).map(|text| Some(vec![text])),
    }
}

impl Arguments {
    /// All flags of a command as they count, in the form of the file, each with where it comes from.
    pub fn text(&self, matches: &ArgMatches) -> String {
        let mut command = Cli::command();
        command.build();
        let Some((name, given)) = matches.subcommand() else { return String::new() };
        let Some(subcommand) = command.find_subcommand(name) else { return String::new() };
        let mut lines = vec![format!("[{name}]")];
        for arg in subcommand.get_arguments() {
            let (id, Some(key)) = (arg.get_id().as_str(), arg.get_long()) else { continue };
            if NOT_IN_FILE.contains(&key) {
                continue;
            }
            let Some(source) = given.value_source(id) else { continue };
            let line = self.taken.iter().find(|(taken, _)| taken == key);
            let source = match (line, source, &self.file) {
                (Some((_, line)), _, Some(file)) => format!("{}:{line}", file.display()),
                (_, ValueSource::DefaultValue, _) => "default".into(),
                _ => "command line".into(),
            };
            lines.push(format!("{key} = {}  # {source}", shown(arg, given)));
        }
        lines.join("\n")
    }
}

/// A flag's value in TOML.
fn shown(arg: &Arg, given: &ArgMatches) -> String {
    let id = arg.get_id().as_str();
    if !arg.get_action().takes_values() {
        return given.get_flag(id).to_string();
    }
    let is_number = |text: &str| text.parse::<f64>().is_ok_and(f64::is_finite) && !text.starts_with('+');
    // A text of JSON is a text of TOML.
    let one = |text: &str| if is_number(text) { text.to_owned() } else { serde_json::json!(text).to_string() };
    let raw = given.get_raw(id).into_iter().flatten().map(|v| v.to_string_lossy());
    let values: Vec<String> = raw.map(|v| one(&v)).collect();
    match &values[..] {
        [value] => value.clone(),
        all => format!("[{}]", all.join(", ")),
    }
}
