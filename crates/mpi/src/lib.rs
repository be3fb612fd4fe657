//! Ranks that are processes under MPI: a `World` is the `Communicator` of all processes that a launcher
//! such as `mpirun` has started.
//!
//! This is a separate crate, so that only the command is compiled again for MPI. It is empty without its
//! feature `mpi`, which needs an MPI library and libclang.
//!
//! # Unsafe code
//! The MPI library is written in C. Each call says why its pointers are valid, and one thread calls at a
//! time.

#![cfg(feature = "mpi")]
#![allow(unsafe_code, reason = "MPI is a C library; each call says why its pointers are valid")]
#![allow(
    clippy::cast_possible_wrap,
    reason = "MPI counts in `int`; ranks come from it, and lengths are cut to `PIECE`"
)]

use std::ffi::{c_int, c_void};
use std::io::Write;
use std::ptr;
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ::mpi::Threading;
use ::mpi::environment::{self, Universe};
use ::mpi::ffi;
use fdem_distributed::{Communicator, Halo, Message, Port, check_messages, check_other};

/// Largest message that is sent in one piece: MPI counts in `int`. Longer ones are cut.
const PIECE: usize = 1 << 30;

/// Tags. The communicator is a copy of the caller's, so nobody else uses them.
const LENGTH_OF_EXCHANGE: c_int = 1;
const EXCHANGE: c_int = 2;
const LENGTH_OF_SEND: c_int = 3;
const SEND: c_int = 4;
/// The first tag of a halo. Each halo has its own, up to the largest tag that every MPI library allows.
const HALO: c_int = 16;
const LARGEST_TAG: c_int = 32767;

/// Exit code of all processes after an error of MPI or a panic.
const FAILED: c_int = 101;

/// One thread calls MPI at a time, as is promised at the start ([`Threading::Serialized`]). A thread that
/// waits in MPI keeps the others waiting.
static CALLS: Mutex<()> = Mutex::new(());

fn one_at_a_time() -> MutexGuard<'static, ()> {
    CALLS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The processes that an MPI launcher such as `mpirun` has started.
///
/// If a rank panics while it holds its world, all processes are ended.
///
/// # Example
/// ```no_run
/// use fdem_distributed::Communicator;
/// use fdem_mpi::World;
///
/// let world = World::start()?;
/// println!("rank {} of {}", world.rank(), world.size());
/// # Ok::<(), fdem_mpi::StartError>(())
/// ```
pub struct World {
    communicator: Comm,
    rank: usize,
    size: usize,
    /// Number of halos that were made.
    halos: AtomicI32,
    /// Ends MPI on drop, if this world has started it. It is dropped once the communicator is freed.
    universe: Option<Universe>,
}

/// A communicator of MPI. Handles may be used by any thread; [`CALLS`] orders the calls.
#[derive(Clone, Copy)]
struct Comm(ffi::MPI_Comm);

// SAFETY: a handle is a number or a pointer that only the MPI library follows. The library is started with
// `Threading::Serialized` or more, so any thread may call it, and `CALLS` lets one thread call at a time.
unsafe impl Send for Comm {}
// SAFETY: as above.
unsafe impl Sync for Comm {}

/// Why MPI could not be started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StartError {
    /// MPI has been started before. [`World::over`] takes a communicator of a program that uses MPI already.
    Started,
    /// The library allows no calls from other threads than the main one.
    Threads,
}

impl std::fmt::Display for StartError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Started => "MPI has been started before, or has ended",
            Self::Threads => "the MPI library supports no calls from threads (MPI_THREAD_SERIALIZED)",
        })
    }
}

impl std::error::Error for StartError {}

/// Name and version of the MPI library, as the library gives them. May be called before MPI is started.
pub fn library_version() -> String {
    let text = environment::library_version().unwrap_or_default();
    text.trim_end_matches(['\0', '\n', ' ']).to_owned()
}

