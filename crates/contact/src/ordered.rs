//! A list that several threads write together in the order that one thread would give.

#![allow(
    unsafe_code,
    reason = "parts are copied into the spare room of a list, whose length is set afterwards"
)]

use std::collections::VecDeque;
use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::Error;
use crate::memory::reserve;
use crate::pool::Pool;

/// Appends the parts `0..count` to `list`, in their order; `fill` writes one into an empty vector, on any
/// thread.
///
/// The length of a part is known when it is done. By then the parts before it are mostly done, or will be
/// soon. Its place in the list is then known, and the part is copied there while it is in cache. When the
/// list is full, the threads stop, and the list grows to its expected length if the rest is like the
/// beginning. The threads also stop when one thread that the system has suspended keeps many parts waiting.
/// `memory` keeps the vectors of parts for the next call.
///
/// # Errors
/// An error of `fill`, or [`Error::OutOfMemory`]; `list` then holds some of the entries.
pub(crate) fn append<V: Copy + Send>(
    list: &mut Vec<V>,
    count: usize,
    fill: impl Fn(usize, &mut Vec<V>) -> Result<(), Error> + Sync,
    pool: &Pool,
    memory: &mut Vec<Vec<V>>,
) -> Result<(), Error> {
    let before = list.len();
    let mut done = 0;
    while done < count {
        let line = Mutex::new(Line {
            first: done,
            next: done,
            count,
            threads: pool.threads(),
            lengths: Vec::new(),
            places: Vec::new(),
            placed: 0,
            room: list.spare_capacity_mut(),
            stopped: Ok(()),
            is_closed: false,
            waiting: Vec::new(),
            memory,
        });
        pool.run(0..pool.threads(), |_| work(&line, &fill));
        let mut line = line.into_inner().unwrap_or_else(PoisonError::into_inner);
        std::mem::replace(&mut line.stopped, Ok(()))?;
        done = line.next;
        let mut waiting = std::mem::take(&mut line.waiting);
        waiting.sort_unstable_by_key(|part| part.number);
        // The entries of parts for which there was no room.
        let mut left = Vec::new();
        for part in waiting {
            match line.place(part.number) {
                Some(place) => line.memory.push(part.move_to(place)),
                None => left.push(part.entries),
            }
        }
        let placed = line.placed;
        // SAFETY: places are handed out one after the other from the first free entry of the list on,
        // `placed` entries in all. Every part that was given one has been copied there, by its thread or
        // above: an error or a panic would have left this function before.
        unsafe { list.set_len(list.len() + placed) };

        let more = left.iter().map(Vec::len).sum::<usize>();
        let expected = (list.len() - before + more) as f64 / done as f64 * (count - done) as f64;
        if reserve(list, more.saturating_add((1.05 * expected) as usize)).is_err() {
            // There may still be memory for the entries found so far.
            reserve(list, more)?;
        }
        for entries in left {
            list.extend_from_slice(&entries);
            memory.push(entries);
        }
    }
    Ok(())
}

/// A thread takes at most `MAX_RUN` consecutive parts at a time, and few enough that each thread takes a run
/// at least `RUNS` times. Neighbouring parts share their input, but all threads should finish at the same
/// time.
const MAX_RUN: usize = 8;
const RUNS: usize = 3;

/// Largest number of bytes of the entries of a run.
const MAX_BYTES: usize = 1 << 21;

/// Largest number of parts per thread that may wait for their places.
const MAX_WAITING: usize = 32;

/// A part that is complete.
struct CompletePart<V> {
    number: usize,
    entries: Vec<V>,
}

impl<V: Copy> CompletePart<V> {
    /// Copies the entries to their place and returns the memory of the part.
    fn move_to(self, place: Slots<'_, V>) -> Vec<V> {
        assert_eq!(place.len(), self.entries.len());
        // SAFETY: both have the same length, as just asserted, and the place belongs to another allocation
        // than the part. One call saves 3 % of a search against a loop.
        unsafe { self.entries.as_ptr().copy_to_nonoverlapping(place.as_mut_ptr().cast(), place.len()) };
        self.entries
    }
}

type Slots<'a, V> = &'a mut [MaybeUninit<V>];

/// The state of the parts on their way into the list.
struct Line<'a, V> {
    first: usize,
    /// The next part to be taken; below, the number of parts.
    next: usize,
    count: usize,
    threads: usize,
    /// Number of entries of the parts from `first` on that have been taken; `None` until a part is complete.
    lengths: Vec<Option<usize>>,
    /// The places of the parts from `first` on, as far as they are known; `None` once a place has been given
    /// out.
    places: Vec<Option<Slots<'a, V>>>,
    /// Number of entries that have places.
    placed: usize,
    /// The free room of the list.
    room: Slots<'a, V>,
    /// Set when no more parts may be taken: the list is full, or too many parts wait.
    is_closed: bool,
    stopped: Result<(), Error>,
    /// Parts that still waited when their threads found nothing more to do.
    waiting: Vec<CompletePart<V>>,
    memory: &'a mut Vec<Vec<V>>,
}

