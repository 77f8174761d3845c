// SPDX-License-Identifier: Apache-2.0
// zstd -19 on whole buffers.
#ifndef NMC_BENCH_PEERS_ZSTD_PEER_H_
#define NMC_BENCH_PEERS_ZSTD_PEER_H_

#include <vector>

namespace nmc::bench {

std::vector<unsigned char> zstd_compress(const std::vector<unsigned char>& bytes);
std::vector<unsigned char> zstd_decompress(const std::vector<unsigned char>& bytes);

}  // namespace nmc::bench

#endif  // NMC_BENCH_PEERS_ZSTD_PEER_H_
