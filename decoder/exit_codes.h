// SPDX-License-Identifier: Apache-2.0
// Exit codes of the decoder's tools: the numbers of encoder/core/error.h, which a decoder must not include. A
// test keeps the two in step.
#ifndef NMC_DECODER_EXIT_CODES_H_
#define NMC_DECODER_EXIT_CODES_H_

namespace nmc {

enum class ToolExit : int {
  kOk = 0,
  kUsage = 1,         // the command line is wrong
  kInputOutput = 2,   // a file cannot be opened, read or written
  kInvalidInput = 3,  // the input is not a valid stream
  kInternal = 4,      // a fault of nmc itself
  kUnsupported = 5,   // a valid stream that uses something this version cannot do
  kLimit = 6,         // a limit on memory or size was reached
  kTargetNotMet = 7,  // no layer of the stream is as asked
  kCutOff = 8,        // decoded, but the stream ends early
};

}  // namespace nmc

#endif  // NMC_DECODER_EXIT_CODES_H_
