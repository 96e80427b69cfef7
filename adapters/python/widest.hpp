#pragma once

// Private to this folder: loops that are compiled for wider instruction sets, too.

#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__UCLIBC__) && defined(__GNUC__) && \
    !defined(__clang__)
/// Of a function: chosen by the loader, on the base of the processor type too. Whole numbers have the same
/// bits everywhere; so have doubles, as nothing is contracted.
#define TOUCHSTONE_WIDEST __attribute__((noinline, target_clones("avx512f", "avx2", "default")))
#else
#define TOUCHSTONE_WIDEST
#endif
