//! Large arrays in huge pages, where the system gives them on request only.
//!
//! The first write to each page of a new array costs a fault, and 512 small pages hold as much as a huge one.
//! For a new list of couples the faults take up to half of the time of a search (`bench/NOTES.md`, "Equal
//! radii, new lists, lanes from the sign"). This is for speed alone: on systems other than Linux nothing is
//! done.

#![allow(unsafe_code, reason = "advises the system on memory, which the standard library cannot do")]

/// Advises the system to hold the memory of `values` in huge pages, if it is large. The values do not change,
/// and nothing happens if the system refuses.
pub(super) fn make_huge<V>(values: &Vec<V>) {
    #[cfg(all(target_os = "linux", not(miri)))]
    linux::advise(values.as_ptr().cast(), values.capacity() * size_of::<V>());
    #[cfg(not(all(target_os = "linux", not(miri))))]
    let _ = values;
}

#[cfg(all(target_os = "linux", not(miri)))]
mod linux {
    use std::ffi::{c_int, c_void};

    /// Smaller arrays have few huge pages, or none.
    const LARGE: usize = 4 << 20;

    /// Size of a page. Where pages are larger, the system refuses most requests.
    const PAGE: usize = 4096;

    /// `MADV_HUGEPAGE` of Linux.
    const HUGE_PAGES: c_int = 14;

    unsafe extern "C" {
        /// A function of the C library. The standard library links it.
        fn madvise(start: *mut c_void, length: usize, advice: c_int) -> c_int;
    }

    /// Requests huge pages for all pages that hold some of the `bytes` bytes from `start` on.
    ///
    /// The first and the last page belong to them, too, though others may hold bytes there. An allocator
    /// gives a large array a mapping of its own and keeps its notes in front of it. Advice on part of a
    /// mapping splits it, and then it cannot be moved when the array grows: it would be copied.
    pub(super) fn advise(start: *const u8, bytes: usize) {
        if bytes < LARGE {
            return;
        }
        let first = start.addr() / PAGE * PAGE;
        let length = (start.addr() + bytes).next_multiple_of(PAGE) - first;
        // SAFETY: every page of the range holds a byte of an allocation that is in use, because the caller
        // holds its vector, so the range is mapped. The advice changes neither the content of memory, nor its
        // addresses, nor who may read or write it: it is safe for bytes of others, too.
        let refused = unsafe { madvise(start.with_addr(first).cast_mut().cast(), length, HUGE_PAGES) };
        // A system without huge pages refuses, and small pages serve.
        let _ = refused;
    }
}

#[cfg(all(test, target_os = "linux", not(miri)))]
mod tests {
    use crate::memory::{grow, resize};

    /// Values stay in place or move with the array while it grows from small pages into huge ones.
    #[test]
    fn values_of_large_arrays_are_kept() {
        let mut values = Vec::new();
        resize(&mut values, 1_000, 7_u64).unwrap();
        for k in 1_000..3_000_000_u64 {
            grow(&mut values, 1).unwrap();
            values.push(k);
        }
        assert!(values[..1_000].iter().all(|&value| value == 7));
        assert!(values.iter().enumerate().skip(1_000).all(|(k, &value)| value == k as u64));
    }

    /// Linux notes the advice at each mapping of the process.
    #[test]
    fn the_advice_arrives() {
        if !std::path::Path::new("/sys/kernel/mm/transparent_hugepage/enabled").exists() {
            return;
        }
        let mut values = Vec::new();
        resize(&mut values, 16 << 20, 1_u8).unwrap();
        let place = values.as_ptr().addr() + values.len() / 2;
        let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
        let mut is_here = false;
        for line in maps.lines() {
            let word = line.split(' ').next().unwrap_or_default();
            if let Some((from, to)) = word.split_once('-') {
                let [from, to] = [from, to].map(|address| usize::from_str_radix(address, 16).unwrap());
                is_here = (from..to).contains(&place);
            } else if is_here && word == "VmFlags:" {
                assert!(line.split(' ').any(|flag| flag == "hg"), "{line}");
                return;
            }
        }
        panic!("no mapping holds the array");
    }
}