impl World {
    /// Starts MPI, with all processes of the program. MPI ends when the world is dropped, and cannot be
    /// started again.
    ///
    /// # Errors
    /// [`StartError`].
    pub fn start() -> Result<Self, StartError> {
        let (universe, threading) =
            environment::initialize_with_threading(Threading::Serialized).ok_or(StartError::Started)?;
        if threading < Threading::Serialized {
            return Err(StartError::Threads);
        }
        // SAFETY: MPI has been started, and this is the communicator of all its processes.
        let mut world = unsafe { Self::over(ffi::RSMPI_COMM_WORLD) };
        world.universe = Some(universe);
        Ok(world)
    }

    /// The processes of a communicator that the program has made. Collective. The world uses a copy of it, so
    /// messages of the program and of the world are kept apart.
    ///
    /// # Safety
    /// `communicator` is an intracommunicator of the MPI library that this crate is linked with. MPI has been
    /// started with at least `MPI_THREAD_SERIALIZED`, and is not finalised before the world is dropped. While
    /// the program makes other calls of MPI, no other thread uses the world, unless MPI was started with
    /// `MPI_THREAD_MULTIPLE`.
    pub unsafe fn over(communicator: ffi::MPI_Comm) -> Self {
        let _calls = one_at_a_time();
        let mut copy = communicator;
        let (mut rank, mut size) = (0, 0);
        // SAFETY: the caller vouches for the communicator; the pointers are those of local variables.
        unsafe {
            check("MPI_Comm_dup", ffi::MPI_Comm_dup(communicator, &raw mut copy), communicator);
            check("MPI_Comm_rank", ffi::MPI_Comm_rank(copy, &raw mut rank), copy);
            check("MPI_Comm_size", ffi::MPI_Comm_size(copy, &raw mut size), copy);
        }
        Self {
            communicator: Comm(copy),
            rank: rank as usize,
            size: size as usize,
            halos: AtomicI32::new(0),
            universe: None,
        }
    }

    fn comm(&self) -> ffi::MPI_Comm {
        self.communicator.0
    }

    fn check(&self, call: &str, code: c_int) {
        check(call, code, self.comm());
    }

    /// Starts to send bytes, in pieces.
    ///
    /// # Safety
    /// The bytes stay where they are, and do not change, until the requests are complete.
    unsafe fn start_send(&self, to: usize, tag: c_int, bytes: &[u8], requests: &mut Vec<ffi::MPI_Request>) {
        for piece in bytes.chunks(PIECE) {
            // SAFETY: the buffer is that of a slice, of a length that fits `int`; the caller keeps it. The
            // request is written by the call.
            unsafe {
                let mut request = ffi::RSMPI_REQUEST_NULL;
                let (data, count) = (piece.as_ptr().cast::<c_void>(), piece.len() as c_int);
                let code = ffi::MPI_Isend(
                    data,
                    count,
                    ffi::RSMPI_UINT8_T,
                    to as c_int,
                    tag,
                    self.comm(),
                    &raw mut request,
                );
                self.check("MPI_Isend", code);
                requests.push(request);
            }
        }
    }

    /// Starts to receive bytes, in pieces.
    ///
    /// # Safety
    /// The bytes stay where they are, and nobody reads or writes them, until the requests are complete.
    unsafe fn start_receive(
        &self,
        from: usize,
        tag: c_int,
        bytes: &mut [u8],
        requests: &mut Vec<ffi::MPI_Request>,
    ) {
        for piece in bytes.chunks_mut(PIECE) {
            // SAFETY: the buffer is that of a slice, of a length that fits `int`; the caller keeps it. The
            // request is written by the call.
            unsafe {
                let mut request = ffi::RSMPI_REQUEST_NULL;
                let (data, count) = (piece.as_mut_ptr().cast::<c_void>(), piece.len() as c_int);
                let code = ffi::MPI_Irecv(
                    data,
                    count,
                    ffi::RSMPI_UINT8_T,
                    from as c_int,
                    tag,
                    self.comm(),
                    &raw mut request,
                );
                self.check("MPI_Irecv", code);
                requests.push(request);
            }
        }
    }

