//! From files to files: one asset ([`run_asset`]), or folders of them ([`run()`]).
//!
//! Nothing here prints or exits; what happens is told to a [`Desk`] or an [`Observer`].

pub mod advice;
mod asset;
mod budget;
mod by_deadline;
mod digest;
mod discover;
mod environment;
mod exposure;
mod facts;
mod failure;
mod job;
mod ledger;
mod lock;
mod looks;
mod manifest;
mod merge;
mod outcome;
mod picture;
mod read;
mod ready;
mod run;
mod schedule;
mod selfcheck;
mod shard;
mod shoot;
mod sink;
mod stages;
mod tally;
mod view_file;
mod views;
mod work;
pub mod workers;

pub use asset::{Desk, run_asset, run_asset_with};
pub use digest::of_settings as settings_digest;
pub use discover::{Discovered, Discovery, Found, Unreadable, discover};
pub use environment::{LoadedEnvironment, lights_itself};
pub use facts::{AssetFacts, CameraFacts, LightFacts, MaterialFacts, TextureFacts};
pub use job::{Job, Output, Stage};
pub use ledger::{Ledger, Policy, Reason, Verdict};
pub use lock::OutputLock;
pub use manifest::{MANIFEST, Manifest};
pub use merge::{Merged, SHARD_NOTE, merge, note_shard};
pub use outcome::{DroppedRecord, LimitRecord, Outcome, OutputRecord, Rays, SceneFacts, StageSeconds, Status};
pub use ready::{Ready, make_ready};
pub use run::{Assignment, Observer, run};
pub use schedule::{Batch, Workshop, schedule};
pub use shard::{Engine, Shard, ShardChoice};
pub use sink::{FileSink, MemorySink, Sink};
pub use tally::{Tally, Warned};
pub use view_file::ViewFile;
pub use views::plan as plan_views;
pub(crate) use work::planned_rays;
