use super::stages::StageClock;
use kiln_formats::{Control, Stopped};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Stack of the thread that works: importers may recurse as deep as the limit on nesting allows.
const STACK_BYTES: usize = 16 << 20;
/// How often the one who waits looks whether somebody asks for a stop.
const PATIENCE: Duration = Duration::from_millis(50);

/// Does work that may look at its control less often than a deadline needs (a decoder of somebody else, a sort of ten
/// million triangles), and gives its result with the CPU seconds of its thread.
///
/// With a deadline the work runs on a thread of its own that is left behind when it is late: it ends at its next look
/// at the control. Without one it runs here. It is not to panic.
///
/// # Errors
/// [`Stopped`] at the deadline.
pub(super) fn by_deadline<T: Send + 'static>(
    control: &Control,
    work: impl FnOnce(&Control) -> T + Send + 'static,
) -> Result<(T, f64), Stopped> {
    let timed = move |control: &Control| {
        let clock = StageClock::begin();
        let result = work(control);
        (result, clock.seconds().1)
    };
    let Some(deadline) = control.deadline() else { return Ok(timed(control)) };
    let (sender, receiver) = channel();
    let own = control.clone();
    // When the one who waits has gone, nobody wants the result.
    let run = move || drop(sender.send(timed(&own)));
    let builder = std::thread::Builder::new().name("by-deadline".into()).stack_size(STACK_BYTES);
    // Without threads nothing can be done by anybody.
    builder.spawn(run).map_err(|_| Stopped)?;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        match receiver.recv_timeout(left.min(PATIENCE)) {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Timeout) if left.is_zero() => return Err(Stopped),
            // Who is asked to stop, stops in order: what it has read is still reported.
            Err(RecvTimeoutError::Timeout) => (),
            Err(RecvTimeoutError::Disconnected) => return Err(Stopped),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_does_not_look_is_left_behind() {
        let soon = Control::default().until(Instant::now() + Duration::from_millis(40));
        let clock = Instant::now();
        let late = by_deadline(&soon, |_| std::thread::sleep(Duration::from_secs(20)));
        assert_eq!(late.map(|_| ()), Err(Stopped));
        assert!(clock.elapsed() < Duration::from_secs(10), "{:?}", clock.elapsed());
        let later = Control::default().until(Instant::now() + Duration::from_secs(60));
        assert_eq!(by_deadline(&later, |control| control.is_stopped()).map(|r| r.0), Ok(false));
        assert_eq!(by_deadline(&Control::default(), |_| 7).map(|r| r.0), Ok(7));
    }
}