    /// Waits for requests.
    fn wait(&self, requests: &mut [ffi::MPI_Request]) {
        // More than `int` can count would take terabytes of messages. SAFETY: the requests were made by this
        // communicator, and their buffers live, because who started them waits here.
        let code = unsafe {
            ffi::MPI_Waitall(requests.len() as c_int, requests.as_mut_ptr(), ffi::RSMPI_STATUSES_IGNORE)
        };
        self.check("MPI_Waitall", code);
    }

    /// Sends a short message and waits until its buffer is free.
    fn send_number(&self, to: usize, tag: c_int, number: u64) {
        let bytes = number.to_le_bytes();
        // SAFETY: the buffer is local, and the call returns when it may be reused.
        let code = unsafe {
            ffi::MPI_Send(bytes.as_ptr().cast(), 8, ffi::RSMPI_UINT8_T, to as c_int, tag, self.comm())
        };
        self.check("MPI_Send", code);
    }

    /// Receives a number, and says from which rank; from any one if none is given.
    fn receive_number(&self, from: Option<usize>, tag: c_int) -> (usize, u64) {
        let mut bytes = [0; 8];
        // SAFETY: the buffer and the status are local, and the call returns when they are written. A status
        // is plain numbers, for which zeros are valid.
        let source = unsafe {
            let source = from.map_or(ffi::RSMPI_ANY_SOURCE, |rank| rank as c_int);
            let mut status: ffi::MPI_Status = std::mem::zeroed();
            let data = bytes.as_mut_ptr().cast();
            let code = ffi::MPI_Recv(data, 8, ffi::RSMPI_UINT8_T, source, tag, self.comm(), &raw mut status);
            self.check("MPI_Recv", code);
            status.MPI_SOURCE
        };
        (source as usize, u64::from_le_bytes(bytes))
    }

    /// Number of messages that this rank will get, if each rank sends one to the given ranks.
    fn count_incoming(&self, to: impl Iterator<Item = usize>) -> usize {
        let mut sends = vec![0 as c_int; self.size];
        to.for_each(|rank| sends[rank] = 1);
        let mut incoming = 0 as c_int;
        // SAFETY: one number for each rank is read, and one is written.
        let code = unsafe {
            ffi::MPI_Reduce_scatter_block(
                sends.as_ptr().cast(),
                (&raw mut incoming).cast(),
                1,
                ffi::RSMPI_INT32_T,
                ffi::RSMPI_SUM,
                self.comm(),
            )
        };
        self.check("MPI_Reduce_scatter_block", code);
        incoming as usize
    }

    /// Replaces values by the result of `operation` over the values of all ranks.
    ///
    /// # Safety
    /// `V` is the type that `datatype` describes.
    unsafe fn reduce<V: Copy>(&self, values: &mut [V], datatype: ffi::MPI_Datatype, operation: ffi::MPI_Op) {
        for piece in values.chunks_mut(PIECE / 8) {
            let own = piece.to_vec();
            // SAFETY: both buffers have the given number of values of the datatype.
            let code = unsafe {
                ffi::MPI_Allreduce(
                    own.as_ptr().cast(),
                    piece.as_mut_ptr().cast(),
                    piece.len() as c_int,
                    datatype,
                    operation,
                    self.comm(),
                )
            };
            self.check("MPI_Allreduce", code);
        }
    }

    /// Sends bytes from one rank to all, which know their length.
    fn broadcast_from(&self, root: usize, bytes: &mut [u8]) {
        for piece in bytes.chunks_mut(PIECE) {
            // SAFETY: the buffer is that of a slice, of a length that fits `int`.
            let code = unsafe {
                let (data, count) = (piece.as_mut_ptr().cast(), piece.len() as c_int);
                ffi::MPI_Bcast(data, count, ffi::RSMPI_UINT8_T, root as c_int, self.comm())
            };
            self.check("MPI_Bcast", code);
        }
    }
}

