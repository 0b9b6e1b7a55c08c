// SPDX-License-Identifier: Apache-2.0
// SCANMILL_WIDE before a function: compiled for plain x86-64 and for wider vector sets, the best one that the processor
// has is chosen at run time. For loops of + - * / sqrt, comparisons and integers over arrays only: such loops give the
// same bits in every width (no FMA: -ffp-contract=off). No call into inline code of others, which the linker might then
// take for all.
#pragma once

#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SCANMILL_WIDE __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
/// For what loops cannot say: a function written for 512-bit integers, beside a plain one that gives the same. Called
/// where SCANMILL_HAS_512 is true.
#define SCANMILL_WITH_512 __attribute__((target("avx512f,avx512bw")))
#define SCANMILL_HAS_512 (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw"))
#else
#define SCANMILL_WIDE
#endif
