use crate::batch::{Job, Outcome, Stage};
use serde::{Deserialize, Serialize};

/// What a worker is told: one line of JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Request {
    /// Do this.
    Do(Box<Job>),
    /// Finish what you are at with what there is.
    Stop,
}

/// What a worker tells: one line of JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Report {
    /// The job has come to a stage.
    Stage(Stage),
    /// Steps done and steps in all of the stage.
    Progress(u64, u64),
    /// The job is done; the bytes that the worker still holds, where the system tells.
    Done(Box<Outcome>, Option<u64>),
}