impl Communicator for World {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn barrier(&self) {
        let _calls = one_at_a_time();
        // SAFETY: the communicator lives as long as the world.
        let code = unsafe { ffi::MPI_Barrier(self.comm()) };
        self.check("MPI_Barrier", code);
    }

    fn exchange(&self, messages: Vec<Message>) -> Vec<Message> {
        check_messages(&messages, self.size);
        let _calls = one_at_a_time();
        let (own, others): (Vec<_>, Vec<_>) =
            messages.into_iter().partition(|message| message.rank == self.rank);
        let incoming = self.count_incoming(others.iter().map(|message| message.rank));
        let lengths: Vec<[u8; 8]> =
            others.iter().map(|message| (message.bytes.len() as u64).to_le_bytes()).collect();
        let mut requests = Vec::new();
        for (message, length) in others.iter().zip(&lengths) {
            // SAFETY: the messages and their lengths are kept until the requests are waited for below.
            unsafe {
                self.start_send(message.rank, LENGTH_OF_EXCHANGE, length, &mut requests);
                self.start_send(message.rank, EXCHANGE, &message.bytes, &mut requests);
            }
        }
        // No rank is ahead by a whole exchange: nobody gets past the count of the next one before all ranks
        // have come there. Therefore each length that arrives belongs to this exchange.
        let mut received = own;
        for _ in 0..incoming {
            let (rank, length) = self.receive_number(None, LENGTH_OF_EXCHANGE);
            received.push(Message { rank, bytes: vec![0; length as usize] });
        }
        for message in received.iter_mut().filter(|message| message.rank != self.rank) {
            // SAFETY: the bytes are on the heap, and nobody touches them until the requests are waited for
            // below.
            unsafe { self.start_receive(message.rank, EXCHANGE, &mut message.bytes, &mut requests) };
        }
        self.wait(&mut requests);
        received.sort_unstable_by_key(|message| message.rank);
        received
    }

    fn all_gather(&self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let _calls = one_at_a_time();
        let mut lengths = vec![0_u64; self.size];
        let own = bytes.len() as u64;
        // SAFETY: one number is read, and one from each rank is written.
        let code = unsafe {
            ffi::MPI_Allgather(
                (&raw const own).cast(),
                1,
                ffi::RSMPI_UINT64_T,
                lengths.as_mut_ptr().cast(),
                1,
                ffi::RSMPI_UINT64_T,
                self.comm(),
            )
        };
        self.check("MPI_Allgather", code);
        let lengths: Vec<usize> = lengths.into_iter().map(|length| length as usize).collect();
        if lengths.iter().all(|&length| length == 0) {
            // MPI refuses buffers at the same address, which empty ones have.
            return vec![Vec::new(); self.size];
        }
        if lengths.iter().sum::<usize>() > PIECE {
            let each = lengths.iter().enumerate().map(|(root, &length)| {
                let mut of_root = if root == self.rank { bytes.to_vec() } else { vec![0; length] };
                self.broadcast_from(root, &mut of_root);
                of_root
            });
            return each.collect();
        }
        let counts: Vec<c_int> = lengths.iter().map(|&length| length as c_int).collect();
        let starts: Vec<c_int> =
            counts.iter().scan(0, |end, count| Some(std::mem::replace(end, *end + count))).collect();
        let mut all = vec![0_u8; lengths.iter().sum()];
        // SAFETY: the lengths and starts are those of parts of `all`, one for each rank, and this rank's part
        // has the length of `bytes`.
        let code = unsafe {
            ffi::MPI_Allgatherv(
                bytes.as_ptr().cast(),
                bytes.len() as c_int,
                ffi::RSMPI_UINT8_T,
                all.as_mut_ptr().cast(),
                counts.as_ptr(),
                starts.as_ptr(),
                ffi::RSMPI_UINT8_T,
                self.comm(),
            )
        };
        self.check("MPI_Allgatherv", code);
        let mut rest = &all[..];
        lengths.iter().map(|&length| rest.split_off(..length).unwrap_or_default().to_vec()).collect()
    }