impl<'a, V> Line<'a, V> {
    /// Takes a run of consecutive parts for a thread; the run is short when few parts are left.
    fn take(&mut self) -> Range<usize> {
        let left = if self.is_closed || self.stopped.is_err() { 0 } else { self.count - self.next };
        // The run should fit into the second-level cache, judged by the parts that have places; at first
        // nothing is known.
        let room = (MAX_BYTES * self.places.len()).checked_div(self.placed * size_of::<V>()).unwrap_or(1);
        let run = left.div_ceil(RUNS * self.threads).min(room.clamp(1, MAX_RUN));
        let run = self.next..self.next + run;
        self.next = run.end;
        self.lengths.resize(run.end - self.first, None);
        run
    }

    /// Records the length of a part. It and the parts that waited for it get their places.
    fn done(&mut self, part: &CompletePart<V>) {
        self.lengths[part.number - self.first] = Some(part.entries.len());
        while let Some(&Some(len)) = self.lengths.get(self.places.len()) {
            let Some(place) = self.room.split_off_mut(..len) else {
                self.is_closed = true;
                return;
            };
            self.places.push(Some(place));
            self.placed += len;
        }
    }

    /// The place of a part, if it is known; it is given out once.
    fn place(&mut self, number: usize) -> Option<Slots<'a, V>> {
        self.places.get_mut(number - self.first)?.take()
    }
}

/// Works on parts until none are left or there is no room for them.
fn work<V: Copy>(
    line: &Mutex<Line<'_, V>>,
    fill: &(impl Fn(usize, &mut Vec<V>) -> Result<(), Error> + Sync),
) {
    let mut waiting = VecDeque::new();
    loop {
        let run = locked(line).take();
        if run.is_empty() {
            break;
        }
        for number in run {
            let mut entries = locked(line).memory.pop().unwrap_or_default();
            entries.clear();
            let filled = fill(number, &mut entries);
            let part = CompletePart { number, entries };
            let mut at = locked(line);
            if filled.is_err() {
                at.stopped = filled;
                return;
            }
            at.done(&part);
            waiting.push_back(part);
            let mut placed = Vec::new();
            while let Some(place) = waiting.front().and_then(|part: &CompletePart<V>| at.place(part.number)) {
                placed.extend(waiting.pop_front().map(|part| (part, place)));
            }
            at.is_closed |= waiting.len() > MAX_WAITING;
            drop(at);
            for (part, place) in placed {
                let memory = part.move_to(place);
                locked(line).memory.push(memory);
            }
        }
    }
    locked(line).waiting.extend(waiting);
}

/// Locks the line. A panic of a thread ends the whole search, so a poisoned state is never used.
fn locked<'l, 'a, V>(line: &'l Mutex<Line<'a, V>>) -> MutexGuard<'l, Line<'a, V>> {
    line.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Part `k` is the number `k` repeated `k % 7` times.
    fn fill(number: usize, part: &mut Vec<usize>) {
        part.extend(std::iter::repeat_n(number, number % 7));
    }

    #[test]
    fn the_order_is_that_of_one_thread_whatever_room_there_is() {
        let fill = |number, part: &mut Vec<usize>| {
            fill(number, part);
            Ok(())
        };
        let expected: Vec<_> = (0..1000).flat_map(|k| std::iter::repeat_n(k, k % 7)).collect();
        for threads in [1, 2, 3, 8] {
            let pool = Pool::new(threads).unwrap_or_default();
            let memory = &mut Vec::new();
            for room in [0, 1, 100, 2_997, 2_998, 2_999, 10_000] {
                let mut list = Vec::with_capacity(room);
                append(&mut list, 1000, fill, &pool, memory).unwrap();
                assert_eq!(list, expected, "{threads} threads, room for {room}");
                append(&mut list, 1000, fill, &pool, memory).unwrap();
                assert_eq!(list[expected.len()..], expected);
            }
            let most = threads * (MAX_WAITING + MAX_RUN + 1);
            assert!(memory.len() <= most, "{} parts kept, {threads} threads", memory.len());
        }
    }

    #[test]
    fn an_error_of_a_part_is_that_of_the_list() {
        let pool = Pool::new(2).unwrap_or_default();
        for wrong in [0, 77, 99] {
            let mut list = Vec::with_capacity(if wrong == 77 { 1000 } else { 0 });
            let fill = |number, part: &mut Vec<usize>| {
                fill(number, part);
                if number == wrong { Err(Error::OutOfMemory { bytes: wrong }) } else { Ok(()) }
            };
            let error = append(&mut list, 100, fill, &pool, &mut Vec::new());
            assert_eq!(error, Err(Error::OutOfMemory { bytes: wrong }));
        }
    }
}
