use super::exit::Exit;
use kiln::Control;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ctrl-C: the first stops the work in order, the second ends the program at once.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    happened: Arc<AtomicBool>,
}

impl Interrupt {
    /// Watches from now on.
    pub fn watch(control: &Control) -> Self {
        let interrupt = Self::default();
        let (happened, control) = (interrupt.happened.clone(), control.clone());
        let handler = move || {
            if happened.swap(true, Ordering::SeqCst) {
                std::process::exit(Exit::Interrupted as i32);
            }
            control.stop();
        };
        if let Err(error) = ctrlc::set_handler(handler) {
            eprintln!("warning: Ctrl-C will end the program at once: {error}");
        }
        interrupt
    }

    /// Whether there was one.
    pub fn happened(&self) -> bool {
        self.happened.load(Ordering::SeqCst)
    }
}
