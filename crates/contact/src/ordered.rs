//! A list that several threads write together, in the order of one.

#![allow(unsafe_code, reason = "entries are moved to their places in a list")]

use std::collections::VecDeque;
use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::Error;
use crate::pool::Pool;

/// Appends the parts `0..count` to `list`, in their order; `fill` writes one into an empty vector, on any thread.
///
/// How long a part is, is known when it is done; those before it are mostly done by then, or soon. So its place in the list is known, and it is moved
/// there while it is in cache. When the list is full, the threads stop, and it gets the room that it will need if the rest is like
/// the beginning; they stop too when one that the system has put aside keeps many parts waiting. `memory` keeps the memory of parts for the next time.
///
/// # Errors
/// An error of `fill`, or [`Error::OutOfMemory`]; then `list` holds some of the entries.
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
        // Those for which there was no room.
        let mut left = Vec::new();
        for part in waiting {
            match line.place(part.number) {
                Some(place) => line.memory.push(part.move_to(place)),
                None => left.push(part.entries),
            }
        }
        let placed = line.placed;
        // SAFETY: all parts with a place have been moved there, and the places follow each other, from the first free one of the list on.
        unsafe { list.set_len(list.len() + placed) };

        let more = left.iter().map(Vec::len).sum::<usize>();
        let expected = (list.len() - before + more) as f64 / done as f64 * (count - done) as f64;
        if list.try_reserve_exact(more.saturating_add((1.05 * expected) as usize)).is_err() {
            // There may be memory for what is needed now.
            let bytes = (list.len() + more).saturating_mul(size_of::<V>());
            list.try_reserve_exact(more).map_err(|_| Error::OutOfMemory { bytes })?;
        }
        for entries in left {
            list.extend_from_slice(&entries);
            memory.push(entries);
        }
    }
    Ok(())
}

/// A thread takes so many parts at most, and a run for each thread so many times at least: neighbouring parts share what they read, but all should be done
/// at the same time.
const MAX_RUN: usize = 8;
const RUNS: usize = 3;

/// Of the entries of a run.
const MAX_BYTES: usize = 1 << 21;

/// So many parts of a thread may wait for their places.
const MAX_WAITING: usize = 32;

/// A part that is done.
struct Part<V> {
    number: usize,
    entries: Vec<V>,
}

impl<V: Copy> Part<V> {
    /// Fills its place, and gives its memory back.
    fn move_to(self, place: Place<'_, V>) -> Vec<V> {
        assert_eq!(place.len(), self.entries.len());
        // SAFETY: both are as long, and a place in the list is not in the memory of a part. One call is 3 % of a search quicker than a loop.
        unsafe { self.entries.as_ptr().copy_to_nonoverlapping(place.as_mut_ptr().cast(), place.len()) };
        self.entries
    }
}

type Place<'a, V> = &'a mut [MaybeUninit<V>];

/// The parts on their way into the list.
struct Line<'a, V> {
    first: usize,
    /// The part to be taken next, and the number of parts.
    next: usize,
    count: usize,
    threads: usize,
    /// Entries of the parts from `first` on that have been taken; `None` until they are done.
    lengths: Vec<Option<usize>>,
    /// The places of the parts from `first` on, `None` when they have been given out: as many as are known.
    places: Vec<Option<Place<'a, V>>>,
    /// Entries that have places.
    placed: usize,
    /// The rest of the list.
    room: Place<'a, V>,
    /// No more parts are taken: the list is full, or too many wait.
    is_closed: bool,
    stopped: Result<(), Error>,
    /// Left by threads that have found nothing more to do.
    waiting: Vec<Part<V>>,
    memory: &'a mut Vec<Vec<V>>,
}

impl<'a, V> Line<'a, V> {
    /// Parts for a thread to do: some that follow each other, few when few are left.
    fn take(&mut self) -> Range<usize> {
        let left = if self.is_closed || self.stopped.is_err() { 0 } else { self.count - self.next };
        // As much as the second-level cache holds, going by the parts that are placed: at first nothing is known.
        let room = (MAX_BYTES * self.places.len()).checked_div(self.placed * size_of::<V>()).unwrap_or(1);
        let run = left.div_ceil(RUNS * self.threads).min(room.clamp(1, MAX_RUN));
        let run = self.next..self.next + run;
        self.next = run.end;
        self.lengths.resize(run.end - self.first, None);
        run
    }

    /// Notes how long a part is; it and those that have waited for it get their places.
    fn done(&mut self, part: &Part<V>) {
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

    /// The place of a part, if it is known: once.
    fn place(&mut self, number: usize) -> Option<Place<'a, V>> {
        self.places.get_mut(number - self.first)?.take()
    }
}

/// Does parts until there are none left, or no room for them.
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
            let part = Part { number, entries };
            let mut at = locked(line);
            if filled.is_err() {
                at.stopped = filled;
                return;
            }
            at.done(&part);
            waiting.push_back(part);
            let mut placed = Vec::new();
            while let Some(place) = waiting.front().and_then(|part: &Part<V>| at.place(part.number)) {
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

/// A thread that panicked ends the whole search: what it left is not looked at.
fn locked<'l, 'a, V>(line: &'l Mutex<Line<'a, V>>) -> MutexGuard<'l, Line<'a, V>> {
    line.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Part `k` is `k % 7` times the number `k`.
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
