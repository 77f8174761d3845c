// SPDX-License-Identifier: Apache-2.0
// The integers of a stream apart from how they are coded: what models of the entropy coder are trained and
// measured on.
#ifndef NMC_BENCH_TRAIN_INTEGERS_H_
#define NMC_BENCH_TRAIN_INTEGERS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "libnmc/common/base_mesh_coder.h"
#include "libnmc/common/coefficient_coder.h"

namespace nmc::bench {

struct Integers {
  std::string name;
  std::uint32_t vertex_count = 0;
  std::vector<std::uint32_t> faces;       // of the base mesh, 3 each
  std::vector<std::int32_t> coordinates;  // 3 per vertex
  struct Level {
    std::vector<std::int32_t> normal;
    std::vector<TangentialCoefficient> tangential;
  };
  std::vector<Level> levels;
};

/// Decodes a stream of one quality layer without creases. Throws Error.
Integers integers_of_stream(const std::string& path);

/// A file of 32-bit words, lowest byte first; it outlives changes of the format. Throw Error.
void write_integers(const Integers& integers, const std::string& path);
Integers read_integers(const std::string& path);

/// The integers and all connectivity, ready to be coded again and again.
class CodableMesh {
 public:
  explicit CodableMesh(const Integers& integers);

  /// Bits of the base mesh and of the coefficients under the two models, which learn from it.
  struct Bits {
    double base = 0, coefficients = 0;
  };
  Bits code(BaseMeshModel& base_model, CoefficientModel& coefficient_model) const;

  const std::string& name() const { return integers_.name; }

 private:
  Integers integers_;
  BaseMesh base_;  // in the order of the stream
  std::vector<LevelTopology> topology_;
  std::uint32_t parallelogram_share_ = 0;
};

}  // namespace nmc::bench

#endif  // NMC_BENCH_TRAIN_INTEGERS_H_
