// The differences between a device and the host, on which tests run the same kernels.
//
// A kernel is a function of the number of its block. It consists of phases, each a loop over the threads of
// the block: EACH_THREAD. On a device all threads run at once and wait for each other at the end of a phase.
// On the host they run one after the other. Numbers that a later phase needs are in shared arrays, so both have the
// same results. A phase has no `return`, `break` out of it or `continue` of it.
//
// Arithmetic rounds after each operation on both: kernels are compiled without contraction.
#pragma once

typedef unsigned int u32;
typedef unsigned long long u64;
typedef long long i64;
typedef float f32;

// Threads of a block.
const u32 THREADS = 256;

#ifdef __CUDACC_RTC__

#define INLINE static __device__ __forceinline__
#define FUNCTION static __device__ __noinline__
#define SHARED __shared__
#define EACH_THREAD(t) for (u32 t = threadIdx.x, more = 1; more; more = 0, __syncthreads())
#define KERNEL(name, Arguments) \
    INLINE void name##_of_block(u32 block, const Arguments &a); \
    extern "C" __global__ void __launch_bounds__(THREADS) name(const Arguments a) { name##_of_block(blockIdx.x, a); } \
    INLINE void name##_of_block(u32 block, const Arguments &a)

INLINE u64 bits_of(double x) { return (u64)__double_as_longlong(x); }
INLINE double of_bits(u64 bits) { return __longlong_as_double((i64)bits); }
INLINE u64 high_product(u64 a, u64 b) { return __umul64hi(a, b); }
INLINE double square_root(double x) { return __dsqrt_rn(x); }
INLINE f32 square_root(f32 x) { return __fsqrt_rn(x); }
INLINE void set_flag(u32 *flag) { atomicOr(flag, 1u); }

#else

#include <math.h>
#include <string.h>

#define INLINE static inline
#define FUNCTION static
#define SHARED
#ifdef DESCENDING
#define EACH_THREAD(t) for (u32 t = THREADS; t-- > 0;)
#else
#define EACH_THREAD(t) for (u32 t = 0; t < THREADS; ++t)
#endif
// A kernel enters itself into a list, in which it is found by its name.
typedef void (*HostKernel)(u32 blocks, const void *arguments);
struct Entry {
    const char *name;
    HostKernel kernel;
    const Entry *next;
    Entry(const char *name, HostKernel kernel, const Entry **first) : name(name), kernel(kernel), next(*first) {
        *first = this;
    }
};
static const Entry *first_entry = nullptr;
#define KERNEL(name, Arguments) \
    static void name##_of_block([[maybe_unused]] u32 block, const Arguments &a); \
    static void name(u32 blocks, const void *arguments) { \
        for (u32 block = 0; block < blocks; ++block) name##_of_block(block, *(const Arguments *)arguments); \
    } \
    static const Entry name##_entry(#name, name, &first_entry); \
    static void name##_of_block([[maybe_unused]] u32 block, const Arguments &a)

INLINE u64 bits_of(double x) {
    u64 bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
INLINE double of_bits(u64 bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
// The upper half of a product.
INLINE u64 high_product(u64 a, u64 b) {
    const u64 mask = 0xffffffffu;
    const u64 low = (a & mask) * (b & mask), one = (a >> 32) * (b & mask), two = (a & mask) * (b >> 32);
    const u64 middle = (low >> 32) + (one & mask) + (two & mask);
    return (a >> 32) * (b >> 32) + (one >> 32) + (two >> 32) + (middle >> 32);
}
INLINE double square_root(double x) { return sqrt(x); }
INLINE f32 square_root(f32 x) { return sqrtf(x); }
INLINE void set_flag(u32 *flag) { *flag |= 1u; }

#endif

// A phase in which each thread of all blocks has a number of its own, up to a count.
#define EACH(number, count) \
    EACH_THREAD(t) if (const u64 number = (u64)block * THREADS + t; number < (count))
