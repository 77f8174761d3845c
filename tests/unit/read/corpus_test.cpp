// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <filesystem>

#include "tests/unit/read/read_test_tools.h"

namespace nmc {
namespace {

struct CorpusMesh {
  const char* file;
  std::size_t vertex_count;  // as stored, before any weld
  std::size_t triangle_count;
  bool has_colors;
  double diagonal;
};

/// Triangles and diagonals are those of the corpus's own inventory, made by another program.
constexpr CorpusMesh kCorpus[] = {
    {"ADIS16480.stl", 22308, 7436, false, 0.0658863},
    {"Block.obj", 8771, 17550, true, 47.3705},
    {"DamagedHelmet.glb", 14556, 15452, false, 3.28923},
    {"Hand1.off", 50085, 100170, false, 240.707},
    {"HarleyDavidson.obj", 5791, 9979, false, 5.8421},
    {"Julius.obj", 36201, 71912, false, 1.50916},
    {"Laurana50k.ply", 27861, 49954, true, 732.951},
    {"amo.off", 90112, 180220, false, 154.063},
    {"armadillo.obj", 49999, 99994, false, 1.51076},
    {"bimba.off", 8857, 17710, false, 1.5075},
    {"boot.obj", 19931, 39906, false, 0.38387},
    {"botijo.obj", 41158, 82332, false, 3.92503},
    {"bun_zipper.ply", 35947, 69451, false, 0.250246},
    {"chaise.ply", 83734, 167464, false, 2.33876},
    {"conrod.off", 3223, 6442, false, 9},
    {"cycloidal.ply", 21384, 43368, true, 2.87315},
    {"dilo.off", 27174, 54344, false, 1.53862},
    {"dragon_100k.obj", 50000, 100000, false, 18.3616},
    {"dragon_871k_draco11.ply", 435545, 871306, false, 0.266888},
    {"fandisk.obj", 6475, 12946, false, 7.61559},
    {"fertility.obj", 30000, 60012, false, 256.012},
    {"gyroidpuzzle.obj", 14169, 28394, false, 53.724},
    {"horse.ply", 48485, 96966, false, 0.253041},
    {"igea.ply", 134345, 268686, false, 0.156399},
    {"impeller.obj", 12042, 24084, false, 3.10716},
    {"m1phobos.obj", 15581, 31158, false, 40.0061},
    {"mask.off", 31756, 62460, false, 2.30446},
    {"motorBike.obj", 132871, 331653, false, 2.54277},
    {"mountain.obj", 25600, 50562, false, 49.9487},
    {"nefertiti.obj", 49971, 99938, false, 658.055},
    {"ogre.obj", 62194, 124008, false, 45.7785},
    {"pepper.ply", 14980, 29956, false, 157.311},
    {"pinion.ply", 21439, 42878, false, 2.17122},
    {"propellerTip.obj", 16785, 33432, false, 0.29679},
    {"rabbit_scan.obj", 37394, 73679, false, 136.368},
    {"rgb_nefertiti.off", 10013, 20022, true, 13.2068},
    {"rockerArm.ply", 40177, 80354, true, 0.0914092},
    {"rolling_stage.obj", 49988, 100000, false, 3.12127},
    {"rs1_normals.ply", 114373, 221803, false, 436.567},
    {"skull.obj", 49999, 100002, false, 20.3831},
    {"thingi_99865.stl", 215922, 71974, false, 64.7403},
};
static_assert(std::size(kCorpus) == 41);

std::filesystem::path corpus_folder() {
  const char* const given = std::getenv("NMC_CORPUS");
  return given != nullptr ? std::filesystem::path(given)
                          : std::filesystem::path(NMC_SOURCE_DIR) / "../shared/corpus";
}

TEST_CASE("corpus: every mesh is read with the counts and the size of its inventory", "[corpus]") {
  if (!std::filesystem::exists(corpus_folder()) && std::getenv("CI") == nullptr) {
    WARN("no corpus in " << corpus_folder());
    return;
  }
  for (const CorpusMesh& expected : kCorpus) {
    CAPTURE(expected.file);
    TriangleMesh mesh;
    REQUIRE_NOTHROW(mesh = read_mesh((corpus_folder() / expected.file).string()));
    CHECK(mesh.vertex_count() == expected.vertex_count);
    CHECK(mesh.triangle_count() == expected.triangle_count);
    CHECK(mesh.colors.size() == (expected.has_colors ? mesh.vertex_count() : 0));
    CHECK(bounding_box(mesh).diagonal() == Approx(expected.diagonal).epsilon(1e-5));
    for (const VertexAttribute& attribute : mesh.attributes)
      CHECK(attribute.values.size() == mesh.vertex_count());
  }
}

}  // namespace
}  // namespace nmc
