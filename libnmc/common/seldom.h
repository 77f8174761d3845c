// SPDX-License-Identifier: Apache-2.0
// A mark for functions that run a few times per stream: not to be inlined, and compiled for size.
#ifndef NMC_COMMON_SELDOM_H_
#define NMC_COMMON_SELDOM_H_

#if defined(__clang__)
#define NMC_SELDOM [[gnu::noinline]] [[gnu::cold]] [[clang::minsize]]
#elif defined(__GNUC__)
#define NMC_SELDOM [[gnu::noinline]] [[gnu::cold]]
#else
#define NMC_SELDOM
#endif

#endif  // NMC_COMMON_SELDOM_H_
