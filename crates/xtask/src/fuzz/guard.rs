//! A guard over the engine's processes: one that stands still is ended, and the engine begins another.
//!
//! libFuzzer allocates in its handler of alarms. One that comes while an input frees memory waits for a lock that its own thread holds, and the process
//! that watches it has no limit of its own. Such a process sleeps and takes no processor; one that computes may be given none for minutes on a busy machine, but
//! is ready to run.

use std::collections::{BTreeMap, BTreeSet};
use std::process::{Child, Command};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A process that sleeps for that long without a tick of the processor stands still: no target waits for anything but its memory and its files.
pub(super) const STILL: Duration = Duration::from_secs(180);

pub(super) struct Guard {
    /// Dropped to end the thread.
    go_on: Sender<()>,
    thread: JoinHandle<usize>,
}

impl Guard {
    /// Looks after a process and all that it starts. Where there is no `/proc`, nothing is seen to stand still.
    pub(super) fn over(child: &Child, still: Duration) -> Self {
        let (go_on, ended) = channel::<()>();
        let root = child.id();
        let thread = std::thread::spawn(move || {
            let mut seen: BTreeMap<u32, (u64, Instant)> = BTreeMap::new();
            let mut count = 0;
            while ended.recv_timeout(still / 10) == Err(RecvTimeoutError::Timeout) {
                let now = asleep(root);
                seen.retain(|id, _| now.contains_key(id));
                for (id, ticks) in now {
                    let (before, since) = seen.entry(id).or_insert((ticks, Instant::now()));
                    if *before != ticks {
                        (*before, *since) = (ticks, Instant::now());
                    } else if since.elapsed() > still {
                        let id = id.to_string();
                        let _ = Command::new("kill").args(["-KILL", &id]).status();
                        *since = Instant::now();
                        count += 1;
                    }
                }
            }
            count
        });
        Self { go_on, thread }
    }

    /// How many processes it has ended.
    pub(super) fn count(self) -> usize {
        drop(self.go_on);
        self.thread.join().unwrap_or(0)
    }
}

/// Of a process and all below it those that sleep and wait for no other, with the ticks of the processor that each has had.
fn asleep(root: u32) -> BTreeMap<u32, u64> {
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let texts = entries.map(|e| std::fs::read_to_string(e.path().join("stat")));
    let all: Vec<Process> = texts.filter_map(|t| process(&t.ok()?)).collect();
    let mut below = BTreeSet::from([root]);
    loop {
        let more = all.iter().filter(|p| below.contains(&p.parent));
        let more: BTreeSet<u32> = more.map(|p| p.id).collect();
        let before = below.len();
        below.extend(more);
        if below.len() == before {
            break;
        }
    }
    let waits = |id: u32| all.iter().any(|p| p.parent == id);
    let still = |p: &&Process| below.contains(&p.id) && p.sleeps && !waits(p.id);
    let some = all.iter().filter(still);
    some.map(|p| (p.id, p.ticks)).collect()
}

#[derive(Debug, PartialEq)]
struct Process {
    id: u32,
    parent: u32,
    sleeps: bool,
    ticks: u64,
}

/// From a line of `/proc/PID/stat` (proc(5)); nothing of one that has ended.
fn process(stat: &str) -> Option<Process> {
    // The name stands in parentheses and may hold any.
    let (id, rest) = (stat.split(' ').next()?, &stat[stat.rfind(')')? + 1..]);
    let fields: Vec<&str> = rest.split_whitespace().collect();
    let ticks = |i: usize| fields.get(i)?.parse::<u64>().ok();
    let state = *fields.first()?;
    if state == "Z" {
        return None;
    }
    Some(Process {
        id: id.parse().ok()?,
        parent: fields.get(1)?.parse().ok()?,
        sleeps: state == "S",
        ticks: ticks(11)? + ticks(12)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(line: &str) -> Child {
        Command::new("sh").args(["-c", line]).spawn().unwrap()
    }

    #[test]
    fn a_line_of_proc() {
        let line = "17 (a ) b) S 4 17 17 0 -1 4194560 9 0 0 0 300 21 0 0 39 19 1 0 5 6";
        let sleeper = Process {
            id: 17,
            parent: 4,
            sleeps: true,
            ticks: 321,
        };
        assert_eq!(process(line), Some(sleeper));
        assert!(process(&line.replace(" S ", " R ")).is_some_and(|p| !p.sleeps));
        assert_eq!(process(&line.replace(" S ", " Z ")), None);
        assert_eq!(process("17 (a) S 4"), None);
    }

    /// A quarter of a second of standing still, below a shell that waits, and that goes on.
    #[test]
    #[cfg(target_os = "linux")]
    fn what_stands_still_is_ended_and_what_computes_is_not() {
        let still = Duration::from_millis(250);
        let mut child = shell("sleep 1000; exit 7");
        let guard = Guard::over(&child, still);
        assert_eq!(child.wait().unwrap().code(), Some(7));
        assert_eq!(guard.count(), 1);

        let mut child = shell("while :; do :; done");
        let guard = Guard::over(&child, still);
        std::thread::sleep(4 * still);
        assert!(child.try_wait().unwrap().is_none());
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(guard.count(), 0);
    }
}
