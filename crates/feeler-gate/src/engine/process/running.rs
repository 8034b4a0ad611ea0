//! A program that runs, by its three pipes.
//!
//! Each pipe has a thread of its own, so that neither a program that does not read, nor one that writes without
//! end, holds up who waits with a deadline.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// No answer is near as long: 64 MiB. A program that writes more without a line's end has ended for us.
const LONGEST_LINE: u64 = 1 << 26;
/// So many lines ahead a program may be before it has to wait.
const LINES_AHEAD: usize = 16;
/// How much of a program's complaint is kept.
const COMPLAINT: usize = 300;
/// How long a program may take to end after its standard input has ended; then it is killed.
const GRACE: Duration = Duration::from_secs(1);
/// How long its last words on standard error are waited for.
const LAST_WORDS: Duration = Duration::from_secs(1);
/// How often it is looked whether it has ended.
const LOOK: Duration = Duration::from_millis(2);

/// Why there is no line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Silence {
    /// Not in time.
    Late,
    /// The program has ended, or has closed its standard output.
    Ended,
}

/// A program that runs. Dropped, it is killed.
#[derive(Debug)]
pub(super) struct Running {
    child: Child,
    /// None once its standard input has ended.
    to: Option<Sender<String>>,
    from: Receiver<String>,
    complaint: Arc<Mutex<String>>,
    /// Disconnected when standard error has ended.
    complained: Receiver<()>,
}

impl Running {
    pub(super) fn start(words: &[String]) -> Result<Self, String> {
        let (program, arguments) = words.split_first().ok_or("no command line")?;
        let mut child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|e| format!("`{program}` cannot be started: {e}; check the command line"))?;
        let pipes = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(mut input), Some(output), Some(errors)) = pipes else {
            return Err("no pipes".to_owned());
        };

        let (to, lines) = channel::<String>();
        thread::spawn(move || {
            for line in lines {
                if input.write_all(line.as_bytes()).and(input.flush()).is_err() {
                    break;
                }
            }
        });

        let (send, from) = sync_channel(LINES_AHEAD);
        thread::spawn(move || {
            let mut output = BufReader::new(output);
            while let Some(line) = next_line(&mut output) {
                if send.send(line).is_err() {
                    break;
                }
            }
        });

        let complaint = Arc::new(Mutex::new(String::new()));
        let (done, complained) = channel::<()>();
        let last = Arc::clone(&complaint);
        thread::spawn(move || {
            // Dropped with the thread.
            let _done = done;
            let mut errors = BufReader::new(errors);
            while let Some(line) = next_line(&mut errors) {
                let line = line.trim();
                if !line.is_empty() {
                    let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
                    *last = line.chars().take(COMPLAINT).collect();
                }
            }
        });
        Ok(Self {
            child,
            to: Some(to),
            from,
            complaint,
            complained,
        })
    }

    /// Sends a line. Whether it arrives shows in what comes back.
    pub(super) fn send(&mut self, mut line: String) {
        line.push('\n');
        if let Some(to) = &self.to {
            let _ = to.send(line);
        }
    }

    /// The next line.
    pub(super) fn line(&mut self, deadline: Instant) -> Result<String, Silence> {
        let left = deadline.saturating_duration_since(Instant::now());
        self.from.recv_timeout(left).map_err(|e| match e {
            RecvTimeoutError::Timeout => Silence::Late,
            RecvTimeoutError::Disconnected => Silence::Ended,
        })
    }

    /// How it ended, with its last words.
    pub(super) fn end(&mut self) -> String {
        let _ = self.complained.recv_timeout(LAST_WORDS);
        let status = match self.wait(LAST_WORDS) {
            Some(status) => format!("it ended ({status})"),
            None => "it closed its standard output".to_owned(),
        };
        let last = self
            .complaint
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        match last.as_str() {
            "" => status,
            words => format!("{status}: {words}"),
        }
    }

    fn wait(&mut self, within: Duration) -> Option<std::process::ExitStatus> {
        let deadline = Instant::now() + within;
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) if Instant::now() < deadline => thread::sleep(LOOK),
                _ => return None,
            }
        }
    }

    /// Ends its standard input and lets it end by itself, for a while.
    pub(super) fn stop(mut self) {
        self.to = None;
        self.wait(GRACE);
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself; that is as well.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The next line, whatever its bytes; none at the end, or where it is longer than any answer.
fn next_line(from: &mut impl BufRead) -> Option<String> {
    let mut bytes = Vec::new();
    let read = from.take(LONGEST_LINE).read_until(b'\n', &mut bytes).ok()?;
    let whole = bytes.last() == Some(&b'\n') || (read as u64) < LONGEST_LINE;
    (read > 0 && whole).then(|| String::from_utf8_lossy(&bytes).into_owned())
}