    fn broadcast(&self, bytes: &mut Vec<u8>) {
        let _calls = one_at_a_time();
        let mut length = (bytes.len() as u64).to_le_bytes();
        self.broadcast_from(0, &mut length);
        bytes.resize(u64::from_le_bytes(length) as usize, 0);
        self.broadcast_from(0, bytes);
    }

    fn all_sum(&self, values: &mut [i64]) {
        let _calls = one_at_a_time();
        // Unsigned numbers wrap around in C, where the overflow of signed ones is undefined.
        // SAFETY: `i64` and `u64` have the same bytes.
        unsafe { self.reduce(values, ffi::RSMPI_UINT64_T, ffi::RSMPI_SUM) };
    }

    fn all_max(&self, values: &mut [f64]) {
        let _calls = one_at_a_time();
        // SAFETY: `f64` is C's double.
        unsafe { self.reduce(values, ffi::RSMPI_DOUBLE, ffi::RSMPI_MAX) };
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        check_other(to, self.rank, self.size);
        let _calls = one_at_a_time();
        self.send_number(to, LENGTH_OF_SEND, bytes.len() as u64);
        let mut requests = Vec::new();
        // SAFETY: the bytes are borrowed until the requests are complete.
        unsafe { self.start_send(to, SEND, bytes, &mut requests) };
        self.wait(&mut requests);
    }

    fn receive(&self, from: usize) -> Vec<u8> {
        check_other(from, self.rank, self.size);
        let _calls = one_at_a_time();
        let (_, length) = self.receive_number(Some(from), LENGTH_OF_SEND);
        let mut bytes = vec![0; length as usize];
        let mut requests = Vec::new();
        // SAFETY: nobody touches the bytes until the requests are complete.
        unsafe { self.start_receive(from, SEND, &mut bytes, &mut requests) };
        self.wait(&mut requests);
        bytes
    }

    fn halo(&self, send: &[Port], receive: &[Port]) -> Box<dyn Halo + '_> {
        // Ranks make the same halos in the same order, so their tags agree.
        let number = self.halos.fetch_add(1, Ordering::Relaxed);
        let tag = HALO + number.rem_euclid(LARGEST_TAG - HALO);
        let _calls = one_at_a_time();
        let mut halo = Persistent {
            of: self,
            outgoing: send.iter().map(|port| vec![0; port.bytes]).collect(),
            incoming: receive.iter().map(|port| vec![0; port.bytes]).collect(),
            requests: Vec::new(),
            started: false,
        };
        // Receives come first, so that arriving data has its place.
        for (port, bytes) in receive.iter().zip(&mut halo.incoming) {
            for piece in bytes.chunks_mut(PIECE) {
                // SAFETY: the buffer is on the heap; the halo owns it, never resizes it, and frees the
                // request first.
                let code = unsafe {
                    halo.requests.push(ffi::RSMPI_REQUEST_NULL);
                    let request = halo.requests.last_mut().map_or(ptr::null_mut(), ptr::from_mut);
                    let (data, count) = (piece.as_mut_ptr().cast(), piece.len() as c_int);
                    let from = port.rank as c_int;
                    ffi::MPI_Recv_init(data, count, ffi::RSMPI_UINT8_T, from, tag, self.comm(), request)
                };
                self.check("MPI_Recv_init", code);
            }
        }
        for (port, bytes) in send.iter().zip(&halo.outgoing) {
            for piece in bytes.chunks(PIECE) {
                // SAFETY: as above.
                let code = unsafe {
                    halo.requests.push(ffi::RSMPI_REQUEST_NULL);
                    let request = halo.requests.last_mut().map_or(ptr::null_mut(), ptr::from_mut);
                    let (data, count) = (piece.as_ptr().cast(), piece.len() as c_int);
                    let to = port.rank as c_int;
                    ffi::MPI_Send_init(data, count, ffi::RSMPI_UINT8_T, to, tag, self.comm(), request)
                };
                self.check("MPI_Send_init", code);
            }
        }
        Box::new(halo)
    }

    fn abort(&self, code: i32) -> ! {
        abort(self.comm(), code)
    }
}

impl Drop for World {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // The other ranks would wait for this one forever.
            abort(self.comm(), FAILED);
        }
        let _calls = one_at_a_time();
        // SAFETY: the copy was made by this world, whose halos have ended or are forgotten, because they
        // borrow it.
        let code = unsafe { ffi::MPI_Comm_free(&raw mut self.communicator.0) };
        // SAFETY: MPI has not ended yet.
        check("MPI_Comm_free", code, unsafe { ffi::RSMPI_COMM_WORLD });
        drop(self.universe.take());
    }
}

/// Persistent requests of MPI, and their buffers.
struct Persistent<'a> {
    of: &'a World,
    /// Bytes by port. They are never resized, because the requests point to them.
    outgoing: Vec<Vec<u8>>,
    incoming: Vec<Vec<u8>>,
    requests: Vec<ffi::MPI_Request>,
    started: bool,
}

impl Halo for Persistent<'_> {
    fn outgoing(&mut self, port: usize) -> &mut [u8] {
        assert!(!self.started, "the messages are under way");
        &mut self.outgoing[port]
    }

    fn start(&mut self) {
        assert!(!self.started, "the messages are under way");
        self.started = true;
        let _calls = one_at_a_time();
        // `MPI_Startall` may start them in any order, and messages between two ranks would be mixed up if
        // there are several.
        for request in &mut self.requests {
            // SAFETY: the request is persistent and not active; its buffer is owned by this halo, and is not
            // touched before `finish`.
            let code = unsafe { ffi::MPI_Start(request) };
            self.of.check("MPI_Start", code);
        }
    }

    fn finish(&mut self) {
        assert!(self.started, "the messages have been started");
        {
            let _calls = one_at_a_time();
            self.of.wait(&mut self.requests);
        }
        self.started = false;
    }

    fn incoming(&self, port: usize) -> &[u8] {
        assert!(!self.started, "the messages are under way");
        &self.incoming[port]
    }
}

impl Drop for Persistent<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // The world ends all ranks; waiting for them here might take forever.
            abort(self.of.comm(), FAILED);
        }
        let _calls = one_at_a_time();
        if self.started {
            self.of.wait(&mut self.requests);
        }
        for request in &mut self.requests {
            // SAFETY: the request is persistent and not active.
            let code = unsafe { ffi::MPI_Request_free(request) };
            self.of.check("MPI_Request_free", code);
        }
    }
}

/// Ends all ranks if a call has failed.
fn check(call: &str, code: c_int, comm: ffi::MPI_Comm) {
    // MPI_SUCCESS is 0 by the standard.
    if code == 0 {
        return;
    }
    // SAFETY: the buffer has the length that the library requires, and the length is written by the call.
    let text = unsafe {
        let mut text = vec![0_u8; ffi::MPI_MAX_ERROR_STRING as usize];
        let mut length = 0;
        ffi::MPI_Error_string(code, text.as_mut_ptr().cast(), &raw mut length);
        text.truncate(usize::try_from(length).unwrap_or_default());
        text
    };
    // Nothing can be done if even the error cannot be printed.
    let _ =
        writeln!(std::io::stderr(), "error: {call} of MPI has failed: {}", String::from_utf8_lossy(&text));
    abort(comm, FAILED)
}

fn abort(comm: ffi::MPI_Comm, code: c_int) -> ! {
    // No lock: a thread that waits in MPI may hold it forever.
    // SAFETY: MPI has been started, and the communicator was made by it.
    unsafe { ffi::MPI_Abort(comm, code) };
    std::process::exit(code)
}
